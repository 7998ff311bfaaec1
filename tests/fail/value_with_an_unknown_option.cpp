// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An option that is none.
// EXPECT: with<T, ...> takes bits, offset, or_none, ten_to, times_row, high_word_first, low_word_first and low_byte_first
// MEND: using one_register = servobus::with<servobus::u16, servobus::bits<0, 3>>;
#include "meters.hpp"

namespace meters {
inline constexpr ro<with<u16, u16>> wrong{0x0070, full<u16>, no_unit, no_default}; // wrong
}

int main() {
    some_meters io;
    (void)io.read<meters::wrong>();
}
