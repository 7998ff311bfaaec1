// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The reads that every drive's rule of "at rest" shares.
#pragma once

#include <array>
#include <cstddef>

#include "session.hpp"

namespace tool {

/// Reads registers that the tool needs for itself.
template <std::size_t Count>
servobus::status read_words(session& on, u16 address, std::array<u16, Count>& words) {
    return on.read(chosen{"", address, static_cast<u16>(Count), nullptr}, words);
}

inline bool is_ok(const servobus::status& why) { return why.error() == servobus::errc::ok; }

} // namespace tool
