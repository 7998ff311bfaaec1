// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A parameter that counts from the next power-on is set until the power goes.
// EXPECT: this register counts from the next power-on: keep it
// MEND: (void)servo.run(c630s::keep<c630s::pulses_per_revolution>{checked(raw(10000))});
#include "drives.hpp"

int main() {
    some_servo servo;
    (void)servo.run(
        servobus::c630s::set<servobus::c630s::pulses_per_revolution>{checked(raw(10000))}); // wrong
}
