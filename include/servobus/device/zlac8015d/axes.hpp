// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: a drive whose two motors move an axis each, in lengths and speeds of the machine, such as two
// belts. Programs include it beside or in place of servobus/device/zlac8015d.hpp.
//
//     static constexpr auto belt = axis::of(rolling(120_mm, counts_per_turn{4096}, gear_ratio{5, 1}));
//     zlac8015d::axes belts{wire, 1, belt, belt, {.command_timeout = milliseconds(300)}};
//     using zlac8015d::operating_mode, zlac8015d::synchronisation;
//     const zlac8015d::enable_in ways{operating_mode::relative_position, synchronisation::asynchronous};
//     if (!belts.run(init{}) || !belts.run(ways) || !belts.left().run(move_by{250_mm})) return 1;
#pragma once

#include <cstdint>

#include <servobus/axis/axis_place.hpp>
#include <servobus/control/axis_command.hpp>
#include <servobus/control/axis_commands.hpp>
#include <servobus/device/zlac8015d/commanded_motion.hpp>
#include <servobus/device/zlac8015d/counted_model.hpp>
#include <servobus/device/zlac8015d/drive.hpp>
#include <servobus/device/zlac8015d/shaped_speeds.hpp>

namespace servobus::zlac8015d {

/// A prepared command of an axis: the drive's own, what a relative move leaves, and the setpoint that a speed becomes.
struct axis_command : servobus::axis_command<prepared_command> {
    using servobus::axis_command<prepared_command>::axis_command;

    shaped_setpoint setpoint{};
    bool is_shaped = false;
};

/// The model of a drive with two axes.
class axes_model : public counted_model {
  public:
    using prepared_command = axis_command;

    constexpr void set_axes(const axis& left, const axis& right) {
        left_ = axis_place{left};
        right_ = axis_place{right};
    }
    constexpr const axis_place& place(wheels which) const { return which == wheels::left ? left_ : right_; }

    /// Axes with limits are moved at speeds only.
    constexpr bool has_limits() const { return stops_.left_ms != 0; }
    constexpr void set_limits(const speed_limits& left, const speed_limits& right) {
        shaped_[0].set_limits(left);
        shaped_[1].set_limits(right);
        stops_ = {left.stop_ms, right.stop_ms};
    }
    /// The top speed in counts; 0 if it is below one.
    constexpr std::int32_t top_counts(wheels which, const cached_settings& known) const {
        return static_cast<std::int32_t>(shaped_[number_of(which)].top_in(known.resolution));
    }
    /// The setpoint that is begun now on the way to a speed in counts.
    constexpr shaped_setpoint towards(wheels which, std::int32_t counts, instant now,
                                      const cached_settings& known) const {
        const std::int32_t top = top_counts(which, known);
        const std::int32_t within = counts > top ? top : counts < -top ? -top : counts;
        return shaped_[number_of(which)].towards({within, 0}, {speeds_[number_of(which)], 0},
                                                 known.resolution, now);
    }
    /// True while the last speed of the axis is not reached.
    constexpr bool is_changing(wheels which) const { return shaped_[number_of(which)].is_changing(); }

