// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write to an array's element that a C630S keeps in its EEPROM, without the proof that it does not now.
// EXPECT: every write of this register wears the drive's EEPROM
// MEND: (void)servo.write<c630s::position_segment_speeds>(2, 300, *servo.ram_only());
#include <servobus/device/c630s/registers.hpp>

#include "program.hpp"

namespace c630s = servobus::c630s;

int main() {
    some_port port;
    servobus::line wire{port, servobus::modbus::timing_at(57600)};
    servobus::client servo{wire, servobus::node<c630s::device>{1}};
    (void)servo.write<c630s::position_segment_speeds>(2, 300); // wrong
}
