// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Says in words why a drive does not follow its commands: its state, the cause and the faults of both wheels.
#pragma once

#include <cstdint>
#include <string>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

namespace servobus_ros2_control {

/// Lists the faults of one wheel; "none" without a fault.
inline std::string list(servobus::zlac8015d::faults of) {
    std::string names;
    for (; of.any(); of.bits = static_cast<std::uint16_t>(of.bits & (of.bits - 1u)))
        names += (names.empty() ? "" : ", ") + std::string{text(of.first())};
    return names.empty() ? "none" : names;
}

/// Lists the faults in the last feedback.
template <class Drive> std::string faults_of(const Drive& drive) {
    const auto seen = drive.feedback(servobus::milliseconds(32'000));
    if (!seen) return "the drive's faults are not known";
    return "the drive has a fault: left " + list(seen->left_faults) + "; right " + list(seen->right_faults);
}

/// Returns why an enabled drive does not follow, or an empty string. `port_error`: of a port that is gone, else empty.
template <class Drive>
std::string trouble_of(const Drive& drive, const std::string& port_error, std::uint32_t watchdog_ms) {
    using servobus::drive_state;
    using servobus::stop_cause;
    const drive_state state = drive.state();
    const stop_cause cause = drive.cause();
    if (port_error.empty() && state == drive_state::enabled) return {};
    std::string why;
    if (!port_error.empty())
        why = "the port is gone (" + port_error + ")";
    else if (state == drive_state::faulted || cause == stop_cause::fault)
        why = faults_of(drive);
    else if (cause == stop_cause::input)
        why = "a wired stop, or another program, has stopped the drive";
    else if (cause == stop_cause::restart)
        why = "the drive has restarted, or was switched off";
    else if (drive.is_absent())
        why =
            "the drive did not respond for the time of its watchdog, " + std::to_string(watchdog_ms) + " ms";
    else
        why = std::string{"the outcome of a command is not known: "} + text(drive.last().error());
    return why + " [state: " + text(state) + ", cause: " + text(cause) + "]";
}

} // namespace servobus_ros2_control
