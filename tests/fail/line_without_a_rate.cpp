// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Devices on one line that have no baud rate in common: here the port has none above 2400 Bd
// EXPECT: these devices have no baud rate in common: they cannot share a line
// MEND: constexpr auto shared =
//  servobus::settings_on_one_line<9600>(servobus::node<zlac::device>{1}, servobus::node<c630s::device>{2});
#include <servobus/client/settings_on_one_line.hpp>
#include <servobus/device/c630s/registers.hpp>

#include "program.hpp"

namespace c630s = servobus::c630s;

int main() {
    constexpr auto shared = servobus::settings_on_one_line<2400>(servobus::node<zlac::device>{1},
                                                                 servobus::node<c630s::device>{2}); // wrong
    (void)shared;
}
