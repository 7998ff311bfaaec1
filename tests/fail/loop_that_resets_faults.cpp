// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A setpoint loop that would reset faults by itself, in each of its take-overs.
// EXPECT: a loop resets faults by consent: reset_faults(), not with_fault_reset{} in its take-over
// MEND: servobus::setpoint_loop lift{stepper, servobus::take_over{servobus::disable{}}};
#include <servobus/control/setpoint_loop.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    servobus::setpoint_loop lift{stepper, servobus::take_over{servobus::with_fault_reset{}}}; // wrong
    (void)lift;
}
