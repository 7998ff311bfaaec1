// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A mode that each enable sets anew is set by its row.
// EXPECT: a mode and its sources are set by enable_in{}
// MEND: (void)servo.run(c630s::enable_in{c630s::control_mode::speed});
#include "drives.hpp"

int main() {
    some_servo servo;
    (void)servo.run(servobus::c630s::set<servobus::c630s::mode_of_operation>{
        servobus::c630s::control_mode::speed}); // wrong
}
