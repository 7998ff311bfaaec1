// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Names the commands that a machine needs after each enable and before it may move, such as a homing. A `setpoint_loop`
// takes it after the enable and begins its commands. control/setpoint_loop.hpp includes it.
//
//     constexpr after_enable homed{yako::closed_loop::home{yako::homing::home_24}, read_feedback{}};
//     // setpoint_loop loop{lift, take_over{disable{}}, enable{}, homed}; // no move before the lift is homed
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstddef>

#include <servobus/control/command_status.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/detail/command_list.hpp>
#include <servobus/control/moving_commands.hpp>
#include <servobus/control/states.hpp>

namespace servobus {

namespace detail {
// True for a command that takes the drive over, gives its motor power or takes it, or resets a fault.
template <class Model, class Command> consteval bool changes_power() {
    if constexpr (std::same_as<Command, init> || std::same_as<Command, enable> ||
                  std::same_as<Command, disable> || std::same_as<Command, quick_stop> ||
                  std::same_as<Command, fault_reset>) {
        return true;
    } else if constexpr (planned_by_default<Model, Command>) {
        constexpr command_kind kind = Model::kinds[Command{}.prepare(Model::unknown).then];
        return kind == command_kind::power || kind == command_kind::take_over;
    } else {
        return false;
    }
}
template <class Drive, class Command> constexpr void check_after_enable() {
    static_assert(
        !changes_power<model_of_drive<Drive>, Command>(),
        "an after_enable neither takes the drive over nor changes the motor's power, nor resets faults");
}
} // namespace detail

/// The commands between an enable and the motion of a program, in their order. A `setpoint_loop` begins each once the
/// one before has ended well. The consent to the enable covers a homing among them: **the machine moves then**. A move
/// ends once it has begun: put `wait_reached{}` after it. Commands that take the drive over, change the motor's power
/// or reset a fault do not compile. Put no `save{}` in the list, which would wear the drive's EEPROM.
///
/// The list runs after each enable that is sent. A drive that is still energised, as after a halt, is not enabled anew.
/// Its feedback is read then. The list is left out if it has ended well and only halts have stopped the motor since.
/// The list runs again
/// - after a disable, a quick stop, a fault or a loss
/// - after a wired stop that was seen; `not_executed`, `not_reached` and `stopped_short` count as one, since they may
///   be all that shows it
/// - after a halt that failed
/// - after a moving command of the program that failed or that a halt replaced: it may be a homing
///
/// The first command that fails ends the list and withdraws the consent. The next consent begins the list anew. No stop
/// is sent for a failure: a move that has begun goes on to its target.
template <class... Commands> class after_enable {
    static_assert(sizeof...(Commands) <= command_status::most_settings,
                  "an after_enable has at most 119 commands");

  public:
    static constexpr std::size_t size = sizeof...(Commands);

    constexpr explicit after_enable(const Commands&... commands) : commands_{commands...} {}

    /// Calls `f` with the command of `Drive` at `place`, which is one of the list. Returns what it does.
    template <class Drive, class F> constexpr auto apply(std::size_t place, F&& f) const {
        (detail::check_after_enable<Drive, Commands>(), ...);
        return commands_.visit(place, f);
    }

    /// An `after_enable` is several commands.
    template <class Known> constexpr auto prepare(const Known& known) const {
        static_assert(sizeof(Known) == 0,
                      "an after_enable is several commands: a setpoint_loop begins them after its enable");
        return commands::prepared(init{}, known); // no second error follows
    }

  private:
    [[no_unique_address]] detail::command_list<Commands...> commands_;
};
template <class... Commands> after_enable(const Commands&...) -> after_enable<Commands...>;

namespace detail {
template <class T> inline constexpr bool is_after_enable = false;
template <class... Commands> inline constexpr bool is_after_enable<after_enable<Commands...>> = true;
template <class T>
concept list_after_enable = is_after_enable<T>;
} // namespace detail

} // namespace servobus
