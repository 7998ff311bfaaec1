// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A loop that would take the power away after each enable: the list of commands is for those that need it.
// EXPECT: an after_enable neither takes the drive over nor changes the motor's power, nor resets faults
// MEND: servobus::setpoint_loop homed{stepper, servobus::take_over{servobus::disable{}}, servobus::enable{},
//                               servobus::after_enable{yako::open_loop::home{yako::homing::home_24}}};
#include <servobus/control/setpoint_loop.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    constexpr servobus::after_enable released{servobus::disable{}};
    servobus::setpoint_loop lift{stepper, servobus::take_over{}, servobus::enable{}, released}; // wrong
    lift.command();
}
