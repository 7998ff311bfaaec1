// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles what a stepper shows while it moves: less than a turn, at 20 r/min at most.
#pragma once

#include <cstdint>
#include <optional>

#include "yako_hands.hpp"

namespace tool {

class yako_motions : public yako_hands {
  protected:
    using yako_hands::yako_hands;

    // Reads bit 1 while the motor moves from home to the offset; only of a drive that was not homed before.
    void homed_at_an_offset() {
        namespace y = servobus::yako;
        enable();
        const bool was_homed = has(bits::homed_bit);
        (void)write_number(y::home_offset.address, 40);
        (void)on_->write(y::homing_offset_mode.address,
                         static_cast<u16>(y::offset_handling::move_position_actual));
        (void)on_->write(y::closed_loop::homing_method.address,
                         static_cast<u16>(y::homing::current_position));
        command(motion::home());
        const bool is_moving = is_in_motion();
        const u16 now = status();
        if (is_moving && !was_homed && (now & bits::moving_bit) != 0)
            found("is_homed_before_offset", (now & bits::homed_bit) != 0);
        (void)rests();
    }

    // Bit 0 before any move since power-on is asked after the power cycle; here after a move, a jog, and its stop.
    void in_position() {
        enable();
        moves(20);
        (void)is_in_motion();
        (void)rests();
        on_->wait(servobus::milliseconds(500));
        command(motion::jog());
        const bool is_moving = is_in_motion();
        const u16 in_motion = status();
        stop();
        on_->wait(servobus::milliseconds(500));
        if (!is_moving || (in_motion & bits::moving_bit) == 0) return;
        is_set_in_motion_ = (in_motion & bits::in_position_bit) != 0;
        is_set_after_stop_ = has(bits::in_position_bit);
    }
    void judge_in_position(bool is_set_at_power_on) {
        if (!is_set_in_motion_ || !is_set_after_stop_) return;
        if (*is_set_in_motion_)
            found("in_position", "until_next_move");
        else if (!*is_set_after_stop_)
            found("in_position", "at_target");
        else if (!is_set_at_power_on)
            found("in_position", "after_first_move");
        // `at_rest` or `until_commanded`: they differ for the two milliseconds after a command alone.
    }

    void what_clears_homed() {
        enable();
        home_here();
        if (!has(bits::homed_bit)) return;
        command(motion::emergency_stop());
        wait();
        if (!has(bits::homed_bit)) return found("homed", "until_place_lost");
        search();
        if (is_in_motion()) {
            const u16 now = status();
            if ((now & bits::moving_bit) != 0)
                found("homed", (now & bits::homed_bit) != 0 ? "always" : "until_homing");
        }
        stop_in_any_case();
    }

    void stop_while_homing() {
        enable();
        search();
        if (!is_in_motion()) return;
        command(motion::stop());
        found("stops_homing", until([&] { return !has(bits::moving_bit); }, 20));
        stop_in_any_case();
    }

    // A ramp of 2 s: to 1000 r/min it leads to 5 r/min in a hundredth of it.
    void ramp() {
        namespace y = servobus::yako;
        enable();
        (void)on_->write(y::jog_acceleration_time.address, 2000);
        command(motion::jog());
        if (!is_in_motion()) return;
        on_->wait(servobus::milliseconds(200));
        const int early = speed();
        const bool is_full_later = until([&] { return speed() >= slow; }, 80);
        if (is_full_later) found("ramps_to_1000_r_per_min", early >= slow - 1);
        stop();
    }

    // 200 pulses forward, interrupted soon by 50 more.
    void interrupted_move() {
        namespace y = servobus::yako;
        enable();
        const std::int32_t from = position();
        moves(200);
        if (!is_in_motion()) return;
        (void)write_number(y::target_position.address, 50);
        command(motion::move(y::positioning::relative, y::while_moving::interrupt));
        wait();
        if (!rests()) return stop();
        const std::int32_t way = position() - from;
        if (way > 45 && way < 190) found("interrupts_from_target", false);
        if (way >= 240 && way <= 260) found("interrupts_from_target", true);
    }

    // 20 counts in tenths are 2 r/min, or 20 if only the feedback is in tenths.
    void speed_unit() {
        namespace c = servobus::yako::closed_loop;
        enable();
        (void)on_->write(c::speed_resolution.address, 1);
        (void)on_->write(c::jog_speed.address, 20);
        command(motion::jog());
        if (is_in_motion()) {
            on_->wait(servobus::milliseconds(500));
            const int counts = speed();
            if (counts >= 15 && counts <= 25) found("rescales_feedback_only", false);
            if (counts >= 150 && counts <= 250) found("rescales_feedback_only", true);
        }
        stop();
        (void)on_->write(c::speed_resolution.address, 0);
    }

  private:
    std::optional<bool> is_set_in_motion_{}; // bit 0 during a jog
    std::optional<bool> is_set_after_stop_{};
};

} // namespace tool
