// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How an exchange is stepped on the line of a bus. A request of the program is sent in its turn if the plan has it, and
// later if its node is silent. Any other is refused, but for a stop.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/bus/detail/other_requests.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/status.hpp>
#include <servobus/modbus/exchange.hpp>

namespace servobus::detail {

enum class admission : std::uint8_t { granted, later, refused };

template <const auto& Plan> constexpr std::size_t place_of(std::uint8_t address) {
    std::size_t i = 0;
    while (i < Plan.requested && Plan.requests[i].address != address) ++i;
    return i;
}

/// `longest`: the time of the request and of the wait for its response.
template <const auto& Plan>
constexpr admission judge(other_requests& others, std::uint8_t address, duration longest,
                          const bus_gaps& wanted, instant now) {
    if (address == modbus::broadcast) // short, and without a response
        return longest <= Plan.longest_in_flight() ? admission::granted : admission::refused;
    const std::size_t i = place_of<Plan>(address);
    if (i == Plan.requested) return admission::refused;
    const auto& r = Plan.requests[i];
    if (longest > Plan.longest_exchange(r) || wanted.gap > r.gaps.gap ||
        wanted.quarantine > r.gaps.quarantine)
        return admission::refused;
    const unsigned failures = Plan.rules().failures;
    const unsigned enough = failures < others.most_misses ? failures : others.most_misses;
    if (!Plan.is_apart(address) || others.misses(i) < enough) return admission::granted;
    return others.is_due(i, now, Plan.rules().retry_every) ? admission::granted : admission::later;
}

/// The `step` of a line with a bus of this plan.
template <const auto& Plan, class Line>
constexpr duration step_beside(Line& on, typename Line::exchange& x, const bus_gaps& wanted) {
    if (x.done()) return {};
    const bool is_other = x.priority() == priority::ordinary;
    using phase = typename Line::exchange::phase;
    const auto asks = [&x] { return x.state() == phase::ready; };
    if (is_other && asks()) {
        const duration longest = on.timing().wire_time(x.request().size()) + x.longest_before_stop();
        const admission said = judge<Plan>(on.others_, x.address(), longest, wanted, on.now());
        if (said == admission::refused) {
            x.abort(errc::not_in_plan, false);
            return {};
        }
        if (said == admission::later) return milliseconds(1);
    }
    const duration idle = on.Line::base::step(x, wanted);
    if (x.done()) {
        const std::size_t i = place_of<Plan>(x.address());
        if (i != Plan.requested && x.was_sent()) on.others_.note(i, x.status().has_response());
        return {};
    }
    if (is_other && asks()) on.others_.note_waiting(x.ticket());
    if (!on.Line::base::is_stop_waiting() || x.state() != phase::receiving) return idle;
    // A response that trickles in is given up for a stop.
    const duration waited = since(x.sent_at(), on.now());
    const duration longest = x.longest_before_stop();
    if (waited < longest) return shorter_of(idle, longest - waited);
    on.abandon(x);
    return {};
}

} // namespace servobus::detail
