// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The rows of a device as C++, and their entries in a catalogue.
#pragma once

#include <string>

#include <servobus/registers/catalogue.hpp>

namespace tool::cpp {

/// True if the named unit is one of meter_units.hpp.
constexpr bool is_of_meters(servobus::unit u) { return u.of > servobus::measure::radian_per_second; }

/// True if the row is more than an integer of one or two registers in the word order of its device.
bool has_form(const servobus::entry& e);

/// The definition of a row: `rw<servobus::u16> ratio{0x0030, {1, 1000}, servobus::units::times / 100, 100}`. `codes` is
/// the enumeration of its codes; empty if it has none. `scaled_by` is the row that scales it.
std::string row(const servobus::entry& e, servobus::table in, const std::string& name,
                const std::string& codes, const std::string& scaled_by = {});

/// The entry of a row in its catalogue. `row` is the row's full name, `names` that of the array of its names; empty if
/// it has none.
std::string row_entry(const servobus::entry& e, servobus::table in, const std::string& row,
                      const std::string& names);

} // namespace tool::cpp
