// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the constants of the message lifecycle_msgs/State (Humble; the same in Jazzy).
#pragma once

#include <cstdint>

namespace lifecycle_msgs::msg {

struct State {
    static constexpr std::uint8_t PRIMARY_STATE_UNKNOWN = 0;
    static constexpr std::uint8_t PRIMARY_STATE_UNCONFIGURED = 1;
    static constexpr std::uint8_t PRIMARY_STATE_INACTIVE = 2;
    static constexpr std::uint8_t PRIMARY_STATE_ACTIVE = 3;
    static constexpr std::uint8_t PRIMARY_STATE_FINALIZED = 4;
};

} // namespace lifecycle_msgs::msg
