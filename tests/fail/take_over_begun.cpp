// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A take-over that is begun as if it were one command.
// EXPECT: a take_over is several commands: a facade or a bus runs it, or a setpoint_loop steps it
// MEND: (void)stepper.run(servobus::take_over{servobus::disable{}, yako::save{}});
#include <servobus/control/take_over.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.begin(servobus::take_over{servobus::disable{}, yako::save{}}); // wrong
}
