// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How long what was learned of a node holds: until a request to it gets no valid response, since it may have
// restarted then, or the port is lost. A line counts both; what learns something of a node includes this.
//
//     constexpr verified<word_order> learned{word_order::low_first, epoch{.misses = 3}};
//     static_assert(learned.holds(epoch{.misses = 3}) && !learned.holds(epoch{.misses = 4}));
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus {

/// `line::epoch(address)`: another value after each request to the node that left and got no valid response,
/// after each exchange that was left without its end, after each loss of the port, and after each write by another
/// client of a setting that a facade caches, of whichever node. It wraps.
struct epoch {
    /// So many losses stand for a write of a setting that a facade caches.
    static constexpr std::uint8_t change = 4;

    std::uint16_t misses = 0;
    /// Losses of the port, each of which counts as a miss too, and writes of settings that a facade caches.
    std::uint8_t losses = 0;

    friend constexpr bool operator==(const epoch&, const epoch&) = default;
    /// True if the node cannot have restarted between the two: they differ by changes alone.
    friend constexpr bool is_same_life(epoch a, epoch b) {
        return a.misses == b.misses && ((a.losses ^ b.losses) & (change - 1u)) == 0;
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
