// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a client does with rows of all four tables, and with functions 16h and 17h. any_device.hpp includes it.
//
//     const auto now = io.read<tank::level, tank::temperature, tank::valve>(); // io: a client of a tank
//     if (now && now->get<tank::level>() > 900 && !io.write<tank::valve>(true)) return 1;
//     if (!io.change_bits<tank::options, 0x000C>(0x0004)) return 1;
//     const auto after = io.write_then_read<rows<tank::state>, tank::ramp>(500 * millisecond);
#pragma once

#include <servobus/client/client.hpp>
#include <servobus/client/detail/table_calls.hpp>
#include <servobus/client/stepped_tables.hpp>
