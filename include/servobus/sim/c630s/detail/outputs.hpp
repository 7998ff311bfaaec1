// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the outputs of the simulated C630S: the functions FunOUT.1 to 20, real and virtual terminals.
// Source: manual V24.111, sections 6.4.2, 7.4 and 7.16.
#pragma once

#include <cstdint>

#include <servobus/sim/c630s/detail/speed.hpp>

namespace servobus::sim::detail {

class c630s_outputs : protected c630s_speed {
  public:
    enum class state : std::uint8_t {
        off,      ///< the motor has no power
        on,       ///< enabled
        stopping, ///< S-ON is inactive: stopping at zero speed, or waiting for the brake; then off
    };

  protected:
    using out = coolmay::output_function;
    using c630s_speed::c630s_speed;

    /// The control mode that FunIN.10 and FunIN.11 select from those of P02-00.
    constexpr coolmay::control_mode control() const {
        using mode = coolmay::control_mode;
        const bool first = given(function::mode_selection_1);
        switch (memory_.get(coolmay::mode_of_operation)) {
        case mode::torque_or_speed: return first ? mode::speed : mode::torque;
        case mode::speed_or_position: return first ? mode::position : mode::speed;
        case mode::torque_or_position: return first ? mode::position : mode::torque;
        case mode::torque_or_speed_or_position:
            if (given(function::mode_selection_2)) return mode::position;
            return first ? mode::speed : mode::torque;
        default: return memory_.get(coolmay::mode_of_operation);
        }
    }

    /// FunOUT.n as bit n - 1.
    constexpr std::uint32_t functions() const { return functions_; }
    constexpr bool is_out(coolmay::output_function f) const { return is_out(static_cast<std::int64_t>(f)); }
    /// True if output `number`, DO1 to DO6 from 0 and VDO1 to VDO16 from 6, shows its function.
    constexpr bool is_shown(unsigned number) const {
        const std::int64_t f = function_of(number);
        for (unsigned n = 0; n < number && options_.first_output_shows; ++n) {
            if (function_of(n) == f) return false;
        }
        return is_out(f);
    }
    /// DO1 to DO6; a bit is set if the optocoupler conducts.
    constexpr std::uint16_t outputs() const {
        const auto forcing = memory_.get(coolmay::terminal_forcing);
        if (forcing == coolmay::forcing::outputs_only || forcing == coolmay::forcing::both)
            return static_cast<std::uint16_t>(value(coolmay::forced_outputs));
        unsigned bits = 0;
        for (unsigned n = 0; n < 6; ++n) {
            const auto at = static_cast<std::uint16_t>(coolmay::do1_function.address + 2 * n);
            const bool is_inverted = value(static_cast<std::uint16_t>(at + 1)) != 0;
            if (is_shown(n) != is_inverted) bits |= 1u << n;
        }
        return static_cast<std::uint16_t>(bits);
    }
    constexpr std::uint16_t virtual_outputs() const {
        if (!memory_.is_on(coolmay::virtual_outputs_enable)) return 0;
        unsigned bits = 0;
        for (unsigned n = 0; n < 16; ++n) {
            const auto at = static_cast<std::uint16_t>(coolmay::virtual_output_functions[0].address + 2 * n);
            const bool is_inverted = value(static_cast<std::uint16_t>(at + 1)) != 0;
            const bool is_one = value(at) == 0 ? (value(coolmay::virtual_output_defaults) >> n & 1) != 0
                                               : is_shown(6 + n) != is_inverted;
            if (is_one) bits |= 1u << n;
        }
        return static_cast<std::uint16_t>(bits);
    }

    /// True if the brake function is assigned to an output that counts as a brake.
    constexpr bool has_brake() const {
        if (has_wired_brake()) return true;
        if (!options_.virtual_brake_delays || !memory_.is_on(coolmay::virtual_outputs_enable)) return false;
        for (unsigned n = 6; n < 22; ++n) {
            if (function_of(n) == static_cast<std::int64_t>(out::brake)) return true;
        }
        return false;
    }

