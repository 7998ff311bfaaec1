// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a plan says of a request that the program steps on the line beside the bus: it is one of its `own_requests(..)`, and
// its node is not silent, or it is refused or sent later.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/line/admission.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::detail {

template <const auto& Plan> struct other_requests {
    static constexpr admission judge(silent_nodes& silent, std::uint8_t address, duration longest,
                                     const bus_gaps& wanted, instant now) {
        if (address == modbus::broadcast) // it is short, and no node is awaited
            return longest <= Plan.worst_case_stop_latency() ? admission::granted : admission::refused;
        const std::size_t i = place_of(address);
        if (i == Plan.requested) return admission::refused;
        const auto& r = Plan.requests[i];
        if (longest > Plan.longest_exchange(r) || wanted.gap > r.gaps.gap ||
            wanted.quarantine > r.gaps.quarantine)
            return admission::refused;
        const unsigned failures = Plan.rules().failures;
        const unsigned enough = failures < silent_nodes::most_misses ? failures : silent_nodes::most_misses;
        if (!Plan.is_apart(address) || silent.misses(i) < enough) return admission::granted;
        return silent.is_due(i, now, Plan.rules().retry_every) ? admission::granted : admission::later;
    }
    static constexpr void note(silent_nodes& silent, std::uint8_t address, bool has_response) {
        if (const std::size_t i = place_of(address); i != Plan.requested) silent.note(i, has_response);
    }
    static constexpr admission_rules rules{.judge = judge, .note = note};

  private:
    static constexpr std::size_t place_of(std::uint8_t address) {
        std::size_t i = 0;
        while (i < Plan.requested && Plan.requests[i].address != address) ++i;
        return i;
    }
};

} // namespace servobus::detail
