// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What is read from whom and how often on a line that several drives share: a constant of the program, judged
// by the compiler. It must fit on the wire, and where a drive stops by itself when its host is silent, it
// must hear a request in time even if every other drive is gone.
//
//     inline constexpr poll_plan plan{
//         modbus::timing_at(57600), controlled_drives{wheels_node, lift_node},
//         cyclic<left_actual_speed, right_actual_speed>(wheels_node, milliseconds(20))
//             .keeps_alive(milliseconds(2000)),
//         cyclic<status_word>(lift_node, milliseconds(50))};
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/step.hpp>
#include <servobus/registers/block.hpp>

namespace servobus {

/// A clock wraps after 71 minutes, and what lies more than half of that apart has no order.
inline constexpr duration longest_period = milliseconds(1'800'000);

/// A cyclic read as the bus sees it: one request to one node.
struct poll {
    std::uint8_t node_address = 0;
    std::uint16_t address = 0;
    std::uint16_t words = 0;
    duration period{};
    duration keep_alive{}; ///< the drive's own watchdog; 0: none
    servobus::word_order word_order = word_order::high_first;
    response_limits limits{};
    bus_gaps gaps{};

    constexpr std::size_t response_size() const { return 5u + 2u * words; }
};

namespace detail {
// Not constexpr on purpose: a plan that calls one does not compile, and the error names the rule.
inline void a_cyclic_read_is_one_frame_of_adjacent_registers() {}
inline void a_cyclic_read_has_a_period_of_half_an_hour_at_most() {}
inline void a_cyclic_read_goes_to_an_address_that_its_device_can_have() {}
inline void the_reads_of_this_plan_do_not_fit_on_the_line() {}
inline void a_drive_of_this_plan_could_miss_its_keep_alive() {}
inline void a_drive_has_one_facade() {}
inline void the_times_of_this_plan_are_longer_than_its_clock_can_tell() {}

/// A duration whose sums and products end at the longest that there is, instead of beginning again.
struct bound {
    duration time{};

    constexpr bound(duration d) : time{d} {} // NOLINT: a term of a sum
    constexpr operator duration() const { return time; }
    friend constexpr bound operator+(bound a, duration b) { return at_most(std::uint64_t{a.time.us} + b.us); }
    friend constexpr bound operator+(bound a, bound b) { return a + b.time; }
    friend constexpr bound operator*(bound a, std::uint32_t n) {
        return at_most(std::uint64_t{a.time.us} * n);
    }