    /// Computes the functions. Called after a tick, and when an alarm is raised.
    constexpr void update_functions() {
        const std::int64_t speed = shaft::size(motor_.speed());
        const auto rpm = [this](const auto& row) { return value(row) * shaft::r_per_min; };
        const bool is_on = state_ == state::on;
        const bool is_position = is_on && control() == coolmay::control_mode::position;
        const std::int64_t torque = shaft::size(motor_.torque());
        const std::int64_t base = value(coolmay::torque_reached_base);
        has_reached_torque_ = torque >= base + value(has_reached_torque_ ? coolmay::torque_reached_off_offset
                                                                         : coolmay::torque_reached_on_offset);
        std::uint32_t bits = 0;
        const auto set = [&bits](out f, bool is_active) {
            if (is_active) bits |= 1u << (static_cast<unsigned>(f) - 1);
        };
        set(out::servo_ready, !alarms_.has_fault());
        set(out::rotating, speed >= rpm(coolmay::rotation_threshold));
        set(out::zero_speed, speed <= rpm(coolmay::zero_speed_threshold));
        set(out::speed_coincidence,
            is_on && control() == coolmay::control_mode::speed &&
                shaft::size(motor_.speed() - wanted_speed_) < rpm(coolmay::speed_coincidence_threshold));
        set(out::positioning_completed, is_position && is_completed());
        set(out::positioning_near,
            is_position && shaft::size(deviation()) < value(coolmay::positioning_near_threshold));
        set(out::torque_limited, motor_.is_limited());
        set(out::speed_limited, is_on && is_speed_limited_);
        set(out::brake,
            options_.brake == c630s_brake::always_released ||
                (is_brake_open_ && (options_.brake == c630s_brake::follows_servo || has_wired_brake())));
        set(out::warning, alarms_.has_warning());
        set(out::fault, alarms_.has_fault());
        set(out::home_attained, is_home_);
        set(out::electrical_home_attained, is_electrically_home_);
        set(out::torque_reached, has_reached_torque_);
        set(out::speed_reached, speed >= rpm(coolmay::speed_reached_threshold));
        functions_ = bits;
    }

    /// The value of P0B-19.
    constexpr std::uint32_t seconds() const { return static_cast<std::uint32_t>(ms_ / 1000); }

    std::int64_t ms_ = 0; // of power-on time
    state state_ = state::off;
    bool is_brake_open_ = false;

  private:
    // The function of an output: DO1 to DO6 count from 0, VDO1 to VDO16 from 6.
    constexpr std::int64_t function_of(unsigned number) const {
        const unsigned at = number < 6 ? coolmay::do1_function.address + 2 * number
                                       : coolmay::virtual_output_functions[0].address + 2 * (number - 6);
        return value(static_cast<std::uint16_t>(at));
    }
    constexpr bool has_wired_brake() const {
        for (unsigned n = 0; n < 6; ++n) {
            if (function_of(n) == static_cast<std::int64_t>(out::brake)) return true;
        }
        return false;
    }
    constexpr bool is_out(std::int64_t f) const {
        return f >= 1 && f <= 32 && (functions_ >> (f - 1) & 1u) != 0;
    }

    constexpr bool is_completed() {
        const bool is_near = shaft::size(deviation()) < value(coolmay::positioning_completed_threshold);
        const bool has_no_command = !is_commanding() && !is_homing();
        switch (memory_.get(coolmay::positioning_completed_condition)) {
        case coolmay::completed_condition::deviation: return is_near;
        case coolmay::completed_condition::deviation_held:
            if (is_near && has_no_command)
                completed_until_ = ms_ + value(coolmay::positioning_completed_hold_time);
            return (is_near && has_no_command) || ms_ < completed_until_;
        default: return is_near && has_no_command;
        }
    }

    std::int64_t completed_until_ = 0; // ms of power-on time, by P05-60
    std::uint32_t functions_ = 0;
    bool has_reached_torque_ = false;
};

} // namespace servobus::sim::detail
