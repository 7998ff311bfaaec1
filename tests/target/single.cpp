// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// small.cpp, and function 06 with its read-back on a line that has proven nothing yet.
#include <servobus/line/blocking_line.hpp>

#include "board.hpp"
#include "job.hpp"

namespace {

using namespace servobus;
using wire = blocking_line<uart, modbus::timing_at(115200)>;

uart port_1;
wire line_1{port_1};
client drive{line_1, fixed_node<zlac8015d::device, 1>{}};

} // namespace

extern "C" bool job() {
    return drive.write<zlac8015d::control_word>(zlac8015d::command::stop) && read_and_write(drive);
}
