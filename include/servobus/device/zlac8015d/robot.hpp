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
#include <type_traits>

#include <servobus/axis/differential.hpp>
#include <servobus/axis/plane_pose.hpp>
#include <servobus/control/axis_commands.hpp>
#include <servobus/device/zlac8015d/drive.hpp>
#include <servobus/device/zlac8015d/robot_model.hpp>
#include <servobus/device/zlac8015d/shaped_speeds.hpp>

namespace servobus::zlac8015d {

namespace detail {
/// A twist of a robot, begun now.
struct twist_of {
    const robot_model& robot;
    const twist& wanted;
    instant now;

    constexpr robot_command prepare(const cached_settings& cached) const {
        return robot.prepare(wanted, now, cached);
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
    /// Velocity mode: changes the speeds of both wheels to those of a twist, within the limits, by a setpoint every
    /// 20 ms. It ends when the twist is ordered. Speeds are whole counts. Above the top speed, or 2008h, both wheels
    /// are slowed down by one factor, so that the path is kept. Errors: `wrong_state`, `needs_init`.
    command_status run(const twist& wanted) {
        for (;;) {
            const instant begun = this->line().now();
            const command_status how = base::run(with_geometry(wanted));
            if (!how || !is_changing_speed()) return how;
            if (!shaped_speeds::pause(*this, begun)) return errc::clock_stopped;
        }
    }
    /// True for a command that its blocking call repeats until it is reached.
    template <class Wanted> static constexpr bool repeats = std::is_same_v<Wanted, twist>;
    /// Begins one setpoint on the way to a twist. A program begins its latest twist every 20 ms or so, as a
    /// `setpoint_loop` does. Errors likewise.
    constexpr command_status begin(const twist& wanted) { return base::begin(with_geometry(wanted)); }
    /// True while the twist that was begun last is not reached: it is to be begun again.
    constexpr bool is_changing_speed() const {
        return this->model().is_changing() && this->state() == drive_state::enabled;
    }
    /// A twist with this robot's wheels, as `why` asks for it.
    constexpr detail::twist_of with_geometry(const twist& wanted) const {
        return {this->model(), wanted, this->line().now()};
    }

    /// Where the robot was at the pose's time, when the request for the last feedback began to leave. While the robot
    /// is to move and is seen where it stood, the time is up to 250 ms earlier: it may be a late response. The pose
    /// begins at x 0, y 0, heading 0 with the first feedback. It is not continuous after a restart of the drive,
    /// `init`, a lost port or cleared positions. Nor is it after a gap between two feedbacks in which the path may
    /// have left its arc by more than 0.75 mm. `set_pose` makes it continuous again.
    constexpr plane_pose pose() const {
        plane_pose p = this->model().pose();
        const bool is_same = this->model().epoch() == this->machine().known().feedback().epoch_of_positions();
        p.is_continuous = p.is_continuous && is_same && this->state() != drive_state::needs_init;
        return p;
    }
    /// Limits the speeds of the wheels over the ground: `top`, and the times from standstill to it and back. By default
    /// a motor gains and loses 500 r/min in a second, and 2008h is the top. The next `init` writes the time in which
    /// the drive stops without the program, 2084h: no harder than the limits, by default 500 ms. Lower limits also keep
    /// the pose over longer gaps. Errors:
    /// - `wrong_state` while the drive is enabled
    /// - `bad_argument` for a profile that is not whole or has a start
    /// - `out_of_range` above 3276 r/min of a motor, 6553 r/min in a second, or 17 s
    constexpr status set_limits(const axis_profile& by) {
        if (this->state() == drive_state::enabled) return errc::wrong_state;
        const wheel_speeds top = this->model().base().wheels({by.top, {}}, 10, 0x7FFF);
        const std::int32_t left = top.left < 0 ? -top.left : top.left;
        const std::int32_t right = top.right < 0 ? -top.right : top.right;
        const std::int32_t slower = left < right ? left : right;
        const result<speed_limits> made = speed_limits::of(by, top.is_limited ? 0x8000 : slower);
        if (made) this->model().set_limits(*made);
        return made.error();
    }
    /// The pose is this one since the last feedback.
    constexpr void set_pose(const plane_pose& here) { this->model().set_pose(here); }
};
template <class Line> robot(Line&, std::uint8_t, const differential&, const supervision&) -> robot<Line>;
template <class Line>
robot(Line&, const servobus::node<device>&, const differential&, const supervision&) -> robot<Line>;

} // namespace servobus::zlac8015d
