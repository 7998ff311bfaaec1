// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plan's times, compared with a second calculation of them: each is added up frame by frame, for each entry anew and
// in 64 bits. The plans have random limits, gaps, periods and addresses; some times are longer than a `duration`.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>

#include <servobus/bus/bus.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>

#include <tests/support/bare_drive.hpp>
#include <tests/support/plan_reference.hpp>

namespace plan_times_tests {

using namespace servobus;
struct meter {
    static constexpr profile facts{
        .name = "meter", .limits = {.response = milliseconds(1)}, .quarantine = {}};
};
bare::model model_of(const meter&);
constexpr reg<u16, access::ro, meter> level{0x0010, full<u16>, no_unit, no_default};
constexpr reg<u16, access::ro, meter> flow{0x0011, full<u16>, no_unit, no_default};

template <const auto&... Rs> consteval auto read(std::uint8_t address) {
    return cyclic<Rs...>(node<meter>{address}, milliseconds(60'000));
}
template <class Device> consteval auto drive(std::uint8_t address) {
    node<Device> at{address};
    at.limits.response = milliseconds(1);
    at.gaps.quarantine = {};
    return controlled(at, unsupervised);
}
consteval auto own(std::uint8_t address) {
    return own_requests(node<meter>{address}, milliseconds(60'000), 4);
}

constexpr auto quick = modbus::timing_at(115200);
constexpr auto strict = modbus::timing_at(19200, modbus::timing_mode::strict);
constexpr poll_plan one_read{quick, read<level>(1)};
constexpr poll_plan one_drive{modbus::timing_at(9600), drive<meter>(1)};
constexpr poll_plan two_drives{strict, drive<zlac8015d::device>(1), back_off{.stop_every = {}},
                               drive<c630s::device>(2)};
constexpr poll_plan reads{strict, read<level>(1), read<level, flow>(2), read<level>(3), read<level>(4)};
constexpr poll_plan all_kinds{quick,
                              read<level>(1),
                              drive<zlac8015d::device>(2),
                              own(3),
                              read<level, flow>(4),
                              back_off{.retry_every = milliseconds(7), .stop_every = milliseconds(40)},
                              read<level>(5),
                              drive<meter>(6),
                              drive<c630s::device>(7),
                              own(8),
                              read<flow>(9)};
constexpr poll_plan requests_beside_a_read{
    modbus::timing_at(1200), own(1), own(2), own(3), read<level, flow>(4), own(5), own(6), own(7), own(8)};

class dice {
  public:
    explicit dice(std::uint32_t seed) : random_{seed} {}
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
    /// Mostly the times of a machine, a few so long that sums of them end at the longest `duration`.
    duration time() {
        switch (below(8)) {
        case 0: return {};
        case 1: return duration{below(0x7FFF'FFFF)};
        case 2: return milliseconds(100);
        default: return duration{below(300'000)};
        }
    }
    duration period() { return longer_of(time(), duration{1000}); }

  private:
    std::mt19937 random_;
};

template <class Plan> void change(Plan& plan, dice& any) {
    // Addresses are few, so that a node has several entries.
    std::uint8_t address = 0;
    for (controlled_node& d : std::span{plan.controlled}.first(Plan::drives)) {
        d.address = static_cast<std::uint8_t>(++address);
        d.limits.response = any.time();
        d.gaps = {any.time(), any.time()};
        d.by.feedback = any.below(3) == 0 ? duration{} : any.period();
        d.keep_alive = any.below(2) == 0 ? duration{} : any.period();
        d.command_period = any.below(2) == 0 ? duration{} : any.period();
    }
    for (poll& p : std::span{plan.polls}.first(Plan::size)) {
        p.node_address = static_cast<std::uint8_t>(1 + any.below(5));
        p.words = static_cast<std::uint16_t>(1 + any.below(125));
        p.period = any.period();
        p.limits.response = any.time();
        p.gaps = {any.time(), any.time()};
    }
    for (requested_node& r : std::span{plan.requests}.first(Plan::requested)) {
        r.address = static_cast<std::uint8_t>(1 + any.below(12));
        r.words = static_cast<std::uint16_t>(1 + any.below(125));
        r.period = any.period();
        r.limits.response = any.time();
        r.gaps = {any.time(), any.time()};
    }
}

template <class Plan> void compare(const Plan& plan) {
    const tests::plan_reference second{plan};
    const detail::request_gaps<Plan> checked{plan}; // as the compiler checks them
    REQUIRE(plan.longest_response().us == second.longest_response());
    REQUIRE(plan.load_per_mille() == static_cast<std::uint32_t>(second.load()));
    for (std::size_t i = 0; i < Plan::size; ++i) {
        const poll& p = plan.polls[i];
        REQUIRE(plan.shortest(p).us ==
                static_cast<std::uint32_t>(second.answered(p.gaps, 8, 5u + 2u * p.words)));
        REQUIRE(plan.longest(p).us == second.cut(second.late(p)));
        REQUIRE(plan.longest_gap(p).us == second.cut(second.gap(i)));
        REQUIRE(checked.of(p) == plan.longest_gap(p));
    }
    for (const controlled_node& d : second.drives) {
        REQUIRE(plan.longest_gap(d).us == second.cut(second.gap(d)));
        REQUIRE(checked.of(d) == plan.longest_gap(d));
    }
    REQUIRE(plan.longest_stop().us == second.cut(second.stop()));
    REQUIRE(plan.longest_stop_pause().us == second.cut(second.stop_pause()));
    REQUIRE(plan.absent_load_per_mille() == second.absent_load());
    for (const std::uint32_t n : {1u, 2u, 5u}) {
        REQUIRE(plan.rediscovery_bound(n).us == second.cut(second.rediscovery(n)));
        REQUIRE(plan.worst_case_stop_latency(n).us == second.cut(second.stop_latency(n)));
    }
    REQUIRE(plan.longest_in_flight().us == second.cut(second.longest_in_flight()));
}

template <class... Plans> void compare_many(const Plans&... plans) {
    dice any{20'260'101};
    for (int i = 0; i < 2000; ++i) {
        CAPTURE(i);
        const auto one = [&](auto plan) {
            compare(plan);
            change(plan, any);
            compare(plan);
        };
        (one(plans), ...);
    }
}

TEST_CASE("G19, G25, G28: the times of 12000 random plans are those that a second calculation adds up frame "
          "by frame") {
    compare_many(one_read, one_drive, two_drives, reads, all_kinds, requests_beside_a_read);
}

TEST_CASE("a sum of times that is too long for a duration is the longest one, for each of its reads") {
    auto plan = reads;
    plan.polls[1].limits.response = duration{0xFFFF'FFFF};
    plan.polls[2].limits.response = duration{0xFFFF'FFFF};
    const detail::request_gaps<decltype(plan)> checked{plan};
    for (const poll& p : plan.polls) CHECK(checked.of(p) == duration{0xFFFF'FFFF});
    // Without the two long ones the sum of the others is exact again.
    plan.polls[1].node_address = plan.polls[2].node_address = plan.polls[0].node_address;
    const detail::request_gaps<decltype(plan)> of_one_node{plan};
    CHECK(of_one_node.of(plan.polls[0]).us == tests::plan_reference{plan}.gap(0));
    CHECK(of_one_node.of(plan.polls[0]) < milliseconds(61'000));
}

TEST_CASE("the error of a plan that does not fit names the node whose frames take the most") {
    const detail::busiest_node alone{one_read};
    CHECK(alone.address == 1);
    CHECK(alone.per_mille == one_read.load_per_mille());
    auto plan = all_kinds;
    plan.polls[1].period = milliseconds(3); // node 4
    CHECK(detail::busiest_node{plan}.address == 4);
    plan.requests[1].period = milliseconds(2); // node 8
    CHECK(detail::busiest_node{plan}.address == 8);
    plan.controlled[2].command_period = milliseconds(1); // node 7
    const detail::busiest_node driven{plan};
    CHECK(driven.address == 7);
    CHECK(driven.per_mille > 1000);
    CHECK(driven.per_mille < plan.load_per_mille());
}

TEST_CASE("G19: what the error of a keep-alive proposes mends the plan, and nothing less does") {
    auto plan = all_kinds;
    for (controlled_node& d : plan.controlled) d.by.feedback = milliseconds(20);
    for (poll& p : plan.polls) {
        p.limits.response = p.gaps.quarantine = milliseconds(400);
        p.keep_alive = {};
    }
    controlled_node& watched = plan.controlled[0];
    const auto is_allowed = [](const auto& of) { return detail::request_gaps{of}.are_allowed(); };
    REQUIRE(watched.keep_alive != duration{});
    REQUIRE(!is_allowed(plan));

    SUBCASE("nodes that respond sooner") {
        const std::uint32_t most = detail::longest_allowed_response(plan);
        const auto with = [&](std::uint32_t ms) {
            auto changed = plan;
            const auto grant = [ms](auto& entry) { // as `responds_within`
                entry.limits.response = milliseconds(ms);
                entry.gaps.quarantine = longer_of(milliseconds(ms + 10), entry.gaps.gap);
            };
            for (poll& p : changed.polls) grant(p);
            for (controlled_node& d : changed.controlled) grant(d);
            for (requested_node& r : changed.requests) grant(r);
            return changed;
        };
        CHECK(most > 5);
        CHECK(is_allowed(with(most)));
        CHECK(!is_allowed(with(most + 1)));
    }
    SUBCASE("none is short enough") {
        watched.keep_alive = milliseconds(20);
        CHECK(detail::longest_allowed_response(plan) == 0);
    }
    SUBCASE("a longer watchdog") {
        for (const duration feedback : {milliseconds(20), milliseconds(50'000)}) {
            watched.by.feedback = feedback;
            const auto ms = static_cast<std::uint32_t>(detail::request_gaps{plan}.needed(watched));
            watched.keep_alive = at_least(milliseconds(ms));
            CHECK(is_allowed(plan));
            watched.keep_alive = at_least(milliseconds(ms - 2)); // what is rounded up is less than that
            CHECK(!is_allowed(plan));
        }
    }
    SUBCASE("a longer watchdog of a node that is only read") {
        watched.keep_alive = {};
        poll& read = plan.polls[0];
        for (const duration period : {milliseconds(20), milliseconds(600'000)}) {
            read.period = period;
            const auto ms = static_cast<std::uint32_t>(detail::request_gaps{plan}.needed(read));
            read.keep_alive = milliseconds(ms);
            CHECK(is_allowed(plan));
            read.keep_alive = milliseconds(ms - 2);
            CHECK(!is_allowed(plan));
        }
    }
}

} // namespace plan_times_tests
