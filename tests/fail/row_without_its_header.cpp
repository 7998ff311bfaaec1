// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A coil, in a program that includes servobus.hpp alone.
// ALONE
// EXPECT: for coils, inputs and functions 16h and 17h include servobus/any_device.hpp
// MEND: #include <servobus/any_device.hpp>
#include <servobus/registers/tables.hpp>

#include "program.hpp"

inline constexpr servobus::coil<servobus::access::rw, zlac::device> horn{0x0003};

int main() {
    some_drive drive;
    (void)drive.read<horn>(); // wrong
}
