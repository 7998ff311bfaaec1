// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A length that is no whole number of micrometres.
// EXPECT: this quantity is finer than a count of the command: it would be rounded
// MEND: (void)servobus::move_to{5 * units::micrometre};
#include "drives.hpp"

int main() {
    using servobus::part;
    (void)servobus::move_to{55 * part<10>(units::micrometre)}; // wrong
}
