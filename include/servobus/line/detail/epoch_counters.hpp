// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a line counts for `epoch`: requests without a valid response, losses of its port, and writes of settings that a
// facade caches. A counter also holds whether a response of its nodes may be an echo since the last miss.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/epoch.hpp>

namespace servobus::detail {

/// The events of a line that has no facades, and so no changes of their settings.
struct losses_alone {
    std::uint8_t losses = 0;

    constexpr operator line_events() const { return {losses}; } // NOLINT: implicit, as part of an epoch
};

// Nodes share `Counters` counters of 7 bits, and a bit beside each. One that wraps advances the next wider one, so that
// no epoch comes back before 2^15 misses.
template <std::size_t Counters, class Events = line_events> class epoch_counters {
  public:
    [[gnu::always_inline]] constexpr epoch of(std::uint8_t node_address) const {
        const std::uint8_t of_node = of_node_[node_address % Counters];
        return {static_cast<std::uint16_t>(of_all_ << 8 | of_node >> 1), events_};
    }
    /// Begins an epoch of a node that responds.
    constexpr void begin(std::uint8_t node_address) { advance(of_node_[node_address % Counters]); }
    constexpr void count_miss(std::uint8_t node_address) {
        std::uint8_t& of_node = of_node_[node_address % Counters];
        of_node = static_cast<std::uint8_t>(of_node | suspect);
        advance(of_node);
    }
    /// True from a miss on until `clear_suspicion`.
    constexpr bool is_suspect(std::uint8_t node_address) const {
        return (of_node_[node_address % Counters] & suspect) != 0;
    }
    constexpr bool is_any_suspect() const {
        unsigned all = 0;
        for (const std::uint8_t of_node : of_node_) all |= of_node;
        return (all & suspect) != 0;
    }
    constexpr void clear_suspicion(std::uint8_t node_address) {
        std::uint8_t& of_node = of_node_[node_address % Counters];
        of_node = static_cast<std::uint8_t>(of_node & ~suspect);
    }
    constexpr void count_miss_of_all() {
        if (++of_all_ == 0) ++events_.losses;
    }
    constexpr void count_loss() {
        ++events_.losses;
        count_miss_of_all();
    }
    // No miss: what clients have learned of a node holds.
    constexpr void count_change() { ++events_.changes; }

  private:
    static constexpr unsigned suspect = 1; // the bit of a counter that no epoch has
    static constexpr unsigned miss = 2;
    constexpr void advance(std::uint8_t& of_node) {
        of_node = static_cast<std::uint8_t>(of_node + miss);
        if (of_node < miss) count_miss_of_all();
    }
    Events events_{};
    std::uint8_t of_all_ = 0;
    std::uint8_t of_node_[Counters]{};
};

} // namespace servobus::detail
