// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of one node on a blocking line: the smallest program that keeps the promises.
#include <servobus/line/blocking_line.hpp>
#include <servobus/modbus/crc_tables.hpp>

#include "board.hpp"
#include "job.hpp"

#ifndef CRC
#define CRC default_crc
#endif
#ifndef TIMING
#define TIMING host
#endif

namespace {

using namespace servobus;
using wire = blocking_line<uart, modbus::timing_at(115200, modbus::timing_mode::TIMING), milliseconds(100),
                           modbus::CRC>;

#ifdef WITHOUT_RETRIES
struct wheels : zlac8015d::device {
    static constexpr profile facts = [] {
        profile f = zlac8015d::device::facts;
        f.read_retries = 0;
        return f;
    }();
};
#else
using wheels = zlac8015d::device;
#endif

uart port_1;
wire line_1{port_1};
client drive{line_1, fixed_node<wheels, 1>{}};
static_assert(sizeof line_1 + sizeof drive <= 40);

} // namespace

extern "C" bool job() { return read_and_write(drive); }
