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

    constexpr void note(const block_feedback& r, const settings& known) {
        if (known.state == drive_state::needs_init) return; // counts from elsewhere after it
        const wheel_image left = left_in(r.words), right = right_in(r.words);
        if (r.epoch != epoch_) odometry_.restart(left.position, right.position);
        epoch_ = r.epoch;
        const duration took = since(odometry_.pose().time, r.taken);
        // Lost responses cost no pose while the robot keeps its twist.
        if (step_of_left(left_, left, took).is_steady() && step_of_right(right_, right, took).is_steady())
            odometry_.expect_arc(r.taken);
        (void)odometry_.update(left.position, right.position, r.taken);
        left_ = left;
        right_ = right;
    }
    /// Also a position that both wheels may have reached from zero, and not by their speeds from where they were: a restart
    /// puts both to zero.
    constexpr bool has_fallen(const block_feedback& r, const settings& known) const {
        if (model::has_fallen(r, known)) return true;
        const wheel_step left = step_of_left(left_in(r.before), left_in(r.words), r.between);
        const wheel_step right = step_of_right(right_in(r.before), right_in(r.words), r.between);
        return left.may_come_from_zero() && right.may_come_from_zero() && (left.is_odd() || right.is_odd());
    }
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        const axle& on = base_->base();
        return learn_counts(c, e, known, on.left().counts_of_motor_turn(), on.right().counts_of_motor_turn());
    }

  private:
    template <const auto& Position, const auto& Speed>
    static constexpr wheel_image wheel_in(const std::uint16_t* w) {
        const std::uint16_t* const position = w + image::place_of<Position>;
        return {join_words(position[0], position[1], device::facts.word_order),
                static_cast<std::int16_t>(w[image::place_of<Speed>])};
    }
    static constexpr wheel_image left_in(const std::uint16_t* w) {
        return wheel_in<left_actual_position, left_actual_speed>(w);
    }
    static constexpr wheel_image right_in(const std::uint16_t* w) {
        return wheel_in<right_actual_position, right_actual_speed>(w);
    }
    constexpr wheel_step step_of_left(const wheel_image& from, const wheel_image& to,
                                      duration between) const {
        return {from, to, between, base_->base().left().counts_of_motor_turn()};
    }
    constexpr wheel_step step_of_right(const wheel_image& from, const wheel_image& to,
                                       duration between) const {
        return {from, to, between, base_->base().right().counts_of_motor_turn()};
    }
    const differential* base_ = nullptr;
    odometry odometry_{};
    wheel_image left_{};
    wheel_image right_{};
    std::uint16_t epoch_ = 0;
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
    /// Velocity mode: drives both wheels by a twist, rounded to whole counts of their speeds. Above the drive's limit, 2008h,
    /// both slow down by one factor, so that the path is kept. Errors: `wrong_state`, `needs_init`.
    routine_status run(const twist& wanted) { return base::run(with_geometry(wanted)); }
    [[nodiscard]] constexpr errc begin(const twist& wanted) { return base::begin(with_geometry(wanted)); }
    /// A twist with this robot's wheels, as `why` asks for it.
    constexpr detail::twist_of with_geometry(const twist& wanted) const {
        return {this->model().base(), wanted};
    }

    /// Where the robot was at the pose's time, when the request for the last feedback began to leave. It begins at x 0, y 0,
    /// heading 0 with the first feedback. It is continuous unless the way since then is not known: no feedback yet, a
    /// restart of the drive, `init`, a lost port, cleared positions. `set_pose` makes it continuous again.
    constexpr plane_pose pose() const {
        plane_pose p = this->model().pose();
        const bool is_same = this->model().epoch() == this->machine().known().epoch_of_positions();
        p.is_continuous = p.is_continuous && is_same && this->state() != drive_state::needs_init;
        return p;
    }
    /// The pose is this one since the last feedback.
    constexpr void set_pose(const plane_pose& here) { this->model().set_pose(here); }
};
template <class Line> robot(Line&, std::uint8_t, const differential&, const supervision&) -> robot<Line>;
template <class Line>
robot(Line&, const servobus::node<device>&, const differential&, const supervision&) -> robot<Line>;

} // namespace servobus::zlac8015d
