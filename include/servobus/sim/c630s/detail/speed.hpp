// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: speed and torque control of the simulated C630S: sources, ramps and limits, the segments of group
// P12, jog and zero clamp. Source: manual V24.111, sections 6.2, 6.3, 7.6, 7.7 and 7.15.
#pragma once

#include <cstdint>

#include <servobus/sim/c630s/detail/homing.hpp>

namespace servobus::sim::detail {

class c630s_speed : protected c630s_homing {
  protected:
    using c630s_homing::c630s_homing;

    constexpr void begin_speed() {
        segment_ = 1;
        elapsed_ = 0;
        is_through_ = false;
        command_.place(motor_.position());
    }

    /// 1 or -1 while one of FunIN.18 and FunIN.19 is active, otherwise 0.
    constexpr std::int64_t jog() const {
        return (given(function::jog_forward) ? 1 : 0) - (given(function::jog_reverse) ? 1 : 0);
    }

    /// One tick at the jog speed.
    constexpr void run_jog() {
        const std::int64_t pace =
            options_.jog_follows_command ? value(coolmay::target_speed) : value(coolmay::jog_speed);
        wanted_speed_ = limited(jog() * pace * shaft::r_per_min);
        turn(wanted_speed_, value(coolmay::acceleration_time), value(coolmay::deceleration_time));
    }

    /// One tick of speed control.
    constexpr void run_speed() {
        ramp_up_ = value(coolmay::acceleration_time);
        ramp_down_ = value(coolmay::deceleration_time);
        std::int64_t wanted = selected_speed();
        if (given(function::speed_direction)) wanted = -wanted;
        const std::int64_t clamp = value(coolmay::zero_clamp_threshold) * shaft::r_per_min;
        const bool is_clamped = given(function::zero_clamp) && shaft::size(wanted) <= clamp;
        wanted_speed_ = is_clamped ? 0 : limited(wanted);
        turn(wanted_speed_, ramp_up_, ramp_down_);
    }

    /// One tick of torque control.
    constexpr void run_torque() {
        std::int64_t wanted = selected_torque();
        if (given(function::torque_direction)) wanted = -wanted;
        wanted_speed_ = 0;
        std::int64_t forward = value(coolmay::forward_speed_limit);
        std::int64_t reverse = value(coolmay::reverse_speed_limit);
        const auto source = memory_.get(coolmay::speed_limit_source);
        if (source == coolmay::speed_limit::by_input) {
            if (!given(function::speed_limit_selection)) forward = reverse;
            reverse = forward;
        } else if (source == coolmay::speed_limit::analogue) {
            const auto input = static_cast<std::size_t>(value(coolmay::speed_limit_input) - 1);
            forward = shaft::size(analogue(input, value(coolmay::speed_at_10_v)));
            reverse = forward;
        }
        forward *= shaft::r_per_min;
        reverse *= shaft::r_per_min;
        if (is_barred(1)) forward = 0;
        if (is_barred(-1)) reverse = 0;
        motor_.push(wanted, forward, reverse);
        is_speed_limited_ = motor_.speed() >= forward || motor_.speed() <= -reverse;
        command_.place(motor_.position());
    }

    /// Sets the torque limits by P07-07. Called before a tick.
    constexpr void set_torque_limits() {
        std::int64_t forward = value(coolmay::positive_internal_torque_limit);
        std::int64_t reverse = value(coolmay::negative_internal_torque_limit);
        const auto input = static_cast<std::size_t>(value(coolmay::torque_limit_input) - 1);
        const std::int64_t voltage = shaft::size(analogue(input, value(coolmay::torque_at_10_v) * 10));
        const bool is_forward = given(function::positive_torque_limit);
        const bool is_reverse = given(function::negative_torque_limit);
        const std::int64_t external_forward = value(coolmay::positive_external_torque_limit);
        const std::int64_t external_reverse = value(coolmay::negative_external_torque_limit);
        switch (memory_.get(coolmay::torque_limit_source)) {
        case coolmay::torque_limit::internal: break;
        case coolmay::torque_limit::external:
            if (is_forward) forward = external_forward;
            if (is_reverse) reverse = external_reverse;
            break;
        case coolmay::torque_limit::analogue:
            forward = voltage;
            reverse = voltage;
            break;
        case coolmay::torque_limit::external_or_analogue:
            forward = shaft::lesser(is_forward ? external_forward : forward, voltage);
            reverse = shaft::lesser(is_reverse ? external_reverse : reverse, voltage);
            break;
        case coolmay::torque_limit::internal_or_analogue:
            if (is_forward) forward = voltage;
            if (is_reverse) reverse = voltage;
            break;
        }
        motor_.set_limits(forward, reverse);
    }

    std::int64_t wanted_speed_ = 0; // P0B-01, in 10^-6 r/min
    bool is_speed_limited_ = false;

