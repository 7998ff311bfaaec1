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

namespace plan_times_tests {

using namespace servobus;
using u64 = std::uint64_t;

struct meter {
    static constexpr profile facts{
        .name = "meter", .limits = {.response = milliseconds(1)}, .quarantine = {}};
};
bare::model model_of(const meter&);
constexpr reg<u16, access::ro, meter> level{0x0010, full<u16>, no_unit, no_default};
constexpr reg<u16, access::ro, meter> flow{0x0011, full<u16>, no_unit, no_default};

// --- The second calculation

u64 cut(u64 us) { return std::min<u64>(us, 0xFFFF'FFFF); }

struct reference {
    modbus::rtu_timing timing;
    back_off rules;
    std::span<const poll> polls;
    std::span<const controlled_node> drives;
    std::span<const requested_node> requests;

    template <class Plan>
    explicit reference(const Plan& of)
        : timing{of.timing()}, rules{of.rules()}, polls{of.polls, Plan::size},
          drives{of.controlled, Plan::drives}, requests{of.requests, Plan::requested} {}

    u64 wire(u64 bytes) const { return bytes * timing.character; }
    u64 end_of_frame() const {
        const bool is_strict = timing.mode == modbus::timing_mode::strict;
        return is_strict ? timing.t3_5 : std::max<u64>(timing.inter_byte.us, timing.t3_5);
    }
    u64 slowest(u64 bytes) const {
        const u64 spaced = bytes * (timing.character + u64{timing.t1_5});
        if (timing.mode == modbus::timing_mode::strict) return spaced;
        return std::max(spaced, end_of_frame() + wire(bytes));
    }
    template <class Of> u64 most(u64 least, Of&& of) const {
        for (const poll& p : polls) least = std::max<u64>(least, of(p));
        for (const controlled_node& d : drives) least = std::max<u64>(least, of(d));
        for (const requested_node& r : requests) least = std::max<u64>(least, of(r));
        return least;
    }
    u64 quarantine() const {
        return most(end_of_frame(), [](const auto& e) { return e.gaps.quarantine.us; });
    }
    u64 any_gap() const {
        return most(timing.t3_5, [](const auto& e) { return e.gaps.gap.us; });
    }
    u64 own_gap(const bus_gaps& gaps) const { return std::max<u64>(timing.t3_5, gaps.gap.us); }
    u64 stop_gap() const {
        u64 longest = timing.t3_5;
        for (const controlled_node& d : drives) longest = std::max<u64>(longest, d.gaps.gap.us);
        return longest;
    }
    u64 longest_response() const {
        u64 longest = 0;
        for (const poll& p : polls) longest = std::max<u64>(longest, p.limits.response.us);
        for (const controlled_node& d : drives) longest = std::max<u64>(longest, d.limits.response.us);
        return longest;
    }

    u64 silent(const bus_gaps& gaps, u64 response) const {
        return own_gap(gaps) + wire(8) + response + quarantine();
    }
    u64 late(const poll& p) const {
        return silent(p.gaps, p.limits.response.us) + wire(5u + 2u * p.words) + quarantine();
    }
    u64 late(const requested_node& r) const {
        return own_gap(r.gaps) + wire(9u + 2u * r.words) + r.limits.response.us + quarantine() +
               wire(5u + 2u * r.words) + quarantine();
    }
    u64 command() const {
        if (drives.empty()) return 0;
        return any_gap() + wire(21) + longest_response() + quarantine() + wire(27) + quarantine();
    }
    u64 in_flight(u64 response, u64 request, u64 answer) const {
        return wire(request) + response + stop_gap() + slowest(answer);
    }
    u64 stop_frame() const { return drives.empty() ? 0 : in_flight(longest_response(), 13, 8) + stop_gap(); }
    u64 stop() const { return drives.empty() ? 0 : 3 * stop_frame() + quarantine() + wire(8) + quarantine(); }
    u64 own_requests() const {
        u64 sum = 0;
        for (const requested_node& r : requests) sum += late(r);
        return sum;
    }
    u64 late_read() const {
        u64 longest = 0;
        for (const poll& p : polls) longest = std::max(longest, late(p));
        return longest;
    }

    // A frame of each other drive and of each own request with each read; a stop of each other drive.
    template <class Counts> u64 wait(std::size_t own, Counts counts) const {
        u64 sum = 0;
        for (std::size_t i = 0; i < polls.size(); ++i) {
            if (i != own && !counts(polls[i].node_address)) continue;
            sum += late(polls[i]) + own_requests();
            for (const controlled_node& d : drives) sum += counts(d.address) ? command() : 0;
        }
        for (const controlled_node& d : drives) sum += counts(d.address) ? stop() : 0;
        return sum;
    }
    u64 gap(std::size_t own) const {
        const std::uint8_t at = polls[own].node_address;
        return polls[own].period.us + wait(own, [at](std::uint8_t address) { return address != at; });
    }
    u64 drive_wait() const {
        return late_read() + own_requests() + command() * drives.size() + stop() * (drives.size() - 1);
    }
    static u64 poll_period(const controlled_node& d) {
        const bool has_watchdog = d.keep_alive.us != 0 && d.by.feedback.us != 0;
        return has_watchdog ? std::min(d.by.feedback.us, d.keep_alive.us / 4) : d.by.feedback.us;
    }
    u64 gap(const controlled_node& d) const { return poll_period(d) + drive_wait(); }
    u64 stop_pause() const {
        if (rules.stop_every.us == 0) return 0xFFFF'FFFF;
        return rules.stop_every.us + late_read() + own_requests() + command() * drives.size();
    }

    u64 absent_load() const {
        u64 read = 0;
        u64 feedback = 0;
        u64 us = 0;
        for (const poll& p : polls) read = std::max(read, cut(silent(p.gaps, p.limits.response.us)));
        for (const controlled_node& d : drives) {
            if (d.keep_alive.us == 0 && d.by.feedback.us != 0)
                feedback = std::max(feedback, cut(silent(d.gaps, longest_response())));
        }
        for (const requested_node& r : requests) {
            const bool is_apart =
                std::ranges::none_of(polls, [&](const poll& p) { return p.node_address == r.address; }) &&
                std::ranges::none_of(drives, [&](const auto& d) { return d.address == r.address; });
            us += is_apart ? cut(late(r)) : 0;
        }
        us += read + feedback;
        if (us == 0) return 0;
        return rules.retry_every.us <= us ? 1000 : us * 1000 / rules.retry_every.us + 1;
    }
    u64 rediscovery(u64 absent) const {
        u64 period = 0;
        for (const poll& p : polls) period = std::max<u64>(period, p.period.us);
        const u64 turn = cut(wait(0, [](std::uint8_t) { return true; }));
        u64 longest = polls.empty() ? 0 : period + (rules.retry_every.us + turn) * absent;
        for (const controlled_node& d : drives) {
            if (d.keep_alive.us == 0 && d.by.feedback.us != 0)
                longest = std::max(longest, u64{rules.retry_every.us} * drives.size() + drive_wait());
        }
        return longest;
    }

    u64 longest_in_flight() const {
        u64 longest = 0;
        for (const poll& p : polls)
            longest = std::max(longest, in_flight(p.limits.response.us, 8, 5u + 2u * p.words));
        for (const requested_node& r : requests) {
            longest = std::max(longest, in_flight(r.limits.response.us, 8, 5u + 2u * r.words));
            longest = std::max(longest, in_flight(r.limits.response.us, 9u + 2u * r.words, 8));
        }
        if (drives.empty()) return longest;
        longest = std::max(longest, in_flight(longest_response(), 8, 27));
        return std::max(longest, in_flight(longest_response(), 21, 8));
    }
    u64 stop_latency(u64 stops) const {
        return cut(longest_in_flight()) + stop_gap() + wire(13) + stop_frame() * (stops - 1);
    }

    u64 answered(const bus_gaps& gaps, u64 request, u64 answer) const {
        return own_gap(gaps) + wire(request) + timing.t3_5 + wire(answer);
    }
    u64 load() const {
        u64 billionths = 0;
        const auto add = [&](u64 us, u64 period) { billionths += us * 1'000'000'000 / period; };
        for (const poll& p : polls) add(answered(p.gaps, 8, 5u + 2u * p.words), p.period.us);
        for (const controlled_node& d : drives) {
            if (d.command_period.us != 0) add(answered(d.gaps, 13, 8), d.command_period.us);
            if (d.by.feedback.us == 0) continue;
            add(answered(d.gaps, 8, 5u + 2u * d.image_words), poll_period(d));
            add(answered(d.gaps, 8, 9), 500'000);
            if (d.readings_between == 0) continue;
            billionths += answered(d.gaps, 8, 5u + 2u * d.slower_words) * 1'000'000'000 / d.by.feedback.us /
                          d.readings_between;
        }
        for (const requested_node& r : requests)
            add(std::max(answered(r.gaps, 8, 5u + 2u * r.words), answered(r.gaps, 9u + 2u * r.words, 8)),
                r.period.us);
        return (billionths + 999'999) / 1'000'000;
    }
};

// --- Plans of any shape

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
    const reference second{plan};
    const detail::request_gaps<Plan> checked{plan}; // as the compiler checks them
    REQUIRE(plan.longest_response().us == second.longest_response());
    REQUIRE(plan.load_per_mille() == static_cast<std::uint32_t>(second.load()));
    for (std::size_t i = 0; i < Plan::size; ++i) {
        const poll& p = plan.polls[i];
        REQUIRE(plan.shortest(p).us ==
                static_cast<std::uint32_t>(second.answered(p.gaps, 8, 5u + 2u * p.words)));
        REQUIRE(plan.longest(p).us == cut(second.late(p)));
        REQUIRE(plan.longest_gap(p).us == cut(second.gap(i)));
        REQUIRE(checked.of(p) == plan.longest_gap(p));
    }
    for (const controlled_node& d : second.drives) {
        REQUIRE(plan.longest_gap(d).us == cut(second.gap(d)));
        REQUIRE(checked.of(d) == plan.longest_gap(d));
    }
    REQUIRE(plan.longest_stop().us == cut(second.stop()));
    REQUIRE(plan.longest_stop_pause().us == cut(second.stop_pause()));
    REQUIRE(plan.absent_load_per_mille() == second.absent_load());
    for (const std::uint32_t n : {1u, 2u, 5u}) {
        REQUIRE(plan.rediscovery_bound(n).us == cut(second.rediscovery(n)));
        REQUIRE(plan.worst_case_stop_latency(n).us == cut(second.stop_latency(n)));
    }
    REQUIRE(plan.longest_in_flight().us == cut(second.longest_in_flight()));
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
    CHECK(of_one_node.of(plan.polls[0]).us == reference{plan}.gap(0));
    CHECK(of_one_node.of(plan.polls[0]) < milliseconds(61'000));
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

    SUBCASE("a shorter response limit and quarantine") {
        const std::uint32_t most = detail::most_response_and_quarantine(plan);
        const auto with = [&](std::uint32_t ms) {
            auto changed = plan;
            for (poll& p : changed.polls) p.limits.response = p.gaps.quarantine = milliseconds(ms);
            return changed;
        };
        CHECK(most > 5);
        CHECK(is_allowed(with(most)));
        CHECK(!is_allowed(with(most + 1)));
    }
    SUBCASE("none is short enough") {
        watched.keep_alive = milliseconds(20);
        CHECK(detail::most_response_and_quarantine(plan) == 0);
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
