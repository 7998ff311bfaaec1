// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The terms on which a machine exchanges frames: limits of responses, gaps, retries of reads, the priority of requests.
// A node states them, and a plan may change them.
#pragma once

#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

class terms {
  public:
    template <class Node>
    constexpr terms(const Node& at, bool is_by_plan)
        : limits_{at.limits}, gaps_{at.gaps}, read_retries_{at.read_retries}, is_refused_{is_by_plan} {}

    constexpr const response_limits& limits() const { return limits_; }
    constexpr response_limits& limits() { return limits_; }
    constexpr const bus_gaps& gaps() const { return gaps_; }
    constexpr std::uint8_t read_retries() const { return read_retries_; }
    /// The priority of all requests but urgent stops.
    constexpr servobus::priority priority() const { return priority_; }
    /// Response limit and quarantine of a lost request, without its time on the wire.
    constexpr duration lost_response() const { return limits_.response + gaps_.quarantine; }

    /// The plan has another drive in its place.
    constexpr void refuse() { is_refused_ = true; }
    /// True also for a drive that waits for the bus of its plan.
    constexpr bool is_refused() const { return is_refused_; }
    /// Takes over what a plan states.
    constexpr void adopt(const response_limits& limits, const bus_gaps& gaps, duration longest_response) {
        is_refused_ = false;
        limits_ = limits;
        gaps_ = gaps;
        bound_response(longest_response);
    }
    /// Shortens the response limit to the plan's, though the drive may state a longer one.
    constexpr void bound_response(duration longest) {
        if (longest < limits_.response) limits_.response = longest;
    }
    /// Requests have a plan's priority from now on, also those of a refused drive: its stops are read back.
    constexpr void follow_plan() { priority_ = servobus::priority::planned; }

  private:
    response_limits limits_;
    bus_gaps gaps_;
    std::uint8_t read_retries_;
    servobus::priority priority_ = servobus::priority::ordinary;
    bool is_refused_;
};

} // namespace servobus::detail
