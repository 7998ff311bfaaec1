// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: a drive that moves an axis, in lengths and speeds of the machine. Programs include it beside
// or in place of servobus/device/yako.hpp.
//
//     constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000})); // 0011h: pulses of a turn
//     yako::closed_loop::axis_drive lift{wire, 2, screw};
//     if (!lift.run(init{}) || !lift.run(enable{})) return 1;
//     if (!lift.run(yako::closed_loop::home{yako::homing::home_24})) return 1;
//     if (!lift.run(move_to{125.5_mm}, wait_reached{})) return 1;
#pragma once

#include <cstdint>

#include <servobus/axis/axis_place.hpp>
#include <servobus/control/axis_command.hpp>
#include <servobus/control/axis_commands.hpp>
#include <servobus/control/axis_facade.hpp>
#include <servobus/device/yako/drive.hpp>
#include <servobus/device/yako/hold.hpp>

namespace servobus::yako {

using axis_command = servobus::axis_command<prepared_command>;

/// The model of a drive that moves an axis.
template <class Device> class axis_model : public model<Device> {
    using base = model<Device>;

  public:
    using prepared_command = axis_command;
    using settings = typename base::settings;

    constexpr axis_place& place() { return place_; }
    constexpr const axis_place& place() const { return place_; }

    constexpr void note(const block_feedback& r, const settings& known) {
        base::note(r, known);
        const auto raw = motion_under_way<Device>::position_in(r.words, known).count();
        place_.follow(static_cast<std::uint32_t>(raw), r.epoch);
    }
    static constexpr prepared_command stop_for(stop_priority priority, const settings& known,
                                               bool has_watchdog_expired) {
        return base::stop_for(priority, known, has_watchdog_expired);
    }
    /// A drive that counts otherwise than the program says is not taken over.
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        const bool is_kept = e.is_done && c.carries;
        const bool is_init = e.is_done && c.then == effect::initialised;
        c.carries = false;
        const errc found = base::learn(c, e, known);
        if (is_kept) place_.keep(c.rest);
        if (!is_init || found != errc::ok || known.microsteps == place_.geometry().counts_of_motor_turn())
            return found;
        known = base::unknown;
        c.steps = no_steps;
        return errc::unexpected_value;
    }

  private:
    axis_place place_{};
};

namespace detail {
/// The speed of a motor as a count of the drive; `out_of_range` if it is not 0 and rounds to it.
struct rounded_speed {
    speed value{};
    errc error = errc::ok;
};
constexpr rounded_speed speed_on(const axis& on, micrometres_per_second wanted,
                                 const cached_settings& known) {
    const std::int32_t counts_of_r_per_min = known.resolution == speed_count::tenth_r_per_min ? 10 : 1;
    const result<std::int32_t> counts = on.motor_counts_of(wanted, counts_of_r_per_min);
    if (!counts) return {{}, counts.error()};
    const bool is_lost = *counts == 0 && wanted.count() != 0;
    const std::int32_t tenths = counts_of_r_per_min == 10 ? *counts : *counts * 10;
    return {speed{tenths}, is_lost ? errc::out_of_range : errc::ok};
}
struct rounded_profile {
    motion_profile value{};
    errc error = errc::ok;
};
/// The speeds of a profile have no direction.
constexpr rounded_profile profile_on(const axis& on, const axis_profile& by, const cached_settings& known) {
    if (by.is_stored()) return {};
    if (!by.is_whole()) return {{}, errc::bad_argument};
    const rounded_speed top = speed_on(on, by.top, known);
    const rounded_speed start = speed_on(on, by.start, known);
    const auto size = [&on](speed s) { return on.is_mirrored() ? -s : s; };
    return {motion_profile{size(start.value), by.acceleration, by.deceleration, size(top.value)},
            first_error(top.error, start.error)};
}
} // namespace detail