    constexpr void note(const block_feedback& r, const settings& known) {
        if (known.state == drive_state::needs_init) return; // counts from elsewhere after it
        left_.follow(position(r.words + image::place_of<left_actual_position>), r.epoch);
        right_.follow(position(r.words + image::place_of<right_actual_position>), r.epoch);
        speeds_[0] = static_cast<std::int16_t>(r.words[image::place_of<left_actual_speed>]);
        speeds_[1] = static_cast<std::int16_t>(r.words[image::place_of<right_actual_speed>]);
    }
    static constexpr prepared_command stop_for(stop_priority priority, const settings& known,
                                               bool has_watchdog_expired) {
        return model::stop_for(priority, known, has_watchdog_expired);
    }
    constexpr errc admit(prepared_command& c, duration lost) {
        const bool needs_own_ramps = commanded_motion::sets_ramps(c) || c.then == effect::moved;
        if (has_limits() && needs_own_ramps) return errc::bad_argument;
        if (c.is_shaped)
            shaped_[number_of(c.which)].begin(c.setpoint);
        else
            forget_speeds(c);
        return counted_model::admit(c, lost);
    }
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        if (e.is_done && c.carries) (c.which == wheels::left ? left_ : right_).keep(c.rest);
        if (e.is_done && !c.is_shaped && commanded_motion::sets_speeds(c, e.steps)) {
            shaped_[0].know(c.arguments[0], 0);
            shaped_[1].know(c.arguments[1], 0);
        } else if (!c.is_shaped || !e.is_done) {
            forget_speeds(c);
        }
        c.carries = c.is_shaped = false;
        return learn_counts(c, e, known, left_.geometry().counts_of_motor_turn(),
                            right_.geometry().counts_of_motor_turn(), stops_);
    }

  private:
    static constexpr std::uint32_t position(const std::uint16_t* w) {
        return join_words(w[0], w[1], device::facts.word_order);
    }
    static constexpr std::size_t number_of(wheels which) { return which == wheels::left ? 0 : 1; }
    // Any command that may change a speed but that of the other axis.
    constexpr void forget_speeds(const prepared_command& c) {
        if (commanded_motion::keeps_speeds(c)) return;
        if (!c.is_shaped || c.which == wheels::left) shaped_[0].forget();
        if (!c.is_shaped || c.which == wheels::right) shaped_[1].forget();
    }

    axis_place left_{};
    axis_place right_{};
    shaped_speeds shaped_[2]{};
    std::int16_t speeds_[2]{}; // 0.1 r/min
    stop_times stops_{};       // without limits none
};

namespace detail {
/// A wheel's axis at a time.
struct axis_now {
    const axes_model& model;
    wheels which;
    instant now;

    constexpr const axis_place& place() const { return model.place(which); }
};
/// A command of one axis.
template <class Wanted> struct command_of_wheel {
    const Wanted& wanted;
    axis_now on;

    constexpr axis_command prepare(const cached_settings& known) const {
        return plan_on_wheel(wanted, on, known);
    }
};
// The ramps of axes with limits are too short for a move.
constexpr errc position_error(const axes_model& of) {
    return of.has_limits() ? errc::bad_argument : errc::ok;
}
// The drive's own profile counts: `position_speed` and `ramps` set it.
constexpr errc profile_error(const axis_profile& by) {
    return by.is_stored() ? errc::ok : errc::bad_argument;
}
} // namespace detail

