// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: both hub motors as the wheels of a robot, which is driven by twists and says where it is. Programs
// include it beside or in place of servobus/device/zlac8015d.hpp.
//
//     constexpr feed wheel = rolling(534_mm, counts_per_turn{4096}); // 4 x the encoder's lines, 2030h
//     constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 400_mm});
//     zlac8015d::robot robot{wire, 1, base, {.command_timeout = milliseconds(300)}};
//     if (!robot.run(init{}) || !robot.run(enable{}) || !robot.run(twist{400_mm_per_s, 250_mrad_per_s})) return 1;
//     if (const plane_pose p = robot.pose(); p.is_continuous) std::printf("%d mm\n", int(p.x_mm().count()));
#pragma once

#include <cstdint>

#include <servobus/axis/differential.hpp>
#include <servobus/axis/odometry.hpp>
#include <servobus/device/zlac8015d/commanded_motion.hpp>
#include <servobus/device/zlac8015d/counted_model.hpp>
#include <servobus/device/zlac8015d/drive.hpp>
#include <servobus/device/zlac8015d/wheel_step.hpp>

namespace servobus::zlac8015d {

/// The model of a drive whose wheels carry a robot: each feedback counts once.
class robot_model : public counted_model {
  public:
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

    /// The greatest change of a wheel's speed, in 0.1 r/min of its motor in a millisecond.
    constexpr void set_acceleration(std::uint8_t tenths) { acceleration_ = tenths; }

    constexpr void note(const block_feedback& r, const settings& known) {
        if (known.state == drive_state::needs_init) return; // counts from elsewhere after it
        const both_wheels now = wheels_in(r.words);
        const bool is_known = r.epoch == epoch_ && is_path_known(now, since(odometry_.pose().time, r.taken));
        if (!is_known) odometry_.restart(now.left.position, now.right.position);
        odometry_.expect_arc(r.taken);
        (void)odometry_.update(now.left.position, now.right.position, r.taken);
        epoch_ = r.epoch;
        last_ = now;
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
    static constexpr steps::recheck witness(const settings& known, const prepared_command& under_way) {
        const bool has_mode =
            known.state != drive_state::needs_init && known.mode != operating_mode::undefined;
        return {.look = has_mode && !changes_mode(under_way) ? routines::same_mode : nullptr,
                .words = {static_cast<std::uint16_t>(known.mode)}};
    }
    constexpr errc admit(const prepared_command& c, duration lost) {
        commanded_.begin(c);
        return counted_model::admit(c, lost);
    }
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        commanded_.end(c, e);
        if (is_save(e.steps)) known.mode = operating_mode::undefined;
        const axle& on = base_->base();
        return learn_counts(c, e, known, on.left().counts_of_motor_turn(), on.right().counts_of_motor_turn());
    }

  private:
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
                wheel_step::swing(acceleration_, took, left),
                wheel_step::swing(acceleration_, took, right)};
    }
    // True if both wheels have moved as their speeds allow, and the path is near an arc. A new command lets each wheel
    // swing; without one its speed only goes from that of the last feedback to that of this one.
    constexpr bool is_path_known(const both_wheels& now, duration took) const {
        const both_steps by = steps_between(last_, now, took);
        if (by.left.excess() > 5 + 8 * by.left_swing || by.right.excess() > 5 + 8 * by.right_swing)
            return false;
        const std::int32_t left_swing = commanded_.is_new() ? by.left_swing : 0;
        const std::int32_t right_swing = commanded_.is_new() ? by.right_swing : 0;
        return odometry_.is_near_arc(by.left.bow() + left_swing, by.right.bow() + right_swing,
                                     by.left.farthest() + 8 * left_swing,
                                     by.right.farthest() + 8 * right_swing);
    }
    static constexpr bool is_save(routine steps) { return steps.data() == routine{routines::save}.data(); }
    static constexpr bool changes_mode(const prepared_command& c) {
        return !c.steps.empty() && (c.then == effect::enabled || is_save(c.steps));
    }

    const differential* base_ = nullptr;
    odometry odometry_{};
    both_wheels last_{};
    commanded_motion commanded_{};
    std::uint16_t epoch_ = 0;
    std::uint8_t acceleration_ = 5;
};

