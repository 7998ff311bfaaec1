// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A factor that another row scales.
// EXPECT: another row scales by an integer of one or two registers: u16, i16, u32, i32
// MEND: using by_exponent = servobus::with<servobus::u16, servobus::ten_to<meters::exponent>>;
#include "meters.hpp"

namespace meters {
inline constexpr ro<with<u16, times_row<current>>> wrong{0x0070, full<u16>, units::volt, no_default}; // wrong
}

int main() { servobus::row_type<meters::wrong>::value_type count; }
