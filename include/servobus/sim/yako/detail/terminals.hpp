// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the input terminals of a simulated YAKOTEC stepper: levels, functions, edges, and the selection
// of a segment.
#pragma once

#include <cstdint>

#include <servobus/sim/detail/wheel.hpp>
#include <servobus/sim/yako/detail/axis.hpp>
#include <servobus/sim/yako/detail/memory.hpp>

namespace servobus::sim::detail {

class yako_terminals {
  public:
    using function = servobus::yako::input_function;

    constexpr yako_terminals(const yako_variant& of, const yako_memory& m, const yako_axis& a)
        : of_{&of}, memory_{&m}, axis_{&a} {}
    yako_terminals(const yako_terminals&) = delete;
    yako_terminals& operator=(const yako_terminals&) = delete;

    constexpr void set(unsigned input, bool level) {
        if (input < of_->inputs) put(levels_, input, level);
    }

    /// True if a terminal of this function is active when the shaft is at `at`.
    constexpr bool is_active(function f, std::int64_t at) const {
        const unsigned active = active_at(at);
        for (unsigned i = 0; active >> i != 0; ++i) {
            if ((active >> i & 1u) != 0 && function_of(i) == f) return true;
        }
        return false;
    }
    constexpr bool is_active(function f) const { return is_active(f, axis_->shaft()); }
    /// The value of 0008h.
    constexpr std::uint16_t active() const { return static_cast<std::uint16_t>(active_at(axis_->shaft())); }

    /// One tick: finds the edges of the functions, and how long the PIN inputs have been stable.
    constexpr void look() {
        std::uint32_t now = 0;
        const unsigned active = active_at(axis_->shaft());
        for (unsigned i = 0; active >> i != 0; ++i) {
            if ((active >> i & 1u) != 0) now |= 1u << static_cast<unsigned>(function_of(i));
        }
        risen_ = now & ~before_;
        const bool is_held = ((now ^ before_) & pins) == 0;
        are_held_ = now == before_;
        before_ = now;
        if (!is_held)
            held_us_ = 0;
        else
            hold(wheel::tick.us);
    }
    /// The PIN inputs stay as they are for this time.
    constexpr void hold(std::int64_t us) { held_us_ = smaller_of(held_us_ + us, 1'000'000); }
    /// True if the last tick found no change of a function.
    constexpr bool are_held() const { return are_held_; }
    /// Takes the active functions over without edges.
    constexpr void forget_edges() {
        look();
        risen_ = 0;
    }
    constexpr bool has_risen(function f) const { return (risen_ >> static_cast<unsigned>(f) & 1u) != 0; }
    /// True if the function was active at the last tick.
    constexpr bool is_on(function f) const { return (before_ >> static_cast<unsigned>(f) & 1u) != 0; }
    /// The segment that PIN0..PIN3 select, from 0.
    constexpr std::uint16_t segment() const {
        return static_cast<std::uint16_t>(before_ >> static_cast<unsigned>(function::pin0) & 15u);
    }
    /// How long PIN0..PIN3 have been stable, in us, at most 1 s.
    constexpr std::int64_t held_us() const { return held_us_; }

  private:
    static constexpr std::uint32_t pins = 15u << static_cast<unsigned>(function::pin0);

    constexpr function function_of(unsigned input) const {
        return static_cast<function>(
            (*memory_)[static_cast<std::uint16_t>(servobus::yako::x0_function.address + input)]);
    }
    static constexpr void put(unsigned& word, unsigned bit, bool value) {
        word = value ? word | 1u << bit : word & ~(1u << bit);
    }
    // The active terminals when the shaft is at `at`; bit 0 is X0.
    constexpr unsigned active_at(std::int64_t at) const {
        const yako_geometry g = axis_->geometry();
        unsigned levels = levels_;
        for (unsigned i = 0; g.has_wires() && i < of_->inputs; ++i) {
            if (g.is_wired(i)) put(levels, i, g.level(i, at));
        }
        const unsigned polarity = (*memory_)[servobus::yako::closed_loop::input_polarity.address];
        return (levels ^ polarity) & ((1u << of_->inputs) - 1);
    }

    const yako_variant* of_;
    const yako_memory* memory_;
    const yako_axis* axis_;
    unsigned levels_ = 0;      // of the terminals that are not wired to the machine; bit 0 is X0
    std::uint32_t before_ = 0; // a bit for each function
    std::uint32_t risen_ = 0;
    std::int64_t held_us_ = 0;
    bool are_held_ = false;
};

} // namespace servobus::sim::detail
