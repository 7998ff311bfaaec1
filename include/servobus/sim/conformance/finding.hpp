// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What sim/conformance.hpp reports: which promise was broken, by which command, and what had happened to it, with the
// frames on the wire before it.
//
//     void print(void*, const sim::finding& f) {
//         std::printf("%s: %s (%s, request %u: %s)\n", f.promise, f.what, f.command, f.first.request,
//                     sim::text(f.first.what));
//     }
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/bytes.hpp>
#include <servobus/sim/conformance/mishap.hpp>

namespace servobus::sim {

/// A frame on the wire. The bytes beyond the first 24 are not kept.
struct traced_frame {
    std::uint64_t at_us = 0; ///< when its last byte passed
    std::uint8_t data[24]{};
    std::uint8_t size = 0;
    bool is_request = false;

    bytes kept() const { return bytes{data}.first(size < sizeof data ? size : sizeof data); }
};

/// What happens to which request of a command; they count from 0.
struct planned_mishap {
    mishap what = mishap::none;
    unsigned request = 0;
};

struct finding {
    const char* promise = ""; ///< its number, as in promises.md
    const char* what = "";    ///< what was seen from outside, a sentence
    const char* command = "";
    unsigned interpretation = 0; ///< of the manual
    planned_mishap first{};
    planned_mishap second{};
    std::span<const traced_frame> trace{}; ///< the last frames, in order
};

} // namespace servobus::sim
