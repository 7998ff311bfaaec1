// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of all four tables, the values of coils, and reads of several rows. Headers of devices that have more than
// holding registers include it; programs that have such a device include any_device.hpp.
//
//     struct gate { static constexpr profile facts{.name = "gate", .baud = 19200}; };
//     constexpr discrete_input<gate> is_closed{0x0000};
//     constexpr coil<access::rw, gate> motor{0x0000};
//     constexpr input_reg<u16, gate> cycles{0x0000, full<u16>, no_unit, no_default};
//     constexpr reg<u16, access::rw, gate> delay{0x0000, {0, 100}, units::second / 10, 20};
#pragma once

#include <servobus/registers/coil_value.hpp>
#include <servobus/registers/table_readings.hpp>
#include <servobus/registers/table_rows.hpp>
