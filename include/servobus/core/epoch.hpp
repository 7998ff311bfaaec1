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
/// after each exchange that was left without its end, and after each loss of the port. It wraps.
struct epoch {
    std::uint16_t misses = 0;
    std::uint8_t losses = 0; ///< of the port; a loss counts as a miss too

    friend constexpr bool operator==(const epoch&, const epoch&) = default;
};

/// A value that was read from a node, and the epoch in which that was.
template <class T> struct verified {
    T value{};
    epoch at{};

    /// Nothing has happened since. If not, the value is to be read again before it is used.
    constexpr bool holds(epoch now) const { return at == now; }
};

} // namespace servobus
