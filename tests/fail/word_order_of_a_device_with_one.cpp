// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Another word order for a device whose word order its manual fixes.
// EXPECT: assign
// MEND: servo.node().word_order = servobus::word_order::low_first;
#include "program.hpp"

int main() {
    some_drive drive;
    drive.node().word_order = servobus::word_order::low_first; // wrong
}
