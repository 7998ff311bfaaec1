// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the state machine of the simulated YAKOTEC stepper: what starts, moves and stops the motor.
// sim/yako.hpp lists the assumptions.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/core/time.hpp>
#include <servobus/sim/yako/detail/axis.hpp>
#include <servobus/sim/yako/detail/commands.hpp>
#include <servobus/sim/yako/detail/homing.hpp>
#include <servobus/sim/yako/detail/memory.hpp>
#include <servobus/sim/yako/detail/terminals.hpp>
#include <servobus/sim/yako/options.hpp>

namespace servobus::sim {

namespace detail {

class yako_core {
  public:
    yako_core(const yako_core&) = delete;
    yako_core& operator=(const yako_core&) = delete;

  protected:
    using function = servobus::yako::input_function;
    using motion = yako_motion;

    constexpr yako_core(const yako_variant& of, const yako_options& chosen) : of_{of}, options_{chosen} {}

    constexpr std::uint16_t word_at(std::uint16_t address) const { return memory_[address]; }
    constexpr bool has_alarm() const { return alarm_ != 0; }
    constexpr bool is_released() const { return is_released_ || terminals_.is_on(function::motor_free); }
    constexpr bool is_moving() const {
        return now_.what != motion::none || (of_.has_encoder && !axis_.stands());
    }
    constexpr bool is_in_position() const {
        const bool is_near = !of_.has_encoder || magnitude(axis_.following_error()) <=
                                                     word_at(yako_rows::position_window.address);
        const bool is_settled =
            !is_released() && is_near && now_.what == motion::none &&
            still_us_ >= 1000 * std::int64_t{word_at(yako_rows::in_position_time.address)};
        switch (options_.in_position) {
        case yako_in_position::at_rest: return is_settled;
        case yako_in_position::until_commanded: return is_settled && next_.what == motion::none;
        case yako_in_position::after_first_move: return is_settled && has_positioned_;
        case yako_in_position::at_target: return is_settled && has_reached_;
        case yako_in_position::until_next_move: return has_reached_;
        }
        return false;
    }
    /// 1 or -1 while the position is beyond that software limit, otherwise 0.
    constexpr int software_limit() const {
        if (!is_homed_ || word_at(yako_rows::software_limits.address) == 0) return 0;
        const std::int64_t at = axis_.position();
        if (at > memory_.pair(yako_rows::positive_software_limit.address)) return 1;
        return at < memory_.pair(yako_rows::negative_software_limit.address) ? -1 : 0;
    }

    // Commands

    constexpr void command(std::uint16_t word) {
        using bits = servobus::yako::motion_code;
        if ((word & bits::emergency_stop_bit) != 0) return can_stop() ? quick_stop() : void();
        if ((word & bits::stop_bit) != 0) return can_stop() ? stop() : void();
        if ((word & bits::start_position_bit) != 0)
            return start(commands_.move((word & bits::absolute_bit) != 0), (word & bits::interrupt_bit) != 0);
        if ((word & bits::start_speed_bit) != 0) return start(commands_.jog(), false);
        if ((word & bits::start_homing_bit) != 0) start(commands_.home(), false);
    }

    constexpr bool can_start(bool interrupts) const {
        const bool is_busy = is_moving() || next_.what != motion::none;
        const bool is_stopped =
            terminals_.is_on(function::stop) || terminals_.is_on(function::emergency_stop);
        return !is_released() && !has_alarm() && !is_stopped && (!is_busy || interrupts);
    }
    constexpr void start(const yako_command& wanted, bool interrupts) {
        if (!can_start(interrupts)) return;
        next_ = wanted;
        wait_us_ = interrupts && is_moving() ? 0 : options_.start_delay.us;
        ++starts_;
        if (wait_us_ == 0) begin();
    }

