// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An element of an array of another device.
// EXPECT: this register belongs to another device
// MEND: (void)servo.read<c630s::position_segment_speeds>(2);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.read<other::speeds>(1); // wrong
}
