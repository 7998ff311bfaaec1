// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A duration for a time that the drive counts in milliseconds.
// EXPECT: a_duration_is_a_whole_number_of_the_unit
// MEND: (void)zlac::watchdog{servobus::milliseconds(2)};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

int main() {
    (void)(zlac::watchdog{servobus::microseconds(1500)}); // wrong
}
