// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The program of full.cpp with echo handling.
#include "board.hpp"
#include "job.hpp"

namespace {

using namespace servobus;
using wire = line<uart, counters, echoed>;

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
client<wire, zlac8015d::device> drive{line_1, node<zlac8015d::device>{1}};

} // namespace

extern "C" bool job() { return read_and_write(drive); }
