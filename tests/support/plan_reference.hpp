// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A second calculation of a plan's times, which run/bus/plan_times.cpp compares with the library's.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/bus/plan.hpp>

namespace tests {

using namespace servobus; // NOLINT: as a test has it

/// The times of a plan, added up frame by frame, for each entry anew and in 64 bits.
struct plan_reference {
    using u64 = std::uint64_t;

    /// The time as a `duration` has it: at most the longest.
    static u64 cut(u64 us) { return std::min<u64>(us, 0xFFFF'FFFF); }

    modbus::rtu_timing timing;
    back_off rules;
    std::span<const poll> polls;
    std::span<const controlled_node> drives;
    std::span<const requested_node> requests;

    template <class Plan>
    explicit plan_reference(const Plan& of)
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
            if (d.refreshes_between == 0) continue;
            billionths += answered(d.gaps, 8, 5u + 2u * d.slower_words) * 1'000'000'000 / d.by.feedback.us /
                          d.refreshes_between;
        }
        for (const requested_node& r : requests)
            add(std::max(answered(r.gaps, 8, 5u + 2u * r.words), answered(r.gaps, 9u + 2u * r.words, 8)),
                r.period.us);
        return (billionths + 999'999) / 1'000'000;
    }
};

} // namespace tests
