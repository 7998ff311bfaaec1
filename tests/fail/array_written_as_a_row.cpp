// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An array of coils that is written without an index.
// EXPECT: an array is written by the element: write<rows>(i, v), or write<at<rows, 0>, at<rows, 1>>(v, w)
// MEND: (void)io.write<servobus::at<basin::lamps, 0>, servobus::at<basin::lamps, 1>>(true, false);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::lamps>(true, false); // wrong
}
