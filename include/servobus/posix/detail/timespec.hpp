// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: a duration as the system takes it.
#pragma once

#include <time.h>

#include <servobus/core/time.hpp>

namespace servobus::posix::detail {

inline timespec to_timespec(duration d) {
    timespec t{};
    t.tv_sec = static_cast<time_t>(d.us / 1'000'000u);
    t.tv_nsec = static_cast<long>(d.us % 1'000'000u) * 1000;
    return t;
}

} // namespace servobus::posix::detail
