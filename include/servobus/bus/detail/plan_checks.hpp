// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The rules of a plan: one that breaks them does not compile.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/bus/detail/plan_errors.hpp>
#include <servobus/bus/detail/plan_times.hpp>

namespace servobus::detail {

/// The longest time that may pass between two requests to a node, and what its keep-alive allows.
struct longest_gap {
    duration keep_alive{};
    duration longest{};

    constexpr bool is_allowed() const { return longest <= keep_alive; }
};

/// The longest times between two requests to the nodes of a plan, and whether each keep-alive allows them.
template <class Plan> class request_gaps {
  public:
    constexpr explicit request_gaps(const Plan& of)
        : plan_{of}, times_{of}, others_{of, times_}, wait_of_a_drive_{times_.wait_of_a_drive()} {}

    constexpr duration of(const poll& p) const {
        return bound{p.period} + times_.wait(p, others_.than(p.node_address));
    }
    constexpr duration of(const controlled_node& d) const { return bound{poll_period(d)} + wait_of_a_drive_; }
    // The time while other nodes respond too late; if that is allowed, the time while all respond. The latter must be
    // allowed even if the clocks of node and program differ.
    constexpr longest_gap judge(const poll& p) const {
        if (p.keep_alive == duration{}) return {};
        const longest_gap late{p.keep_alive, of(p)};
        return late.is_allowed() ? longest_gap{at_least(p.keep_alive), p.period + times_.shortest(p)} : late;
    }
    constexpr longest_gap judge(const controlled_node& d) const {
        return is_kept_alive(d) ? longest_gap{d.keep_alive, of(d)} : longest_gap{};
    }
    constexpr bool are_allowed() const {
        for (std::size_t i = 0; i < Plan::size; ++i) {
            if (!judge(plan_.polls[i]).is_allowed()) return false;
        }
        for (std::size_t i = 0; i < Plan::drives; ++i) {
            if (!judge(plan_.controlled[i]).is_allowed()) return false;
        }
        return true;
    }

    // The shortest keep-alive in milliseconds that allows its time, as `keeps_alive(..)` takes it.
    constexpr unsigned long needed(const poll& p) const {
        const unsigned long answered = stated(std::uint64_t{p.period.us} + times_.shortest(p).us);
        const unsigned long gap = in_ms(of(p).us);
        return answered < gap ? gap : answered;
    }
    // The drive is read every quarter of its keep-alive at least.
    constexpr unsigned long needed(const controlled_node& d) const {
        const std::uint64_t wait = wait_of_a_drive_.time.us;
        const std::uint64_t period = d.by.feedback.us < wait / 3 ? d.by.feedback.us : wait / 3 + 1;
        return stated(wait + period);
    }

  private:
    static constexpr unsigned long in_ms(std::uint64_t us) {
        return static_cast<unsigned long>((us + 999) / 1000);
    }
    // The keep-alive whose `at_least` is this time: clocks differ.
    static constexpr unsigned long stated(std::uint64_t us) { return in_ms(us * 16 / 15 + 1); }

    const Plan& plan_;
    plan_times times_;
    all_others others_;
    bound wait_of_a_drive_;
};

/// The longest time, in whole milliseconds, that `responds_within` may grant to all nodes while each is still kept
/// alive; 0 if there is none.
template <class Plan> constexpr std::uint32_t longest_allowed_response(const Plan& of) {
    const auto would_do = [&of](std::uint32_t ms) {
        Plan other = of;
        const auto grant = [ms](auto& entry) {
            entry.limits.response = milliseconds(ms);
            entry.gaps.quarantine = quarantine_of(milliseconds(ms), entry.gaps);
        };
        for (poll& p : other.polls) grant(p);
        for (controlled_node& d : other.controlled) grant(d);
        for (requested_node& r : other.requests) grant(r);
        return request_gaps<Plan>{other}.are_allowed();
    };
    std::uint32_t most = 0;
    for (std::uint32_t step = 4096; step != 0; step /= 2) {
        if (would_do(most + step)) most += step;
    }
    return most;
}

/// The node whose frames take the most of the line's time, and how much, in thousandths.
struct busiest_node {
    std::uint8_t address = 0;
    std::uint32_t per_mille = 0;

    template <class Plan> constexpr explicit busiest_node(const Plan& of) {
        const plan_times times{of};
        std::uint64_t billionths[256]{};
        for (std::size_t i = 0; i < Plan::size; ++i)
            billionths[of.polls[i].node_address] += times.load_of(of.polls[i]);
        for (std::size_t i = 0; i < Plan::drives; ++i)
            billionths[of.controlled[i].address] += times.load_of(of.controlled[i]);
        for (std::size_t i = 0; i < Plan::requested; ++i)
            billionths[of.requests[i].address] += times.load_of(of.requests[i]);
        for (unsigned i = 0; i < 256; ++i) {
            if (billionths[i] > billionths[address]) address = static_cast<std::uint8_t>(i);
        }
        per_mille = static_cast<std::uint32_t>((billionths[address] + 999'999u) / 1'000'000u);
    }
};

template <class Plan> constexpr plan_fault fault_of_addresses(const Plan& of) {
    bool has_facade[256]{};
    for (std::size_t i = 0; i < Plan::drives; ++i) {
        const std::uint8_t address = of.controlled[i].address;
        if (has_facade[address]) return {plan_fault::kind::two_facades, {address}};
        has_facade[address] = true;
    }
    bool has_requests[256]{};
    for (std::size_t i = 0; i < Plan::requested; ++i) {
        const std::uint8_t address = of.requests[i].address;
        if (has_requests[address]) return {plan_fault::kind::two_requests, {address}};
        has_requests[address] = true;
    }
    return {};
}

template <class Plan> constexpr plan_fault fault_of(const Plan& of) {
    plan_fault why = fault_of_addresses(of);
    if (why.rule != plan_fault::kind::none) return why;
    const std::uint32_t load = of.load_per_mille();
    if (load > 1000) {
        const busiest_node most{of};
        return {plan_fault::kind::load, {load, most.address, most.per_mille}};
    }
    const request_gaps<Plan> gaps{of};
    const auto judge = [&](std::uint8_t address, const auto& entry, duration own) {
        const duration gap = gaps.of(entry);
        const longest_gap v = gaps.judge(entry);
        if (own > longest_period || gap > longest_period)
            why = {plan_fault::kind::too_long, {address, longer_of(own, gap).us}};
        else if (!v.is_allowed())
            why = {
                plan_fault::kind::keep_alive,
                {address, v.keep_alive.us, v.longest.us, longest_allowed_response(of), gaps.needed(entry)}};
        return why.rule == plan_fault::kind::none;
    };
    for (std::size_t i = 0; i < Plan::size; ++i) {
        if (!judge(of.polls[i].node_address, of.polls[i], of.polls[i].period)) return why;
    }
    for (std::size_t i = 0; i < Plan::drives; ++i) {
        if (!judge(of.controlled[i].address, of.controlled[i], of.controlled[i].by.feedback)) return why;
    }
    return why;
}

} // namespace servobus::detail
