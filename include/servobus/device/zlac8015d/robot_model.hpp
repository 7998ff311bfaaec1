// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the model of a drive whose motors are the wheels of a robot. It makes setpoints of twists, judges
// whether the path between two feedbacks is known, and keeps the pose. zlac8015d/robot.hpp includes it.
//
//     constexpr plane_pose pose_at_first(const differential& base) {
//         zlac8015d::robot_model model;
//         model.set_base(base); // it is referred to
//         return model.pose();
//     }
#pragma once

#include <cstdint>

#include <servobus/axis/differential.hpp>
#include <servobus/axis/odometry.hpp>
#include <servobus/device/zlac8015d/commanded_motion.hpp>
#include <servobus/device/zlac8015d/counted_model.hpp>
#include <servobus/device/zlac8015d/shaped_speeds.hpp>
#include <servobus/device/zlac8015d/wheel_step.hpp>

namespace servobus::zlac8015d {

/// A prepared command of a robot: the drive's own, and the setpoint that a twist has become.
struct robot_command : prepared_command {
    constexpr robot_command(const prepared_command& c)
        : prepared_command{c} {} // NOLINT: implicit, as every other command
    constexpr explicit robot_command(const routine& table) : prepared_command{.steps = table} {}

    shaped_setpoint setpoint{};
    bool is_twist = false;
};

/// The model of a drive whose wheels carry a robot: each feedback counts once.
class robot_model : public counted_model {
  public:
    using prepared_command = robot_command;

    /// `on` must outlive the model.
    constexpr void set_base(const differential& on) {
        base_ = &on;
        odometry_ = odometry{on.base()};
    }
    constexpr const differential& base() const { return *base_; }

    constexpr const plane_pose& pose() const { return odometry_.pose(); }
    /// The epoch of the positions that it is made of.
    constexpr std::uint16_t epoch() const { return epoch_; }
    constexpr void set_pose(const plane_pose& to) { odometry_.set(to); }

    /// Limits both wheels.
    constexpr void set_limits(const speed_limits& to) {
        shaped_.set_limits(to);
        const std::uint16_t more = to.acceleration > to.deceleration ? to.acceleration : to.deceleration;
        acceleration_ = static_cast<std::uint8_t>((more + 999u) / 1000u);
    }
    /// The setpoint that is begun now on the way to a twist, as a command in velocity mode.
    constexpr prepared_command prepare(const twist& wanted, instant now,
                                       const cached_settings& cached) const {
        const std::uint32_t limit = limit_in(cached);
        const wheel_speeds both = base_->wheels(wanted, cached.resolution, limit == 0 ? 1 : limit);
        const measured_speeds seen{last_.left.speed, last_.right.speed};
        prepared_command c{routines::velocity};
        c.setpoint = shaped_.towards(both, seen, cached.resolution, now);
        c.is_twist = true;
        c.arguments = {c.setpoint.left_word(), c.setpoint.right_word()};
        c.then = effect::motion;
        c.refusal = zlac8015d::detail::needs(cached, operating_mode::velocity);
        if (limit == 0) c.refusal = zlac8015d::detail::first_error(c.refusal, errc::out_of_range);
        return c;
    }
    /// True while the last twist is not reached.
    constexpr bool is_changing() const { return shaped_.is_changing(); }

