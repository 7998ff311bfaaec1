// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What all parts of a simulated run share: its random numbers, the faults that affect the operation in
// progress, and the exception that ends a run in which a promise was broken.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include <servobus/modbus/rtu.hpp>
#include <servobus/sim/faults.hpp>
#include <servobus/sim/line.hpp>

#include "event_counts.hpp"
#include "record.hpp"

namespace trial {

/// Thrown where a promise is found broken: "G2: ...".
struct broken {
    std::string promise;
};

/// The times that the faults respect: a late response begins within the quarantine after its transaction, a
/// doubled one before the next request has left (G2).
struct fault_model {
    std::uint32_t response_us = 0;
    std::uint32_t quarantine_us = 0;
    std::uint8_t leading_bytes = 4;
};

struct scene {
    servobus::sim::virtual_line* wire = nullptr;
    record* log = nullptr;
    event_counts* count = nullptr;
    servobus::modbus::rtu_timing timing{};
    servobus::sim::dice random{1};

    std::uint64_t transaction = 0;     ///< requests that have begun to leave
    fault_model model;                 ///< of the node that the operation in progress addresses
    std::uint32_t chance = 0;          ///< of a fault in a frame, in thousandths
    std::uint32_t frames_apart_us = 0; ///< the gap needed between another node's frame and a response
    std::uint32_t blur_us = 0; ///< by so much a gap may look shorter, due to the client's clock and loop

    bool is_clock_still = false; ///< the client's clock is stopped

    // Of the operation in progress
    bool is_struck = false;       ///< it met a fault that excuses a failure
    bool may_end_early = false;   ///< other causes than its responses may end it
    bool cuts_quarantine = false; ///< a stop, during which the late response of another exchange may arrive
    bool is_any_away = false;     ///< a device is off or slow as the operation begins
    bool has_intruded = false;    ///< another exchange, a read of register 0, was sent after a stall
    bool has_jumped_back = false; ///< the client's clock jumped back, so the client waits longer
    bool does_clock_lie = false;  ///< the client's clock is wrong
    // Of the transaction in progress
    bool is_awaited = false;     ///< its response is awaited
    bool must_fail = false;      ///< what was sent is no valid response
    bool has_long_pause = false; ///< because of a pause, see `hide_pause`
    bool is_spoiled = false;     ///< bytes were changed on the way, so a CRC may match by chance
    const char* borne = "G9";    ///< the promise by which it must succeed nevertheless

    std::uint8_t asked_node = 0;                   ///< the node of the last request
    std::array<drive_kind, 256> kinds{};           ///< of the nodes
    std::array<switch_positions, 256> positions{}; ///< of the switches of each node
    interpretations manuals{1};                    ///< that the drives of this run follow
    std::uint64_t left_us = 0;                     ///< when the last request had left
    std::uint64_t sounding_until = 0;              ///< faulty, late and second frames have ended by then
    std::uint64_t held_until = 0;                  ///< until then the adapter holds received bytes back
    std::uint64_t clock_read_us = 0;               ///< when the program last read its clock
    std::uint64_t stalled_us = 0;                  ///< total time of all stalls
    std::uint64_t jumped_back_at = 0;              ///< the program's clock; it cannot tell the time before
    /// The program stalled in the step in which the last frame began to leave. A party that read the clock
    /// before the stall, and then let the line send, cannot know of it.
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
    /// The program stalls, or its clock jumps back: it cannot measure a pause that lies there.
    void hide_pause() {
        if (has_long_pause) must_fail = false;
    }
    /// The device moves to another address.
    void moves(std::uint8_t from, std::uint8_t to) {
        std::swap(kinds[from], kinds[to]);
        std::swap(positions[from], positions[to]);
    }
    void sounds_until(std::uint64_t at) {
        if (at > sounding_until) sounding_until = at;
    }
};

} // namespace trial
