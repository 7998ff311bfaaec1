// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register's content as VALUE of `servobus write`, for commands that are printed to be typed.
#pragma once

#include <span>
#include <string>

#include "session.hpp"

namespace tool {

/// Codes and bits by their names, a number in the register's unit: `servo_on`, `x0+x1`, `12.5`. A content that no such
/// text gives is in hexadecimal. The high word of a pair is first.
std::string typed_value(const chosen& what, std::span<const u16> words);

/// `REG=VALUE`
std::string typed_assignment(const chosen& what, std::span<const u16> words);

} // namespace tool
