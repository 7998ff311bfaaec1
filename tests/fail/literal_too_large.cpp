// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A literal that does not fit the 32 bits of a quantity.
// EXPECT: a_quantity_fits_32_bits
// MEND: (void)(2147_m);
#include <servobus/registers/literals.hpp>

using namespace servobus::literals;

int main() {
    (void)(2147'483'648_um); // wrong
}
