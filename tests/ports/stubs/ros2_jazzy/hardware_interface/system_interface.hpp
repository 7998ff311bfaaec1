// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the base class of a hardware with several joints, and its defaults (hardware_interface 4.46.0, Jazzy),
// without its node, its asynchronous thread and the interfaces that the framework exports itself.
#pragma once

#include <string>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/types/hardware_component_interface_params.hpp"
#include "hardware_interface/types/hardware_interface_return_values.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "lifecycle_msgs/msg/state.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/logger.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"
#include "rclcpp_lifecycle/state.hpp"

namespace hardware_interface {

using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

class HardwareComponentInterface : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
  public:
    HardwareComponentInterface()
        : lifecycle_state_{lifecycle_msgs::msg::State::PRIMARY_STATE_UNKNOWN, "unknown"} {}
    HardwareComponentInterface(const HardwareComponentInterface& other) = delete;
    HardwareComponentInterface(HardwareComponentInterface&& other) = delete;
    virtual ~HardwareComponentInterface() = default;

    [[deprecated(
        "Use on_init(const HardwareComponentInterfaceParams & params) instead.")]] virtual CallbackReturn
    on_init(const HardwareInfo& hardware_info) {
        info_ = hardware_info;
        return CallbackReturn::SUCCESS;
    }
    virtual CallbackReturn on_init(const HardwareComponentInterfaceParams& params) {
        return on_init(params.hardware_info);
    }
    [[deprecated("Replaced by vector<StateInterface::ConstSharedPtr> on_export_state_interfaces() method. "
                 "Exporting is handled by the Framework.")]] virtual std::vector<StateInterface>
    export_state_interfaces() {
        return {};
    }
    [[deprecated("Replaced by vector<CommandInterface::SharedPtr> on_export_command_interfaces() method. "
                 "Exporting is handled by the Framework.")]] virtual std::vector<CommandInterface>
    export_command_interfaces() {
        return {};
    }
    virtual return_type prepare_command_mode_switch(const std::vector<std::string>&,
                                                    const std::vector<std::string>&) {
        return return_type::OK;
    }
    virtual return_type perform_command_mode_switch(const std::vector<std::string>&,
                                                    const std::vector<std::string>&) {
        return return_type::OK;
    }
    virtual return_type read(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;
    virtual return_type write(const rclcpp::Time&, const rclcpp::Duration&) { return return_type::OK; }

    const HardwareInfo& get_hardware_info() const { return info_; }
    const rclcpp_lifecycle::State& get_lifecycle_state() const { return lifecycle_state_; }
    void set_lifecycle_state(const rclcpp_lifecycle::State& new_state) { lifecycle_state_ = new_state; }

  protected:
    HardwareInfo info_;
    rclcpp_lifecycle::State lifecycle_state_;
};

class SystemInterface : public HardwareComponentInterface {
  public:
    return_type write(const rclcpp::Time& time, const rclcpp::Duration& period) override = 0;
};

} // namespace hardware_interface
