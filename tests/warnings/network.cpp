// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client over each port of the network. This file is only compiled.
#include <servobus/client/client.hpp>
#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/line/line.hpp>
#include <servobus/line/reconnecting.hpp>
#include <servobus/posix/mbap.hpp>

using namespace servobus;

template <class Port> errc read_over(const char* host, const char* service, int& speed) {
    Port port;
    if (const status opened = port.open(host, service); !opened) return opened.error();
    line on{port, modbus::timing_at(115200)};
    client drive{on, node<zlac8015d::device>{1}};
    const auto found = drive.template read<zlac8015d::left_actual_speed>();
    if (!found) return found.error();
    speed = found->count();
    return errc::ok;
}
bool is_back(reconnecting<posix::mbap>& port) { return port.take_change() && port.is_open(); }
errc read_over_tcp(const char* host, int& speed) { return read_over<posix::tcp>(host, "4001", speed); }
errc read_over_mbap(const char* host, int& speed) { return read_over<posix::mbap>(host, "502", speed); }
