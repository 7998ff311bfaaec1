// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of several registers, one of another device.
// EXPECT: this register belongs to another device
// MEND: (void)drive.write<zlac::left_max_speed, zlac::right_max_speed>(1, 1);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::right_max_speed, other::speed>(1, 1); // wrong
}
