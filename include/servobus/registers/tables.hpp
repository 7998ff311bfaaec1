// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of all four tables, the values of coils, and reads of several rows. Headers of devices that have more than holding
// registers include it; programs that have such a device include any_device.hpp.
#pragma once

#include <servobus/registers/coil_value.hpp>
#include <servobus/registers/table_readings.hpp>
#include <servobus/registers/table_rows.hpp>
