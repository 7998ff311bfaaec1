// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A text of nine characters for four registers.
// EXPECT: this text is longer than its registers
// MEND: (void)meter.write<meters::name>("8 LETTER");
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.write<meters::name>("9 LETTERS"); // wrong
}
