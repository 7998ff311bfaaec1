// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The plan of a line: the requests to several drives, and how often. It is a constant, checked by the compiler. It
// must fit on the wire, and a drive with a watchdog must get a request in time even if every other drive is absent.
//
//     inline constexpr poll_plan plan{
//         modbus::timing_at(115200),
//         controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}),
//         cyclic<zlac8015d::left_actual_speed>(pump_node, milliseconds(100))};
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/bus/detail/bound.hpp>
#include <servobus/bus/detail/entry_list.hpp>
#include <servobus/bus/detail/other_requests.hpp>
#include <servobus/bus/detail/plan_checks.hpp>
#include <servobus/bus/detail/plan_times.hpp>
#include <servobus/bus/plan_entries.hpp>

namespace servobus {

/// The plan of a line, of `controlled(..)` drives, `cyclic<..>(..)` reads, `own_requests(..)` of the program and at
/// most one `back_off`, in any order. Each time that it returns is an upper bound, or the longest `duration` if none
/// can hold it. It assumes that
/// - the program's loop steps the bus, and each request of its own, all the time: a pause of it adds to each frame;
/// - each request gets one response at most, right or wrong, before its time is over or within the quarantine after
///   that;
/// - the rest of a response that is late, or that pauses for longer than `rtu_timing::longest_frame` counts, does not
///   keep the line busy any more.
template <class... Entries> class poll_plan {
    using bound = detail::bound;
    using times = detail::plan_times;
    using entries = detail::entry_list<Entries...>;
    static_assert(entries::are_entries, "a plan is made of its timing, and of controlled(..), "
                                        "cyclic<..>(..), own_requests(..) and back_off{..}");
    static_assert(entries::rules <= 1, "a plan has one back_off at most");

  public:
    static constexpr std::size_t size = entries::reads;          ///< cyclic reads
    static constexpr std::size_t drives = entries::drives;       ///< drives with a facade
    static constexpr std::size_t requested = entries::requested; ///< nodes of the program's own requests
    static_assert(requested <= detail::other_requests::most_nodes,
                  "a plan has own_requests(..) of 8 nodes at most");
    static_assert(size + drives != 0, "a plan has a drive or reads something");
    static constexpr std::size_t words = entries::words; ///< that all cyclic reads have
    static constexpr std::size_t response_room = entries::longest_response;
    static constexpr bool has_pairs = entries::reads_with_pairs != 0; ///< a read has 32-bit values
    static constexpr bool has_other_tables = entries::reads_of_other_tables != 0; ///< than holding registers
    static constexpr const auto& offsets = entries::of_reads; ///< where the words of each read begin
    /// The model of drive number `I`, in the order of the plan.
    template <std::size_t I> using model = typename entries::template drive<I>;

    /// A plan that cannot be kept does not compile.
    consteval poll_plan(modbus::rtu_timing timing, Entries... all) : timing_{timing} {
        numbers next{};
        // No fold expression: clang++ takes at most 256 entries in one.
        [[maybe_unused]] const bool added[] = {add(all, next)...};
        const detail::plan_fault why = detail::fault_of(*this);
        detail::refuse(why);
    }

    constexpr const modbus::rtu_timing& timing() const { return timing_; }
    constexpr const back_off& rules() const { return rules_; }

    /// Where a read's words lie among all that the bus keeps.
    constexpr std::size_t offset_of(std::size_t i) const {
        std::size_t offset = 0;
        for (std::size_t k = 0; k < i; ++k) offset += polls[k].words;
        return offset;
    }
    /// The controlled drive at an address, or `drives` if there is none.
    constexpr std::size_t drive_at(std::uint8_t address) const {
        std::size_t i = 0;
        while (i < drives && controlled[i].address != address) ++i;
        return i;
    }

    /// The share of the wire's time that reads, feedback, commands and requests take, in thousandths, if all nodes
    /// respond immediately.
    constexpr std::uint32_t load_per_mille() const {
        const times common{*this};
        std::uint64_t billionths = 0;
        for (std::size_t i = 0; i < size; ++i) billionths += common.load_of(polls[i]);
        for (std::size_t i = 0; i < drives; ++i) billionths += common.load_of(controlled[i]);
        for (std::size_t i = 0; i < requested; ++i) billionths += common.load_of(requests[i]);
        return static_cast<std::uint32_t>((billionths + 999'999u) / 1'000'000u);
    }

    /// The longest response time that any drive is allowed.
    constexpr duration longest_response() const { return times{*this}.longest_response; }

    /// A read with its response and the gaps, if the node responds immediately.
    constexpr duration shortest(const poll& p) const { return times{*this}.shortest(p); }
    /// A read whose response comes too late: at the end of the quarantine, which then starts again.
    constexpr duration longest(const poll& p) const { return times{*this}.longest(p); }

    /// The longest time between two requests to the node of `p`, if it responds and whatever the others do. Each
    /// drive sends one frame between two reads; the urgent frames of a stop, which go before everything, are counted
    /// once for each drive. An application that commands one drive's stop again within that time
    /// adds `longest_stop()` each time.
    constexpr duration longest_gap(const poll& p) const {
        const times common{*this};
        detail::other_entries others{};
        for (std::size_t i = 0; i < size; ++i) {
            if (polls[i].node_address != p.node_address) others.add(common.longest(polls[i]));
        }
        for (std::size_t i = 0; i < drives; ++i)
            others.drives += controlled[i].address != p.node_address ? 1u : 0u;
        return bound{p.period} + common.wait(p, others);
    }
    /// The longest time between two requests to a controlled drive whose state is known.
    constexpr duration longest_gap(const controlled_node& d) const {
        return bound{detail::poll_period(d)} + times{*this}.wait_of_a_drive();
    }

    /// The longest that the urgent frames of one stop keep the line from all others, with the quarantine after them;
    /// 0 without a controlled drive.
    constexpr duration longest_stop() const { return times{*this}.longest_stop(); }

    /// The longest time between two frames of a stop that gets no response, while nothing is commanded: a frame that
    /// is not urgent waits until each of the others has sent one.
    constexpr duration longest_stop_pause() const {
        if (rules_.stop_every == duration{}) return duration{0xFFFF'FFFF}; // they are not repeated
        const times common{*this};
        return bound{rules_.stop_every} + common.longest_read + common.requests_between +
               common.longest_command() * drives;
    }

    /// The most of the line's time, in thousandths, that absent nodes take from the others, however many are absent:
    /// by reads, feedback and the program's requests. Commands to drives, and stops that are repeated, come on top.
    constexpr std::uint32_t absent_load_per_mille() const {
        const times common{*this};
        duration read{};
        duration feedback{};
        for (std::size_t i = 0; i < size; ++i)
            read = longer_of(read, common.unanswered(polls[i].gaps, polls[i].limits.response));
        for (std::size_t i = 0; i < drives; ++i) {
            if (detail::backs_off(controlled[i]))
                feedback =
                    longer_of(feedback, common.unanswered(controlled[i].gaps, common.longest_response));
        }
        std::uint64_t us = std::uint64_t{read.us} + feedback.us;
        for (std::size_t i = 0; i < requested; ++i) {
            if (is_apart(requests[i].address)) us += common.longest(requests[i]).time.us;
        }
        if (us == 0) return 0;
        if (rules_.retry_every.us <= us) return 1000;
        return static_cast<std::uint32_t>(us * 1000u / rules_.retry_every.us + 1u);
    }
    /// The time between two attempts to find an absent drive.
    constexpr duration retry_period() const { return bound{rules_.retry_every} * drives; }

    /// The longest time from the return of a node to the request that finds it, while `absent` reads of the plan, its
    /// own among them, get no response: they are tried in turn.
    constexpr duration rediscovery_bound(std::uint32_t absent = size) const {
        const times common{*this};
        duration period{};
        detail::other_entries others{0, 0, drives};
        for (std::size_t i = 0; i < size; ++i) {
            period = longer_of(period, polls[i].period);
            if (i != 0) others.add(common.longest(polls[i]));
        }
        const duration turn = common.wait(polls[0], others); // for the others before it, once it may be tried
        const bound read = bound{period} + (bound{rules_.retry_every} + turn) * absent;
        duration feedback{};
        for (std::size_t i = 0; i < drives; ++i) {
            if (detail::backs_off(controlled[i]))
                feedback = longer_of(feedback, bound{retry_period()} + common.wait_of_a_drive());
        }
        return longer_of(size == 0 ? bound{duration{}} : read, feedback);
    }

    /// From the command of a stop to the last bit of its frame on the wire, while another frame has just begun. It is
    /// the sum of
    /// - the frame in progress and its response, which begins at the end of its time limit or, too late, at the end of
    ///   the gap after that, and then pauses as long as it may;
    /// - the gap before the stop, and its frame.
    ///
    /// `stops`: so many drives stop together, and this is for the last of them.
    constexpr duration worst_case_stop_latency(std::uint32_t stops = 1) const {
        const times common{*this};
        return bound{longest_in_flight()} + common.stop_gap + timing_.wire_time(times::longest_stop_frame) +
               common.one_stop_frame() * (stops - 1u);
    }

    /// The longest that one frame keeps a stop waiting, with its response.
    constexpr duration longest_in_flight() const {
        const times common{*this};
        bound longest = common.in_flight_of_drives();
        for (std::size_t i = 0; i < size; ++i) longest = longer_of(longest, common.in_flight(polls[i]));
        for (std::size_t i = 0; i < requested; ++i)
            longest = longer_of(longest, common.in_flight(requests[i]));
        return longest;
    }

    /// The longest exchange of the program's own requests to a node, without the gaps.
    constexpr duration longest_exchange(const requested_node& r) const {
        const bound read =
            bound{timing_.wire_time(times::read_request)} + timing_.longest_frame(r.longest_response());
        const bound write = bound{timing_.wire_time(r.longest_request())} + timing_.longest_frame(8);
        return longer_of(read, write) + longer_of(r.limits.response, r.limits.turnaround);
    }
    /// True for a node to which the bus itself sends nothing.
    constexpr bool is_apart(std::uint8_t address) const {
        bool is = drive_at(address) == drives;
        for (std::size_t i = 0; i < size; ++i) is = is && polls[i].node_address != address;
        return is;
    }

    poll polls[size == 0 ? 1 : size]{};
    controlled_node controlled[drives == 0 ? 1 : drives]{};
    requested_node requests[requested == 0 ? 1 : requested]{};

  private:
    // The next entry of each kind, while they are added.
    struct numbers {
        std::size_t read = 0;
        std::size_t drive = 0;
        std::size_t request = 0;
    };
    constexpr bool add(const poll& p, numbers& next) {
        polls[next.read++] = p;
        return true;
    }
    constexpr bool add(const controlled_node& d, numbers& next) {
        controlled[next.drive++] = d;
        return true;
    }
    constexpr bool add(const requested_node& r, numbers& next) {
        requests[next.request++] = r;
        return true;
    }
    constexpr bool add(const back_off& rules, numbers&) {
        rules_ = rules;
        return true;
    }

    modbus::rtu_timing timing_;
    back_off rules_{};
};
template <class... Entries> poll_plan(modbus::rtu_timing, Entries...) -> poll_plan<Entries...>;

} // namespace servobus
