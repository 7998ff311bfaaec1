// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of adjacent registers in another order than theirs.
// EXPECT: a write of several registers is one frame: they must be adjacent and in address order
// MEND: (void)drive.write<zlac::left_target_speed, zlac::right_target_speed>(raw(0), raw(0));
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::right_target_speed, zlac::left_target_speed>(raw(0), raw(0)); // wrong
}
