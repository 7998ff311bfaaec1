// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An array that is read without an index.
// EXPECT: an array is read by the element: read<rows>(i), or read<at<rows, 0>, at<rows, 1>>()
// MEND: (void)io.read<basin::sensors>(2);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.read<basin::sensors>(); // wrong
}
