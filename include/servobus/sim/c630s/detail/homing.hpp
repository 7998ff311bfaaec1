// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: homing of the simulated C630S: the ten modes of P05-31, the way to the electrical home, and the
// current position as home. Source: manual V24.111, section 7.5. The manual does not state in which direction
// the motor approaches the edge; the model searches at high speed, backs off at low speed until the signal is
// inactive, and approaches it again at low speed.
#pragma once

#include <cstdint>

#include <servobus/sim/c630s/detail/positioning.hpp>

namespace servobus::sim::detail {

class c630s_homing : protected c630s_positioning {
  protected:
    using c630s_positioning::c630s_positioning;

    constexpr bool is_homing() const { return phase_ != phase::idle; }
    constexpr std::uint32_t homings() const { return homings_; }

    /// Handles a write of P05-30.
    constexpr void command_homing(coolmay::homing what) {
        wanted_ = coolmay::homing::off;
        switch (what) {
        case coolmay::homing::start:
        case coolmay::homing::start_electrical: wanted_ = what; return;
        case coolmay::homing::set_home: return set_home();
        case coolmay::homing::off: return abort_homing();
        default: return;
        }
    }
    /// Power on: P05-30 = 3 homes as soon as the motor is enabled. A stored command is discarded unless the
    /// restart keeps it.
    constexpr void prepare_homing() {
        phase_ = phase::idle;
        wanted_ = coolmay::homing::off;
        const auto set = memory_.get(coolmay::homing_control);
        if (set == coolmay::homing::at_power_on) wanted_ = coolmay::homing::start;
        if (!is_command(set)) return;
        if (keeps(c630s_restart::homing_command)) return command_homing(set);
        memory_.set(coolmay::homing_control.address, 0);
    }
    /// Handles the edges of FunIN.32 and FunIN.38.
    constexpr void watch_homing_inputs() {
        const auto set = memory_.get(coolmay::homing_control);
        const bool starts = inputs_.take_edge(function::homing_start);
        const bool sets = inputs_.take_edge(function::set_home);
        if (sets && set == coolmay::homing::set_home_by_input) set_home();
        if (!starts || !is_enabled_) return;
        if (set == coolmay::homing::by_input) wanted_ = coolmay::homing::start;
        if (set == coolmay::homing::electrical_by_input) wanted_ = coolmay::homing::start_electrical;
    }
    constexpr void set_home() {
        make_home(command_or_motor());
        end_command();
    }
    constexpr void abort_homing() {
        if (phase_ == phase::idle) return;
        phase_ = phase::idle;
        end_command();
    }

    /// Starts the commanded homing. Requires an enabled motor in position control.
    constexpr void start_commanded_homing() {
        if (wanted_ == coolmay::homing::off) return;
        interrupt();
        const bool is_electrical = wanted_ == coolmay::homing::start_electrical;
        wanted_ = coolmay::homing::off;
        mode_ = value(coolmay::homing_method);
        direction_ = mode_ % 2 == 0 ? 1 : -1;
        elapsed_ = 0;
        is_armed_ = false;
        ++homings_;
        if (options_.home_output_falls) (is_electrical ? is_electrically_home_ : is_home_) = false;
        if (is_electrical) {
            home_ = zero_;
            phase_ = phase::electrical;
        } else {
            phase_ = slows_by_z() || !is_slow() ? phase::search : phase::back_off;
        }
        seen_turn_ = turn();
    }

