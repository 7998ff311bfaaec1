// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A servo that is to turn while a button is held, by a program that does not say what becomes of it without the line:
// the drive has no watchdog.
// EXPECT: this motor turns on when the line is lost: hold{speed, runs_on_without_line{}}
// MEND: (void)c630s::hold{60 * units::r_per_min, c630s::runs_on_without_line{}};
#include <servobus/device/c630s.hpp>

using namespace servobus;

int main() {
    (void)c630s::hold{60 * units::r_per_min}; // wrong
}
