// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The findings about any device that a file describes.
#pragma once

#include "report.hpp"

namespace tool::diagnosis {

/// Reads every row that can be read. Reports those that the device does not give, values outside their range, and
/// values that are not the default. A device that refuses most rows is another one: that is the only finding then.
/// Returns what ended it before the last row.
servobus::status judge_rows(report& to, session& on, const target& of);

} // namespace tool::diagnosis