    /// One tick. False if the homing takes too long or a limit switch blocks the way: Er.601.
    constexpr bool run_homing() {
        const std::int64_t high = value(coolmay::homing_high_speed) * shaft::r_per_min;
        const std::int64_t low = value(coolmay::homing_low_speed) * shaft::r_per_min;
        const bool meets_z = look_for_z();
        switch (phase_) {
        case phase::idle: return true;
        case phase::search:
            run(direction_ * high);
            if (slows_by_z() ? meets_z : is_slow()) {
                phase_ = phase::back_off;
            } else if (is_barred(direction_)) {
                phase_ = phase::escape;
            }
            break;
        case phase::escape: // the limit came first: home is on the other side
            run(is_barred(-direction_) ? 0 : -direction_ * high);
            is_armed_ = is_armed_ || is_slow();
            if (slows_by_z() ? meets_z && is_turning(-direction_) : is_armed_ && !is_slow()) approach_home();
            break;
        case phase::back_off:
            run(-direction_ * low);
            if (!is_turning(-direction_)) break;
            if (slows_by_z() ? meets_z : !is_slow()) {
                if (mode_ >= 8) {
                    phase_ = phase::find_z;
                } else {
                    approach_home();
                }
            }
            break;
        case phase::find_z:
            run(-direction_ * low);
            if (meets_z) found(z_);
            break;
        case phase::approach:
            run(direction_ * low);
            is_armed_ = is_armed_ || is_slow();
            if (slows_by_z()) {
                if (meets_z && is_turning(direction_)) found(z_);
            } else if (mode_ == 4 || mode_ == 5) {
                if (is_armed_ && meets_z) found(z_);
            } else if (is_armed_) {
                found(command_.position());
            }
            break;
        case phase::settle:
            if (command_.approach(home_, low, value(coolmay::homing_acceleration_time))) {
                make_home(home_);
                finish();
            }
            break;
        case phase::electrical:
            if (is_barred(home_ > command_.position() ? 1 : home_ < command_.position() ? -1 : 0)) {
                abort_homing();
                return false;
            }
            if (command_.approach(home_, high, value(coolmay::homing_acceleration_time))) {
                is_electrically_home_ = true;
                finish();
            }
            break;
        }
        motor_.follow(command_, fastest());
        if (phase_ == phase::idle || ++elapsed_ <= limit()) return true;
        abort_homing();
        return false;
    }

    bool is_enabled_ = false;

  private:
    enum class phase : std::uint8_t { idle, search, escape, back_off, find_z, approach, settle, electrical };

    constexpr bool slows_by_z() const { return mode_ == 2 || mode_ == 3; }
    // True while the signal is active that slows the motor down.
    constexpr bool is_slow() const {
        if (slows_by_z()) return false;
        if (mode_ < 6) return given(function::home_switch);
        return given(direction_ > 0 ? function::positive_overtravel : function::negative_overtravel);
    }
    constexpr bool is_turning(std::int64_t direction) const { return command_.speed() * direction > 0; }

    // The time limit P05-35 in ms; its unit by P05-61 is 1, 10 or 100 ms.
    constexpr std::int64_t limit() const {
        const std::int64_t unit = value(coolmay::homing_time_unit);
        return value(coolmay::homing_time_limit) * (unit == 0 ? 1 : unit == 1 ? 10 : 100);
    }

    constexpr void run(std::int64_t speed) {
        const std::int64_t change = shaft::change_of(value(coolmay::homing_acceleration_time));
        command_.ramp_to(speed, change, change);
    }

    // The turn of the encoder. The Z signal is at the beginning of each turn.
    constexpr std::int64_t turn() const {
        const std::int64_t at = motor_.position();
        return at / shaft::counts_per_turn - (at % shaft::counts_per_turn < 0 ? 1 : 0);
    }
    constexpr bool look_for_z() {
        const std::int64_t now = turn();
        if (now == seen_turn_) return false;
        z_ = (now > seen_turn_ ? now : seen_turn_) * shaft::counts_per_turn;
        seen_turn_ = now;
        return true;
    }

    constexpr void approach_home() {
        phase_ = phase::approach;
        is_armed_ = false;
    }
    constexpr void found(std::int64_t where) {
        home_ = where;
        phase_ = phase::settle;
    }
    constexpr std::int64_t command_or_motor() const {
        return is_enabled_ ? command_.position() : motor_.position();
    }
    // Makes this position home: P0B-07 is P05-36 there.
    constexpr void make_home(std::int64_t where) {
        zero_ = where - to_counts(value(coolmay::home_offset));
        is_home_ = true;
    }
    constexpr void finish() {
        phase_ = phase::idle;
        end_command();
    }
    static constexpr bool is_command(coolmay::homing set) {
        return set == coolmay::homing::start || set == coolmay::homing::start_electrical ||
               set == coolmay::homing::set_home;
    }
    constexpr void end_command() {
        if (options_.homing_command_ends && is_command(memory_.get(coolmay::homing_control)))
            memory_.set(coolmay::homing_control.address, 0);
    }

    std::int64_t mode_ = 0;
    std::int64_t direction_ = 1;
    std::int64_t home_ = 0;
    std::int64_t z_ = 0;
    std::int64_t seen_turn_ = 0;
    std::int64_t elapsed_ = 0; // ms
    std::uint32_t homings_ = 0;
    coolmay::homing wanted_ = coolmay::homing::off;
    phase phase_ = phase::idle;
    bool is_armed_ = false;
};

} // namespace servobus::sim::detail
