// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ring whose capacity is no power of two: its counters could not wrap.
// EXPECT: power_of_two_up_to_32768
// MEND: (void)servobus::ring<4>{};
#include <servobus/line/ring.hpp>

int main() {
    (void)servobus::ring<3>{}; // wrong
}