namespace detail {
/// A twist with the machine that it is of.
struct twist_of {
    const differential& base;
    const twist& wanted;

    constexpr prepared_command plan(const cached_settings& cached) const {
        const wheel_speeds both = base.wheels(wanted, cached.resolution, limit_in(cached));
        return {.steps = routines::velocity,
                .arguments = {commands::as_word(both.left), commands::as_word(both.right)},
                .then = effect::motion,
                .refusal = needs(cached, operating_mode::velocity)};
    }

  private:
    // In counts: beyond 2008h the drive raises a fault [errata B5].
    static constexpr std::uint32_t limit_in(const cached_settings& cached) {
        const std::uint32_t reached = std::uint32_t{cached.max_speed} * cached.resolution;
        const auto most = static_cast<std::uint32_t>(left_target_speed.limits.high);
        return reached < most ? reached : most;
    }
};
} // namespace detail

/// One ZLAC8015D on a line whose motors are the wheels of a robot; a `drive` with a pose.
template <class Line> class robot : public basic_drive<Line, robot_model> {
    using base = basic_drive<Line, robot_model>;

  public:
    constexpr robot(Line& wire, std::uint8_t at, const differential& on, const supervision& by)
        : robot{wire, servobus::node<device>{at}, on, by} {}
    /// With limits and gaps of its own.
    constexpr robot(Line& wire, const servobus::node<device>& at, const differential& on,
                    const supervision& by)
        : base{wire, at, by} {
        this->model().set_base(on);
    }
    robot(Line&, std::uint8_t, const differential&&, const supervision&) = delete; // it is referred to
    robot(Line&, const servobus::node<device>&, const differential&&, const supervision&) = delete;

    using base::begin;
    using base::run;
    /// Velocity mode: drives both wheels by a twist, rounded to whole counts of their speeds. Above the drive's limit,
    /// 2008h, both slow down by one factor, so that the path is kept. Errors: `wrong_state`, `needs_init`.
    routine_status run(const twist& wanted) { return base::run(with_geometry(wanted)); }
    [[nodiscard]] constexpr errc begin(const twist& wanted) { return base::begin(with_geometry(wanted)); }
    /// A twist with this robot's wheels, as `why` asks for it.
    constexpr detail::twist_of with_geometry(const twist& wanted) const {
        return {this->model().base(), wanted};
    }

    /// Where the robot was at the pose's time, when the request for the last feedback began to leave. The pose begins
    /// at x 0, y 0, heading 0 with the first feedback. It is continuous unless the way since then is not known: no
    /// feedback yet, a restart of the drive, `init`, a lost port, cleared positions, a gap between two feedbacks in
    /// which the path may have left its arc by more than 0.75 mm. `set_pose` makes it continuous again.
    constexpr plane_pose pose() const {
        plane_pose p = this->model().pose();
        const bool is_same = this->model().epoch() == this->machine().known().epoch_of_positions();
        p.is_continuous = p.is_continuous && is_same && this->state() != drive_state::needs_init;
        return p;
    }
    /// States by how much a wheel's speed changes in a second at most, in r/min of its motor: 500 r/min until this is
    /// called, 100 to 25 500 r/min in steps of 100; more counts as 25 500. It is a limit of the robot, as its program
    /// shapes the twists and the drive its ramps. A lower one keeps the pose over longer gaps in which the twist
    /// changes.
    constexpr void set_acceleration(speed in_a_second) {
        constexpr std::uint32_t step = 252'000u; // counts of a tenth of a r/min in a millisecond
        const auto counts = static_cast<std::uint32_t>(in_a_second.count() < 0 ? 0 : in_a_second.count());
        std::uint32_t tenths = 1;
        while (tenths < 255 && tenths * step < counts) ++tenths;
        this->model().set_acceleration(static_cast<std::uint8_t>(tenths));
    }
    /// The pose is this one since the last feedback.
    constexpr void set_pose(const plane_pose& here) { this->model().set_pose(here); }
};
template <class Line> robot(Line&, std::uint8_t, const differential&, const supervision&) -> robot<Line>;
template <class Line>
robot(Line&, const servobus::node<device>&, const differential&, const supervision&) -> robot<Line>;

} // namespace servobus::zlac8015d
