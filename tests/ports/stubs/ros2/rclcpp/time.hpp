// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats what the hardware interface and its tests use of rclcpp::Time (rclcpp 16, Humble; the same in Jazzy).
#pragma once

#include <cstdint>

enum rcl_clock_type_t { RCL_CLOCK_UNINITIALIZED = 0, RCL_ROS_TIME, RCL_SYSTEM_TIME, RCL_STEADY_TIME };

namespace rclcpp {

class Time {
  public:
    explicit Time(std::int64_t nanoseconds = 0, rcl_clock_type_t = RCL_SYSTEM_TIME)
        : nanoseconds_{nanoseconds} {}
    virtual ~Time() = default;
    std::int64_t nanoseconds() const { return nanoseconds_; }

  private:
    std::int64_t nanoseconds_;
};

} // namespace rclcpp
