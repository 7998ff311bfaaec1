// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The program of small.cpp, and before it function 06, which is read back since the line has not yet ruled
// out an echo.
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
    return drive.write<zlac8015d::control_word>(zlac8015d::control_code::stop) && read_and_write(drive);
}
