// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Any Modbus device: rows of all four tables in a client, blocking and stepped, and functions 16h and 17h. Programs whose
// devices have more than holding registers include it after servobus.hpp; others pay nothing for it.
//
//     client io{wire, node<tank::device>{9}}; // tank: rows of a sensor with a pump, see registers/tables.hpp
//     const auto now = io.read<tank::level, tank::temperature, tank::pump>();
//     if (now && now->get<tank::level>() > 900 && !io.write<tank::pump>(true)) return 1;
#pragma once

#include <servobus/client/client.hpp>
#include <servobus/client/detail/table_calls.hpp>
#include <servobus/client/stepped_tables.hpp>
#include <servobus/registers/tables.hpp>
