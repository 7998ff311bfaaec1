// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The sensor of a cell, an invented device. Its client and its server share these rows.
#pragma once

#include <servobus/registers/profile.hpp>
#include <servobus/registers/tables.hpp>

namespace tests::cell_sensor {

using namespace servobus;

struct device {
    static constexpr profile facts{.name = "cell sensor", .baud = 115200};
};

// clang-format off
inline constexpr input_reg<u16, device>         distance     {0x0000, full<u16>, no_unit,                    0}; // mm
inline constexpr input_reg<i16, device>         temperature  {0x0001, full<i16>, units::degree_celsius / 10, 200};
inline constexpr discrete_input<device>         is_door_open {0x0000};
inline constexpr discrete_input<device>         is_guarded   {0x0001, true};
inline constexpr coil<access::rw, device>       lamp         {0x0000};
// clang-format on

} // namespace tests::cell_sensor
