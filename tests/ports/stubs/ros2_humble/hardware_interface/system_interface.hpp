// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the base class of a hardware with several joints, and its defaults (hardware_interface 2.54.0, Humble).
#pragma once

#include <string>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/types/hardware_interface_return_values.hpp"
#include "lifecycle_msgs/msg/state.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"
#include "rclcpp_lifecycle/state.hpp"

namespace hardware_interface {

using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

class SystemInterface : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
  public:
    SystemInterface() : lifecycle_state_{lifecycle_msgs::msg::State::PRIMARY_STATE_UNKNOWN, "unknown"} {}
    SystemInterface(const SystemInterface& other) = delete;
    SystemInterface(SystemInterface&& other) = default;
    virtual ~SystemInterface() = default;

    virtual CallbackReturn on_init(const HardwareInfo& hardware_info) {
        info_ = hardware_info;
        return CallbackReturn::SUCCESS;
    }
    virtual std::vector<StateInterface> export_state_interfaces() = 0;
    virtual std::vector<CommandInterface> export_command_interfaces() = 0;
    virtual return_type prepare_command_mode_switch(const std::vector<std::string>&,
                                                    const std::vector<std::string>&) {
        return return_type::OK;
    }
    virtual return_type perform_command_mode_switch(const std::vector<std::string>&,
                                                    const std::vector<std::string>&) {
        return return_type::OK;
    }
    virtual return_type read(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;
    virtual return_type write(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;

    virtual std::string get_name() const { return info_.name; }
    const rclcpp_lifecycle::State& get_state() const { return lifecycle_state_; }
    void set_state(const rclcpp_lifecycle::State& new_state) { lifecycle_state_ = new_state; }

  protected:
    HardwareInfo info_;
    rclcpp_lifecycle::State lifecycle_state_;
};

} // namespace hardware_interface