    constexpr void note(const block_feedback& r, const settings& known) {
        if (known.state == drive_state::needs_init) return; // counts from elsewhere after it
        const both_wheels now = wheels_in(r.words);
        const duration took = since(taken_, r.taken);
        if (r.epoch == epoch_ && may_be_late(now, r.taken)) {
            if (!is_still(last_, now, took)) return;
            last_ = now;
            taken_ = r.taken;
            return;
        }
        const bool is_known = r.epoch == epoch_ && !may_be_of_gap(now, r.taken) &&
                              is_path_known(steps_between(last_, now, took));
        if (!is_known) odometry_.restart(now.left.position, now.right.position);
        odometry_.expect_arc(r.taken);
        (void)odometry_.update(now.left.position, now.right.position, r.taken);
        if (!is_known || is_still(last_, now, took)) {
            stood_ = now;
            stood_at_ = r.taken;
        }
        note_gap(now, r.taken, took);
        taken_ = r.taken;
        epoch_ = r.epoch;
        last_ = now;
        step_ = {};
        commanded_.note_feedback();
    }
    /// True also where both wheels may have been at zero, where a restart puts them, and the robot may have moved.
    constexpr bool has_fallen(const block_feedback& r, const settings& known) const {
        if (model::has_fallen(r, known)) return true;
        const both_steps by = steps_between(wheels_in(r.before), wheels_in(r.words), r.between);
        if (!by.left.may_come_from_zero(by.left_swing) || !by.right.may_come_from_zero(by.right_swing))
            return false;
        return commanded_.could_move() || !by.left.is_at_rest() || !by.right.is_at_rest();
    }
    /// The mode, from the first enable on: a drive that is disabled keeps it, and a restart loses it.
    static constexpr steps::recheck witness(const settings& known,
                                            const zlac8015d::prepared_command& under_way) {
        const bool has_mode =
            known.state != drive_state::needs_init && known.mode != operating_mode::undefined;
        return {.look = has_mode && !changes_mode(under_way) ? routines::same_mode : nullptr,
                .words = {static_cast<std::uint16_t>(known.mode)}};
    }
    static constexpr prepared_command stop_for(stop_priority priority, const settings& known,
                                               bool has_watchdog_expired) {
        return model::stop_for(priority, known, has_watchdog_expired);
    }
    constexpr errc admit(prepared_command& c, duration lost) {
        if (commanded_motion::sets_ramps(c)) return errc::bad_argument;
        commanded_.begin(c);
        if (c.is_twist) {
            shaped_.begin(c.setpoint);
            note_step(c);
        } else if (!commanded_motion::keeps_speeds(c)) {
            shaped_.forget();
        }
        return counted_model::admit(c, lost);
    }
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        commanded_.end(c, e);
        if (!c.is_twist && e.is_done && commanded_motion::sets_speeds(c, e.steps))
            shaped_.know(c.arguments[0], c.arguments[1]);
        else if (!commanded_motion::keeps_speeds(c) && !(c.is_twist && e.is_done))
            shaped_.forget();
        if (c.is_twist) note_step(c);
        c.is_twist = false; // what follows is none
        if (is_save(e.steps) || c.then == effect::rescaled) known.mode = operating_mode::undefined;
        const axle& on = base_->base();
        const std::uint16_t stop_ms = shaped_.limits().stop_ms;
        return learn_counts(c, e, known, on.left().counts_of_motor_turn(), on.right().counts_of_motor_turn(),
                            {stop_ms, stop_ms});
    }

  private:
    /// No response is later than this after its request.
    static constexpr duration latest_response = milliseconds(250);

    struct both_wheels {
        wheel_image left, right;
    };
    struct both_steps {
        wheel_step left, right;
        std::int32_t left_swing, right_swing;
    };