    constexpr bool can_stop() const {
        const bool is_homing =
            now_.what == motion::homing || now_.what == motion::home_offset || next_.what == motion::homing;
        return options_.stops_homing || !is_homing;
    }
    constexpr void stop() {
        next_ = {};
        if (now_.what == motion::none) return;
        has_positioned_ = has_positioned_ || now_.what == motion::position;
        now_.what = motion::stopping;
        axis_.forget_target();
    }
    constexpr void stop_at_once() {
        next_ = now_ = {};
        if (!is_released()) axis_.halt();
    }
    constexpr void quick_stop() {
        stop_at_once();
        lose_place();
    }
    constexpr void release() {
        next_ = now_ = {};
        is_released_ = true;
        lose_place();
    }
    constexpr void lose_place() {
        if (options_.homed == yako_homed::until_place_lost) is_homed_ = false;
    }
    constexpr void enable() {
        if (has_alarm()) return;
        if (is_released_) axis_.energise();
        is_released_ = false;
    }
    constexpr void trip(std::uint16_t code) {
        was_enabled_ = !is_released_ || (has_alarm() && was_enabled_);
        if (!has_alarm()) alarm_ = code;
        if (options_.alarm != yako_alarm::holds) return release();
        stop_at_once();
        if (!is_released()) axis_.energise();
    }
    constexpr void clear_alarm() {
        if (cause_ != 0 || !has_alarm()) return;
        alarm_ = 0;
        if (options_.alarm == yako_alarm::clearing_enables && was_enabled_) enable();
    }

    // One tick

    constexpr void tick() {
        adopt_settings();
        terminals_.look();
        obey_inputs();
        if (next_.what != motion::none) {
            wait_us_ -= wheel::tick.us;
            if (wait_us_ <= 0) begin();
        }
        stop_at_limits();
        turn();
        watch_error();
        const bool is_still = now_.what == motion::none && axis_.stands();
        still_us_ = is_still ? smaller_of(still_us_ + wheel::tick.us, 1'000'000) : 0;
        quiet_ticks_ = is_still && terminals_.are_held() ? quiet_ticks_ + 1 : 0;
    }

