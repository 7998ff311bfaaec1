// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A float of a device in a program that has not the header of such values.
// ALONE
// EXPECT: servobus/any_value.hpp has other values
// MEND: #include <servobus/any_value.hpp>
#include <servobus/client/client.hpp>

#include "program.hpp"

struct meter {
    static constexpr servobus::profile facts{.name = "meter"};
};
inline constexpr servobus::reg<float, servobus::access::ro, meter> voltage{
    0x0000, {0, 400}, servobus::units::volt, servobus::no_default};

int main() {
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(115200)};
    servobus::client io{wire, servobus::node<meter>{1}};
    (void)io.read<voltage>(); // wrong
}
