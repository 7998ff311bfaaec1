// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A frame in hex with a character that is no digit.
// EXPECT: a_frame_in_hex_has_two_digits_for_each_byte
// MEND: constexpr auto frame = servobus::hex("01 06 20 0E");
#include "program.hpp"

int main() {
    constexpr auto frame = servobus::hex("01 06 20 OE"); // wrong
}
