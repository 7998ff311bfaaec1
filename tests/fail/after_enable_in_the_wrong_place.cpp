// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A setpoint loop whose enable is left out, so that its homing is in the place of the enable.
// EXPECT: after_enable{...} comes right after the enable: take_over{}, enable{}, after_enable{...}, setpoints<>{}
// MEND: servobus::setpoint_loop homed{stepper, servobus::take_over{servobus::disable{}}, servobus::enable{},
//                               servobus::after_enable{yako::open_loop::home{yako::homing::home_24}}};
#include <servobus/control/setpoint_loop.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    constexpr servobus::after_enable home{yako::open_loop::home{yako::homing::home_24}};
    servobus::setpoint_loop homed{stepper, servobus::take_over{servobus::disable{}}, home}; // wrong
    (void)homed;
}