/// Absolute position mode, asynchronous: to a place from the drive's absolute zero (2006h). Errors: as `move_left_to`;
/// `out_of_range`; `bad_argument` with a profile, which is the drive's: `position_speed`, `ramps`.
constexpr axis_command plan_on_wheel(const axis_move_to& wanted, const detail::axis_now& on,
                                     const cached_settings& known) {
    const result<std::int32_t> counts = on.place().geometry().counts_of(wanted.place);
    const distance place{counts.value_or(0)};
    axis_command c =
        on.which == wheels::left ? move_left_to{place}.prepare(known) : move_right_to{place}.prepare(known);
    c.refusal =
        detail::first_error(c.refusal, detail::first_error(detail::profile_error(wanted.by), counts.error()));
    c.refusal = detail::first_error(detail::position_error(on.model), c.refusal);
    return c;
}
/// Relative position mode, asynchronous. Errors likewise.
constexpr axis_command plan_on_wheel(const axis_move_by& wanted, const detail::axis_now& on,
                                     const cached_settings& known) {
    std::int32_t rest = 0;
    const result<std::int32_t> counts = on.place().plan(wanted.way, rest);
    const distance way{counts.value_or(0)};
    axis_command c =
        on.which == wheels::left ? move_left_by{way}.prepare(known) : move_right_by{way}.prepare(known);
    c.refusal =
        detail::first_error(c.refusal, detail::first_error(detail::profile_error(wanted.by), counts.error()));
    c.refusal = detail::first_error(detail::position_error(on.model), c.refusal);
    c.rest = rest;
    c.carries = true;
    return c;
}
/// Velocity mode, to the nearest count of the drive's speed; the other axis keeps its speed. Errors: as
/// `left_velocity`; `out_of_range`, also for a speed that is not 0 and rounds to it.
constexpr axis_command plan_on_wheel(const axis_velocity& wanted, const detail::axis_now& on,
                                     const cached_settings& known) {
    const std::int32_t n = known.resolution;
    const result<std::int32_t> exact = on.place().geometry().motor_counts_of(wanted.target, n);
    const std::int32_t counted = exact.value_or(0);
    const std::int32_t counts = counted > 32'767 || counted < -32'767 ? 0 : counted;
    const speed to{counts * (2520 / n)};
    axis_command c =
        on.which == wheels::left ? left_velocity{to}.prepare(known) : right_velocity{to}.prepare(known);
    const errc lost = counts == 0 && wanted.target.count() != 0 ? errc::out_of_range : errc::ok;
    c.refusal = detail::first_error(exact.error(), detail::first_error(lost, c.refusal));
    if (c.refusal != errc::ok || !on.model.has_limits()) return c;
    if (on.model.top_counts(on.which, known) == 0) c.refusal = errc::out_of_range;
    c.which = on.which;
    c.setpoint = on.model.towards(on.which, counts, on.now, known);
    c.is_shaped = true;
    c.arguments[0] = c.setpoint.left_word();
    return c;
}

/// One axis of a drive with two.
template <class Drive> class axis_of_drive {
  public:
    constexpr axis_of_drive(Drive& of, wheels which) : drive_{&of}, which_{which} {}

    /// The axis that the motor moves.
    constexpr const axis& geometry() const { return place().geometry(); }

    /// Runs a command of this axis: `move_to`, `move_by`, `velocity`. Waits; with limits until the speed is
    /// ordered, by a setpoint every 20 ms.
    template <class Wanted> command_status run(const Wanted& wanted) {
        for (;;) {
            const instant begun = drive_->line().now();
            const command_status how = drive_->run(with_geometry(wanted));
            if (!how || !is_changing_speed()) return how;
            if (!shaped_speeds::pause(*drive_, begun)) return errc::clock_stopped;
        }
    }
    /// Begins a command of this axis. With limits `velocity` begins one setpoint on the way to its speed: a program
    /// begins it every 20 ms or so.
    template <class Wanted> constexpr command_status begin(const Wanted& wanted) {
        return drive_->begin(with_geometry(wanted));
    }
    /// A command with this axis, and what the drive knows: as `why` asks for it.
    template <class Wanted>
    constexpr detail::command_of_wheel<Wanted> with_geometry(const Wanted& wanted) const {
        return {wanted, {drive_->model_of_axes(), which_, drive_->line().now()}};
    }
    /// True while the speed that was begun last is not reached: it is to be begun again.
    constexpr bool is_changing_speed() const {
        return drive_->model_of_axes().is_changing(which_) && state() == drive_state::enabled;
    }
    constexpr drive_state state() const { return drive_->state(); }
    constexpr cached_settings cached() const { return drive_->cached(); }

    /// Runs a move of this axis and waits for its end. Returns how that was; `none` if the move did not begin, as
    /// `last` says.
    template <class Move> axis_arrival run(const Move& move, const wait_reached& end) {
        commands::check_target<Move>();
        if (!run(move)) return {};
        (void)drive_->run(wait_wheels_reached{which_, end.limit});
        return arrival();
    }
    constexpr axis_arrival arrival() const {
        const zlac8015d::arrival a = drive_->arrival(which_);
        const distance missing = which_ == wheels::left ? a.left_missing : a.right_missing;
        return {a.how, a.cause, geometry().length_of(missing.count()).value_or(micrometres{})};
    }

    /// Where the axis is, by feedback that is at most `oldest` old; counted from elsewhere after `init`, a restart,
    /// `clear_position`. Errors: as `feedback`.
    constexpr result<micrometres> position(duration oldest) const {
        const auto seen = drive_->feedback(oldest);
        if (!seen) return seen.error();
        return place().length();
    }
    /// The speed of the axis, likewise.
    constexpr result<micrometres_per_second> speed(duration oldest) const {
        const auto seen = drive_->feedback(oldest);
        if (!seen) return seen.error();
        const std::int32_t tenths =
            which_ == wheels::left ? seen->left_speed.count() : seen->right_speed.count();
        return geometry().speed_of(motor_speed{tenths});
    }

  private:
    constexpr const axis_place& place() const { return drive_->place(which_); }

    Drive* drive_;
    wheels which_;
};

