// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Takes a drive over and sets it up by one command: init, settings, a first reading of the feedback. Programs include
// it together with the header of their device; a facade's `run` and that of a bus run it, and a `setpoint_loop` steps
// it.
//
//     const auto ready = wheels.run(take_over{zlac8015d::resolution{10}, zlac8015d::watchdog{500 * millisecond}});
//     if (!ready) std::printf("%s %u: %s\n", text(ready.part()), ready.setting(), text(ready.error()));
#pragma once

#include <cstddef>

#include <servobus/control/command_status.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/detail/command_list.hpp>
#include <servobus/control/detail/take_over_progress.hpp>
#include <servobus/control/moving_commands.hpp>

namespace servobus {

/// Named first in a `take_over`: a drive with a fault is reset before the settings. Whether a stepper is energised
/// after that is the drive's, as after `fault_reset`.
struct with_fault_reset {};

namespace detail {
template <class... Settings> inline constexpr bool asks_for_reset = false;
template <class... Settings> inline constexpr bool asks_for_reset<with_fault_reset, Settings...> = true;

template <class Drive, class Setting> constexpr void check_setting() {
    static_assert(!may_move<model_of_drive<Drive>, Setting>,
                  "a take-over neither energises the motor nor moves it: run this command after it");
}
} // namespace detail

/// Takes a drive over: `init`, the settings in their order, then a reading of the feedback. It ends at the first part
/// that fails. The settings are any commands but those that energise a motor or move it, which do not compile;
/// `disable{}` before settings that need a drive without power, for example. A drive that `init` leaves energised, as
/// some steppers are after power-on, stays so unless `disable{}` is in the list.
///
/// With `with_fault_reset{}` as the first one the feedback is read after `init`, and a fault is reset. Without it a
/// drive with a fault is taken over too: `state()` is `faulted` then, and a setting may be refused for it.
///
/// Errors: those of the parts, and, as `part()` says,
/// - `power_cycle`, `wrong_state`: the drive must be switched off and on; then take it over again, which goes on
/// - `set_up`, `wrong_state`: the drive needs a set-up that is not among the settings
/// - `reading`, `needs_init`: the drive has restarted meanwhile
/// - `reading`, `faulted`: `with_fault_reset`, and the drive has a fault again
template <class... Settings> class take_over {
    static constexpr std::size_t size = sizeof...(Settings) - (detail::asks_for_reset<Settings...> ? 1u : 0u);
    static_assert(size <= command_status::most_settings, "a take-over has at most 119 settings");

  public:
    static constexpr bool is_made_of_commands = true;
    /// True with `with_fault_reset{}`.
    static constexpr bool resets_faults = detail::asks_for_reset<Settings...>;

    constexpr explicit take_over(const Settings&... settings) : settings_{settings...} {}

    /// Runs the parts by `run`, which returns how a command of `drive` ended.
    template <class Drive, class Run> constexpr command_status run_by(const Drive& drive, Run&& run) const {
        detail::take_over_progress parts = begin();
        while (!parts.is_over()) {
            const command_status how = apply<Drive>(parts, run); // before its state is read
            parts.conclude(how, drive.state());
        }
        return parts.status();
    }

    /// Begins the parts one by one, for a program that steps them: `apply` gives the one that is due.
    constexpr detail::take_over_progress begin() const {
        return detail::take_over_progress{resets_faults, size};
    }
    /// Calls `f` with the command of `Drive` that is due, and returns what it does.
    template <class Drive, class F> constexpr auto apply(const detail::take_over_progress& at, F&& f) const {
        (detail::check_setting<Drive, Settings>(), ...);
        if (at.due() == take_over_part::init) return f(servobus::init{});
        if constexpr (resets_faults) {
            if (at.due() == take_over_part::fault_reset) return f(fault_reset{});
        }
        if constexpr (size != 0) {
            if (at.due() == take_over_part::setting) return list().visit(at.index(), f);
        }
        return f(read_feedback{});
    }

    /// A take-over is several commands.
    template <class Known> constexpr auto prepare(const Known&) const {
        static_assert(
            sizeof(Known) == 0,
            "a take_over is several commands: a facade or a bus runs it, or a setpoint_loop steps it");
    }

  private:
    constexpr const auto& list() const {
        if constexpr (resets_faults) {
            return settings_.rest;
        } else {
            return settings_;
        }
    }

    [[no_unique_address]] detail::command_list<Settings...> settings_;
};
template <class... Settings> take_over(const Settings&...) -> take_over<Settings...>;

} // namespace servobus
