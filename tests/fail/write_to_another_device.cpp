// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write to a register of another device.
// EXPECT: this register belongs to another device
// MEND: (void)drive.write<zlac::left_max_speed>(1);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<other::speed>(1); // wrong
}
