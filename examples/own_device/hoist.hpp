// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device of your own, on both sides: its client and its server include this header. hoist_server.hpp is the device.
// The device here, a hoist, is invented. A client of it:
//
//     servobus::client<decltype(line), hoist::device> io{line, servobus::node<hoist::device>{7}};
//     if (!io.write<hoist::ramp, hoist::target>(500 * millisecond, checked(wanted))) return;
#pragma once

#include <cstdint>

#include <servobus/registers/profile.hpp>
#include <servobus/registers/tables.hpp>

namespace hoist {

/// The device's profile. Members that are not set here have the values of the Modbus standard.
struct device {
    static constexpr servobus::profile facts{.name = "hoist", .baud = 115200};
};

/// Values of the register `operating_mode`.
enum class mode : std::uint16_t { off, jog, move };

template <servobus::wire_value T> using ro = servobus::reg<T, servobus::access::ro, device>;
template <servobus::wire_value T> using rw = servobus::reg<T, servobus::access::rw, device>;
template <servobus::wire_value T> using input = servobus::input_reg<T, device>;
using coil = servobus::coil<servobus::access::rw, device>;

using servobus::i16, servobus::i32, servobus::u16, servobus::full, servobus::no_unit;
namespace units = servobus::units;

// clang-format off
inline constexpr rw<mode> operating_mode {0x0000, {0, 2},                  no_unit,             0};
inline constexpr rw<i16>  speed          {0x0001, {-600, 600},             units::r_per_min,    0};
inline constexpr rw<u16>  ramp           {0x0002, {10, 5000},              units::millisecond,  500};
inline constexpr rw<i32>  target         {0x0003, {-1'000'000, 1'000'000}, units::pulse,        0, servobus::motion};
inline constexpr rw<u16>  current_limit  {0x0005, {0, 250},                units::ampere / 10,  100};
inline constexpr rw<u16>  options        {0x0006, full<u16>,               no_unit,             0};
inline constexpr ro<u16>  status_word    {0x0007, full<u16>,               no_unit,             0};
inline constexpr ro<i32>  position       {0x0008, full<i32>,               units::pulse,        0};
inline constexpr ro<u16>  load           {0x000A, full<u16>,               units::ampere / 10,  0};
inline constexpr ro<u16>  fault          {0x000B, full<u16>,               no_unit,             0};

inline constexpr input<i16> temperature  {0x0000, full<i16>,               units::degree_celsius, 25};
inline constexpr input<u16> voltage      {0x0001, full<u16>,               units::volt / 100,   2400};

inline constexpr coil pump {0x0000}, fan {0x0001}, lamp {0x0002}, horn {0x0003};
// clang-format on

} // namespace hoist
