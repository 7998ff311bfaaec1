// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Commands after an enable that are begun as if they were one.
// EXPECT: an after_enable is several commands: a setpoint_loop begins them after its enable
// MEND: servobus::setpoint_loop homed{stepper, servobus::take_over{servobus::disable{}}, servobus::enable{},
//                               servobus::after_enable{yako::open_loop::home{yako::homing::home_24}}};
#include <servobus/control/setpoint_loop.hpp>

#include "drives.hpp"

int main() {
    some_servo servo;
    (void)servo.run(servobus::after_enable{servobus::read_feedback{}}); // wrong
}
