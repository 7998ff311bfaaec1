// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The times that all entries of a plan share, and what follows from them for one entry. A plan computes them once for
// a calculation, so that its work is linear in the number of entries.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/bus/detail/bound.hpp>
#include <servobus/bus/plan_entries.hpp>
#include <servobus/control/step.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::detail {

// A drive with a watchdog is not polled once the watchdog is over: then its state is unknown.
constexpr bool backs_off(const controlled_node& d) {
    return d.keep_alive == duration{} && d.by.feedback != duration{};
}
constexpr bool is_kept_alive(const controlled_node& d) {
    return d.keep_alive != duration{} && d.by.feedback != duration{};
}
// A facade reads an enabled drive four times within its watchdog.
constexpr duration poll_period(const controlled_node& d) {
    return is_kept_alive(d) ? shorter_of(d.by.feedback, duration{d.keep_alive.us / 4}) : d.by.feedback;
}

/// Entries for which a read waits. The sum has 64 bits, and does not end at the longest `duration`: entries are taken
/// out of it again.
struct other_entries {
    std::uint64_t reads_us = 0;
    std::uint32_t reads = 0;
    std::uint32_t drives = 0;

    constexpr void add(bound read) {
        reads_us += read.time.us;
        ++reads;
    }
};

struct plan_times {
    // Bytes of the frames of a facade.
    static constexpr std::size_t read_request = 8;
    static constexpr std::size_t longest_write = 9 + 2 * steps::max_arguments;
    static constexpr std::size_t longest_stop_frame = 13; // two words
    static constexpr std::size_t longest_read_response = 5 + 2 * steps::longest;

    modbus::rtu_timing timing;
    std::uint32_t drives = 0;
    duration quarantine = timing.visible_gap(); ///< the longest: of the node before, or of the next one
    duration longest_own_gap{timing.t3_5};      ///< before a request of any node
    duration stop_gap{timing.t3_5};             ///< before a stop: the gap of its own drive only
    duration longest_response{};                ///< the longest time limit among the controlled drives
    bound requests_between = duration{};        ///< one request to each node of the program's own ones
    bound longest_read = duration{};

    template <class Plan>
    constexpr explicit plan_times(const Plan& of) : timing{of.timing()}, drives{Plan::drives} {
        for (std::size_t i = 0; i < Plan::size; ++i) note(of.polls[i].gaps);
        for (std::size_t i = 0; i < Plan::drives; ++i) {
            note(of.controlled[i].gaps);
            longest_response = longer_of(longest_response, of.controlled[i].limits.response);
            stop_gap = longer_of(stop_gap, of.controlled[i].gaps.gap);
        }
        for (std::size_t i = 0; i < Plan::requested; ++i) note(of.requests[i].gaps);
        for (std::size_t i = 0; i < Plan::requested; ++i)
            requests_between = requests_between + longest(of.requests[i]);
        for (std::size_t i = 0; i < Plan::size; ++i)
            longest_read = longer_of(longest_read, longest(of.polls[i]));
    }

    // --- If a node responds immediately

    constexpr duration shortest(const bus_gaps& gaps, std::size_t request, std::size_t response) const {
        return own_gap(gaps) + timing.wire_time(request) + duration{timing.t3_5} + timing.wire_time(response);
    }
    constexpr duration shortest(const poll& p) const {
        return shortest(p.gaps, read_request, p.response_size());
    }
    // The share of the wire's time, in billionths.
    constexpr std::uint64_t load_of(const poll& p) const { return share(shortest(p), p.period); }
    constexpr std::uint64_t load_of(const requested_node& r) const {
        return share(longer_of(shortest(r.gaps, read_request, r.longest_response()),
                               shortest(r.gaps, r.longest_request(), 8)),
                     r.period);
    }
    constexpr std::uint64_t load_of(const controlled_node& d) const {
        std::uint64_t billionths = 0;
        if (d.by.feedback != duration{}) {
            billionths += share(shortest(d.gaps, read_request, 5u + 2u * d.image_words), poll_period(d));
            if (d.refreshes_between != 0)
                billionths += share(shortest(d.gaps, read_request, 5u + 2u * d.slower_words), d.by.feedback) /
                              d.refreshes_between;
            billionths += share(shortest(d.gaps, read_request, 9), witness_period);
        }
        if (d.command_period != duration{})
            billionths += share(shortest(d.gaps, longest_stop_frame, 8), d.command_period);
        return billionths;
    }

