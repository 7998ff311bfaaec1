// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A part of a value of two registers.
// EXPECT: bits<First, Last> are those of one register
// MEND: using one_register = servobus::with<servobus::u16, servobus::bits<0, 3>>;
#include "meters.hpp"

namespace meters {
inline constexpr ro<with<u32, bits<0, 3>>> wrong{0x0070, full<u16>, no_unit, no_default}; // wrong
}

int main() {
    some_meters io;
    (void)io.read<meters::wrong>();
}
