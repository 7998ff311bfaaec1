// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What several drives on a line are sent and how often: a constant of the program, checked by the compiler. It
// must fit on the wire, and a drive with a watchdog must get a request in time even if every other drive is absent.
//
//     inline constexpr poll_plan plan{
//         modbus::timing_at(115200),
//         controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}),
//         cyclic<zlac8015d::left_actual_speed>(pump_node, milliseconds(100))};
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/bus/detail/bound.hpp>
#include <servobus/bus/detail/entry_list.hpp>
#include <servobus/bus/plan_entries.hpp>
#include <servobus/control/step.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a plan that calls one does not compile, and the error names the rule.
inline void the_entries_of_this_plan_do_not_fit_on_the_line() {}
inline void a_drive_of_this_plan_could_miss_its_keep_alive() {}
inline void a_drive_has_one_facade() {}
inline void the_requests_to_a_node_are_one_entry() {}
inline void the_times_of_this_plan_are_longer_than_its_clock_can_tell() {}
} // namespace detail

/// The plan of a line, of `controlled(..)` drives, `cyclic<..>(..)` reads, `own_requests(..)` of the program and at most
/// one `back_off`, in any order. Each time that it returns is an upper bound, or the longest `duration` if none can
/// hold it. It assumes that
/// - the program's loop steps the bus, and each request of its own, all the time: a pause of it adds to each frame;
/// - each request gets one response at most, right or wrong, before its time is over or within the quarantine after that;
/// - the rest of a response that is late, or that pauses for longer than `rtu_timing::longest_frame` counts, does not
///   keep the line busy any more.
template <class... Entries> class poll_plan {
    using bound = detail::bound;
    using entries = detail::entry_list<Entries...>;
    static_assert((detail::is_entry<Entries> && ...), "a plan is made of its timing, and of controlled(..), "
                                                      "cyclic<..>(..), own_requests(..) and back_off{..}");
    static_assert(entries::rules <= 1, "a plan has one back_off at most");

  public:
    static constexpr std::size_t size = entries::reads;          ///< cyclic reads
    static constexpr std::size_t drives = entries::drives;       ///< drives with a facade
    static constexpr std::size_t requested = entries::requested; ///< nodes of the program's own requests
    static_assert(requested <= other_requests::most_nodes, "a plan has own_requests(..) of 8 nodes at most");
    static_assert(size + drives != 0, "a plan has a drive or reads something");
    static constexpr std::size_t words = entries::words; ///< of all cyclic reads
    static constexpr std::size_t response_room = entries::longest_response;
    /// Of read number `I`, and the model of drive number `I`, in the order of the plan.
    template <std::size_t I> using values = typename entries::template read<I>::values;
    template <std::size_t I> using model = typename entries::template drive<I>;

    /// A plan that cannot be kept does not compile.
    consteval poll_plan(modbus::rtu_timing timing, Entries... all) : timing_{timing} {
        (add(all), ...);
        for (std::size_t i = 0; i < drives; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                if (controlled[i].address == controlled[k].address) detail::a_drive_has_one_facade();
            }
        }
        for (std::size_t i = 0; i < requested; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                if (requests[i].address == requests[k].address)
                    detail::the_requests_to_a_node_are_one_entry();
            }
        }
        if (load_per_mille() > 1000) detail::the_entries_of_this_plan_do_not_fit_on_the_line();
        for (std::size_t i = 0; i < size; ++i) {
            const poll& p = polls[i];
            if (longest_gap(p) > longest_period)
                detail::the_times_of_this_plan_are_longer_than_its_clock_can_tell();
            if (p.keep_alive != duration{} &&
                (longest_gap(p) > p.keep_alive || p.period + shortest(p) > at_least(p.keep_alive)))
                detail::a_drive_of_this_plan_could_miss_its_keep_alive();
        }
        for (std::size_t i = 0; i < drives; ++i) {
            const controlled_node& d = controlled[i];
            if (d.by.feedback > longest_period || longest_gap(d) > longest_period)
                detail::the_times_of_this_plan_are_longer_than_its_clock_can_tell();
            if (is_kept_alive(d) && longest_gap(d) > d.keep_alive)
                detail::a_drive_of_this_plan_could_miss_its_keep_alive();
        }
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

    /// The wire's time that reads, feedback, commands and requests take, in thousandths, if all nodes respond
    /// immediately.
    constexpr std::uint32_t load_per_mille() const {
        std::uint64_t billionths = 0;
        for (std::size_t i = 0; i < size; ++i) billionths += share(shortest(polls[i]), polls[i].period);
        for (std::size_t i = 0; i < drives; ++i) billionths += load_of(controlled[i]);
        for (std::size_t i = 0; i < requested; ++i) {
            const requested_node& r = requests[i];
            billionths += share(longer_of(shortest(r.gaps, read_request, r.longest_response()),
                                          shortest(r.gaps, r.longest_request(), 8)),
                                r.period);
        }
        return static_cast<std::uint32_t>((billionths + 999'999u) / 1'000'000u);
    }

    /// The longest response time that any drive is allowed.
    constexpr duration longest_response() const {
        duration response{};
        for (std::size_t i = 0; i < size; ++i) response = longer_of(response, polls[i].limits.response);
        for (std::size_t i = 0; i < drives; ++i)
            response = longer_of(response, controlled[i].limits.response);
        return response;
    }

    /// A read with its response and the gaps, if the node responds immediately.
    constexpr duration shortest(const poll& p) const {
        return shortest(p.gaps, read_request, p.response_size());
    }
    /// The same if the response comes too late: at the end of the quarantine, which then starts again.
    constexpr duration longest(const poll& p) const {
        return unanswered(p.gaps, p.limits.response) + timing_.wire_time(p.response_size()) + quarantine();
    }

    /// The longest time between two requests to the node of `p`, if it responds and whatever the others do. Each
    /// drive sends one frame between two reads; the urgent frames of a stop, which go before everything, are counted
    /// once for each drive. An application that commands one drive's stop again within that time
    /// adds `longest_stop()` each time.
    constexpr duration longest_gap(const poll& p) const {
        return bound{p.period} +
               longest_wait(p, [&](std::uint8_t node_address) { return node_address != p.node_address; });
    }
    /// The same of a controlled drive whose state is known.
    constexpr duration longest_gap(const controlled_node& d) const {
        return bound{poll_period(d)} + longest_wait_of_a_drive();
    }

    /// The longest that the urgent frames of one stop keep the line from all others, with the quarantine after them;
    /// 0 without a controlled drive.
    constexpr duration longest_stop() const {
        if constexpr (drives == 0) {
            return {};
        } else {
            return one_stop_frame() * steps::urgent_frames + quarantine() + timing_.wire_time(8) +
                   quarantine();
        }
    }

    /// The longest time between two frames of a stop that gets no response, while nothing is commanded: what is not
    /// urgent waits until each of the others has sent a frame.
    constexpr duration longest_stop_pause() const {
        if (rules_.stop_every == duration{}) return duration{0xFFFF'FFFF}; // they are not repeated
        return bound{rules_.stop_every} + longest_read() + requests_between() + longest_command() * drives;
    }

    /// The most of the line's time, in thousandths, that reads of absent nodes and drives take from the others,
    /// however many they are, and the program's requests to absent nodes. Commands to drives, and stops that are
    /// repeated, come on top.
    constexpr std::uint32_t absent_load_per_mille() const {
        duration read{};
        duration feedback{};
        for (std::size_t i = 0; i < size; ++i)
            read = longer_of(read, unanswered(polls[i].gaps, polls[i].limits.response));
        for (std::size_t i = 0; i < drives; ++i) {
            if (backs_off(controlled[i]))
                feedback = longer_of(feedback, unanswered(controlled[i].gaps, longest_response()));
        }
        std::uint64_t us = std::uint64_t{read.us} + feedback.us;
        for (std::size_t i = 0; i < requested; ++i) {
            if (is_apart(requests[i].address)) us += longest(requests[i]).time.us;
        }
        if (us == 0) return 0;
        if (rules_.retry_every.us <= us) return 1000;
        return static_cast<std::uint32_t>(us * 1000u / rules_.retry_every.us + 1u);
    }
    /// Of each absent drive.
    constexpr duration retry_period() const { return bound{rules_.retry_every} * drives; }

    /// The longest time from the return of a node to the request that finds it, while `absent` reads of the plan, its
    /// own among them, get no response: they are tried in turn.
    constexpr duration rediscovery_bound(std::uint32_t absent = size) const {
        duration period{};
        duration turn{}; // of the others before it, once it may be tried
        for (std::size_t i = 0; i < size; ++i) {
            period = longer_of(period, polls[i].period);
            turn = longer_of(turn, longest_wait(polls[i], [](std::uint8_t) { return true; }));
        }
        const bound read = bound{period} + (bound{rules_.retry_every} + turn) * absent;
        duration feedback{};
        for (std::size_t i = 0; i < drives; ++i) {
            if (backs_off(controlled[i]))
                feedback = longer_of(feedback, bound{retry_period()} + longest_wait_of_a_drive());
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
        return bound{longest_in_flight()} + stop_gap() + timing_.wire_time(longest_stop_frame) +
               one_stop_frame() * (stops - 1u);
    }

    /// The longest that one frame keeps a stop waiting, with its response.
    constexpr duration longest_in_flight() const {
        bound longest = in_flight_of_drives();
        for (std::size_t i = 0; i < size; ++i)
            longest = longer_of(longest,
                                in_flight(polls[i].limits.response, read_request, polls[i].response_size()));
        for (std::size_t i = 0; i < requested; ++i) longest = longer_of(longest, in_flight_of(requests[i]));
        return longest;
    }

    /// Of the program's own requests to a node, and their responses.
    constexpr duration longest_exchange(const requested_node& r) const {
        const bound read =
            bound{timing_.wire_time(read_request)} + timing_.longest_frame(r.longest_response());
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
    // Bytes of the frames of a facade.
    static constexpr std::size_t read_request = 8;
    static constexpr std::size_t longest_write = 9 + 2 * steps::max_arguments;
    static constexpr std::size_t longest_stop_frame = 13; // two words
    static constexpr std::size_t longest_read_response = 5 + 2 * steps::longest;

    consteval void add(const poll& p) { polls[reads_++] = p; }
    consteval void add(const controlled_node& d) { controlled[drives_++] = d; }
    consteval void add(const requested_node& r) { requests[requested_++] = r; }
    consteval void add(const back_off& rules) { rules_ = rules; }

    static constexpr std::uint64_t share(duration of, duration period) {
        return std::uint64_t{of.us} * 1'000'000'000u / period.us;
    }
    constexpr std::uint64_t load_of(const controlled_node& d) const {
        std::uint64_t billionths = 0;
        if (d.by.feedback != duration{}) {
            billionths += share(shortest(d.gaps, read_request, 5u + 2u * d.image_words), poll_period(d));
            if (d.readings_between != 0)
                billionths += share(shortest(d.gaps, read_request, 5u + 2u * d.slower_words), d.by.feedback) /
                              d.readings_between;
            billionths += share(shortest(d.gaps, read_request, 9), witness_period);
        }
        if (d.command_period != duration{})
            billionths += share(shortest(d.gaps, longest_stop_frame, 8), d.command_period);
        return billionths;
    }
    constexpr duration shortest(const bus_gaps& gaps, std::size_t request, std::size_t response) const {
        return own_gap(gaps) + timing_.wire_time(request) + duration{timing_.t3_5} +
               timing_.wire_time(response);
    }

    // A drive with a watchdog is polled no longer than that: then its state is unknown.
    static constexpr bool backs_off(const controlled_node& d) {
        return d.keep_alive == duration{} && d.by.feedback != duration{};
    }
    static constexpr bool is_kept_alive(const controlled_node& d) {
        return d.keep_alive != duration{} && d.by.feedback != duration{};
    }
    // While it is enabled a facade reads it four times within its watchdog.
    static constexpr duration poll_period(const controlled_node& d) {
        return is_kept_alive(d) ? shorter_of(d.by.feedback, duration{d.keep_alive.us / 4}) : d.by.feedback;
    }

    constexpr duration own_gap(const bus_gaps& gaps) const {
        return longer_of(duration{timing_.t3_5}, gaps.gap);
    }
    // The next request waits for the longer of its own quarantine and that of the node before.
    constexpr duration quarantine() const {
        duration longest = timing_.visible_gap();
        for (std::size_t i = 0; i < size; ++i) longest = longer_of(longest, polls[i].gaps.quarantine);
        for (std::size_t i = 0; i < drives; ++i) longest = longer_of(longest, controlled[i].gaps.quarantine);
        for (std::size_t i = 0; i < requested; ++i) longest = longer_of(longest, requests[i].gaps.quarantine);
        return longest;
    }
    // Before a stop: the gap of its own drive only.
    constexpr duration stop_gap() const {
        duration longest{timing_.t3_5};
        for (std::size_t i = 0; i < drives; ++i) longest = longer_of(longest, controlled[i].gaps.gap);
        return longest;
    }
    constexpr duration longest_own_gap() const {
        duration longest{timing_.t3_5};
        for (std::size_t i = 0; i < size; ++i) longest = longer_of(longest, polls[i].gaps.gap);
        for (std::size_t i = 0; i < drives; ++i) longest = longer_of(longest, controlled[i].gaps.gap);
        for (std::size_t i = 0; i < requested; ++i) longest = longer_of(longest, requests[i].gaps.gap);
        return longest;
    }
    constexpr bound longest_read() const {
        bound longest = duration{};
        for (std::size_t i = 0; i < size; ++i) longest = longer_of(longest, this->longest(polls[i]));
        return longest;
    }
    // From a read's time to its end, after the frames to all nodes that count.
    template <class Counts> constexpr bound longest_wait(const poll& p, Counts counts) const {
        std::uint32_t others = 0;
        for (std::size_t i = 0; i < drives; ++i) others += counts(controlled[i].address) ? 1u : 0u;
        const bound commands = longest_command() * others;
        const bound between = commands + requests_between();
        bound sum = bound{longest(p)} + between + bound{longest_stop()} * others;
        for (std::size_t i = 0; i < size; ++i) {
            if (&polls[i] != &p && counts(polls[i].node_address)) sum = sum + longest(polls[i]) + between;
        }
        return sum;
    }
    // From the time of a drive's frame to its end, after one of each other drive and a read.
    constexpr bound longest_wait_of_a_drive() const {
        constexpr std::uint32_t others = drives == 0 ? 0 : drives - 1;
        return longest_read() + requests_between() + longest_command() * drives +
               bound{longest_stop()} * others;
    }
    // One to each node of the program's own requests.
    constexpr bound requests_between() const {
        bound sum = duration{};
        for (std::size_t i = 0; i < requested; ++i) sum = sum + longest(requests[i]);
        return sum;
    }
    constexpr bound longest(const requested_node& r) const {
        return bound{own_gap(r.gaps)} + timing_.wire_time(r.longest_request()) + r.limits.response +
               quarantine() + timing_.wire_time(r.longest_response()) + quarantine();
    }
    constexpr bound unanswered(const bus_gaps& gaps, duration response) const {
        return bound{own_gap(gaps)} + timing_.wire_time(read_request) + response + quarantine();
    }
    // From a request's first bit to the end of its response, which comes as late as it keeps a stop waiting.
    constexpr bound in_flight(duration response, std::size_t request, std::size_t response_size) const {
        return bound{timing_.wire_time(request)} + response + stop_gap() +
               timing_.longest_frame(response_size);
    }
    // A frame of a stop with the gap after it.
    constexpr bound one_stop_frame() const {
        if constexpr (drives == 0) return duration{};
        return in_flight(longest_response(), longest_stop_frame, 8) + stop_gap();
    }
    constexpr bound in_flight_of(const requested_node& r) const {
        return longer_of(in_flight(r.limits.response, read_request, r.longest_response()),
                         in_flight(r.limits.response, r.longest_request(), 8));
    }
    // Of a facade's frames.
    constexpr bound in_flight_of_drives() const {
        if constexpr (drives == 0) {
            return duration{};
        } else {
            return longer_of(in_flight(longest_response(), read_request, longest_read_response),
                             in_flight(longest_response(), longest_write, 8));
        }
    }
    // A facade's frame with the gaps, if the response comes too late.
    constexpr bound longest_command() const {
        if constexpr (drives == 0) {
            return duration{};
        } else {
            return bound{longest_own_gap()} + timing_.wire_time(longest_write) + longest_response() +
                   quarantine() + timing_.wire_time(longest_read_response) + quarantine();
        }
    }

    modbus::rtu_timing timing_;
    back_off rules_{};
    std::size_t reads_ = 0; // while the plan is made
    std::size_t drives_ = 0;
    std::size_t requested_ = 0;
};
template <class... Entries> poll_plan(modbus::rtu_timing, Entries...) -> poll_plan<Entries...>;

} // namespace servobus
