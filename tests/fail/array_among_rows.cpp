// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An array among the rows of a read or of a cyclic read.
// EXPECT: an element of an array is a row by name: at<rows, i>
// MEND: (void)io.read<basin::valve, servobus::at<basin::lamps, 0>, servobus::at<basin::lamps, 1>>();
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.read<basin::valve, basin::lamps>(); // wrong
}
