// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the check that a number is small, in three instructions.
//
//     static_assert(detail::is_beyond(-6, 5) && !detail::is_beyond(-5, 5));
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::detail {

/// True if `value` is outside -most .. most; most < 2^31.
constexpr bool is_beyond(std::int32_t value, std::uint32_t most) {
    return static_cast<std::uint32_t>(value) + most > 2 * most;
}

} // namespace servobus::detail