  private:
    static constexpr bound at_most(std::uint64_t us) {
        return duration{us < 0xFFFF'FFFFu ? static_cast<std::uint32_t>(us) : 0xFFFF'FFFFu};
    }
};

/// What a plan is made of that does not name the drives with a facade.
struct no_drives_named {};

template <std::size_t I, class First, class... More> struct nth : nth<I - 1, More...> {};
template <class First, class... More> struct nth<0, First, More...> { using type = First; };
} // namespace detail

/// A cyclic read of `Rs`, which come in one frame, and so belong to one moment.
template <const auto&... Rs> struct cyclic_read : poll {
    using values = readings<Rs...>;

    /// The drive stops when it hears nothing for `time`: the plan must reach it within that.
    constexpr cyclic_read keeps_alive(duration time) const {
        cyclic_read r = *this;
        r.keep_alive = time;
        return r;
    }
};

/// Reads `Rs` of a node every `period`, as well as the line allows.
template <const auto&... Rs, device_class Device>
consteval cyclic_read<Rs...> cyclic(const node<Device>& at, duration period) {
    static_assert((belongs_to<typename row_type<Rs>::device, Device> && ...),
                  "this register belongs to another device");
    if (!readings<Rs...>::is_one_frame) detail::a_cyclic_read_is_one_frame_of_adjacent_registers();
    if (period == duration{} || period > longest_period)
        detail::a_cyclic_read_has_a_period_of_half_an_hour_at_most();
    if (!at.is_valid()) detail::a_cyclic_read_goes_to_an_address_that_its_device_can_have();
    const auto& plan = readings<Rs...>::plan;
    return {{.node_address = at.address,
             .address = plan.requests[0].address,
             .words = plan.words,
             .period = period,
             .word_order = at.word_order,
             .limits = at.limits,
             .gaps = at.gaps}};
}

/// The drives whose facades command their own frames between the reads, by the nodes that the facades are
/// made of: what is granted to them counts in the plan's times, polled or not.
template <std::size_t Count> struct controlled_drives {
    std::uint8_t units[Count == 0 ? 1 : Count]{};
    duration response{}; ///< the longest of theirs, as the next two
    duration gap{};
    duration quarantine{};

    template <device_class... Devices>
    consteval explicit controlled_drives(const node<Devices>&... nodes) : units{nodes.address...} {
        for (std::size_t i = 0; i < Count; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                if (units[i] == units[k]) detail::a_drive_has_one_facade();
            }
        }
        ((response = longer_of(response, nodes.limits.response)), ...);
        ((gap = longer_of(gap, nodes.gaps.gap)), ...);
        ((quarantine = longer_of(quarantine, nodes.gaps.quarantine)), ...);
    }
};
template <device_class... Devices>
controlled_drives(const node<Devices>&...) -> controlled_drives<sizeof...(Devices)>;

/// When a drive counts as absent, and how often it is asked then.
struct back_off {
    std::uint8_t failures = 3; ///< reads in a row without a valid response; what keeps a drive alive
                               ///< is asked on until its keep-alive has passed, too
    duration retry_every = milliseconds(1000); ///< for all absent drives together: so little they cost
    duration stop_every = milliseconds(100);   ///< a facade's stop that was not confirmed is ordered again
};

