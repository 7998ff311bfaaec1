// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The machine on a simulated YAKOTEC stepper's shaft: switches, hard stops and the encoder's index pulse.
// sim/yako.hpp includes it; a test attaches a machine to its drive:
//
//     servobus::sim::yako_machine machine;
//     machine.home_from = 2000; // thousandths of a turn
//     machine.home_to = 2100;
//     drive.attach(machine);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::sim {

/// Positions of switches and hard stops, in thousandths of a turn from the shaft's position at construction,
/// positive as 0010h = 0 turns it. A switch is active at its edge and beyond. A wired terminal has the level
/// of its switch.
struct yako_machine {
    static constexpr std::int64_t nowhere = 1'000'000'000'000;
    static constexpr std::uint8_t not_wired = 0xFF;

    std::int64_t negative_stop = -nowhere; ///< a hard stop
    std::int64_t negative_limit = -nowhere;
    std::int64_t home_from = nowhere; ///< the home switch's negative edge
    std::int64_t home_to = nowhere;   ///< the home switch's positive edge
    std::int64_t positive_limit = nowhere;
    std::int64_t positive_stop = nowhere;
    std::int64_t index = 0; ///< the index pulse's place within a turn

    std::uint8_t home_input = 0; ///< terminals: 0 is X0
    std::uint8_t positive_limit_input = 1;
    std::uint8_t negative_limit_input = 2;
    bool are_normally_closed = false; ///< an active switch makes its terminal's level low

    /// A free shaft, with no terminal wired.
    static constexpr yako_machine none() {
        yako_machine m;
        m.home_input = m.positive_limit_input = m.negative_limit_input = not_wired;
        return m;
    }
};

namespace detail {

/// A machine's positions in pulses, at a microstep resolution.
class yako_geometry {
  public:
    constexpr yako_geometry(const yako_machine& m, std::int64_t pulses_per_turn)
        : m_{m}, pulses_per_turn_{pulses_per_turn} {}

    constexpr bool is_home(std::int64_t at) const {
        return at >= pulses(m_.home_from) && at <= pulses(m_.home_to);
    }
    constexpr bool is_positive_limit(std::int64_t at) const { return at >= pulses(m_.positive_limit); }
    constexpr bool is_negative_limit(std::int64_t at) const { return at <= pulses(m_.negative_limit); }
    constexpr bool is_index(std::int64_t at) const { return (at - pulses(m_.index)) % pulses_per_turn_ == 0; }
    /// The nearest position that the hard stops allow.
    constexpr std::int64_t allowed(std::int64_t at) const {
        if (at < pulses(m_.negative_stop)) return pulses(m_.negative_stop);
        return at > pulses(m_.positive_stop) ? pulses(m_.positive_stop) : at;
    }

    constexpr bool has_wires() const {
        return is_wired_to(m_.home_input) || is_wired_to(m_.positive_limit_input) ||
               is_wired_to(m_.negative_limit_input);
    }
    constexpr bool is_wired(unsigned input) const {
        return input == m_.home_input || input == m_.positive_limit_input || input == m_.negative_limit_input;
    }
    /// The level at a wired terminal.
    constexpr bool level(unsigned input, std::int64_t at) const {
        const bool is_active = (input == m_.home_input && is_home(at)) ||
                               (input == m_.positive_limit_input && is_positive_limit(at)) ||
                               (input == m_.negative_limit_input && is_negative_limit(at));
        return is_active != m_.are_normally_closed;
    }

  private:
    static constexpr bool is_wired_to(unsigned input) { return input != yako_machine::not_wired; }
    // Rounded down, so that distances are the same on both sides of 0.
    constexpr std::int64_t pulses(std::int64_t thousandths) const {
        const std::int64_t product = thousandths * pulses_per_turn_;
        return product / 1000 - (product % 1000 < 0 ? 1 : 0);
    }

    const yako_machine& m_;
    std::int64_t pulses_per_turn_;
};

} // namespace detail
} // namespace servobus::sim
