// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A node of constants on a line whose nodes are variables.
// EXPECT: a fixed_node is for a blocking_line
// MEND: servobus::client servo{wire, servobus::node<c630s::device>{1}};
#include <servobus/device/c630s/registers.hpp>

#include "program.hpp"

namespace c630s = servobus::c630s;

int main() {
    some_port port;
    servobus::line wire{port, servobus::modbus::timing_at(57600)};
    servobus::client servo{wire, servobus::fixed_node<c630s::device, 1>{}}; // wrong
    (void)servo.read_words(0, {});
}