    // --- If a response comes too late, at the end of the quarantine, which then starts again

    constexpr bound longest(const poll& p) const {
        return unanswered(p.gaps, p.limits.response) + timing.wire_time(p.response_size()) + quarantine;
    }
    constexpr bound longest(const requested_node& r) const {
        return bound{own_gap(r.gaps)} + timing.wire_time(r.longest_request()) + r.limits.response +
               quarantine + timing.wire_time(r.longest_response()) + quarantine;
    }
    // A facade's frame with the gaps.
    constexpr bound longest_command() const {
        if (drives == 0) return duration{};
        return bound{longest_own_gap} + timing.wire_time(longest_write) + longest_response + quarantine +
               timing.wire_time(longest_read_response) + quarantine;
    }
    constexpr bound unanswered(const bus_gaps& gaps, duration response) const {
        return bound{own_gap(gaps)} + timing.wire_time(read_request) + response + quarantine;
    }

    // --- What keeps a stop waiting

    // The time from a request's first bit to the end of its response, which comes as late as a stop waits for it.
    constexpr bound in_flight(duration response, std::size_t request, std::size_t response_size) const {
        return bound{timing.wire_time(request)} + response + stop_gap + timing.longest_frame(response_size);
    }
    constexpr bound in_flight(const poll& p) const {
        return in_flight(p.limits.response, read_request, p.response_size());
    }
    constexpr bound in_flight(const requested_node& r) const {
        return longer_of(in_flight(r.limits.response, read_request, r.longest_response()),
                         in_flight(r.limits.response, r.longest_request(), 8));
    }
    // The longest of a facade's frames.
    constexpr bound in_flight_of_drives() const {
        if (drives == 0) return duration{};
        return longer_of(in_flight(longest_response, read_request, longest_read_response),
                         in_flight(longest_response, longest_write, 8));
    }
    // A frame of a stop with the gap after it.
    constexpr bound one_stop_frame() const {
        if (drives == 0) return duration{};
        return in_flight(longest_response, longest_stop_frame, 8) + stop_gap;
    }
    constexpr bound longest_stop() const {
        if (drives == 0) return duration{};
        return one_stop_frame() * steps::urgent_frames + quarantine + timing.wire_time(8) + quarantine;
    }

    // --- What a frame waits for

    // The time from when a read is due to its end. With each read the drives send a frame each, and the program one to
    // each of its nodes; then there is a stop of each drive.
    constexpr bound wait(const poll& own, const other_entries& others) const {
        const bound between = longest_command() * others.drives + requests_between;
        return bound::at_most(others.reads_us + longest(own).time.us +
                              std::uint64_t{between.time.us} * (others.reads + 1u) +
                              (longest_stop() * others.drives).time.us);
    }
    // The time from when a drive's frame is due to its end, after one of each other drive and a read.
    constexpr bound wait_of_a_drive() const {
        return longest_read + requests_between + longest_command() * drives +
               longest_stop() * (drives == 0 ? 0 : drives - 1);
    }

  private:
    static constexpr std::uint64_t share(duration of, duration period) {
        return std::uint64_t{of.us} * 1'000'000'000u / period.us;
    }
    constexpr void note(const bus_gaps& gaps) {
        quarantine = longer_of(quarantine, gaps.quarantine);
        longest_own_gap = longer_of(longest_own_gap, gaps.gap);
    }
    constexpr duration own_gap(const bus_gaps& gaps) const {
        return longer_of(duration{timing.t3_5}, gaps.gap);
    }
};

/// The entries for which the reads of a node wait: all, less those of the node. A plan with hundreds of reads would
/// otherwise add them up again for each.
class all_others {
  public:
    template <class Plan> constexpr all_others(const Plan& of, const plan_times& times) {
        for (std::size_t i = 0; i < Plan::size; ++i) {
            const poll& p = of.polls[i];
            all_.add(times.longest(p));
            at_[p.node_address].add(times.longest(p));
        }
        for (std::size_t i = 0; i < Plan::drives; ++i) {
            ++all_.drives;
            ++at_[of.controlled[i].address].drives;
        }
    }
    constexpr other_entries than(std::uint8_t address) const {
        const other_entries& own = at_[address];
        return {all_.reads_us - own.reads_us, all_.reads - own.reads, all_.drives - own.drives};
    }

  private:
    other_entries all_{};
    other_entries at_[256]{};
};

} // namespace servobus::detail
