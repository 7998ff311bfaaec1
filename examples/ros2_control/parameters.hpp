// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads what the robot's URDF states of the hardware: the parameters of <hardware>, the joints and an optional sensor.
// A description that is wrong is refused as a whole, with one sentence that names the wrong part.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <system_error>
#include <vector>

#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"

namespace servobus_ros2_control {

/// The parameters, with their defaults. README.md has them as a table.
struct parameters {
    std::string port;
    std::uint32_t node = 1;
    std::uint32_t baud = 115200;
    std::uint32_t left_counts_per_turn = 0;
    std::uint32_t right_counts_per_turn = 0;
    std::uint32_t watchdog_ms = 500;
    std::uint32_t command_timeout_ms = 300;
    std::uint32_t acceleration = 50; ///< rad/s of a wheel in a second
    std::uint32_t deceleration = 50; ///< likewise
    std::uint32_t stop_ms = 500;
    std::uint32_t feedback_ms = 20;
    std::uint32_t response_ms = 50;
    bool left_mirrored = false;
    bool right_mirrored = false;
    bool reset_faults = false;
    bool rs485 = false;
};

/// The name of the interface that is 1 while the drive has a fault.
inline constexpr char is_faulted[] = "is_faulted";
/// The name of the interface that counts how often the positions went on without the way between.
inline constexpr char position_gaps[] = "position_gaps";

/// A description that was read, or why it is refused.
struct described_hardware {
    parameters chosen{};
    std::string error{}; ///< empty if the description is right
};

namespace detail {

struct number_parameter {
    const char* name;
    std::uint32_t parameters::*member;
    std::uint32_t low;
    std::uint32_t high;
    bool is_required;
};
inline constexpr std::array<number_parameter, 11> numbers{{
    {"node", &parameters::node, 1, 127, false},
    {"baud", &parameters::baud, 9600, 128000, false},
    {"left_counts_per_turn", &parameters::left_counts_per_turn, 4, 16384, true},
    {"right_counts_per_turn", &parameters::right_counts_per_turn, 4, 16384, true},
    {"watchdog_ms", &parameters::watchdog_ms, 1, 32767, false},
    {"command_timeout_ms", &parameters::command_timeout_ms, 50, 32767, false},
    {"acceleration", &parameters::acceleration, 1, 600, false},
    {"deceleration", &parameters::deceleration, 1, 600, false},
    {"stop_ms", &parameters::stop_ms, 0, 32767, false},
    {"feedback_ms", &parameters::feedback_ms, 5, 1000, false},
    {"response_ms", &parameters::response_ms, 10, 1000, false},
}};

struct switch_parameter {
    const char* name;
    bool parameters::*member;
};
inline constexpr std::array<switch_parameter, 4> switches{{
    {"left_mirrored", &parameters::left_mirrored},
    {"right_mirrored", &parameters::right_mirrored},
    {"reset_faults", &parameters::reset_faults},
    {"rs485", &parameters::rs485},
}};

inline std::string quoted(const std::string& text) { return "'" + text + "'"; }

// Returns an error, or an empty string.
inline std::string read_number(const number_parameter& p, const std::string& text, parameters& to) {
    std::uint32_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [stopped, failure] = std::from_chars(text.data(), end, value);
    if (failure == std::errc{} && stopped == end && value >= p.low && value <= p.high) {
        to.*p.member = value;
        return {};
    }
    return "parameter " + quoted(p.name) + ": " + quoted(text) + " is no whole number from " +
           std::to_string(p.low) + " to " + std::to_string(p.high);
}
// xacro writes True and False.
inline std::string read_switch(const switch_parameter& p, const std::string& text, parameters& to) {
    const bool is_true = text == "true" || text == "True";
    if (!is_true && text != "false" && text != "False")
        return "parameter " + quoted(p.name) + ": " + quoted(text) + " is neither true nor false";
    to.*p.member = is_true;
    return {};
}

inline std::string read_parameter(const std::string& name, const std::string& text, parameters& to) {
    if (name == "port") {
        to.port = text;
        return {};
    }
    for (const number_parameter& p : numbers) {
        if (name == p.name) return read_number(p, text, to);
    }
    for (const switch_parameter& p : switches) {
        if (name == p.name) return read_switch(p, text, to);
    }
    return "unknown parameter " + quoted(name);
}

inline std::string check_parameters(const hardware_interface::HardwareInfo& info, const parameters& p) {
    if (p.port.empty()) return "parameter 'port' is missing";
    for (const number_parameter& n : numbers) {
        if (n.is_required && info.hardware_parameters.count(n.name) == 0)
            return "parameter " + quoted(n.name) + " is missing";
    }
    bool has_rate = false;
    for (const std::uint32_t rate : {9600u, 19200u, 38400u, 57600u, 115200u, 128000u})
        has_rate = has_rate || p.baud == rate;
    if (!has_rate) return "parameter 'baud': the drive has no rate of " + std::to_string(p.baud);
    if (p.left_counts_per_turn % 4 != 0 || p.right_counts_per_turn % 4 != 0)
        return "counts per turn are 4 times the encoder's lines: a multiple of 4";
    return {};
}

using interfaces = std::vector<hardware_interface::InterfaceInfo>;

inline std::string check_joint(const hardware_interface::ComponentInfo& joint) {
    using namespace hardware_interface;
    const interfaces& commands = joint.command_interfaces;
    if (commands.size() != 1 || commands[0].name != HW_IF_VELOCITY)
        return "joint " + quoted(joint.name) + " needs one command interface, velocity";
    const interfaces& states = joint.state_interfaces;
    const auto is_pair = [&](const char* a, const char* b) {
        return states[0].name == a && states[1].name == b;
    };
    if (states.size() != 2 ||
        (!is_pair(HW_IF_POSITION, HW_IF_VELOCITY) && !is_pair(HW_IF_VELOCITY, HW_IF_POSITION)))
        return "joint " + quoted(joint.name) + " needs two state interfaces, position and velocity";
    return {};
}

inline std::string check_components(const hardware_interface::HardwareInfo& info) {
    if (info.joints.size() != 2)
        return "two joints are needed, the left wheel and then the right one; there are " +
               std::to_string(info.joints.size());
    for (const hardware_interface::ComponentInfo& joint : info.joints) {
        if (std::string error = check_joint(joint); !error.empty()) return error;
    }
    if (info.joints[0].name == info.joints[1].name)
        return "both joints are called " + quoted(info.joints[0].name);
    if (info.sensors.size() > 1) return "there is at most one sensor";
    for (const hardware_interface::ComponentInfo& sensor : info.sensors) {
        for (const hardware_interface::InterfaceInfo& one : sensor.state_interfaces) {
            if (one.name != is_faulted && one.name != position_gaps)
                return "sensor " + quoted(sensor.name) + " has no interface " + quoted(one.name);
        }
    }
    if (!info.gpios.empty()) return "there are no GPIOs";
    if (!info.transmissions.empty())
        return "transmissions are not applied: state the wheel's own counts per turn";
    return {};
}

} // namespace detail

/// Reads and checks a description. Nothing is opened.
inline described_hardware read_description(const hardware_interface::HardwareInfo& info) {
    described_hardware read;
    for (const auto& [name, text] : info.hardware_parameters) {
        read.error = detail::read_parameter(name, text, read.chosen);
        if (!read.error.empty()) return read;
    }
    read.error = detail::check_parameters(info, read.chosen);
    if (read.error.empty()) read.error = detail::check_components(info);
    return read;
}

} // namespace servobus_ros2_control
