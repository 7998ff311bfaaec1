// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A fact that was learned of a node holds until a request to it gets no valid response, since it may have restarted
// then, or until the port is lost. A line counts both.
//
//     constexpr verified<word_order> learned{word_order::low_first, epoch{.misses = 3}};
//     static_assert(learned.holds(epoch{.misses = 3}) && !learned.holds(epoch{.misses = 4}));
#pragma once

#include <servobus/core/cxx20.hpp>

#include <bit>
#include <cstdint>

namespace servobus {

/// The events of a line, compared in one instruction. Each counter wraps.
struct alignas(2) line_events {
    std::uint8_t losses = 0;  ///< of the port; each counts as a miss too
    std::uint8_t changes = 0; ///< of settings that a facade caches, by another client, of whichever node

    friend constexpr bool operator==(line_events a, line_events b) {
        return std::bit_cast<std::uint16_t>(a) == std::bit_cast<std::uint16_t>(b);
    }
};

/// `line::epoch(address)`.
struct epoch {
    /// Requests to the node that left and got no valid response, and exchanges that were left without their end. Wraps.
    std::uint16_t misses = 0;
    line_events events{};

    friend constexpr bool operator==(const epoch&, const epoch&) = default;
    /// True if the node cannot have restarted between the two: they differ by changes alone.
    friend constexpr bool is_same_life(epoch a, epoch b) {
        return a.misses == b.misses && a.events.losses == b.events.losses;
    }
};

/// A value that was read from a node, and the epoch in which that was.
template <class T> struct verified {
    T value{};
    epoch at{};

    /// The node cannot have restarted since. If it can, the value is to be read again before it is used.
    constexpr bool holds(epoch now) const { return is_same_life(at, now); }
};

} // namespace servobus
