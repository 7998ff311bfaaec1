// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Explains why a command was refused: `why` returns the value, its register and its limits; or the state, and the
// states in which the command is possible. It plans the command again, so the facade stores nothing. Programs include
// the `arguments.hpp` of their device, which includes this header.
//
//     constexpr velocity fast{900 * r_per_min, 0 * r_per_min};
//     if (!wheels.begin(fast)) { // asked before another call of the drive
//         const command_argument a = why(wheels, fast).argument;
//         std::printf("%04Xh takes %ld..%ld\n", unsigned{a.address}, long(a.limits.low), long(a.limits.high));
//     }
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/arguments.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>

namespace servobus {

/// A set of states of a drive. A function `planned_states(settings)` in the `arguments.hpp` of a device returns those
/// that its settings may have; without one they are `needs_init`, `disabled` and `enabled`.
class drive_states {
  public:
    constexpr drive_states() = default;
    template <class... More> constexpr explicit drive_states(drive_state first, More... more) {
        add(first);
        (add(more), ...);
    }
    constexpr bool has(drive_state s) const { return (bits_ & mask_of(s)) != 0; }
    constexpr bool is_empty() const { return bits_ == 0; }
    constexpr void add(drive_state s) { bits_ = static_cast<std::uint8_t>(bits_ | mask_of(s)); }
    friend constexpr bool operator==(drive_states, drive_states) = default;

  private:
    static constexpr unsigned mask_of(drive_state s) { return 1u << static_cast<unsigned>(s); }
    std::uint8_t bits_ = 0;
};

/// A cached setting that some commands need to have certain codes, such as the mode of operation.
struct condition {
    std::uint16_t address = 0; ///< the address of its register
    std::uint16_t code = 0;    ///< the code that it has now
    /// Bit n is set if the command is possible with code n in the drive's state; if it is with no code there, in any
    /// state.
    std::uint16_t codes = 0;
    /// True if `code`, 0 or 1, is a fact about the register and not its content. The device's header says which fact.
    bool is_flag = false;

    constexpr bool has(unsigned n) const { return n < 16 && (codes >> n & 1u) != 0; }
    /// False if the command is refused for this setting.
    constexpr bool is_met() const { return has(code); }
};

/// Gives a drive's settings one of all combinations of their codes. A function `conditions(settings, each)` in the
/// `arguments.hpp` of the device lists these settings, each with its row.
class each_condition {
  public:
    static constexpr std::size_t most = 6;

    constexpr explicit each_condition(std::uint32_t combination) : rest_{combination} {}

    /// A setting with all codes of row `R`, 16 at most.
    template <const auto& R, class T> constexpr void of(T& setting) {
        of<R>(setting, static_cast<T>(R.limits.low), static_cast<T>(R.limits.high));
    }
    /// A setting that has only some of the codes of row `R`.
    template <const auto& R, class T> constexpr void of(T& setting, T low, T high) {
        const auto first = static_cast<std::uint16_t>(low);
        const auto count = static_cast<std::uint32_t>(static_cast<std::uint16_t>(high)) - first + 1;
        const auto now = static_cast<std::uint16_t>(setting);
        setting = static_cast<T>(take({.address = R.address, .code = now}, first, count));
    }
    /// A fact about register `R` that the program knows, or does not.
    template <const auto& R> constexpr void flag(bool& setting) {
        const auto now = static_cast<std::uint16_t>(setting);
        setting = take({.address = R.address, .code = now, .is_flag = true}, 0, 2) != 0;
    }

    /// False after the last combination.
    constexpr bool is_valid() const { return rest_ == 0; }
    constexpr std::size_t size() const { return used_; }
    constexpr const condition& operator[](std::size_t i) const { return found_[i]; }

  private:
    constexpr std::uint16_t take(condition c, std::uint16_t first, std::uint32_t count) {
        const auto code = static_cast<std::uint16_t>(first + rest_ % count);
        rest_ /= count;
        c.codes = static_cast<std::uint16_t>(1u << (code & 15u));
        if (used_ < most) found_[used_++] = c;
        return code;
    }

    std::uint32_t rest_;
    std::uint8_t used_ = 0;
    condition found_[most]{};
};

/// Why a command was refused.
struct refusal {
    errc error = errc::ok; ///< `ok` if the command's plan has no objection

    command_argument argument{}; ///< the first argument that explains the error, if `is_of_value()`

    drive_state state = drive_state::needs_init; ///< the state of the drive
    /// The states in which the command is possible with the present settings; if there is none, with other settings.
    drive_states states{};
    std::uint8_t size = 0; ///< the number of `conditions`
    condition conditions[each_condition::most]{};

