// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The codes of a register as an enumeration of C++.
#pragma once

#include <string>

#include <servobus/registers/catalogue.hpp>

namespace tool::cpp {

/// True if all names of the register are codes, and its value is no quantity.
bool has_codes(const servobus::entry& e);

/// What follows the name of the enumeration: ` : std::uint16_t { off = 0, once = 1 };` in several lines. It is the same
/// for registers with the same codes.
std::string enumeration(const servobus::entry& e);

} // namespace tool::cpp
