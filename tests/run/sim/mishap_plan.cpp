// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which mishap happens at which request of a run (sim/conformance/mishap_plan.hpp), and what is known of it afterwards.
// The drive and the program have theirs once; a frame has its own by the faults of the line.
#include <array>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/core/bytes.hpp>
#include <servobus/sim/conformance/mishap_plan.hpp>

namespace mishap_plan_tests {

using namespace servobus;
using sim::mishap;
using sim::mishap_plan;

TEST_CASE("a mishap happens at its request, and not at another one") {
    mishap_plan plan{{mishap::busy, 2}, {mishap::fault, 2}};
    CHECK_FALSE(plan.happens(mishap::busy, 0));
    CHECK_FALSE(plan.happens(mishap::busy, 2));
    CHECK_FALSE(plan.happens(mishap::refused, 3));
    CHECK_FALSE(plan.has_happened(mishap::busy));
    CHECK(plan.happens(mishap::busy, 3));
    CHECK(plan.has_happened(mishap::busy));
    CHECK_FALSE(plan.has_happened(mishap::fault));
    CHECK(plan.happens(mishap::fault, 3));
    CHECK_FALSE(plan.happens(mishap::busy, 4));
}
TEST_CASE("a mishap happens once, or at both requests for which it is planned") {
    mishap_plan one{{mishap::busy, 0}, {mishap::fault, 1}};
    CHECK(one.happens(mishap::busy, 1));
    CHECK_FALSE(one.happens(mishap::busy, 1));
    mishap_plan both{{mishap::busy, 0}, {mishap::busy, 4}};
    CHECK(both.happens(mishap::busy, 1));
    CHECK(both.happens(mishap::busy, 5));
}
TEST_CASE("after its end nothing more happens, and what has happened is known") {
    mishap_plan plan{{mishap::restart_before, 0}, {mishap::busy, 1}};
    CHECK_FALSE(plan.has_restarted());
    CHECK(plan.happens(mishap::restart_before, 1));
    plan.end();
    CHECK_FALSE(plan.happens(mishap::busy, 2));
    CHECK(plan.has_happened(mishap::restart_before));
    CHECK(plan.has_restarted());
    plan = {};
    CHECK_FALSE(plan.has_restarted());
}
TEST_CASE("a fault of the line is that of the present request, if one is planned for it") {
    mishap_plan plan{{mishap::response_doubled, 1}, {mishap::refused, 2}};
    plan.note_line_fault(1);
    CHECK_FALSE(plan.has_happened(mishap::response_doubled));
    plan.note_line_fault(2);
    CHECK(plan.has_happened(mishap::response_doubled));
    plan.note_line_fault(3);
    CHECK_FALSE(plan.has_happened(mishap::refused)); // the drive has it, not the line
}
TEST_CASE("the line's faults are those of the next request, and of the response to the present one") {
    using rates = std::array<std::uint16_t, 6>;
    const auto at = [](mishap m, unsigned requests) {
        sim::fault_plan line;
        mishap_plan{{}, {m, 3}}.set_faults(line, requests);
        return rates{line.lost_request,       line.corrupted_request, line.lost_response,
                     line.corrupted_response, line.late_response,     line.doubled_response};
    };
    constexpr rates none{};
    CHECK(at(mishap::request_lost, 3) == rates{1000, 0, 0, 0, 0, 0});
    CHECK(at(mishap::request_damaged, 3) == rates{0, 1000, 0, 0, 0, 0});
    CHECK(at(mishap::response_lost, 4) == rates{0, 0, 1000, 0, 0, 0});
    CHECK(at(mishap::response_damaged, 4) == rates{0, 0, 0, 1000, 0, 0});
    CHECK(at(mishap::response_late, 4) == rates{0, 0, 0, 0, 1000, 0});
    CHECK(at(mishap::response_doubled, 4) == rates{0, 0, 0, 0, 0, 1000});
    CHECK(at(mishap::request_lost, 4) == none);
    CHECK(at(mishap::response_lost, 3) == none);
    CHECK(at(mishap::busy, 3) == none);
    CHECK(at(mishap::busy, 4) == none);
}
TEST_CASE("a restart between the read of a register and the write that sets it again") {
    sim::wire_log log;
    std::uint64_t at_us = 0;
    const auto send = [&](bytes frame, unsigned requests) {
        for (const std::uint8_t b : frame)
            log.note({.at_us = at_us += 100, .value = b, .is_from_client = true}, requests);
        at_us += 10'000;
    };
    send(hex("05 03 00 03 00 01 75 8E"), 1);
    send(hex("05 06 00 03 00 03 38 4F"), 2);
    send(hex("05 03 00 04 00 01 C4 4F"), 3);
    const auto is_in_a_change = [&](sim::planned_mishap first, sim::planned_mishap second) {
        mishap_plan plan{first, second};
        CHECK_FALSE(plan.has_restarted_in_a_change(log));
        CHECK(plan.happens(first.what, first.request + 1));
        (void)plan.happens(second.what, second.request + 1);
        return plan.has_restarted_in_a_change(log);
    };
    CHECK(is_in_a_change({mishap::restart_after, 0}, {}));
    CHECK(is_in_a_change({mishap::restart_before, 1}, {}));
    CHECK(is_in_a_change({mishap::restart_after, 0}, {mishap::restart_before, 1}));
    CHECK_FALSE(is_in_a_change({mishap::restart_before, 0}, {}));
    CHECK_FALSE(is_in_a_change({mishap::restart_after, 0}, {mishap::restart_before, 2}));
    CHECK_FALSE(is_in_a_change({mishap::busy, 0}, {}));
}

} // namespace mishap_plan_tests
