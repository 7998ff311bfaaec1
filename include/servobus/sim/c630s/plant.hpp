// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What all parts of the simulated C630S share: parameters, inputs, motor, alarms, the electronic
// gear, and the machine that the motor drives. A test attaches a machine to its drive:
//
//     servobus::sim::c630s_machine machine{.home_from = 100'000, .home_to = 110'000};
//     machine.negative_limit = -500'000;
//     machine.positive_limit = 500'000;
//     drive.attach(machine);
#pragma once

#include <array>
#include <cstdint>

#include <servobus/sim/c630s/detail/faults.hpp>
#include <servobus/sim/c630s/detail/memory.hpp>
#include <servobus/sim/c630s/detail/motor.hpp>
#include <servobus/sim/c630s/detail/terminals.hpp>
#include <servobus/sim/c630s/options.hpp>

namespace servobus::sim {

/// A machine on the motor: where its switches are active, in encoder counts from construction. It controls
/// the terminals with the functions FunIN.31, 14 and 15.
struct c630s_machine {
    std::int64_t home_from = 0; ///< the home switch is active from here
    std::int64_t home_to = 0;   ///< up to here
    std::int64_t negative_limit = 0;
    std::int64_t positive_limit = 0;
};

namespace detail {

class c630s_plant {
  protected:
    using function = coolmay::input_function;
    using shaft = c630s_shaft;

    constexpr explicit c630s_plant(const c630s_options& chosen) : options_{chosen} {}

    /// The change of speed in a tick of a stop at zero speed.
    static constexpr std::int64_t stop_change = 30 * shaft::r_per_min;

    constexpr std::int64_t value(std::uint16_t address) const { return memory_[address]; }
    template <class Row> constexpr std::int64_t value(const Row& row) const { return memory_[row.address]; }
    constexpr bool given(function f) const { return inputs_.is_active(f); }
    /// True if a restart keeps this besides the parameters.
    constexpr bool keeps(c630s_restart what) const {
        return options_.restart_keeps == what || options_.restart_keeps == c630s_restart::everything;
    }

    // The electronic gear

    struct ratio {
        std::int64_t numerator;
        std::int64_t denominator;
    };
    constexpr ratio gear() const {
        const std::int64_t pulses = value(coolmay::pulses_per_revolution);
        if (pulses != 0) return {shaft::counts_per_turn, pulses};
        if (has_second_gear_) return {value(coolmay::gear_2_numerator), value(coolmay::gear_2_denominator)};
        return {value(coolmay::gear_1_numerator), value(coolmay::gear_1_denominator)};
    }
    static constexpr std::int64_t farthest = std::int64_t{1} << 42; // counts
    constexpr std::int64_t to_counts(std::int64_t reference_units) const {
        const ratio g = gear();
        const std::int64_t counts = reference_units * g.numerator / g.denominator;
        return shaft::between(-farthest, counts, farthest);
    }
    constexpr std::int64_t to_reference(std::int64_t counts) const {
        const ratio g = gear();
        const auto whole = static_cast<std::uint64_t>(counts / g.numerator) *
                           static_cast<std::uint64_t>(g.denominator); // only its low 32 bits are shown
        return static_cast<std::int64_t>(whole) + counts % g.numerator * g.denominator / g.numerator;
    }

    // Limit switches

    /// True if a limit switch forbids this direction, 1 or -1.
    constexpr bool is_barred(std::int64_t direction) const {
        return (direction > 0 && given(function::positive_overtravel)) ||
               (direction < 0 && given(function::negative_overtravel));
    }
    /// Sets the machine's switches by the motor's position.
    constexpr void move_machine() {
        if (!has_machine_) return;
        const std::int64_t at = motor_.position();
        inputs_.drive(function::home_switch, at >= machine_.home_from && at <= machine_.home_to, memory_);
        inputs_.drive(function::positive_overtravel, at >= machine_.positive_limit, memory_);
        inputs_.drive(function::negative_overtravel, at <= machine_.negative_limit, memory_);
    }

    /// The following error: the real one, plus a lag of 25 ms at the commanded speed.
    constexpr std::int64_t deviation() const {
        return command_.position() - motor_.position() +
               command_.speed() * shaft::counts_per_turn / (60'000'000 * std::int64_t{40});
    }

    /// Stops at zero speed, then holds the position.
    constexpr void stop_and_hold() {
        if (motor_.stands() && command_.stands()) {
            motor_.follow(command_, fastest());
            return;
        }
        motor_.ramp_to(0, stop_change, stop_change);
        command_.place(motor_.position());
    }
    constexpr std::int64_t fastest() const { return value(coolmay::max_speed) * shaft::r_per_min; }

    /// The current in 0.01 A; the rated current is 2.8 A.
    constexpr std::int64_t current() const { return shaft::size(motor_.torque()) * 280 / 1000; }

    /// The value that the voltage at AI1 or AI2 (0 or 1) means, given the value at 10 V.
    constexpr std::int64_t analogue(std::size_t input, std::int64_t at_10_volt) const {
        return analogue_[input] * at_10_volt / 10'000;
    }

    c630s_options options_;
    c630s_memory memory_{options_};
    c630s_inputs inputs_{};
    c630s_motor motor_{};
    c630s_alarms alarms_{};
    c630s_machine machine_{};
    shaft command_{};                        // what the position controller follows
    std::int64_t zero_ = 0;                  // encoder counts at which P0B-07 is 0
    std::array<std::int64_t, 2> analogue_{}; // mV
    bool has_second_gear_ = false;
    bool has_machine_ = false;
    bool is_home_ = false;              // FunOUT.16
    bool is_electrically_home_ = false; // FunOUT.17
};

} // namespace detail
} // namespace servobus::sim
