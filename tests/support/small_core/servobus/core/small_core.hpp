// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// In the place of the library's header of this name: its tests run the code of small cores on a host.
#pragma once

namespace servobus::detail {

inline constexpr bool is_small_core = true;

} // namespace servobus::detail
