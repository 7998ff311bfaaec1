// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program over a port, for a compiler of small cores. It is built and its symbols are checked, but it is
// not run.
#pragma once

#include <servobus/client/client.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>

namespace program {

struct device {
    static constexpr servobus::profile facts{.name = "node"};
};
inline constexpr servobus::reg<servobus::u16, servobus::access::rw, device> level{
    0x0010, servobus::full<servobus::u16>, servobus::no_unit, 0};

/// Reads a register and writes its value plus one.
template <class Port> bool count_up(Port& port) {
    servobus::line wire{port, servobus::modbus::timing_at(115200)};
    servobus::client<decltype(wire), device> client{wire, servobus::node<device>{1}};
    const auto seen = client.template read<level>();
    return seen && client.template write<level>(servobus::checked(*seen + 1));
}

} // namespace program
