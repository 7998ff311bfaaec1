// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An argument of a command listed with a read-only register.
// EXPECT: this register is read-only
// MEND: (void)servobus::commands::argument<zlac::host_timeout>(60 * units::millisecond);
#include <servobus/control/arguments.hpp>

#include "program.hpp"

int main() {
    (void)servobus::commands::argument<zlac::host_connected>(1); // wrong
}
