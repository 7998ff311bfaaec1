// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the commands that change the speeds of the wheels, since the last feedback and until the wheels are
// stopped. zlac8015d/robot_model.hpp includes it.
//
//     constexpr bool changes_speeds(const zlac8015d::prepared_command& c) {
//         zlac8015d::commanded_motion commanded;
//         commanded.begin(c);
//         return commanded.is_new(); // no read, no wait, no twist again
//     }
#pragma once

#include <cstdint>

#include <servobus/control/drive_model.hpp>
#include <servobus/device/zlac8015d/commands.hpp>

namespace servobus::zlac8015d {

class commanded_motion {
  public:
    /// True if a command since the last feedback may have changed a speed: any but a read, a wait, and the twist that
    /// the drive has acknowledged last.
    constexpr bool is_new() const { return is_new_; }
    /// True if the drive may have had a target other than zero since the last feedback.
    constexpr bool could_move() const { return could_move_; }

    /// True for a command that leaves the speeds as they are: a read, a wait, a setting.
    static constexpr bool keeps_speeds(const prepared_command& c) {
        const bool is_setting = c.then == effect::none || c.then == effect::timeout_set ||
                                c.then == effect::speeds_set || c.then == effect::positions_cleared;
        return is_without_motion(c) || (is_setting && c.stop == stop_priority::no_stop);
    }
    /// True for the routine of a twist: the speeds of both wheels.
    static constexpr bool sets_speeds(const prepared_command& c, routine steps) {
        return c.then == effect::motion && steps.data() == routine{routines::velocity}.data();
    }
    /// True for what a drive with shaped setpoints has from its `init`: its ramps, and the stop without the program.
    static constexpr bool sets_ramps(const prepared_command& c) {
        const step* const table = c.steps.data();
        return table == routine{routines::ramps}.data() ||
               table == routine{routines::quick_stop_ramp}.data() ||
               table == routine{routines::quick_stop_by}.data();
    }
    /// True for a read or a wait.
    static constexpr bool is_without_motion(const prepared_command& c) {
        return c.then == effect::seen || c.then == effect::arrived;
    }

    constexpr void begin(const prepared_command& c) {
        note(c, c.steps);
        may_move_ = may_move_ || moves(c, c.steps);
        could_move_ = could_move_ || may_move_;
    }
    constexpr void end(const prepared_command& c, const ending& e) {
        note(c, e.steps);
        if (is_without_motion(c)) return;
        has_twist_ = e.is_done && sets_speeds(c, e.steps);
        left_ = c.arguments[0];
        right_ = c.arguments[1];
        if (e.is_done && c.then == effect::motion) may_move_ = moves(c, e.steps);
        if (e.is_done && stops(c)) may_move_ = false;
    }
    constexpr void note_feedback() {
        is_new_ = false;
        could_move_ = may_move_;
    }

  private:
    static constexpr bool moves(const prepared_command& c, routine steps) {
        if (sets_speeds(c, steps)) return (c.arguments[0] | c.arguments[1]) != 0;
        return c.then == effect::motion || c.then == effect::moved;
    }
    static constexpr bool stops(const prepared_command& c) {
        return c.stop != stop_priority::no_stop || c.then == effect::enabled || c.then == effect::initialised;
    }
    constexpr void note(const prepared_command& c, routine steps) {
        const bool is_repeated =
            has_twist_ && sets_speeds(c, steps) && c.arguments[0] == left_ && c.arguments[1] == right_;
        is_new_ = is_new_ || (!is_repeated && !is_without_motion(c));
    }

    std::uint16_t left_ = 0; ///< of the twist that the drive has acknowledged
    std::uint16_t right_ = 0;
    bool has_twist_ = false;
    bool may_move_ = false; ///< now
    bool could_move_ = false;
    bool is_new_ = false;
};

} // namespace servobus::zlac8015d
