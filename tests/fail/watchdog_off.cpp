// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D's watchdog time of 0, whose meaning is not stated: perhaps nothing stops the wheels then. It is
// written by name: undocumented_zero{}.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)drive.write<zlac::host_timeout>(1000);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::host_timeout>(0); // wrong
}
