// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Devices on one line that have no frame format in common: the wheels have 8N1 only, the gauge 8E1
// EXPECT: these devices have no frame format in common: they cannot share a line
// MEND: constexpr auto formats =
//  servobus::settings_on_one_line(servobus::node<gauge>{1}, servobus::node<c630s::device>{2});
#include <servobus/client/settings_on_one_line.hpp>

#include "gauge.hpp"
#include "program.hpp"

int main() {
    constexpr auto formats =
        servobus::settings_on_one_line(servobus::node<gauge>{1}, servobus::node<zlac::device>{2}); // wrong
    (void)formats;
}
