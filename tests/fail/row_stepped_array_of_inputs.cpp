// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stepped read of an array of input registers.
// EXPECT: an array of input registers is read by stepped_read_words
// MEND: servobus::stepped_read_words<some_basin, 2> sensor{io};
#include "basin.hpp"

int main() {
    some_basin io;
    servobus::stepped_read<some_basin, basin::sensors> sensor{io}; // wrong
}
