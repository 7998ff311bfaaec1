// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: whether the program is for a core that has more time than flash, so that code is shared there which a
// host has inlined. Tests put `true` in its place, to run that code on a host.
//
//     if constexpr (detail::is_small_core) return 1; // here as small as possible
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>

namespace servobus::detail {

inline constexpr bool is_small_core = sizeof(std::size_t) < 8;

} // namespace servobus::detail
