// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A servo that is to turn while a button is held, by a program that does not say what becomes of it without the line:
// the drive has no watchdog.
// EXPECT: this motor turns on when the line is lost: hold{speed, runs_on_without_line{}}
// MEND: (void)servo.run(hold{60 * units::r_per_min, servobus::runs_on_without_line{}});
#include "drives.hpp"

int main() {
    some_servo servo;
    (void)servo.run(servobus::hold{60 * units::r_per_min}); // wrong
}
