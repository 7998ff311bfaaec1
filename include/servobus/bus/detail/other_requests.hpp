// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The requests on the line of a bus that are not its own. It keeps which of them waits, and which nodes of the plan's
// `own_requests(..)` do not respond.
//
//     detail::other_requests others;
//     others.note(2, false); // node number 2 of the plan did not respond
//     const bool is_silent = others.misses(2) == detail::other_requests::most_misses;
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::detail {

class other_requests {
  public:
    static constexpr std::size_t most_nodes = 8;
    static constexpr unsigned most_misses = 3; ///< of a node, in a row, that are counted

    /// An exchange with a node has ended.
    constexpr void note(std::size_t node, bool has_response) {
        const unsigned shift = 2 * static_cast<unsigned>(node);
        const unsigned before = misses(node);
        const unsigned now = has_response ? 0 : before < most_misses ? before + 1 : before;
        misses_ = static_cast<std::uint16_t>((misses_ & ~(3u << shift)) | now << shift);
        asked_ = static_cast<std::uint8_t>(asked_ | 1u << node);
    }
    constexpr unsigned misses(std::size_t node) const { return unsigned{misses_} >> 2 * node & 3u; }
    /// True for each node once in `window`, which is kept to about 0.1 s; a longer one than 30 s counts as 30 s.
    constexpr bool is_due(std::size_t node, instant now, duration window) {
        const auto at = static_cast<std::uint8_t>(now.us >> resolution);
        const duration kept = shorter_of(window, longest_window);
        if (static_cast<std::uint8_t>(at - began_) > (kept.us >> resolution)) {
            began_ = at;
            asked_ = 0;
        }
        return (asked_ >> node & 1) == 0;
    }

    /// An exchange of others waits for the line.
    constexpr void note_waiting(std::uint16_t ticket) {
        const bool is_first = waiting_ == 0 || static_cast<std::int16_t>(ticket - waiting_) < 0; // it wraps
        if (is_first) waiting_ = ticket;
    }
    /// The ticket of the first of them since the last call; 0: none. One that still waits is noted again.
    constexpr std::uint16_t take_waiting() {
        const std::uint16_t first = waiting_;
        waiting_ = 0;
        return first;
    }

  private:
    static constexpr unsigned resolution = 17; // 2^17 us: eight bits have 33 s
    static constexpr duration longest_window = milliseconds(30'000);

    std::uint16_t waiting_ = 0;
    std::uint16_t misses_ = 0; // two bits for each node
    std::uint8_t asked_ = 0;   // in this window, a bit for each
    std::uint8_t began_ = 0;   // the window
};

} // namespace servobus::detail
