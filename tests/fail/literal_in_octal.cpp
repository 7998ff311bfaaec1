// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A literal that C++ takes as octal.
// EXPECT: a_quantity_is_a_plain_decimal_such_as_12_5
// MEND: (void)(10_mm);
#include <servobus/registers/literals.hpp>

using namespace servobus::literals;

int main() {
    (void)(012_mm); // wrong
}