/// The plan of a line. Of its times each is an upper bound, for a program whose loop asks the bus all the
/// time, on a line where each request gets one response at most, right or wrong, in one piece or two, before
/// its time is over or within the quarantine behind that. A loop that takes longer adds its own time to each
/// frame. A bound that no `duration` can hold is the longest one.
template <std::size_t Facades, class... Reads> class poll_plan {
    using bound = detail::bound;

  public:
    static constexpr std::size_t size = sizeof...(Reads);
    static constexpr std::size_t facades = Facades;
    static_assert(size != 0, "a plan reads something");
    static constexpr std::size_t words = (std::size_t{0} + ... + Reads::values::plan.words);
    static constexpr std::size_t response_room = [] {
        std::size_t longest = 0;
        for (const std::size_t response : {5u + 2u * Reads::values::plan.words...}) {
            if (response > longest) longest = response;
        }
        return longest;
    }();
    template <std::size_t I> using values = typename detail::nth<I, Reads...>::type::values;

    /// A plan that cannot be kept does not compile.
    consteval poll_plan(modbus::rtu_timing timing, controlled_drives<Facades> drives, Reads... reads)
        : polls{static_cast<const poll&>(reads)...}, timing_{timing}, drives_{drives} {
        if (load_per_mille() > 1000) detail::the_reads_of_this_plan_do_not_fit_on_the_line();
        for (const poll& p : polls) {
            if (longest_gap(p) > longest_period)
                detail::the_times_of_this_plan_are_longer_than_its_clock_can_tell();
            // A facade counts a sixteenth less, since clocks differ: a read must not come later than that.
            const duration counted = p.keep_alive - duration{p.keep_alive.us / 16};
            if (p.keep_alive != duration{} &&
                (longest_gap(p) > p.keep_alive || p.period + shortest(p) > counted))
                detail::a_drive_of_this_plan_could_miss_its_keep_alive();
        }
    }

    constexpr const modbus::rtu_timing& timing() const { return timing_; }

    /// Where a read's words lie among all that the bus keeps.
    constexpr std::size_t offset_of(std::size_t i) const {
        std::size_t offset = 0;
        for (std::size_t k = 0; k < i; ++k) offset += polls[k].words;
        return offset;
    }

    /// The wire's time that the reads take, in thousandths, all drives answering at once.
    constexpr std::uint32_t load_per_mille() const {
        std::uint64_t billionths = 0;
        for (const poll& p : polls)
            billionths += std::uint64_t{shortest(p).us} * 1'000'000'000u / p.period.us;
        return static_cast<std::uint32_t>((billionths + 999'999u) / 1'000'000u);
    }

    /// What it grants any drive to answer: the longest of them.
    constexpr duration longest_response() const {
        duration response = drives_.response;
        for (const poll& p : polls) response = longer_of(response, p.limits.response);
        return response;
    }

    /// A read with its response and the silences, the drive answering at once.
    constexpr duration shortest(const poll& p) const {
        return gap(p) + timing_.wire_time(8) + duration{timing_.t3_5} + timing_.wire_time(p.response_size());
    }

    /// The same if the response comes too late: as the quarantine ends, which is then kept once more.
    constexpr duration longest(const poll& p) const {
        return unanswered(p) + timing_.wire_time(p.response_size()) + quarantine();
    }

    /// The longest time between two requests to the node of `p`, if it answers and whatever the others do.
    /// Between two reads goes at most one frame of one facade; the urgent frames of a stop, which go before
    /// everything, are counted once for each facade. An application that commands one drive's stop or
    /// initialisation again within that time adds `longest_stop()` each time.
    constexpr duration longest_gap(const poll& p) const {
        return bound{p.period} +
               longest_wait(p, [&](std::uint8_t node_address) { return node_address != p.node_address; });
    }

    /// The longest that the urgent frames of one stop keep the line from all others, with the quarantine
    /// behind them; 0 without a facade.
    constexpr duration longest_stop() const {
        if constexpr (Facades == 0) {
            return {};
        } else {
            const bound frame = bound{longest_gap()} + timing_.wire_time(longest_stop_frame) +
                                longest_response() + inside() + timing_.wire_time(8);
            return frame * steps::urgent_frames + quarantine() + timing_.wire_time(8) + quarantine();
        }
    }

    /// The longest time between two frames of a stop that nobody answers, while nobody commands anything:
    /// what is not urgent waits for its turn, behind a read and a frame of each facade.
    constexpr duration longest_stop_pause(const back_off& rules = {}) const {
        duration read{};
        for (const poll& p : polls) read = longer_of(read, longest(p));
        return bound{rules.stop_every} + (bound{read} + longest_command()) * Facades;
    }

    /// The most of the line's time, in thousandths, that the reads of absent drives take from the others,
    /// however many they are. Commands to them, and stops that are repeated, come on top: a frame of each
    /// facade between two reads, and three for a new stop.
    constexpr std::uint32_t absent_load_per_mille(const back_off& rules = {}) const {
        duration most{};
        for (const poll& p : polls) most = longer_of(most, unanswered(p));
        if (rules.retry_every <= most) return 1000;
        return static_cast<std::uint32_t>(std::uint64_t{most.us} * 1000u / rules.retry_every.us + 1u);
    }

    /// The longest time from a drive's return to the read that finds it, while `absent` reads of the plan,
    /// its own among them, get no response: they are tried in turn.
    constexpr duration rediscovery_bound(std::uint32_t absent = size, const back_off& rules = {}) const {
        duration period{};
        duration turn{}; // of the others before it, once it may be tried
        for (const poll& p : polls) {
            period = longer_of(period, p.period);
            turn = longer_of(turn, longest_wait(p, [](std::uint8_t) { return true; }));
        }
        return bound{period} + (bound{rules.retry_every} + turn) * absent;
    }

    /// From the command of a stop to the last bit of its frame on the wire, while another frame has just
    /// begun. `drives`: so many stop at once, and this is for the last of them.
    constexpr duration worst_case_stop_latency(std::uint32_t drives = 1) const {
        bound in_flight = command_in_flight();
        for (const poll& p : polls) in_flight = longer_of(in_flight, in_flight_of(p));
        return in_flight + longest_gap() + timing_.wire_time(longest_stop_frame) +
               (command_in_flight() + longest_gap()) * (drives - 1u);
    }

    poll polls[size];

  private:
    static constexpr std::size_t longest_write = 9 + 2 * steps::max_arguments;
    static constexpr std::size_t longest_stop_frame = 13; // two words
    static constexpr std::size_t longest_look = 5 + 2 * steps::max_words;

    constexpr duration gap(const poll& p) const { return longer_of(duration{timing_.t3_5}, p.gaps.gap); }
    // The longest pause inside a response, or before a late one that keeps a stop waiting.
    constexpr duration inside() const { return longer_of(timing_.longest_gap(1), duration{timing_.t3_5}); }
    // Whoever is asked next waits for the longer of its own and that of the node before.
    constexpr duration quarantine() const {
        duration longest = longer_of(timing_.visible_gap(), drives_.quarantine);
        for (const poll& p : polls) longest = longer_of(longest, p.gaps.quarantine);
        return longest;
    }
    // From a read's time to its end, behind the frames to all nodes that count.
    template <class Counts> constexpr bound longest_wait(const poll& p, Counts counts) const {
        std::uint32_t stops = 0;
        for (std::size_t i = 0; i < Facades; ++i) stops += counts(drives_.units[i]) ? 1u : 0u;
        const bound command = stops == 0 ? bound{duration{}} : longest_command();
        bound sum = bound{longest(p)} + command + bound{longest_stop()} * stops;
        for (const poll& other : polls) {
            if (&other != &p && counts(other.node_address)) sum = sum + longest(other) + command;
        }
        return sum;
    }
    // A read that nobody answers.
    constexpr bound unanswered(const poll& p) const {
        return bound{gap(p)} + timing_.wire_time(8) + p.limits.response + quarantine();
    }
    // A read that has begun, and its response.
    constexpr bound in_flight_of(const poll& p) const {
        return bound{timing_.wire_time(8)} + p.limits.response + inside() +
               timing_.wire_time(p.response_size());
    }
    constexpr duration longest_gap() const {
        duration longest = longer_of(duration{timing_.t3_5}, drives_.gap);
        for (const poll& p : polls) longest = longer_of(longest, p.gaps.gap);
        return longest;
    }
    // A facade's frame to a drive that answers at the last moment, or not at all.
    constexpr bound command_in_flight() const {
        if constexpr (Facades == 0) {
            return duration{};
        } else {
            return bound{timing_.wire_time(longest_write)} + longest_response() + inside() +
                   timing_.wire_time(longest_look);
        }
    }
    // The same with the silences, if the response comes too late.
    constexpr bound longest_command() const {
        if constexpr (Facades == 0) {
            return duration{};
        } else {
            return bound{longest_gap()} + timing_.wire_time(longest_write) + longest_response() +
                   quarantine() + timing_.wire_time(longest_look) + quarantine();
        }
    }

    modbus::rtu_timing timing_;
    controlled_drives<Facades> drives_;
};

/// A plan in any other form does not compile: without its drives, or with them in another place.
template <> class poll_plan<0, detail::no_drives_named> {
  public:
    template <class... Arguments> consteval poll_plan(Arguments...) {
        static_assert(sizeof...(Arguments) == ~std::size_t{0},
                      "a plan is made of its timing, of controlled_drives{...}, which is empty if none has "
                      "one, and of its cyclic reads");
    }
};
template <class... Arguments> poll_plan(Arguments...) -> poll_plan<0, detail::no_drives_named>;

} // namespace servobus
