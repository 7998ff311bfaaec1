// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which requests may use the line of a bus, beside those of the bus itself: its plan decides. The line asks it by
// two functions, so that only programs with a bus contain them.
//
//     constexpr admission_rules nothing_else{
//         .judge = [](silent_nodes&, std::uint8_t, duration, const bus_gaps&, instant) { return admission::refused; },
//         .note = [](silent_nodes&, std::uint8_t, bool) {}};
//     template <class Line> void be_alone_on(Line& wire) { wire.follow(nothing_else); }
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/response_limits.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// How often the nodes of a plan's `own_requests(..)`, by their numbers in it, did not respond. One that is silent is asked
/// once in a window.
class silent_nodes {
  public:
    static constexpr std::size_t most = 8;
    static constexpr unsigned most_misses = 3; // of a node, in a row, that are counted

    constexpr void note(std::size_t node, bool has_response) {
        const unsigned shift = 2 * static_cast<unsigned>(node);
        const unsigned before = misses(node);
        const unsigned now = has_response ? 0 : before < most_misses ? before + 1 : before;
        misses_ = static_cast<std::uint16_t>((misses_ & ~(3u << shift)) | now << shift);
        asked_ = static_cast<std::uint8_t>(asked_ | 1u << node);
    }
    constexpr unsigned misses(std::size_t node) const { return unsigned{misses_} >> 2 * node & 3u; }
    /// True once in a `window` for each node.
    constexpr bool is_due(std::size_t node, instant now, duration window) {
        const auto at = static_cast<std::uint16_t>(now.us >> resolution);
        if (static_cast<std::uint16_t>(at - began_) > (window.us >> resolution)) {
            began_ = at;
            asked_ = 0;
        }
        return (asked_ >> node & 1) == 0;
    }

  private:
    static constexpr unsigned resolution = 10; // about a millisecond: 16 bits have 67 s

    std::uint16_t began_ = 0;  // the window
    std::uint16_t misses_ = 0; // two bits for each node
    std::uint8_t asked_ = 0;   // in this window, a bit for each
};

/// What the plan says of one.
enum class admission : std::uint8_t { granted, later, refused };

/// The functions of a plan.
struct admission_rules {
    /// `longest`: of the request and the wait for its response.
    admission (*judge)(silent_nodes& silent, std::uint8_t address, duration longest, const bus_gaps& wanted,
                       instant now);
    void (*note)(silent_nodes& silent, std::uint8_t address, bool has_response);
};

} // namespace servobus
