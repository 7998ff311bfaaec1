// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An invented device with rows in all four tables, and a model of it.
#pragma once

#include <cstdint>

#include <servobus/registers/profile.hpp>
#include <servobus/registers/tables.hpp>

#include <tests/support/plain_tables.hpp>

namespace tests::tank {

using namespace servobus;

struct device {
    static constexpr profile facts{.name = "tank", .max_read = 8, .max_write = 6};
};

inline constexpr coil<access::rw, device> valve{0x0003};
inline constexpr coil<access::rw, device> pump{0x0004};
inline constexpr coil<access::rw, device> heater{0x0005};
inline constexpr coil<access::rw, device> lamp{0x0010};
inline constexpr coil<access::wo, device> reset{0x0011};
inline constexpr discrete_input<device> is_full{0x0003};
inline constexpr discrete_input<device> is_door_open{0x0009};
inline constexpr input_reg<u16, device> level{0x0000, full<u16>, no_unit, no_default};
inline constexpr input_reg<i16, device> temperature{0x0001, full<i16>, units::degree_celsius / 10,
                                                    no_default};
inline constexpr input_reg<u32, device> volume{0x0002, full<u32>, no_unit, no_default};
inline constexpr reg<u16, access::rw, device> options{0x0000, full<u16>, no_unit, no_default};
inline constexpr reg<u16, access::rw, device> ramp{0x0003, {1, 5000}, units::millisecond, no_default};
inline constexpr reg<i32, access::rw, device> target{0x0004, full<i32>, no_unit, no_default};
inline constexpr reg<u16, access::ro, device> state{0x0006, full<u16>, no_unit, no_default};

/// Everything off and zero, and no address that has no row.
inline plain_tables model() {
    plain_tables m;
    for (const unsigned address : {0x03u, 0x04u, 0x05u, 0x10u, 0x11u}) m.coils[address] = false;
    for (const unsigned address : {0x03u, 0x09u}) m.discrete_inputs[address] = false;
    for (const unsigned address : {0u, 1u, 2u, 3u}) m.input_registers[address] = 0;
    for (const unsigned address : {0u, 3u, 4u, 5u, 6u}) m.holding_registers[address] = 0;
    return m;
}

} // namespace tests::tank
