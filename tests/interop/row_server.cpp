// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of rows, all four tables, on a pseudo-terminal, until it is killed.   row_server LINK
#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/server/host_row_server.hpp>

#include <examples/own_device/hoist_server.hpp>

#include "registers.hpp"

using namespace servobus;

int main(int, char** words) {
    posix::pseudo_terminal port;
    if (port.open(words[1]) != errc::ok) return 1;
    hoist::values values;
    values.set<hoist::position>(-100'000 * units::pulse);
    host_row_server<posix::pseudo_terminal, hoist::values, with_mask_write, with_read_write> server{
        port, values, interop::node_address, modbus::timing_at(interop::baud)};
    while (true) {
        port.wait(server.is_answering() ? microseconds(200) : milliseconds(5));
        server.step();
    }
}
