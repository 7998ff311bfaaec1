// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stepped call on a line that has blocking calls only.
// EXPECT: a blocking_line has blocking calls only: stepped calls need a line
// MEND: (void)servobus::stepped_read<decltype(drive), zlac::bus_voltage>{drive}.begin();
#include <servobus/client/stepped_read.hpp>
#include <servobus/line/blocking_line.hpp>

#include "program.hpp"

int main() {
    some_port port;
    servobus::blocking_line<some_port, servobus::modbus::timing_at(57600)> small{port};
    servobus::client waiting{small, servobus::node<zlac::device>{1}};
    (void)servobus::stepped_read<decltype(waiting), zlac::bus_voltage>{waiting}.begin(); // wrong
}