    template <const auto& Position, const auto& Speed>
    static constexpr wheel_image wheel_in(const std::uint16_t* w) {
        const std::uint16_t* const position = w + image::place_of<Position>;
        return {join_words(position[0], position[1], device::facts.word_order),
                static_cast<std::int16_t>(w[image::place_of<Speed>])};
    }
    static constexpr both_wheels wheels_in(const std::uint16_t* w) {
        return {wheel_in<left_actual_position, left_actual_speed>(w),
                wheel_in<right_actual_position, right_actual_speed>(w)};
    }
    constexpr both_steps steps_between(const both_wheels& from, const both_wheels& to, duration took) const {
        const std::uint32_t left = base_->base().left().counts_of_motor_turn();
        const std::uint32_t right = base_->base().right().counts_of_motor_turn();
        return {{from.left, to.left, took, left},
                {from.right, to.right, took, right},
                wheel_step::swing(acceleration_, took, left, step_),
                wheel_step::swing(acceleration_, took, right, step_)};
    }
    // True if both wheels have moved as their speeds allow, and the path is near an arc. A new command lets each wheel
    // swing; without one its speed only goes from that of the last feedback to that of this one.
    constexpr bool is_path_known(const both_steps& by) const {
        if (by.left.excess() > 5 + 8 * by.left_swing || by.right.excess() > 5 + 8 * by.right_swing)
            return false;
        const std::int32_t left_swing = commanded_.is_new() ? by.left_swing : 0;
        const std::int32_t right_swing = commanded_.is_new() ? by.right_swing : 0;
        return odometry_.is_near_arc(by.left.bow() + left_swing, by.right.bow() + right_swing,
                                     by.left.farthest() + 8 * left_swing,
                                     by.right.farthest() + 8 * right_swing);
    }
    constexpr bool is_still(const both_wheels& before, const both_wheels& now, duration took) const {
        const both_steps by = steps_between(before, now, took);
        return by.left.is_at_rest() && by.right.is_at_rest();
    }
    // A request without a response leaves a gap that is longer than the one before by its limit at least. Its response
    // may still come, late, and shows where the wheels were in the gap.
    constexpr void note_gap(const both_wheels& now, instant taken, duration took) {
        if (took > last_took_ + milliseconds(25)) {
            gap_from_ = last_;
            gap_to_ = now;
            gap_at_ = taken;
            has_gap_ = true;
        }
        last_took_ = took;
    }
    constexpr bool may_be_of_gap(const both_wheels& now, instant taken) const {
        if (!has_gap_ || !(since(gap_at_, taken) < latest_response)) return false;
        const bool is_at_end = is_near(now.left, gap_to_.left) && is_near(now.right, gap_to_.right);
        return !is_at_end && is_between(now.left, gap_from_.left, gap_to_.left) &&
               is_between(now.right, gap_from_.right, gap_to_.right);
    }
    static constexpr bool is_near(const wheel_image& a, const wheel_image& b) {
        return a.position - b.position + 5u <= 10u; // it trembles
    }
    static constexpr bool is_between(const wheel_image& now, const wheel_image& from, const wheel_image& to) {
        if (is_near(now, from) || is_near(now, to)) return true;
        const auto way = static_cast<std::int32_t>(to.position - from.position);
        const auto gone = static_cast<std::int32_t>(now.position - from.position);
        return way < 0 ? gone < 0 && gone > way : gone > 0 && gone < way;
    }
    // Wheels that are to move and are seen where they stood: the response may be a late one to an earlier request.
    constexpr bool may_be_late(const both_wheels& now, instant taken) const {
        const duration ago = since(stood_at_, taken);
        return commanded_.could_move() && ago < latest_response && is_still(stood_, now, ago);
    }
    static constexpr bool is_save(routine steps) { return steps.data() == routine{routines::save}.data(); }
    constexpr void note_step(const prepared_command& c) {
        if (step_ < c.setpoint.step) step_ = c.setpoint.step;
    }
    // In counts: beyond 2008h the drive raises a fault [errata B5].
    constexpr std::uint32_t limit_in(const cached_settings& cached) const {
        const std::uint32_t reached = std::uint32_t{cached.max_speed} * cached.resolution;
        const std::uint32_t top = shaped_.top_in(cached.resolution);
        const auto most = static_cast<std::uint32_t>(left_target_speed.limits.high);
        const std::uint32_t own = reached < most ? reached : most;
        return top < own ? top : own;
    }
    static constexpr bool changes_mode(const zlac8015d::prepared_command& c) {
        return !c.steps.empty() &&
               (c.then == effect::enabled || c.then == effect::rescaled || is_save(c.steps));
    }

    const differential* base_ = nullptr;
    odometry odometry_{};
    both_wheels last_{};
    both_wheels stood_{};
    instant taken_{}; // the last feedback
    instant stood_at_{};
    both_wheels gap_from_{}; // the last time without feedback
    both_wheels gap_to_{};
    instant gap_at_{};
    duration last_took_{};
    bool has_gap_ = false;
    commanded_motion commanded_{};
    shaped_speeds shaped_{};
    std::uint16_t epoch_ = 0;
    duration step_{};               // the longest of a setpoint since the last feedback
    std::uint8_t acceleration_ = 5; // 0.1 r/min in a millisecond
};

} // namespace servobus::zlac8015d
