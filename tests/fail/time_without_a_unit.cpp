// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A period as a bare number: milliseconds are meant, microseconds would be taken.
// EXPECT: servobus::duration
// MEND: servobus::supervision by{.feedback = servobus::milliseconds(20), .command_timeout = servobus::milliseconds(300)};
#include "program.hpp"

int main() {
    servobus::supervision by{.feedback = 20, .command_timeout = servobus::milliseconds(300)}; // wrong
    (void)by;
}
