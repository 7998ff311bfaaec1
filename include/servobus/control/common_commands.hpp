// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands that every drive has, so that one program drives any of them. Each device makes its routines of them by
// functions `prepare(command, settings)`, whose comments say what differs. Programs get it with the header of a device.
//
//     template <class Drive> bool take_over(Drive& drive) {
//         if (!drive.run(init{})) return false;
//         if (drive.state() == drive_state::faulted && !drive.run(fault_reset{})) return false;
//         return static_cast<bool>(drive.run(enable{}));
//     }
#pragma once

#include <type_traits>
#include <utility>

#include <servobus/core/time.hpp>

namespace servobus {

/// Takes a drive over, whatever a program before this one did: stops it, waits until it is at standstill, reads what
/// must be known. Nothing moves. A stepper that is energised already, as after its power was switched on, stays so.
struct init {};

/// Energises the motor; only at standstill and without a fault. Nothing moves by itself. A drive with several modes of
/// operation is enabled in velocity mode; its `enable_in` names another.
struct enable {};

/// Stops, waits until the motor is at standstill, and switches its power off. The shaft may be free then.
struct disable {};

/// Stops by the ramp of the present motion; the motor stays energised. Errors: `wrong_state` in a mode in which the
/// drive has no such stop.
struct halt {};

/// Stops as fast as the drive can.
struct quick_stop {};

/// Clears the faults, at standstill. Nothing moves. Whether the motor is energised afterwards is the drive's: `state()`
/// says it. Errors: `faulted` if a fault remains.
struct fault_reset {};

/// Waits until the motor is at standstill. Errors: `not_reached` after `limit`; `faulted`; `stopped_short` after a move
/// that has ended elsewhere than at its target.
struct wait_standstill {
    duration limit = milliseconds(60'000);
};

/// Waits until the last move has ended at its target. Errors: `stopped_short` if the motor is at rest elsewhere (the
/// drive's `arrival()` has where and why); `not_reached` after `limit`; `faulted`. `wrong_state`: no move with a known
/// target was commanded since `init`.
struct wait_reached {
    duration limit = milliseconds(60'000);
};

/// Reads the drive's feedback.
struct read_feedback {};

namespace detail {
template <class Command, class Settings>
concept prepares_itself = requires(const Command& wanted, const Settings& known) {
    wanted.prepare(known);
};
template <class Command, class Settings>
concept prepared_by_device = requires(const Command& wanted, const Settings& known) {
    prepare(wanted, known);
};
} // namespace detail

namespace commands {
/// A command that is made of others, which a facade runs one after the other, such as `take_over`.
template <class Wanted>
concept made_of_commands = requires {
    requires Wanted::is_made_of_commands;
};

/// A command in the units of the drive with these settings, by the device's `in_units_of`. A facade calls it where the
/// program names the command, so that a constant speed stays a constant.
template <class Settings, class Command>
[[gnu::always_inline]] constexpr decltype(auto) in_units_of_drive(const Command& wanted) {
    if constexpr (requires { in_units_of(wanted, static_cast<const Settings*>(nullptr)); })
        return in_units_of(wanted, static_cast<const Settings*>(nullptr));
    else
        return (wanted);
}

/// True if the drive with these settings has the command.
template <class Command, class Settings>
inline constexpr bool is_preparable = [] {
    using own = std::remove_cvref_t<decltype(in_units_of_drive<Settings>(std::declval<const Command&>()))>;
    return detail::prepares_itself<own, Settings> || detail::prepared_by_device<own, Settings>;
}();

/// A command made ready by its own `prepare`, or by the device's.
template <class Command, class Settings>
constexpr auto prepared(const Command& wanted, const Settings& known) {
    const auto& own = in_units_of_drive<Settings>(wanted);
    using form = std::remove_cvref_t<decltype(own)>;
    if constexpr (detail::prepares_itself<form, Settings>) {
        return own.prepare(known);
    } else if constexpr (detail::prepared_by_device<form, Settings>) {
        return prepare(own, known);
    } else {
        static_assert(sizeof(Command) == 0, "this drive has no such command");
        return prepare(init{}, known); // no second error follows
    }
}
} // namespace commands

} // namespace servobus
