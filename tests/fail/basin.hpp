// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of a device with rows in all four tables, for the wrong programs about them.
#pragma once

#include <servobus/any_device.hpp>

#include "program.hpp"

namespace basin {
struct device {
    static constexpr servobus::profile facts{.name = "basin", .eeprom_switch = 0x0021};
};
using servobus::access, servobus::full, servobus::no_unit, servobus::u16;
inline constexpr servobus::coil<access::rw, device> valve{0x0003};
inline constexpr servobus::coil<access::rw, device> pump{0x0004};
inline constexpr servobus::coil<access::rw, device> lamp{0x0010};
inline constexpr servobus::coil<access::rw, device> night_light{0x0011, false, servobus::saved_on_write};
inline constexpr servobus::discrete_input<device> is_full{0x0003};
inline constexpr servobus::input_reg<u16, device> level{0x0000, full<u16>, no_unit, servobus::no_default};
inline constexpr servobus::reg<u16, access::rw, device> ramp{0x0003, {1, 100}, no_unit, 1};
inline constexpr servobus::reg<u16, access::rw, device> options{0x0004, full<u16>, no_unit, 0};
inline constexpr servobus::reg<u16, access::rw, device> kept{0x0006, full<u16>, no_unit, 0,
                                                             servobus::saved_on_write};
inline constexpr servobus::reg<servobus::i16, access::rw, device> depth{0x0005, {0, 32767}, no_unit, 0};
inline constexpr servobus::reg<servobus::u32, access::rw, device> wide{0x0020, full<servobus::u32>, no_unit,
                                                                       0};
inline constexpr servobus::reg_array<servobus::input_reg<u16, device>, 4> sensors{level, 1};
inline constexpr servobus::reg_array<servobus::coil<access::rw, device>, 4> lamps{{0x0020}, 1};
} // namespace basin

struct some_basin : servobus::client<servobus::line<some_port>, basin::device> {
    some_basin() : client{wire, servobus::node<basin::device>{1}} {}

  private:
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(115200)};
};
