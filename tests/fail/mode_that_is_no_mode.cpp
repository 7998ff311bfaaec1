// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D has no operation in the mode `undefined`.
// EXPECT: this_drive_is_not_enabled_in_this_operating_mode
// MEND: constexpr auto on = zlac::enable_in{zlac::operating_mode::velocity};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

int main() {
    constexpr auto on = zlac::enable_in{zlac::operating_mode::undefined}; // wrong
    (void)on;
}
