// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A coil of another device.
// EXPECT: this register belongs to another device
// MEND: (void)io.read<basin::lamp>();
#include "basin.hpp"

inline constexpr servobus::coil<servobus::access::rw, other::device> other_lamp{0x0010};

int main() {
    some_basin io;
    (void)io.read<other_lamp>(); // wrong
}
