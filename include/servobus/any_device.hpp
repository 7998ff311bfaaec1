// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Any Modbus device: rows of all four tables in a client, blocking and stepped, and functions 16h and 17h. Programs
// whose devices have more than holding registers include it after servobus.hpp; others pay nothing for it. It has the
// units of meters and sensors too.
//
//     client io{wire, node<tank::device>{9}}; // tank: rows of a sensor with a valve, see registers/tables.hpp
//     const auto level = io.read<tank::level>();
//     if (!level || !io.write<tank::valve>(*level > 900)) return 1;
#pragma once

#include <servobus/client/tables.hpp>
#include <servobus/registers/meter_units.hpp>
#include <servobus/registers/tables.hpp>