/// To a place from the drive's home. Errors: as of a move in pulses; `out_of_range`.
constexpr axis_command plan_on_axis(const axis_move_to& wanted, const axis_place& at,
                                    const cached_settings& known) {
    const axis& on = at.geometry();
    const result<std::int32_t> counts = on.counts_of(wanted.place);
    const auto by = detail::profile_on(on, wanted.by, known);
    axis_command c = prepare(absolute_move{distance{counts.value_or(0)}, by.value}, known);
    c.refusal = detail::first_error(c.refusal, counts.error(), by.error);
    return c;
}
/// Errors: as of a move in pulses; `out_of_range`.
constexpr axis_command plan_on_axis(const axis_move_by& wanted, const axis_place& at,
                                    const cached_settings& known) {
    std::int32_t rest = 0;
    const result<std::int32_t> counts = at.plan(wanted.way, rest);
    const auto by = detail::profile_on(at.geometry(), wanted.by, known);
    axis_command c = prepare(relative_move{distance{counts.value_or(0)}, by.value}, known);
    c.refusal = detail::first_error(c.refusal, counts.error(), by.error);
    c.rest = rest;
    c.carries = true;
    return c;
}
/// Errors: as in r/min; `out_of_range`.
constexpr axis_command plan_on_axis(const axis_velocity& wanted, const axis_place& at,
                                    const cached_settings& known) {
    // A speed that has no count is 0 here, which the drive's own command refuses.
    return commands::prepared(velocity<speed>{detail::speed_on(at.geometry(), wanted.target, known).value},
                              known);
}
/// A button that is held. Errors: as in r/min; `out_of_range`.
constexpr axis_command plan_on_axis(const axis_hold& wanted, const axis_place& at,
                                    const cached_settings& known) {
    // Likewise.
    return commands::prepared(
        hold<speed, duration>{detail::speed_on(at.geometry(), wanted.target, known).value, wanted.every},
        known);
}
/// A mirrored axis has its lowest place where the drive counts highest. Errors: as in pulses;
/// `out_of_range`.
constexpr axis_command plan_on_axis(const limit_travel<micrometres>& wanted, const axis_place& at,
                                    const cached_settings& known) {
    const axis& on = at.geometry();
    const result<std::int32_t> low = on.counts_of(on.is_mirrored() ? wanted.highest : wanted.lowest);
    const result<std::int32_t> high = on.counts_of(on.is_mirrored() ? wanted.lowest : wanted.highest);
    axis_command c = prepare(travel_bounds{distance{low.value_or(0)}, distance{high.value_or(0)}}, known);
    c.refusal = detail::first_error(low.error(), high.error(), c.refusal);
    return c;
}
/// Errors: as in pulses; `out_of_range`.
constexpr axis_command plan_on_axis(const declare_position<micrometres>& wanted, const axis_place& at,
                                    const cached_settings& known) {
    const result<std::int32_t> counts = at.geometry().counts_of(wanted.place);
    axis_command c = prepare(position_declaration{distance{counts.value_or(0)}}, known);
    c.refusal = detail::first_error(c.refusal, counts.error());
    return c;
}

/// One drive on a line that moves an axis; `closed_loop::axis_drive` or `open_loop::axis_drive`. Commands of the drive
/// itself stay in pulses.
template <class Device, class Line>
class basic_axis_drive : public servobus::axis_facade<basic_drive<Device, Line, axis_model<Device>>> {
    using base = servobus::axis_facade<basic_drive<Device, Line, axis_model<Device>>>;

  public:
    constexpr basic_axis_drive(Line& on, std::uint8_t at, const axis& of,
                               const supervision& by = without_watchdog)
        : basic_axis_drive{on, servobus::node<Device>{at}, of, by} {}
    /// With limits and gaps of its own.
    constexpr basic_axis_drive(Line& on, const servobus::node<Device>& at, const axis& of,
                               const supervision& by = without_watchdog)
        : base{of, on, at, by} {}
    basic_axis_drive(Line&, std::uint8_t, const axis&&, const supervision& = without_watchdog) = delete;
    basic_axis_drive(Line&, const servobus::node<Device>&, const axis&&,
                     const supervision& = without_watchdog) = delete; // it is referred to
};

namespace closed_loop {
/// One closed loop drive on a line that moves an axis.
template <class Line> class axis_drive : public basic_axis_drive<device, Line> {
    using basic_axis_drive<device, Line>::basic_axis_drive;
};
template <class Line>
axis_drive(Line&, std::uint8_t, const axis&, const supervision& = without_watchdog) -> axis_drive<Line>;
template <class Line>
axis_drive(Line&, const servobus::node<device>&, const axis&, const supervision& = without_watchdog)
    -> axis_drive<Line>;
} // namespace closed_loop

namespace open_loop {
/// One open loop drive on a line that moves an axis.
template <class Line> class axis_drive : public basic_axis_drive<device, Line> {
    using basic_axis_drive<device, Line>::basic_axis_drive;
};
template <class Line>
axis_drive(Line&, std::uint8_t, const axis&, const supervision& = without_watchdog) -> axis_drive<Line>;
template <class Line>
axis_drive(Line&, const servobus::node<device>&, const axis&, const supervision& = without_watchdog)
    -> axis_drive<Line>;
} // namespace open_loop

} // namespace servobus::yako
