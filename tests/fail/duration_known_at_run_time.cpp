// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A duration that is not known before run time may be no whole number of milliseconds.
// EXPECT: constant expression
// MEND: (void)zlac::watchdog{some_number() * units::millisecond};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

int main() {
    servobus::duration time = servobus::milliseconds(static_cast<std::uint32_t>(some_number()));
    (void)(zlac::watchdog{time}); // wrong
}
