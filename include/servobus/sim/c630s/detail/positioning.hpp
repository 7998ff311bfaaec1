// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: position control of the simulated C630S: pulses, the step of P05-05 and the segments of group
// P11. Source: manual V24.111, sections 6.1.3, 7.5 and 7.14.
#pragma once

#include <cstdint>

#include <servobus/sim/c630s/plant.hpp>

namespace servobus::sim::detail {

class c630s_positioning : protected c630s_plant {
  protected:
    using c630s_plant::c630s_plant;

    constexpr bool is_positioning() const { return phase_ != phase::idle; }
    constexpr bool is_commanding() const { return phase_ == phase::pulses || phase_ == phase::segment; }

    /// Starts position control at the motor's position.
    constexpr void begin_positioning() {
        command_.place(motor_.position());
        phase_ = phase::idle;
        gear_rest_ = 0;
    }
    /// Ends the motion in progress; the remaining segments may be finished later (P11-02).
    constexpr void interrupt() {
        if (phase_ == phase::segment || phase_ == phase::wait) {
            has_remainder_ = value(coolmay::position_segment_mode) !=
                             static_cast<std::int64_t>(coolmay::segment_mode::by_input);
            rest_ = phase_ == phase::segment ? target_ - command_.position() : 0;
        }
        phase_ = phase::idle;
    }
    constexpr void forget_remainder() { has_remainder_ = false; }
    /// Carries out FunIN.35.
    constexpr void clear_deviation() {
        target_ -= command_.position() - motor_.position();
        if (command_.position() != motor_.position()) command_.place(motor_.position());
    }

    /// Takes pulses from the pulse input, in reference units.
    constexpr void take_pulses(std::int64_t count) {
        if (given(function::position_command_inhibit) || given(function::pulse_inhibit)) return;
        add(count, fastest());
    }

    /// One tick. False if a limit switch blocks the way.
    constexpr bool run_position() {
        if (value(coolmay::gear_switching_condition) != 0 || command_.stands())
            has_second_gear_ = given(function::gear_selection);
        if (inputs_.take_edge(function::clear_following_error)) clear_deviation();
        const bool is_step = inputs_.take_edge(function::step_enable);
        const bool is_start = inputs_.take_edge(function::position_segment_start) &&
                              (!options_.segment_start_is_level || given(function::position_segment_start));
        if (given(function::position_command_inhibit)) {
            interrupt();
        } else if (is_step && value(coolmay::position_command_source) == 1) {
            add(value(coolmay::position_step), step_speed);
            ++starts_;
        } else if (is_start && value(coolmay::position_command_source) == 2 && phase_ == phase::idle) {
            start_segments();
        }
        const bool is_free = advance();
        motor_.follow(command_, fastest());
        return is_free;
    }

    std::uint32_t starts_ = 0;

  private:
    enum class phase : std::uint8_t { idle, pulses, segment, wait };
    static constexpr std::int64_t step_speed = 100 * shaft::r_per_min;

    constexpr std::int64_t sign() const { return given(function::position_direction) ? -1 : 1; }
    constexpr std::uint16_t segment_row(std::uint16_t first) const {
        return static_cast<std::uint16_t>(first + 5 * (segment_ - 1));
    }

    constexpr void add(std::int64_t reference_units, std::int64_t speed) {
        if (phase_ != phase::pulses) target_ = command_.position();
        target_ += sign() * to_counts(reference_units);
        speed_ = speed;
        phase_ = phase::pulses;
    }

    constexpr void start_segments() {
        const auto mode = memory_.get(coolmay::position_segment_mode);
        const bool finishes =
            memory_.get(coolmay::position_segment_remainder) == coolmay::segment_remainder::finish;
        ++starts_;
        if (mode == coolmay::segment_mode::by_input) {
            segment_ = 1 + (given(function::segment_selection_1) ? 1 : 0) +
                       (given(function::segment_selection_2) ? 2 : 0) +
                       (given(function::segment_selection_3) ? 4 : 0) +
                       (given(function::segment_selection_4) ? 8 : 0);
            return begin_segment();
        }
        if (has_remainder_ && finishes) {
            has_remainder_ = false;
            target_ = command_.position() + rest_;
            phase_ = phase::segment;
            return;
        }
        segment_ = 1;
        if (mode == coolmay::segment_mode::sequential)
            segment_ = shaft::greater(1, value(coolmay::first_position_segment));
        begin_segment();
    }

    constexpr void begin_segment() {
        const std::int64_t units =
            sign() * value(segment_row(coolmay::position_segment_displacements[0].address));
        const bool is_absolute = value(coolmay::position_segment_type) != 0;
        target_ = is_absolute ? zero_ + to_counts(units) : command_.position() + relative_counts(units);
        has_remainder_ = false;
        phase_ = phase::segment;
    }

    constexpr std::int64_t relative_counts(std::int64_t units) {
        if (!options_.gear_keeps_rest) return to_counts(units);
        const ratio g = gear();
        const std::int64_t parts = units * g.numerator + gear_rest_;
        const std::int64_t counts = shaft::between(-farthest, parts / g.denominator, farthest);
        gear_rest_ = parts % g.denominator;
        return counts;
    }

    constexpr std::int64_t unit_of_time() const {
        return value(coolmay::position_segment_time_unit) != 0 ? 1000 : 1;
    }

    constexpr bool advance() {
        if (is_commanding() && target_ != command_.position() &&
            is_barred(target_ > command_.position() ? 1 : -1))
            return false;
        switch (phase_) {
        case phase::idle: // an interrupted motion slows down
            command_.ramp_to(0, stop_change, last_change_);
            return true;
        case phase::pulses:
            if (command_.approach(target_, speed_, 0)) phase_ = phase::idle;
            return true;
        case phase::segment: {
            const std::int64_t speed =
                value(segment_row(coolmay::position_segment_speeds[0].address)) * shaft::r_per_min;
            const std::int64_t ms =
                value(segment_row(coolmay::position_segment_acceleration_times[0].address)) * unit_of_time();
            last_change_ = shaft::change_of(ms);
            if (command_.approach(target_, speed, ms)) begin_wait();
            return true;
        }
        case phase::wait:
            if (--wait_ <= 0) end_segment();
            return true;
        }
        return true;
    }

    constexpr void begin_wait() {
        wait_ = value(segment_row(coolmay::position_segment_wait_times[0].address)) * unit_of_time();
        const bool runs_on = memory_.get(coolmay::position_segment_mode) == coolmay::segment_mode::sequential;
        phase_ = phase::wait;
        if (runs_on || wait_ == 0) end_segment();
    }

    constexpr void end_segment() {
        const std::int64_t last = value(coolmay::last_position_segment);
        const auto mode = memory_.get(coolmay::position_segment_mode);
        phase_ = phase::idle;
        if (mode == coolmay::segment_mode::by_input) return;
        if (segment_ >= last && mode != coolmay::segment_mode::cyclic) return;
        segment_ = segment_ >= last ? 1 : segment_ + 1;
        begin_segment();
    }

    std::int64_t target_ = 0;
    std::int64_t rest_ = 0;
    std::int64_t gear_rest_ = 0; // in parts of the gear's denominator
    std::int64_t speed_ = 0;
    std::int64_t wait_ = 0; // ms
    std::int64_t last_change_ = stop_change;
    std::int64_t segment_ = 1;
    phase phase_ = phase::idle;
    bool has_remainder_ = false;
};

} // namespace servobus::sim::detail
