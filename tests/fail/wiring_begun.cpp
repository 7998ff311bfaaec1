// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A wiring, which is several commands, is begun as one.
// EXPECT: a wiring is several commands: the facade of the drive runs it
// MEND: (void)stepper.run(yako::wire_inputs{.x0 = yako::input_function::home});
#include <servobus/device/yako/wiring.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.begin(yako::wire_inputs{.x0 = yako::input_function::home}); // wrong
}