/// One ZLAC8015D on a line whose motors move an axis each. `init` compares the counts of a turn with the encoders'
/// lines, 2030h and 2060h: `unexpected_value`.
template <class Line> class axes : public basic_drive<Line, axes_model> {
    using base = basic_drive<Line, axes_model>;

  public:
    constexpr axes(Line& wire, std::uint8_t at, const axis& left, const axis& right, const supervision& by)
        : axes{wire, servobus::node<device>{at}, left, right, by} {}
    /// With limits and gaps of its own.
    constexpr axes(Line& wire, const servobus::node<device>& at, const axis& left, const axis& right,
                   const supervision& by)
        : base{wire, at, by} {
        this->model().set_axes(left, right);
    }
    axes(Line&, std::uint8_t, const axis&&, const axis&, const supervision&) = delete; // they are referred to
    axes(Line&, std::uint8_t, const axis&, const axis&&, const supervision&) = delete;
    axes(Line&, std::uint8_t, const axis&&, const axis&&, const supervision&) = delete;
    axes(Line&, const servobus::node<device>&, const axis&&, const axis&, const supervision&) = delete;
    axes(Line&, const servobus::node<device>&, const axis&, const axis&&, const supervision&) = delete;
    axes(Line&, const servobus::node<device>&, const axis&&, const axis&&, const supervision&) = delete;

    constexpr axis_of_drive<axes> left() { return {*this, wheels::left}; }
    constexpr axis_of_drive<axes> right() { return {*this, wheels::right}; }
    constexpr const axis_place& place(wheels which) const { return this->model().place(which); }
    /// The model of both axes.
    constexpr const axes_model& model_of_axes() const { return this->model(); }

    /// Limits the speeds of both axes: `top`, and the times from standstill to it and back. `velocity` shapes its
    /// setpoints by them, `move_to` and `move_by` are refused. The next `init` writes ramps of 10 ms, and the time
    /// in which the drive stops without the program, no harder than the limits. Errors as `robot::set_limits`.
    constexpr status set_limits(const axis_profile& left, const axis_profile& right) {
        if (this->state() == drive_state::enabled) return errc::wrong_state;
        const result<motor_speed> left_top = place(wheels::left).geometry().motor_speed_of(left.top);
        const result<motor_speed> right_top = place(wheels::right).geometry().motor_speed_of(right.top);
        const motor_speed none{0x8000};
        const result<speed_limits> of_left = speed_limits::of(left, left_top.value_or(none).count());
        const result<speed_limits> of_right = speed_limits::of(right, right_top.value_or(none).count());
        if (of_left && of_right) this->model().set_limits(*of_left, *of_right);
        return detail::first_error(of_left.error(), of_right.error());
    }
};
template <class Line> axes(Line&, std::uint8_t, const axis&, const axis&, const supervision&) -> axes<Line>;
template <class Line>
axes(Line&, const servobus::node<device>&, const axis&, const axis&, const supervision&) -> axes<Line>;

} // namespace servobus::zlac8015d
