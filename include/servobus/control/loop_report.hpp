// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Says what has ended in a setpoint loop, and how. control/setpoint_loop.hpp includes it.
//
//     void print(const loop_report& ended) { // "enable: the drive reports a fault"
//         std::printf("%s: %s\n", text(ended.what), text(ended.how.error()));
//         if (ended.what != loop_part::take_over) return;
//         std::printf("  at %s %u\n", text(ended.how.part()), ended.how.setting());
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/control/command_status.hpp>

namespace servobus {

/// What a setpoint loop begins.
enum class loop_part : std::uint8_t {
    none,
    take_over,   ///< by itself, at first and after each loss
    fault_reset, ///< after a consent
    enable,      ///< after a consent
    setpoint,    ///< every period, while motion is allowed
    command,     ///< which the program has begun through the loop
    stop,        ///< which the program has asked for
    permission, ///< to move, which a fault, a wired stop or a loss has ended; the drive's state and cause say which
    after_enable, ///< the commands between an enable and motion: the end of the last, or of the one that failed
};

constexpr const char* text(loop_part p) {
    switch (p) {
    case loop_part::none: return "nothing";
    case loop_part::take_over: return "take-over";
    case loop_part::fault_reset: return "fault reset";
    case loop_part::enable: return "enable";
    case loop_part::setpoint: return "setpoint";
    case loop_part::command: return "command";
    case loop_part::stop: return "stop";
    case loop_part::permission: return "permission to move";
    case loop_part::after_enable: return "after enable";
    }
    return "unknown";
}

/// An end that the program has not been told yet. It is true if there is one.
struct loop_report {
    loop_part what = loop_part::none;
    command_status how{}; ///< of a take-over also its part and setting; of `after_enable` `setting()`, from 1

    constexpr explicit operator bool() const { return what != loop_part::none; }
};

} // namespace servobus
