// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The findings about any device that a file describes.
#pragma once

#include "report.hpp"

namespace tool::diagnosis {

/// The first row that can be read, to ask whether the device responds; null if there is none.
struct first_row {
    const servobus::entry* row = nullptr;
    servobus::table in = servobus::table::holding_registers;
};
first_row first_readable(const device& of);

/// Reads every row that can be read. Reports those that the device does not give, values outside their range, and
/// values that are not the default. Returns what ended it before the last row.
servobus::status judge_rows(report& to, session& on, const target& of);

} // namespace tool::diagnosis
