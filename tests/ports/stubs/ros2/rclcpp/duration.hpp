// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats what the hardware interface and its tests use of rclcpp::Duration (rclcpp 16, Humble; the same in Jazzy).
#pragma once

#include <chrono>
#include <cstdint>

namespace rclcpp {

class Duration {
  public:
    explicit Duration(std::chrono::nanoseconds nanoseconds) : nanoseconds_{nanoseconds.count()} {}
    virtual ~Duration() = default;
    double seconds() const { return static_cast<double>(nanoseconds_) * 1e-9; }

  private:
    std::int64_t nanoseconds_;
};

} // namespace rclcpp
