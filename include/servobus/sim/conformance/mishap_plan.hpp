// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The mishaps of one run: which is planned at which request, and which have happened. At each request it is asked by
// sim/conformance/trial.hpp, and sets the faults of the line.
//
//     sim::mishap_plan plan{{sim::mishap::busy, 2}, {}};
//     const bool is_too_early = plan.happens(sim::mishap::busy, 2); // the second request has begun: number 1
//     const bool is_refused = plan.happens(sim::mishap::busy, 3) && plan.has_happened(sim::mishap::busy);
#pragma once

#include <array>
#include <cstdint>

#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/wire_log.hpp>
#include <servobus/sim/faults.hpp>

namespace servobus::sim {

/// Up to two mishaps. `requests` are those that have begun since the start of the run, the present one among them.
class mishap_plan {
  public:
    mishap_plan() = default;
    mishap_plan(planned_mishap first, planned_mishap second) : planned_{first, second} {}

    /// Ends the plan: nothing more happens. It still knows what has happened.
    void end() { planned_[0] = planned_[1] = {}; }

    /// True if the mishap is planned at the present request, and so happens now. Different ones happen once each.
    bool happens(mishap m, unsigned requests) {
        for (const planned_mishap& p : planned_) {
            if (p.what != m || requests != p.request + 1) continue;
            bool& was = has_happened_[static_cast<unsigned>(m)];
            if (was && planned_[0].what != planned_[1].what) continue;
            was = true;
            return true;
        }
        return false;
    }
    /// Notes that a frame had a fault: a mishap of the line, if the present request has one.
    void note_line_fault(unsigned requests) {
        for (const planned_mishap& p : planned_) {
            const bool is_of_line = p.what >= mishap::request_lost && p.what <= mishap::response_doubled;
            if (is_of_line && requests == p.request + 1) has_happened_[static_cast<unsigned>(p.what)] = true;
        }
    }
    /// Sets the faults of the line: of the request that leaves next, and of the response to the present one.
    void set_faults(fault_plan& line, unsigned requests) const {
        const auto rate = [this](mishap m, unsigned request) {
            return is_planned(m, request) ? std::uint16_t{1000} : std::uint16_t{0};
        };
        line.lost_request = rate(mishap::request_lost, requests);
        line.corrupted_request = rate(mishap::request_damaged, requests);
        line.lost_response = rate(mishap::response_lost, requests - 1);
        line.corrupted_response = rate(mishap::response_damaged, requests - 1);
        line.late_response = rate(mishap::response_late, requests - 1);
        line.doubled_response = rate(mishap::response_doubled, requests - 1);
    }

    bool has_happened(mishap m) const { return has_happened_[static_cast<unsigned>(m)]; }
    bool has_restarted() const {
        return has_happened(mishap::restart_before) || has_happened(mishap::restart_after);
    }
    /// True if each restart was over between the read of a register and the write that sets it again.
    bool has_restarted_in_a_change(const wire_log& log) const {
        unsigned restarts = 0;
        for (const planned_mishap& p : planned_) {
            const bool is_before = p.what == mishap::restart_before;
            if ((!is_before && p.what != mishap::restart_after) || !has_happened(p.what)) continue;
            if (!log.writes_what_was_read(is_before ? p.request : p.request + 1)) return false;
            ++restarts;
        }
        return restarts != 0;
    }

  private:
    bool is_planned(mishap m, unsigned request) const {
        return (planned_[0].what == m && planned_[0].request == request) ||
               (planned_[1].what == m && planned_[1].request == request);
    }

    planned_mishap planned_[2]{};
    std::array<bool, sizeof all_mishaps / sizeof *all_mishaps + 1> has_happened_{};
};

} // namespace servobus::sim
