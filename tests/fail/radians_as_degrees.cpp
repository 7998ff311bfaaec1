// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Radians where degrees are meant: no whole number of one is one of the other.
// EXPECT: the quantity is of another kind than this unit
// MEND: (void)(90_degree).rounded(servobus::units::degree);
#include <servobus/registers/literals.hpp>

using namespace servobus::literals;

int main() {
    (void)(1.5708_rad).rounded(servobus::units::degree); // wrong
}
