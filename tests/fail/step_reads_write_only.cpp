// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that reads a register which can only be written.
// EXPECT: a_step_reads_no_write_only_register
// MEND: inline constexpr servobus::step kicked = servobus::steps::write<kick>(1);
#include "program.hpp"

inline constexpr servobus::reg<servobus::u16, servobus::access::wo, zlac::device> kick{
    0x3000, {0, 1}, servobus::no_unit, 0};
inline constexpr servobus::step kicked = servobus::steps::fetch<kick>(); // wrong

int main() {}
