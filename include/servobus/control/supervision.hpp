// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a facade supervises its drive while the program steps it: how often it reads the feedback, and after
// how long without a motion command it stops the drive. Programs pass it to the facade of a drive.
//
//     zlac8015d::drive wheels{wire, 1, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};
//     yako::closed_loop::drive lift{wire, 2}; // its own moves end by themselves
#pragma once

#include <servobus/core/time.hpp>

namespace servobus {

/// After so long without a motion command a motion that does not end by itself is stopped. Polling keeps the drive's own
/// watchdog from expiring even if the program has stopped commanding: so for such a drive one is stated, or none by
/// name.
class command_timeout {
  public:
    template <bool IsStated = false> constexpr command_timeout() {
        static_assert(IsStated, "this drive needs a command timeout, or no_command_timeout by name");
    }
    constexpr command_timeout(duration limit) : limit_{limit} {} // NOLINT: implicit, `milliseconds(300)`

    /// Zero if there is none.
    constexpr duration limit() const { return limit_; }

  private:
    duration limit_{};
};
inline constexpr command_timeout no_command_timeout{duration{}};

/// The time of a drive's own watchdog, after which it stops when it gets no request; 0 if its model names none.
template <class Model>
constexpr duration watchdog_of([[maybe_unused]] const typename Model::settings& known) {
    if constexpr (requires { Model::watchdog(known); })
        return Model::watchdog(known);
    else
        return {};
}

/// On a line that is too slow for it the feedback is read as often as the line allows.
inline constexpr duration default_feedback = milliseconds(20);

/// Of a drive without a watchdog that reads would keep from expiring.
struct optional_supervision {
    /// `step` reads the feedback this often; 0: only when a command needs it, and then nothing is sent that
    /// the application did not command, except its stops. A period that is shorter than the frame takes is refused.
    duration feedback = default_feedback;
    servobus::command_timeout command_timeout = no_command_timeout;
};

/// Of a drive with one: the command timeout has no default.
struct supervision {
    duration feedback = default_feedback; ///< as in `optional_supervision`
    servobus::command_timeout command_timeout;

    constexpr operator optional_supervision() const {
        return {feedback, command_timeout};
    } // NOLINT: a special case
};

/// `step` polls nothing: it sends what the application commands, and stops if what was read shows a fault. A watchdog of the drive's own stops it, if it has
/// one, when the application sends nothing.
inline constexpr supervision unsupervised{.feedback = {}, .command_timeout = no_command_timeout};

} // namespace servobus