    /// True if nothing changes until the next command or input.
    constexpr bool is_at_rest() const {
        return quiet_ticks_ >= ticks_to_settle && now_.what == motion::none && next_.what == motion::none &&
               segment_wait_us_ == 0 && (!of_.has_encoder || is_released() || axis_.following_error() == 0);
    }
    /// Counts a time at rest, in which a tick would do no more.
    constexpr void rest(std::int64_t us) {
        still_us_ = smaller_of(still_us_ + us, 1'000'000);
        terminals_.hold(us);
    }
    constexpr void stir() {
        still_us_ = smaller_of(still_us_, 500'000);
        quiet_ticks_ = 0;
    }

    constexpr void adopt_settings() {
        const bool is_reversed = word_at(yako_rows::motion_direction.address) != 0;
        const std::int64_t pulses = word_at(yako_rows::microstep_resolution.address);
        if (now_.what == motion::none && axis_.stands() && !axis_.agrees(is_reversed, pulses))
            axis_.adopt(is_reversed, pulses);
    }

  private:
    constexpr void begin() {
        const bool goes_on = now_.what == motion::position && options_.interrupts_from_target;
        const std::int64_t from = axis_.commanded() + (goes_on ? axis_.sign() * axis_.way_to_go() : 0);
        now_ = next_;
        next_ = {};
        if (now_.what == motion::position || options_.in_position != yako_in_position::until_next_move)
            has_reached_ = false;
        switch (now_.what) {
        case motion::position:
            axis_.aim(now_.is_relative ? from + axis_.sign() * now_.target : axis_.place_of(now_.target));
            return;
        case motion::homing:
            if (options_.homed != yako_homed::always) is_homed_ = false;
            home_direction_ = 0;
            homing_.begin(now_.method, is_switch_active(plan_of(now_.method).from, axis_.shaft()));
            if (homing_.is_at_home()) find_home();
            return;
        default: axis_.forget_target();
        }
    }

    // Inputs

    constexpr void obey_inputs() {
        if (terminals_.is_on(function::motor_free)) {
            next_ = now_ = {};
            was_freed_ = true;
            lose_place();
        } else if (was_freed_) {
            was_freed_ = false;
            if (!is_released_) axis_.energise();
        }
        if (terminals_.is_on(function::emergency_stop)) {
            if (now_.what != motion::none || next_.what != motion::none) stop_at_once();
        } else if (terminals_.is_on(function::stop)) {
            stop();
        }
        if (terminals_.has_risen(function::homing)) start(commands_.home(), false);
        if (terminals_.has_risen(function::position_move))
            start(commands_.move(word_at(yako_rows::io_positioning.address) != 0),
                  now_.what == motion::speed);
        if (terminals_.has_risen(function::pt_trigger)) segment_wait_us_ = pin_time_us;
        wait_for_segment();
        if (word_at(yako_rows::pv_trigger_mode.address) != 0 && terminals_.has_risen(function::pv_trigger))
            start(commands_.speed_segment(), now_.what == motion::speed);
        follow_levels();
    }

    // The PIN inputs must be stable from 5 ms before the trigger to 5 ms after it.
    constexpr void wait_for_segment() {
        if (segment_wait_us_ == 0) return;
        segment_wait_us_ -= wheel::tick.us;
        if (segment_wait_us_ != 0 || terminals_.held_us() < 2 * pin_time_us) return;
        const bool mixes = word_at(yako_rows::pv_trigger_mode.address) != 0;
        start(commands_.position_segment(), mixes && now_.what == motion::speed);
    }

    constexpr void follow_levels() {
        constexpr std::array<function, 4> level_functions{function::speed_move, function::jog_positive,
                                                          function::jog_negative, function::pv_trigger};
        const bool is_pv_level = word_at(yako_rows::pv_trigger_mode.address) == 0;
        for (const function f : level_functions) {
            const std::uint32_t bit = 1u << static_cast<unsigned>(f);
            if (f == function::pv_trigger && !is_pv_level) continue;
            if (!terminals_.is_on(f)) {
                spent_ &= ~bit;
                if (next_.from == f) next_ = {};
                if (now_.from == f && now_.what == motion::speed) stop();
            } else if (now_.from == f && now_.what == motion::speed) {
                if (f == function::pv_trigger && terminals_.held_us() >= pin_time_us) retune();
            } else if (next_.from != f && (spent_ & bit) == 0) {
                const std::uint32_t before = starts_;
                start(commands_.by_level(f), false);
                if (starts_ != before) spent_ |= bit; // once for each time it is active
            }
        }
    }
    constexpr void retune() { now_ = commands_.by_level(function::pv_trigger); }

    // Limits

    // The direction in which the motor turns, or at standstill the direction of its motion.
    constexpr int heading() const {
        const std::int64_t turning = axis_.speed();
        if (turning != 0) return turning > 0 ? 1 : -1;
        std::int64_t wanted = 0;
        switch (now_.what) {
        case motion::position:
        case motion::home_offset: wanted = axis_.way_to_go(); break;
        case motion::speed: wanted = now_.speed; break;
        case motion::homing: wanted = homing_.heading(); break;
        default: break;
        }
        return wanted > 0 ? 1 : wanted < 0 ? -1 : 0;
    }

    constexpr void stop_at_limits() {
        if (now_.what == motion::none) return;
        const int direction = heading();
        const bool is_at_limit = (direction > 0 && terminals_.is_active(function::positive_limit)) ||
                                 (direction < 0 && terminals_.is_active(function::negative_limit));
        if (!is_at_limit && (direction == 0 || software_limit() != direction)) return;
        if (now_.what == motion::homing) {
            if (homing_.expects_limit(direction)) return;
            if (homing_.turns_at_limit()) return homing_.turn();
        }
        const bool coasts = word_at(yako_rows::over_travel_stop_mode.address) == 0;
        coasts ? release() : stop_at_once();
    }

    // Motion

    constexpr void turn() {
        if (is_released()) return axis_.roll();
        switch (now_.what) {
        case motion::none: return axis_.hold();
        case motion::position:
        case motion::home_offset:
            axis_.approach(now_.speed, now_.start_speed, now_.acceleration, now_.deceleration);
            if (!axis_.has_arrived()) return;
            if (now_.what == motion::home_offset) set_home_position();
            if (now_.what == motion::position) has_positioned_ = has_reached_ = true;
            now_ = {};
            return;
        case motion::speed: return axis_.ramp_to(now_.speed, now_.acceleration, now_.deceleration);
        case motion::homing: return home();
        case motion::stopping:
            axis_.ramp_to(0, now_.deceleration, now_.deceleration);
            if (axis_.stands()) now_ = {};
        }
    }

    constexpr void home() {
        const std::int64_t fastest = homing_.is_fast() ? now_.speed : now_.start_speed;
        axis_.ramp_to(homing_.direction() * fastest, now_.acceleration, now_.deceleration);
        if (homing_.is_colliding()) {
            if (magnitude(axis_.following_error()) <= word_at(yako_rows::collision_threshold.address)) return;
            axis_.halt_at(axis_.shaft());
            home_direction_ = homing_.heading();
            if (homing_.collide()) find_home();
            return;
        }
        const std::int64_t end = axis_.shaft();
        const int step = end < axis_.shaft_before() ? -1 : 1;
        for (std::int64_t at = axis_.shaft_before();;) {
            const bool is_new = at != end;
            if (is_new) at += step;
            const bool is_index = is_new && of_.has_encoder && axis_.geometry().is_index(at);
            if (homing_.pass(is_switch_active(homing_.from(), at), is_index)) {
                axis_.halt_at(at);
                home_direction_ = homing_.heading();
                return find_home();
            }
            if (at == end) break;
        }
        if (homing_.direction() == 0 && axis_.stands()) homing_.stood();
    }

    constexpr bool is_switch_active(yako_homing_plan::signal s, std::int64_t at) const {
        using enum yako_homing_plan::signal;
        switch (s) {
        case negative_limit: return terminals_.is_active(function::negative_limit, at);
        case positive_limit: return terminals_.is_active(function::positive_limit, at);
        case yako_homing_plan::signal::home: return terminals_.is_active(function::home, at);
        default: return false;
        }
    }

    // By 0030h: modes 0..5 move by the offset first, modes 6..11 do not move.
    constexpr void find_home() {
        home_ = axis_.shaft();
        if (now_.offset_mode >= 6 || now_.target == 0) {
            set_home_position();
            now_ = {};
            return;
        }
        now_.what = motion::home_offset;
        is_homed_ = is_homed_ || options_.is_homed_before_offset;
        now_.start_speed = 0;
        axis_.aim(axis_.commanded() + axis_.sign() * now_.target);
    }
    constexpr void set_home_position() {
        const std::int64_t offset = now_.target;
        const std::int64_t actual = axis_.position();
        switch (now_.offset_mode % 6) {
        case 0: axis_.set_position(offset); break;
        case 1: axis_.set_position(0); break;
        case 2: axis_.set_position(-offset); break;
        case 4: axis_.set_position(actual + offset); break;
        case 5: axis_.set_position(actual - offset); break;
        default: break; // 3: the counter keeps its value
        }
        is_homed_ = true;
    }

    constexpr void watch_error() {
        if (!of_.has_encoder || is_released()) return;
        if (magnitude(axis_.following_error()) > word_at(yako_rows::following_error_limit.address))
            trip(following_error_alarm);
    }

    static constexpr std::int64_t pin_time_us = 5000;
    // The first tick carries out what a command or an input has changed. The others are a margin.
    static constexpr std::uint32_t ticks_to_settle = 20;

  protected:
    static constexpr std::uint16_t following_error_alarm = 4; // the manual gives its codes no meaning

    const yako_variant& of_;
    yako_options options_;
    yako_memory memory_{of_, options_.kept};
    yako_axis axis_{of_.has_encoder};
    yako_terminals terminals_{of_, memory_, axis_};
    yako_commands commands_{of_, memory_, terminals_, options_};
    yako_homing homing_{};
    yako_command now_{};
    yako_command next_{};
    std::int64_t wait_us_ = 0;
    std::int64_t still_us_ = 0;
    std::int64_t segment_wait_us_ = 0;
    std::int64_t home_ = 0;
    std::uint32_t quiet_ticks_ = 0; // at standstill, since the last command or change of an input
    std::uint32_t starts_ = 0;
    std::uint32_t spent_ = 0; // functions whose active input has started its motion
    std::uint16_t alarm_ = 0;
    std::uint16_t cause_ = 0;
    int home_direction_ = 0;
    bool is_homed_ = false;
    bool is_released_ = false;
    bool was_freed_ = false;
    bool was_enabled_ = false;    // when the alarm was raised
    bool has_positioned_ = false; // since power-on
    bool has_reached_ = false;    // the target of the last position move
};

} // namespace detail
} // namespace servobus::sim
