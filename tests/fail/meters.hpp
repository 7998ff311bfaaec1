// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of a device with floats, text, parts of registers and values that may be none, for the wrong programs about
// them.
#pragma once

#include <servobus/any_value.hpp>

#include "program.hpp"

namespace meters {
struct device {
    static constexpr servobus::profile facts{.name = "meters"};
};
using namespace servobus;
template <class T> using ro = reg<T, access::ro, device>;
template <class T> using rw = reg<T, access::rw, device>;
inline constexpr input_reg<f32, device> voltage{0x0000, full<f32>, units::volt, no_default};
inline constexpr rw<f32> target{0x0010, {-20, 400}, units::degree_celsius, 21};
inline constexpr rw<text_of<4>> name{0x0020, full<text_of<4>>, no_unit, no_default};
inline constexpr rw<with<u16, bits<0, 3>>> mode{0x0040, full<u16>, no_unit, no_default};
inline constexpr rw<with<u16, bits<4, 15>>> level{0x0040, {0, 1000}, units::percent / 10, no_default};
inline constexpr rw<u16> mode_and_level{0x0040, full<u16>, no_unit, no_default};
inline constexpr ro<with<i32, or_none<-0x8000'0000ll>>> power{0x0050, full<i32>, units::watt, no_default};
inline constexpr ro<i16> exponent{0x0060, full<i16>, no_unit, no_default};
inline constexpr ro<with<u16, ten_to<exponent>>> current{0x0061, full<u16>, units::ampere, no_default};
inline constexpr ro<u16> tenths{0x0062, full<u16>, units::ampere / 10, no_default};
} // namespace meters

struct some_meters : servobus::client<servobus::line<some_port>, meters::device> {
    some_meters() : client{wire, servobus::node<meters::device>{1}} {}

  private:
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(115200)};
};
