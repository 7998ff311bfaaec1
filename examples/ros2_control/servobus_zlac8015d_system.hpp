// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Adapts a ZLAC8015D with two wheels to ros2_control: the hardware interface of a differential drive, in rad and rad/s.
// Its `on_init` is that of the installed release, Humble, Jazzy or Rolling. Its `export_*_interfaces()` are those of
// Humble, which the others call as well.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/system_interface.hpp"
#include "hardware_interface/types/hardware_interface_return_values.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp_lifecycle/state.hpp"
#if __has_include("hardware_interface/types/hardware_component_interface_params.hpp") // not in Humble
#include "hardware_interface/types/hardware_component_interface_params.hpp"
#endif

#include <servobus/posix/serial.hpp>

#include "parameters.hpp"
#include "robot_hardware.hpp"

namespace servobus_ros2_control {

/// The hardware interface over a port that has what posix::serial has; tests use a simulated one.
///
///     unconfigured --on_configure--> inactive --on_activate--> active --on_deactivate--> inactive
///     active --read() or write() returns an error--> on_error --> unconfigured
template <class Port> class basic_zlac8015d_system : public hardware_interface::SystemInterface {
    using state = rclcpp_lifecycle::State;
    using return_type = hardware_interface::return_type;
#if __has_include("hardware_interface/types/hardware_component_interface_params.hpp")
    using init_parameters = hardware_interface::HardwareComponentInterfaceParams;
#else
    using init_parameters = hardware_interface::HardwareInfo;
#endif

  public:
    using CallbackReturn = hardware_interface::CallbackReturn;

    basic_zlac8015d_system() = default;
    /// Stops an active drive: Humble destroys components without `on_shutdown`.
    ~basic_zlac8015d_system() override { (void)stop(); }

    using SystemInterface::on_init; // Jazzy has both forms
    CallbackReturn on_init(const init_parameters& given) override {
        if (SystemInterface::on_init(given) != CallbackReturn::SUCCESS) return CallbackReturn::ERROR;
        const described_hardware read = read_description(info_);
        if (!read.error.empty()) return fail(read.error, CallbackReturn::ERROR);
        chosen_ = read.chosen;
        return CallbackReturn::SUCCESS;
    }

    std::vector<hardware_interface::StateInterface> export_state_interfaces() override {
        using namespace hardware_interface;
        std::vector<StateInterface> all;
        for (std::size_t i = 0; i < 2; ++i) {
            all.emplace_back(info_.joints[i].name, HW_IF_POSITION, &positions_[i]);
            all.emplace_back(info_.joints[i].name, HW_IF_VELOCITY, &velocities_[i]);
        }
        for (const ComponentInfo& sensor : info_.sensors) {
            for (const InterfaceInfo& one : sensor.state_interfaces)
                all.emplace_back(sensor.name, one.name, one.name == is_faulted ? &is_faulted_ : &gaps_);
        }
        return all;
    }
    std::vector<hardware_interface::CommandInterface> export_command_interfaces() override {
        std::vector<hardware_interface::CommandInterface> all;
        for (std::size_t i = 0; i < 2; ++i)
            all.emplace_back(info_.joints[i].name, hardware_interface::HW_IF_VELOCITY, &commands_[i]);
        return all;
    }

    CallbackReturn on_configure(const state&) override {
        if (const std::string error = robot_.open(chosen_); !error.empty())
            return fail(error, CallbackReturn::FAILURE);
        return CallbackReturn::SUCCESS;
    }
    /// Waits for the drive; the loop must not call it. A drive that cannot be taken over leaves the component inactive.
    CallbackReturn on_activate(const state&) override {
        commands_[0] = commands_[1] = 0;
        is_reported_ = false;
        const std::string error = robot_.activate();
        publish();
        if (!error.empty()) return fail(error, CallbackReturn::FAILURE);
        is_active_ = true;
        RCLCPP_INFO(logger(), "%s: the drive is enabled on %s", info_.name.c_str(), chosen_.port.c_str());
        return CallbackReturn::SUCCESS;
    }
    /// Returns success only if both wheels stand.
    CallbackReturn on_deactivate(const state&) override {
        is_active_ = false;
        const std::string error = robot_.deactivate();
        publish();
        return error.empty() ? CallbackReturn::SUCCESS : fail(error, CallbackReturn::ERROR);
    }
    CallbackReturn on_cleanup(const state&) override {
        robot_.close();
        return CallbackReturn::SUCCESS;
    }
    CallbackReturn on_shutdown(const state&) override {
        return stop() ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
    }
    /// Stops the drive as far as it can be reached, and closes the port. The framework calls it in its loop, which
    /// waits meanwhile for the ramp and 3 s at most.
    CallbackReturn on_error(const state&) override {
        is_active_ = robot_.is_open(); // an activation that has failed may have left it energised
        (void)stop();
        return CallbackReturn::SUCCESS;
    }

    /// Takes the newest feedback; does not wait.
    return_type read(const rclcpp::Time&, const rclcpp::Duration&) override {
        robot_.read();
        publish();
        if (is_active_) return report(robot_.trouble());
        if (robot_.take_loss())
            RCLCPP_WARN(logger(), "%s: the inactive drive has restarted or does not respond",
                        info_.name.c_str());
        return return_type::OK;
    }
    /// Gives the drive the latest command; does not wait.
    return_type write(const rclcpp::Time&, const rclcpp::Duration&) override {
        if (!is_active_) return return_type::OK;
        std::string error = robot_.write(commands_[0], commands_[1]);
        if (std::string trouble = robot_.trouble(); !trouble.empty()) error = trouble;
        return report(error);
    }

  private:
    static rclcpp::Logger logger() { return rclcpp::get_logger("servobus_ros2_control"); }

    CallbackReturn fail(const std::string& error, CallbackReturn how) const {
        RCLCPP_ERROR(logger(), "%s: %s", info_.name.c_str(), error.c_str());
        return how;
    }
    // An error is logged once: a framework that goes on calling does not fill the log.
    return_type report(const std::string& error) {
        if (error.empty()) return return_type::OK;
        if (!is_reported_) RCLCPP_ERROR(logger(), "%s: %s", info_.name.c_str(), error.c_str());
        is_reported_ = true;
        return return_type::ERROR;
    }
    // False if an active drive was not seen to stand.
    bool stop() {
        std::string error;
        if (is_active_) error = robot_.deactivate();
        is_active_ = false;
        robot_.close();
        publish();
        if (error.empty()) return true;
        RCLCPP_ERROR(logger(), "%s: %s", info_.name.c_str(), error.c_str());
        return false;
    }
    void publish() {
        for (std::size_t i = 0; i < 2; ++i) {
            positions_[i] = robot_.position(i);
            velocities_[i] = robot_.velocity(i);
        }
        is_faulted_ = robot_.has_fault() ? 1 : 0;
        gaps_ = robot_.gaps();
    }

    robot_hardware<Port> robot_{};
    parameters chosen_{};
    double positions_[2]{}; // rad
    double velocities_[2]{};
    double commands_[2]{}; // rad/s
    double is_faulted_ = 0;
    double gaps_ = 0;
    bool is_active_ = false;
    bool is_reported_ = false;
};

/// The plugin.
class Zlac8015dSystem : public basic_zlac8015d_system<servobus::posix::serial> {};

} // namespace servobus_ros2_control
