// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats what is used of rclcpp_lifecycle::State (rclcpp_lifecycle 16, Humble; the same in Jazzy).
#pragma once

#include <cstdint>
#include <string>

namespace rclcpp_lifecycle {

class State {
  public:
    State(std::uint8_t id, const std::string& label) : label_{label}, id_{id} {}
    virtual ~State() = default;
    State(const State&) = default;
    State& operator=(const State&) = default;

    std::uint8_t id() const { return id_; }
    std::string label() const { return label_; }

  private:
    std::string label_;
    std::uint8_t id_;
};

} // namespace rclcpp_lifecycle