    /// True if `argument` is refused. False also for a command without a list of its arguments.
    constexpr bool is_of_value() const { return argument.explains(error); }
    /// True if the command is refused for the drive's state or a setting; it is possible with those in `states` and
    /// `conditions`.
    constexpr bool is_of_state() const {
        return error == errc::needs_init || error == errc::wrong_state || error == errc::faulted;
    }
    /// The first setting for which the command is refused; null if there is none.
    constexpr const condition* unmet() const {
        for (std::size_t i = 0; i < size; ++i) {
            if (!conditions[i].is_met()) return &conditions[i];
        }
        return nullptr;
    }
};

namespace detail {
template <class Settings> constexpr void visit_conditions(Settings& known, each_condition& each) {
    if constexpr (requires { conditions(known, each); }) conditions(known, each);
}

// The states that a model may put into its settings; a fault is seen in the feedback.
template <class Settings> constexpr drive_states states_of(const Settings& known) {
    if constexpr (requires { planned_states(known); }) {
        return planned_states(known);
    } else {
        return drive_states{drive_state::needs_init, drive_state::disabled, drive_state::enabled};
    }
}

/// Collects the states and codes with which a command is possible. It is one class for all commands, for flash.
class possible_states {
  public:
    constexpr void note_settings(refusal& r, const each_condition& each) {
        for (std::size_t i = 0; i < each.size(); ++i) {
            const std::uint16_t before = r.conditions[i].codes;
            r.conditions[i] = each[i];
            r.conditions[i].codes = before;
        }
        r.size = static_cast<std::uint8_t>(each.size());
    }
    /// The command is possible in state `s` with the settings of `each`.
    constexpr void note(refusal& r, const each_condition& each, drive_state s) {
        ever_.add(s);
        for (std::size_t i = 0; i < each.size(); ++i) {
            add(r.conditions[i].codes, each[i].codes);
            if (s == r.state) add(here_[i], each[i].codes);
        }
    }
    constexpr void conclude(refusal& r) const {
        if (r.states.is_empty()) r.states = ever_;
        for (std::size_t i = 0; i < r.size; ++i) {
            if (here_[i] != 0) r.conditions[i].codes = here_[i];
        }
    }

  private:
    static constexpr void add(std::uint16_t& codes, std::uint16_t more) {
        codes = static_cast<std::uint16_t>(codes | more);
    }
    drive_states ever_{};                        // with any settings
    std::uint16_t here_[each_condition::most]{}; // in the drive's state
};

// A command in the machine's units lacks its geometry, which the facade has.
template <class Drive, class Command>
constexpr decltype(auto) made_complete(const Drive& drive, const Command& wanted) {
    if constexpr (requires { drive.with_geometry(wanted); }) {
        return drive.with_geometry(wanted);
    } else {
        return (wanted);
    }
}

// The error of what the command's routine reads first, in a device that has a function `permitted` for that.
template <class Prepared, class Settings>
constexpr errc error_after(const Prepared& planned, const Settings& known) {
    if constexpr (requires { permitted(planned, known); }) {
        return permitted(planned, known);
    } else {
        return errc::ok;
    }
}

constexpr bool is_of_state(errc e) { return e == errc::needs_init || e == errc::wrong_state; }

template <class Command, class Settings>
constexpr bool is_possible(const Command& wanted, Settings& tried, drive_state s) {
    tried.state = s;
    const auto planned = commands::prepared(wanted, tried);
    return !is_of_state(planned.refusal) && !is_of_state(error_after(planned, tried));
}

/// Calls `use(state)` for each state in which the command is possible with the settings `tried`.
template <class Command, class Settings, class Use>
constexpr void for_each_state(const Command& wanted, Settings& tried, Use use) {
    const drive_states all = states_of(tried);
    for (unsigned n = 0; n <= static_cast<unsigned>(drive_state::faulted); ++n) {
        const auto s = static_cast<drive_state>(n);
        if (all.has(s) && is_possible(wanted, tried, s)) use(s);
    }
}

template <class Command, class Settings>
constexpr void find_states(refusal& r, const Command& wanted, const Settings& known) {
    Settings tried = known;
    for_each_state(wanted, tried, [&](drive_state s) { r.states.add(s); });
    possible_states found;
    for (std::uint32_t n = 0;; ++n) {
        tried = known;
        each_condition each{n};
        visit_conditions(tried, each);
        if (!each.is_valid()) break;
        found.note_settings(r, each);
        for_each_state(wanted, tried, [&](drive_state s) { found.note(r, each, s); });
    }
    found.conclude(r);
}
} // namespace detail

namespace commands {
/// Returns why a command is refused with these settings.
template <class Command, class Settings>
constexpr refusal refusal_of(const Command& any, const Settings& known) {
    const auto& wanted = in_units_of_drive<Settings>(any);
    refusal r;
    const auto planned = commands::prepared(wanted, known);
    r.error = commands::first_error(planned.refusal, detail::error_after(planned, known));
    r.state = known.state;
    if (r.error == errc::ok) return r;
    if (r.is_of_state()) detail::find_states(r, wanted, known);
    if constexpr (requires { arguments(wanted, known); }) {
        for (const command_argument& a : arguments(wanted, known)) {
            if (!r.is_of_value() && a.explains(r.error)) r.argument = a;
        }
    }
    return r;
}
} // namespace commands

/// Returns why `drive` has refused `wanted`; call it before another call of the drive. The error is `ok` if the plan
/// of the command has no objection. Then the drive has refused the command, or the facade for a reason of its own.
/// Such reasons are another command under way (`busy`), the stop for a fault (`faulted`), and a wait without a move.
/// Others are a node address or feedback period that cannot be, and a hold without a command timeout
/// (`bad_argument`). The limits of a C630S axis are one too: `end_passed_by` names it. A command in the machine's
/// units has no list of its arguments: lengths and speeds are its own, registers its drive's.
template <class Drive, class Command> constexpr refusal why(const Drive& drive, const Command& wanted) {
    refusal r = commands::refusal_of(detail::made_complete(drive, wanted), drive.cached());
    if (drive.state() == drive_state::faulted && r.error == errc::wrong_state) r.error = errc::faulted;
    if (drive.state() == drive_state::faulted) r.state = drive_state::faulted;
    return r;
}

} // namespace servobus
