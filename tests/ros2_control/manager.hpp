// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Acts as ros2_control's controller manager: makes the transitions of a component, and calls its read and write as the
// framework's loop does. It follows System of hardware_interface/src/system.cpp (Humble).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hardware_interface/system_interface.hpp"
#include "lifecycle_msgs/msg/state.hpp"
#include "rclcpp/rclcpp.hpp"

namespace manager {

using hardware_interface::CallbackReturn;
using hardware_interface::return_type;
using primary = lifecycle_msgs::msg::State;

inline double value_of(const hardware_interface::StateInterface& of) {
#ifdef STAND_IN_JAZZY
    return *of.get_optional();
#else
    return of.get_value();
#endif
}

/// The argument that the framework gives to `on_init`.
#ifdef STAND_IN_JAZZY
inline hardware_interface::HardwareComponentInterfaceParams
parameters_of(const hardware_interface::HardwareInfo& info) {
    hardware_interface::HardwareComponentInterfaceParams given;
    given.hardware_info = info;
    return given;
}
#else
inline const hardware_interface::HardwareInfo& parameters_of(const hardware_interface::HardwareInfo& info) {
    return info;
}
#endif

/// A component with its state, as the framework's resource manager keeps it.
class component {
  public:
    explicit component(hardware_interface::SystemInterface& of) : of_{of} {}

    std::uint8_t state() const { return state_; }
    bool is_active() const { return state_ == primary::PRIMARY_STATE_ACTIVE; }
    unsigned errors() const { return errors_; }

    void initialise(const hardware_interface::HardwareInfo& info) {
        change(of_.on_init(parameters_of(info)), primary::PRIMARY_STATE_UNCONFIGURED,
               primary::PRIMARY_STATE_FINALIZED);
        if (state_ != primary::PRIMARY_STATE_UNCONFIGURED) return;
        states_ = of_.export_state_interfaces();
        commands_ = of_.export_command_interfaces();
    }
    void configure() {
        if (state_ != primary::PRIMARY_STATE_UNCONFIGURED) return;
        change(of_.on_configure(now_in()), primary::PRIMARY_STATE_INACTIVE,
               primary::PRIMARY_STATE_UNCONFIGURED);
    }
    void activate() {
        if (state_ != primary::PRIMARY_STATE_INACTIVE) return;
        change(of_.on_activate(now_in()), primary::PRIMARY_STATE_ACTIVE, primary::PRIMARY_STATE_INACTIVE);
    }
    void deactivate() {
        if (state_ != primary::PRIMARY_STATE_ACTIVE) return;
        change(of_.on_deactivate(now_in()), primary::PRIMARY_STATE_INACTIVE, primary::PRIMARY_STATE_ACTIVE);
    }
    void clean_up() {
        change(of_.on_cleanup(now_in()), primary::PRIMARY_STATE_UNCONFIGURED,
               primary::PRIMARY_STATE_INACTIVE);
    }
    void shut_down() {
        change(of_.on_shutdown(now_in()), primary::PRIMARY_STATE_FINALIZED, primary::PRIMARY_STATE_FINALIZED);
    }

    return_type read() { return call(&hardware_interface::SystemInterface::read); }
    return_type write() { return call(&hardware_interface::SystemInterface::write); }

    void command(double left, double right) {
        (void)commands_[0].set_value(left);
        (void)commands_[1].set_value(right);
    }
    /// The value of "joint/interface".
    double value(const std::string& name) const {
        for (const auto& one : states_) {
            if (one.get_name() == name) return value_of(one);
        }
        return -1e300;
    }
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& one : states_) all.push_back(one.get_name());
        for (const auto& one : commands_) all.push_back(one.get_name());
        return all;
    }

  private:
    using transfer = return_type (hardware_interface::SystemInterface::*)(const rclcpp::Time&,
                                                                          const rclcpp::Duration&);

    rclcpp_lifecycle::State now_in() const { return {state_, ""}; }
    void change(CallbackReturn how, std::uint8_t success, std::uint8_t failure) {
        if (how == CallbackReturn::SUCCESS)
            state_ = success;
        else if (how == CallbackReturn::FAILURE || state_ == primary::PRIMARY_STATE_UNKNOWN)
            state_ = failure;
        else
            fail();
    }
    void fail() {
        ++errors_;
        state_ = of_.on_error(now_in()) == CallbackReturn::SUCCESS ? primary::PRIMARY_STATE_UNCONFIGURED
                                                                   : primary::PRIMARY_STATE_FINALIZED;
    }
    return_type call(transfer what) {
        if (state_ != primary::PRIMARY_STATE_INACTIVE && state_ != primary::PRIMARY_STATE_ACTIVE)
            return return_type::OK;
        const return_type how = (of_.*what)(rclcpp::Time{}, rclcpp::Duration{std::chrono::milliseconds{10}});
        if (how == return_type::ERROR) fail();
        return how;
    }

    hardware_interface::SystemInterface& of_;
    std::vector<hardware_interface::StateInterface> states_{};
    std::vector<hardware_interface::CommandInterface> commands_{};
    unsigned errors_ = 0;
    std::uint8_t state_ = primary::PRIMARY_STATE_UNKNOWN;
};

} // namespace manager
