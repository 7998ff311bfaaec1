// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a program may rely on whichever drive it has: the concept that every facade of the library satisfies. Programs
// for any drive include it, and the author of a drive checks the facade by it.
//
//     static_assert(motor_drive<zlac8015d::drive<line<posix::serial>>>);
//     template <motor_drive Drive> bool is_safe_to_leave(const Drive& drive) {
//         return Drive::traits.stops_without_line || drive.state() == drive_state::disabled;
//     }
#pragma once

#include <concepts>

#include <servobus/control/command_status.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/drive_traits.hpp>
#include <servobus/control/states.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// Feedback that says whether the drive has a fault and whether its motor moves.
template <class Feedback>
concept motor_feedback = requires(const Feedback& seen) {
    { seen.has_fault() } -> std::same_as<bool>;
    { seen.is_moving() } -> std::same_as<bool>;
};

namespace detail {
template <class Drive, class Command>
concept carries_out = requires(Drive& drive, const Command& wanted) {
    { drive.run(wanted) } -> std::same_as<command_status>;
    { drive.begin(wanted) } -> std::same_as<command_status>;
};
template <class Drive, class... Commands>
concept carries_out_all = (carries_out<Drive, Commands> && ...);
} // namespace detail

/// A drive that is taken over, enabled, stopped, reset, waited for and read by the common commands, blocking or
/// stepped.
template <class Drive>
concept motor_drive = detail::carries_out_all<Drive, init, enable, disable, halt, quick_stop, fault_reset,
                                              wait_standstill, wait_reached, read_feedback> &&
    requires(Drive& drive, const Drive& seen, duration oldest) {
    drive.step();
    { seen.is_idle() } -> std::same_as<bool>;
    { seen.is_absent() } -> std::same_as<bool>;
    { seen.last() } -> std::same_as<command_status>;
    { seen.state() } -> std::same_as<drive_state>;
    { seen.cause() } -> std::same_as<stop_cause>;
    { seen.arrival().how } -> std::convertible_to<arrival_state>;
    { *drive.read() } -> motor_feedback;
    { *seen.feedback(oldest) } -> motor_feedback;
    { Drive::traits } -> std::convertible_to<drive_traits>;
};

} // namespace servobus
