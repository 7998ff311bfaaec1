// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of a device with rows in all four tables, for the wrong programs about them.
#pragma once

#include <servobus/any_device.hpp>

#include "program.hpp"

namespace tank {
struct device {
    static constexpr servobus::profile facts{.name = "tank"};
};
using servobus::access, servobus::full, servobus::no_unit, servobus::u16;
inline constexpr servobus::coil<access::rw, device> valve{0x0003};
inline constexpr servobus::coil<access::rw, device> pump{0x0004};
inline constexpr servobus::coil<access::rw, device> lamp{0x0010};
inline constexpr servobus::discrete_input<device> is_full{0x0003};
inline constexpr servobus::input_reg<u16, device> level{0x0000, full<u16>, no_unit, servobus::no_default};
inline constexpr servobus::reg<u16, access::rw, device> ramp{0x0003, {1, 100}, no_unit, 1};
inline constexpr servobus::reg<u16, access::rw, device> options{0x0004, full<u16>, no_unit, 0};
} // namespace tank

struct some_tank : servobus::client<servobus::line<some_port>, tank::device> {
    some_tank() : client{wire, servobus::node<tank::device>{1}} {}

  private:
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(115200)};
};
