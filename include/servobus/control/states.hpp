// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The states of a drive's facade, each enumeration with what leads from one value to the next.
// control/facade.hpp includes it, and so does the author of a drive.
//
//     const zlac8015d::arrival came = wheels.arrival();
//     if (came.how == arrival_state::stopped_short && came.cause == stop_cause::input) std::puts("wired stop");
#pragma once

#include <cstdint>

namespace servobus {

/// A stop replaces any command, and a stop of lower priority; one of a supervisor also a stop of the same priority.
enum class stop_priority : std::uint8_t { no_stop, halt, disable, quick_stop };

/// What a command changes. From this follows what restarts the command timeout, what leaves the drive's
/// state unknown if it is interrupted, and when feedback may contradict the cached settings.
enum class command_kind : std::uint8_t {
    other,          ///< nothing that is cached; a motion goes on
    refresh,        ///< reads the feedback
    setting,        ///< cached settings: unknown if it is interrupted
    power,          ///< energises the motor or frees it: unknown if it is interrupted
    endless_motion, ///< a speed, a torque, a jog: the command timeout supervises it
    move,           ///< a motion that ends by itself
    take_over,      ///< `init`: stops the drive and reads its settings
};

/// Who began the routine that is under way.
///
///     none --begin()--> application --it has ended, and something must follow--> follow_up --> none
///     none --a supervisor's stop--> supervisor --> none
///     application, follow_up --a stop of higher priority--> application, or supervisor
///     supervisor --a stop of the same or a higher priority, or init--> application
///     supervisor, follow_up --it has ended, and something must follow--> follow_up
enum class owner : std::uint8_t { none, application, follow_up, supervisor };

/// What the frame is for that waits for the line or is on it.
///
///     none --a frame is due--> step | refresh | witness --it has ended--> none
///     step | refresh | witness --another routine replaces this one after a byte has left--> drained | drained_write --> none
enum class flight : std::uint8_t {
    none,
    step,          ///< of the routine under way
    refresh,       ///< reads the process image
    witness,       ///< reads what a restart would change
    drained,       ///< of a routine that was replaced: its response is received and not used
    drained_write, ///< the same of a write: without a response the drive's state is unknown
};

/// What the process image says of a drive whose settings are known.
enum class verdict : std::uint8_t {
    as_expected,
    faulted,   ///< and to be stopped
    tripped,   ///< faulted, and without power already
    held,      ///< stopped by an input, or by another program
    disabled,  ///< restarted, or switched off by something else
    uncertain, ///< perhaps restarted: the witness decides
};

/// Why a drive does not follow its last command.
enum class stop_cause : std::uint8_t {
    unknown, ///< or it follows
    fault,   ///< the drive reports one
    input,   ///< a wired stop or a limit switch
    blocked, ///< it presses at its torque limit and does not move
    command, ///< a stop of this program
    restart, ///< or the drive was switched off by something else
};

/// How far a move has come.
///
///     none --a move is started--> under_way --> reached | stopped_short
enum class arrival_state : std::uint8_t {
    none,          ///< no move was commanded, or nothing is known of it any more
    under_way,     ///< or it may not have started yet
    reached,       ///< at rest at its target
    stopped_short, ///< at rest elsewhere
};

/// Whether a move began whose start got no response: `seen` if the motor runs or is away from where it was,
/// `not_seen` otherwise, which a very short move may be as well.
enum class motion_check : std::uint8_t { not_asked, seen, not_seen, unknown };

} // namespace servobus
