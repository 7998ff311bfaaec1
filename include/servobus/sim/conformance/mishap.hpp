// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What can happen to one request of a command: on the line, to the drive, or to the program. sim/conformance.hpp plays
// each of them at each request.
//
//     for (const sim::mishap m : sim::all_mishaps) std::puts(sim::text(m));
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::sim {

/// What happens to a request, or while it is under way.
enum class mishap : std::uint8_t {
    none,
    request_lost,
    request_damaged,
    response_lost,
    response_damaged,
    response_late,    ///< by 150 ms
    response_doubled, ///< the copy follows after 1 ms
    refused,          ///< exception 4
    busy,             ///< exception 6
    restart_before,   ///< the drive is off and on again, and receives the request
    restart_after,    ///< it carries the request out, and is off and on again
    fault,            ///< after the request
    stop_input,       ///< a wired stop, after the request
    foreign_write,    ///< another client writes a register, after the request
    program_stalls,   ///< for 3 s: longer than a hold time
    program_halts,    ///< the application begins a halt
    program_disables, ///< the application begins a disable
};

inline constexpr mishap all_mishaps[] = {
    mishap::request_lost,   mishap::request_damaged,  mishap::response_lost, mishap::response_damaged,
    mishap::response_late,  mishap::response_doubled, mishap::refused,       mishap::busy,
    mishap::restart_before, mishap::restart_after,    mishap::fault,         mishap::stop_input,
    mishap::foreign_write,  mishap::program_stalls,   mishap::program_halts, mishap::program_disables,
};

constexpr const char* text(mishap m) {
    constexpr const char* names[] = {"nothing",
                                     "the request is lost",
                                     "the request is damaged",
                                     "the response is lost",
                                     "the response is damaged",
                                     "the response is late",
                                     "the response comes twice",
                                     "the drive refuses the request",
                                     "the drive is busy",
                                     "the drive restarts before the request",
                                     "the drive restarts after the request",
                                     "the drive gets a fault",
                                     "a wired stop acts",
                                     "another client writes a register",
                                     "the program stalls",
                                     "the program halts the drive",
                                     "the program disables the drive"};
    return names[static_cast<unsigned>(m)];
}

} // namespace servobus::sim
