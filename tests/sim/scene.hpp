// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What all parts of a simulated run share: its random numbers, what has struck the operation under way, and
// the end of a run in which a promise was broken.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include <servobus/modbus/rtu.hpp>
#include <servobus/sim/faults.hpp>
#include <servobus/sim/line.hpp>

#include "record.hpp"
#include "tally.hpp"

namespace trial {

/// Thrown where a promise is found broken: "G2: ...".
struct broken {
    std::string promise;
};

/// Which silences the fault model keeps to: a late response begins within the quarantine after the
/// transaction that it belongs to, a doubled one before the next request has left (G2).
struct fault_model {
    std::uint32_t response_us = 0;
    std::uint32_t quarantine_us = 0;
    std::uint8_t leading_bytes = 4;
};

struct scene {
    servobus::sim::virtual_line* wire = nullptr;
    record* log = nullptr;
    tally* count = nullptr;
    servobus::modbus::rtu_timing timing{};
    servobus::sim::dice random{1};

    std::uint64_t transaction = 0;     ///< requests that have begun to leave
    fault_model model;                 ///< of the node that the operation under way speaks to
    std::uint32_t chance = 0;          ///< of a fault in a frame, in thousandths
    std::uint32_t frames_apart_us = 0; ///< the silence that must part another unit's frame from a response
    std::uint32_t blur_us = 0; ///< a client may see a silence that much shorter, by its clock and its loop

    bool is_clock_still = false; ///< the client's stands

    // Of the operation under way
    bool is_struck = false;       ///< met what excuses a failure
    bool may_end_early = false;   ///< by something else than its responses
    bool cuts_quarantine = false; ///< a stop, which may meet the response that the quarantine is for
    bool is_any_away = false;     ///< a device is off or slow as the operation begins
    bool has_intruded = false;    ///< another exchange, a read of register 0, was sent after a stall
    bool has_jumped_back = false; ///< the client's clock, so that it waits longer
    bool does_clock_lie = false;  ///< the client cannot know what time it is
    // Of the transaction under way
    bool is_awaited = false;     ///< its response
    bool must_fail = false;      ///< what came is no valid response
    bool has_long_pause = false; ///< that is why; a program that stalls meanwhile sees none
    bool is_spoiled = false;     ///< bytes were changed on the way, so that a CRC may fit by chance
    const char* borne = "G9";    ///< the promise by which it succeeds all the same

    std::uint8_t asked_unit = 0;                   ///< by the last request
    std::array<drive_kind, 256> kinds{};           ///< of the units
    std::array<switch_positions, 256> positions{}; ///< of the switches of each unit
    readings manuals{1};                           ///< what this run's drives do
    std::uint64_t left_us = 0;                     ///< when the last request had left
    std::uint64_t sounding_until = 0;              ///< faulty frames, late and second ones, are over by then
    std::uint64_t held_until = 0;                  ///< the adapter keeps what it hears
    std::uint64_t clock_read_us = 0;               ///< when the program looked at its clock last
    std::uint64_t stalled_us = 0;                  ///< in all
    /// The program stalled in the turn in which the last frame began to leave: a party that looked at the
    /// clock before that, and let the line send, cannot know.
    bool was_stalled_unseen = false;

    std::uint64_t now() const { return wire->time_us(); }
    std::uint32_t wire_time(std::size_t bytes) const { return timing.wire_time(bytes).us; }
    std::uint32_t between(std::uint32_t low, std::uint32_t high) {
        return high <= low ? low : low + random.below(high - low + 1);
    }
    bool one_in(std::uint32_t n) { return random.below(n) == 0; }
    std::uint8_t any_byte() { return static_cast<std::uint8_t>(random.roll() & 0xFFu); }

    void strikes(strike s, bool excuses = true) {
        count->note(s);
        is_struck = is_struck || excuses;
        log->remark(now(), text(s));
    }
    /// The device has another address.
    void moves(std::uint8_t from, std::uint8_t to) {
        std::swap(kinds[from], kinds[to]);
        std::swap(positions[from], positions[to]);
    }
    void sounds_until(std::uint64_t at) {
        if (at > sounding_until) sounding_until = at;
    }
};

} // namespace trial
