// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A factor that has a scale of its own.
// EXPECT: the row that scales another has no scale of its own
// MEND: using by_exponent = servobus::with<servobus::u16, servobus::ten_to<meters::exponent>>;
#include "meters.hpp"

namespace meters {
inline constexpr ro<with<u16, times_row<tenths>>> wrong{0x0070, full<u16>, units::volt, no_default}; // wrong
}

int main() { servobus::row_type<meters::wrong>::value_type count; }
