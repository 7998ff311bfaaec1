// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface with its defaults (rclcpp_lifecycle 16, Humble; the
// same in Jazzy): every callback succeeds but on_error, which fails.
#pragma once

#include <cstdint>

#include "rclcpp_lifecycle/state.hpp"

namespace rclcpp_lifecycle::node_interfaces {

class LifecycleNodeInterface {
  protected:
    LifecycleNodeInterface() {}

  public:
    // lifecycle_msgs::msg::Transition::TRANSITION_CALLBACK_*
    enum class CallbackReturn : std::uint8_t { SUCCESS = 97, FAILURE = 98, ERROR = 99 };

    virtual CallbackReturn on_configure(const State&) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_cleanup(const State&) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_shutdown(const State&) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_activate(const State&) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_deactivate(const State&) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_error(const State&) { return CallbackReturn::FAILURE; }
    virtual ~LifecycleNodeInterface() {}
};

} // namespace rclcpp_lifecycle::node_interfaces
