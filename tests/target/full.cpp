// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of a node on a `line`, which has arbitration, an observer and steps that do not wait.
#include "board.hpp"
#include "job.hpp"

namespace {

using namespace servobus;
#ifndef OBSERVER
#define OBSERVER counters
#endif
using wire = line<uart, OBSERVER, unechoed>;

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
client<wire, zlac8015d::device> drive{line_1, node<zlac8015d::device>{1}};

} // namespace

extern "C" bool job() { return read_and_write(drive); }
