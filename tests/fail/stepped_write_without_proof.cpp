// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stepped write that a C630S keeps in its EEPROM each time, without the proof that it does not now.
// EXPECT: every write of this register wears the drive's EEPROM: stepped_store it
// MEND: servobus::stepped_write<decltype(servo), c630s::target_speed> target{servo};
// (void)target.begin(300, *servo.ram_only());
#include <servobus/client/stepped_write.hpp>
#include <servobus/device/c630s/registers.hpp>

#include "program.hpp"

namespace c630s = servobus::c630s;

int main() {
    some_port port;
    servobus::line wire{port, servobus::modbus::timing_at(57600)};
    servobus::client servo{wire, servobus::node<c630s::device>{1}};
    servobus::stepped_write<decltype(servo), c630s::target_speed> target{servo};
    (void)target.begin(300); // wrong
}
