// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read of a register that can only be written.
// EXPECT: this register is write-only
// MEND: (void)drive.write<kick>(1);
#include "program.hpp"

inline constexpr servobus::reg<servobus::u16, servobus::access::wo, zlac::device> kick{
    0x3000, {0, 1}, servobus::no_unit, 0};

int main() {
    some_drive drive;
    (void)drive.read<kick>(); // wrong
}
