// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value taken out of a read that did not ask for it.
// EXPECT: this register was not read
// MEND: (void)drive.read<zlac::bus_voltage, zlac::hall_state>()->get<zlac::hall_state>();
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.read<zlac::bus_voltage, zlac::status_word>()->get<zlac::hall_state>(); // wrong
}