  private:
    constexpr void turn(std::int64_t speed, std::int64_t up_ms, std::int64_t down_ms) {
        if (is_barred(speed > 0 ? 1 : speed < 0 ? -1 : 0)) return stop_and_hold();
        if (speed == 0 && motor_.stands() && command_.stands()) { // at zero speed the position is held
            motor_.follow(command_, fastest());
            return;
        }
        motor_.ramp_to(speed, shaft::change_of(up_ms), shaft::change_of(down_ms));
        command_.place(motor_.position());
    }

    constexpr std::int64_t limited(std::int64_t wanted) {
        const std::int64_t forward =
            shaft::lesser(fastest(), value(coolmay::max_forward_speed) * shaft::r_per_min);
        const std::int64_t reverse =
            shaft::lesser(fastest(), value(coolmay::max_reverse_speed) * shaft::r_per_min);
        const std::int64_t allowed = shaft::between(-reverse, wanted, forward);
        is_speed_limited_ = allowed != wanted;
        return allowed;
    }

    constexpr std::int64_t speed_of(std::int64_t source) {
        switch (static_cast<coolmay::speed_source>(source)) {
        case coolmay::speed_source::ai1: return analogue(0, value(coolmay::speed_at_10_v) * shaft::r_per_min);
        case coolmay::speed_source::ai2: return analogue(1, value(coolmay::speed_at_10_v) * shaft::r_per_min);
        case coolmay::speed_source::segments: return segment_speed();
        default: return value(coolmay::target_speed) * shaft::r_per_min;
        }
    }
    constexpr std::int64_t selected_speed() {
        const std::int64_t a = value(coolmay::main_speed_source);
        const std::int64_t b = value(coolmay::auxiliary_speed_source);
        switch (memory_.get(coolmay::speed_command_selection)) {
        case coolmay::command_selection::auxiliary: return speed_of(b);
        case coolmay::command_selection::sum: return speed_of(a) + speed_of(b);
        case coolmay::command_selection::switched:
            return speed_of(given(function::command_selection) ? b : a);
        default: return speed_of(a);
        }
    }

    constexpr std::int64_t torque_of(std::int64_t source) const {
        if (source == 0) return value(coolmay::target_torque);
        return analogue(source == 1 ? 0 : 1, value(coolmay::torque_at_10_v) * 10);
    }
    constexpr std::int64_t selected_torque() const {
        const std::int64_t a = torque_of(value(coolmay::main_torque_source));
        const std::int64_t b = torque_of(value(coolmay::auxiliary_torque_source));
        switch (memory_.get(coolmay::torque_command_selection)) {
        case coolmay::command_selection::auxiliary: return b;
        case coolmay::command_selection::sum: return a + b;
        case coolmay::command_selection::switched: return given(function::command_selection) ? b : a;
        case coolmay::command_selection::bus: return 0; // the manual documents no parameter for it
        default: return a;
        }
    }

    constexpr std::int64_t segment_value(std::uint16_t first) const {
        return value(static_cast<std::uint16_t>(first + 3 * (segment_ - 1)));
    }
    // The run time in ms; its unit is 0.1 s or 0.1 min.
    constexpr std::int64_t segment_time() const {
        const std::int64_t unit = value(coolmay::speed_segment_time_unit) != 0 ? 6000 : 100;
        return segment_value(coolmay::speed_segment_run_times[0].address) * unit;
    }
    constexpr std::int64_t segment_speed() {
        const auto mode = memory_.get(coolmay::speed_segment_mode);
        if (mode == coolmay::segment_mode::by_input) {
            segment_ = 1 + (given(function::segment_selection_1) ? 1 : 0) +
                       (given(function::segment_selection_2) ? 2 : 0) +
                       (given(function::segment_selection_3) ? 4 : 0) +
                       (given(function::segment_selection_4) ? 8 : 0);
        } else {
            for (int skipped = 0; skipped < 16 && !is_through_ && elapsed_ >= segment_time(); ++skipped)
                next_segment(mode);
            ++elapsed_;
        }
        const std::int64_t pair = segment_value(coolmay::speed_segment_ramps[0].address);
        const auto at =
            static_cast<std::uint16_t>(coolmay::segment_acceleration_time_1.address + 2 * (pair - 1));
        ramp_up_ = pair == 0 ? 0 : value(at);
        ramp_down_ = pair == 0 ? 0 : value(static_cast<std::uint16_t>(at + 1));
        if (is_through_) return 0;
        const std::int64_t speed = segment_value(coolmay::speed_segment_speeds[0].address) * shaft::r_per_min;
        return given(function::segment_direction) ? -speed : speed;
    }
    constexpr void next_segment(coolmay::segment_mode mode) {
        elapsed_ = 0;
        if (segment_ < value(coolmay::last_speed_segment)) {
            ++segment_;
        } else if (mode == coolmay::segment_mode::cyclic) {
            segment_ = 1;
        } else {
            is_through_ = true;
        }
    }

    std::int64_t ramp_up_ = 0;
    std::int64_t ramp_down_ = 0;
    std::int64_t segment_ = 1;
    std::int64_t elapsed_ = 0; // ms
    bool is_through_ = false;
};

} // namespace servobus::sim::detail
