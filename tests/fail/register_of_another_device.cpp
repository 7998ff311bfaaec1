// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register that belongs to another device than the client's.
// EXPECT: this register belongs to another device
// MEND: (void)drive.read<zlac::left_actual_speed>();
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.read<other::speed>(); // wrong
}
