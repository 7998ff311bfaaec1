// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the motions of a simulated YAKOTEC stepper, made from its registers when they are commanded.
#pragma once

#include <cstdint>

#include <servobus/sim/detail/wheel.hpp>
#include <servobus/sim/yako/detail/memory.hpp>
#include <servobus/sim/yako/detail/terminals.hpp>
#include <servobus/sim/yako/options.hpp>

namespace servobus::sim::detail {

namespace yako_rows = servobus::yako::closed_loop; // open loop has the same addresses for what it shares

enum class yako_motion : std::uint8_t { none, position, speed, homing, home_offset, stopping };

/// The parameters of a motion.
struct yako_command {
    yako_motion what = yako_motion::none;
    std::int64_t speed = 0; ///< 10^-6 r/min
    std::int64_t start_speed = 0;
    std::uint32_t acceleration = 0; ///< ms
    std::uint32_t deceleration = 0;
    std::int64_t target = 0; ///< pulses
    bool is_relative = false;
    /// The function of the input whose level keeps the motion running.
    servobus::yako::input_function from = servobus::yako::input_function::undefined;
    servobus::yako::homing method = servobus::yako::homing::current_position;
    std::uint16_t offset_mode = 0; ///< 0030h
};

class yako_commands {
  public:
    using function = servobus::yako::input_function;

    constexpr yako_commands(const yako_variant& of, const yako_memory& m, const yako_terminals& t,
                            const yako_options& o)
        : of_{&of}, memory_{&m}, terminals_{&t}, options_{&o} {}
    yako_commands(const yako_commands&) = delete;
    yako_commands& operator=(const yako_commands&) = delete;

    /// One count of a commanded speed, in 10^-6 r/min.
    constexpr std::int64_t speed_count() const {
        return options_->rescales_feedback_only ? wheel::r_per_min : feedback_count();
    }
    /// One count of 000Ch, in 10^-6 r/min.
    constexpr std::int64_t feedback_count() const {
        const bool is_tenth = of_->has_encoder && word_at(yako_rows::speed_resolution.address) != 0;
        return is_tenth ? wheel::r_per_min / 10 : wheel::r_per_min;
    }
    /// The value of an unsigned speed register, in 10^-6 r/min.
    constexpr std::int64_t speed(std::uint16_t address) const { return word_at(address) * speed_count(); }

    constexpr yako_command move(bool is_absolute) const {
        return ramped({yako_motion::position, speed(yako_rows::positioning_speed.address),
                       speed(yako_rows::start_speed.address), word_at(yako_rows::acceleration_time.address),
                       word_at(yako_rows::deceleration_time.address),
                       memory_->pair(yako_rows::target_position.address), !is_absolute});
    }
    constexpr yako_command jog() const {
        return ramped({yako_motion::speed, signed_speed(yako_rows::jog_speed.address), 0,
                       word_at(yako_rows::jog_acceleration_time.address),
                       word_at(yako_rows::jog_deceleration_time.address)});
    }
    /// A homing: `speed` is the fast speed, `start_speed` the slow one, `target` the offset.
    constexpr yako_command home() const {
        const std::uint16_t ramp = word_at(yako_rows::homing_ramp_time.address);
        return ramped({yako_motion::homing, speed(yako_rows::homing_fast_speed.address),
                       speed(yako_rows::homing_slow_speed.address), ramp, ramp,
                       memory_->pair(yako_rows::home_offset.address), true, function::undefined,
                       from_bits<servobus::yako::homing>(word_at(yako_rows::homing_method.address)),
                       word_at(yako_rows::homing_offset_mode.address)});
    }
    /// The position segment that the PIN inputs select.
    constexpr yako_command position_segment() const {
        const auto at = yako_rows::position_segment_targets[terminals_->segment()].address;
        return ramped({yako_motion::position, speed(address_after(at, 2)), segment_start_speed(),
                       word_at(address_after(at, 3)), word_at(address_after(at, 4)), memory_->pair(at),
                       word_at(address_after(at, 5)) == 0});
    }
    constexpr yako_command speed_segment() const {
        const auto at = yako_rows::speed_segment_speeds[terminals_->segment()].address;
        const bool is_turned = terminals_->is_on(function::speed_segment_direction);
        return ramped({yako_motion::speed, is_turned ? -signed_speed(at) : signed_speed(at), 0,
                       word_at(address_after(at, 1)), word_at(address_after(at, 2))});
    }
    /// The motion that an input of this function runs while it is active.
    constexpr yako_command by_level(function f) const {
        yako_command wanted = f == function::pv_trigger ? speed_segment() : jog();
        if (f == function::jog_positive) wanted.speed = magnitude(wanted.speed);
        if (f == function::jog_negative) wanted.speed = -magnitude(wanted.speed);
        wanted.from = f;
        return wanted;
    }

  private:
    constexpr yako_command ramped(yako_command wanted) const {
        if (!options_->ramps_to_1000_r_per_min) return wanted;
        const std::int64_t whole = 1000 * wheel::r_per_min;
        const auto part = [&](std::uint32_t ms) {
            return static_cast<std::uint32_t>(ms * magnitude(wanted.speed) / whole);
        };
        wanted.acceleration = part(wanted.acceleration);
        wanted.deceleration = part(wanted.deceleration);
        return wanted;
    }
    static constexpr std::uint16_t address_after(std::uint16_t address, unsigned rows) {
        return static_cast<std::uint16_t>(address + rows);
    }
    constexpr std::uint16_t word_at(std::uint16_t address) const { return (*memory_)[address]; }
    constexpr std::int64_t signed_speed(std::uint16_t address) const {
        return memory_->signed_word(address) * speed_count();
    }
    constexpr std::int64_t segment_start_speed() const {
        if (of_->has_encoder) return speed(yako_rows::start_speed.address);
        return magnitude(
            signed_speed(servobus::yako::open_loop::segment_start_speeds[terminals_->segment()].address));
    }

    const yako_variant* of_;
    const yako_memory* memory_;
    const yako_terminals* terminals_;
    const yako_options* options_;
};

} // namespace servobus::sim::detail
