// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A literal that is finer than a unit can be: the next smaller unit is.
// EXPECT: a_quantity_has_at_most_4_decimals
// MEND: (void)(652.3125_mm);
#include <servobus/registers/literals.hpp>

using namespace servobus::literals;

int main() {
    (void)(652.31251_mm); // wrong
}
