// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What is read from whom and how often on a line that several drives share: a constant of the program, judged
// by the compiler. It must fit on the wire, and where a drive stops by itself when its host is silent, it
// must hear a request in time even if every other drive is gone.
//
//     inline constexpr poll_plan plan{
//         modbus::timing_at(57600), drives_with_a_facade{wheels_node, lift_node},
//         cyclic<left_actual_speed, right_actual_speed>(wheels_node, milliseconds(20))
//             .keeps_alive(milliseconds(500)),
//         cyclic<status_word>(lift_node, milliseconds(50))};
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/node.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/step.hpp>

namespace servobus {

/// A cyclic read as the bus sees it: one request to one node.
struct poll {
    std::uint8_t unit = 0;
    std::uint16_t address = 0;
    std::uint16_t words = 0;
    duration period{};
    duration keep_alive{}; ///< the drive's own watchdog; 0: none
    word_order order = word_order::high_first;
    patience limits{};
    silences quiet{};

    constexpr std::size_t reply_size() const { return 5u + 2u * words; }
};

namespace detail {
// Not constexpr on purpose: a plan that calls one does not compile, and the error names the rule.
inline void a_cyclic_read_is_one_frame_of_adjacent_registers() {}
inline void a_cyclic_read_has_a_period() {}
inline void a_cyclic_read_goes_to_an_address_that_its_device_can_have() {}
inline void the_reads_of_this_plan_do_not_fit_on_the_line() {}
inline void a_drive_of_this_plan_could_miss_its_keep_alive() {}
inline void a_drive_has_one_facade() {}

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
    static_assert((belongs_to<typename detail::row_type<Rs>::device, Device> && ...),
                  "this register belongs to another device");
    if (!readings<Rs...>::is_one_frame) detail::a_cyclic_read_is_one_frame_of_adjacent_registers();
    if (period == duration{}) detail::a_cyclic_read_has_a_period();
    if (!at.is_valid()) detail::a_cyclic_read_goes_to_an_address_that_its_device_can_have();
    const auto& plan = readings<Rs...>::plan;
    return {{.unit = at.unit,
             .address = plan.requests[0].address,
             .words = plan.words,
             .period = period,
             .order = at.order,
             .limits = at.limits,
             .quiet = at.quiet}};
}

/// The drives whose facades order their own frames between the reads, by the nodes that the facades are made
/// of: what is granted to them counts in the plan's times, polled or not.
struct drives_with_a_facade {
    std::uint8_t count = 0;
    duration response{}; ///< the longest of theirs, as the next two
    duration gap{};
    duration quarantine{};

    template <device_class... Devices>
    consteval explicit drives_with_a_facade(const node<Devices>&... nodes)
        : count{static_cast<std::uint8_t>(sizeof...(Devices))} {
        const std::array<std::uint8_t, sizeof...(Devices)> units{nodes.unit...};
        for (std::size_t i = 0; i < units.size(); ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                if (units[i] == units[k]) detail::a_drive_has_one_facade();
            }
        }
        ((response = longer_of(response, nodes.limits.response)), ...);
        ((gap = longer_of(gap, nodes.quiet.gap)), ...);
        ((quarantine = longer_of(quarantine, nodes.quiet.quarantine)), ...);
    }
};

/// When a drive counts as absent, and how often it is asked then.
struct absence {
    std::uint8_t failures = 3; ///< reads in a row without a valid reply; what keeps a drive alive
                               ///< is asked on until its keep-alive has passed, too
    duration retry_every = milliseconds(1000); ///< for all absent drives together: so little they cost
    duration stop_every = milliseconds(100);   ///< a facade's stop that was not confirmed is ordered again
};

/// The plan of a line. Of its times each is an upper bound, for a program whose loop asks the bus all the
/// time: a loop that takes longer adds its own time to each frame.
template <class... Reads> class poll_plan {
  public:
    static constexpr std::size_t size = sizeof...(Reads);
    static_assert(size != 0, "a plan reads something");
    static constexpr std::size_t words = (std::size_t{0} + ... + Reads::values::plan.words);
    static constexpr std::size_t longest_reply = [] {
        std::size_t longest = 0;
        for (const std::size_t reply : {5u + 2u * Reads::values::plan.words...}) {
            if (reply > longest) longest = reply;
        }
        return longest;
    }();
    template <std::size_t I> using values = typename detail::nth<I, Reads...>::type::values;

    /// A plan that cannot be kept does not compile.
    consteval poll_plan(modbus::rtu_timing timing, drives_with_a_facade drives, Reads... reads)
        : polls{static_cast<const poll&>(reads)...}, timing_{timing}, drives_{drives} {
        if (load_per_mille() > 1000) detail::the_reads_of_this_plan_do_not_fit_on_the_line();
        for (const poll& p : polls) {
            // A facade counts a sixteenth less, since clocks differ: a read must not come later than that.
            const std::uint32_t counted = p.keep_alive.us - p.keep_alive.us / 16;
            if (p.keep_alive != duration{} &&
                (longest_gap(p) > p.keep_alive || p.period.us + shortest(p).us > counted))
                detail::a_drive_of_this_plan_could_miss_its_keep_alive();
        }
    }

    constexpr const modbus::rtu_timing& timing() const { return timing_; }
    /// How many facades it counts.
    constexpr std::uint8_t facades() const { return drives_.count; }

    /// Where a read's words lie among all that the bus keeps.
    constexpr std::size_t offset_of(std::size_t i) const {
        std::size_t offset = 0;
        for (std::size_t k = 0; k < i; ++k) offset += polls[k].words;
        return offset;
    }

    /// The wire's time that the reads take, in thousandths, all drives answering at once.
    constexpr std::uint32_t load_per_mille() const {
        std::uint64_t load = 0;
        for (const poll& p : polls) load += std::uint64_t{shortest(p).us} * 1000u / p.period.us;
        return static_cast<std::uint32_t>(load);
    }

    /// A read with its reply and the silences, the drive answering at once.
    constexpr duration shortest(const poll& p) const {
        return gap(p) + timing_.wire_time(8) + duration{timing_.t3_5} + timing_.wire_time(p.reply_size());
    }

    /// The same if nobody answers, or only at the last moment; with the quarantine behind it.
    constexpr duration longest(const poll& p) const {
        return gap(p) + timing_.wire_time(8) + p.limits.response +
               longer_of(timing_.longest_gap(1) + timing_.wire_time(p.reply_size()), quarantine());
    }

    /// The longest time between two requests to the node of `p`, if it answers and whatever the others do.
    /// Between two reads goes at most one frame of one facade; the urgent frames of a stop, which go before
    /// everything, are counted once for each facade. An application that orders one drive's stop or
    /// initialisation again within that time adds `longest_stop()` each time.
    constexpr duration longest_gap(const poll& p) const {
        duration sum = p.period + longest(p);
        for (const poll& other : polls) {
            if (&other != &p) sum = sum + longest(other) + longest_command();
        }
        return sum + longest_command() + longest_stop() * drives_.count;
    }

    /// The longest that the urgent frames of one stop keep the line from all others, with the quarantine
    /// behind them; 0 without a facade.
    constexpr duration longest_stop() const {
        if (drives_.count == 0) return {};
        const duration frame = longest_silence() + timing_.wire_time(longest_stop_frame) +
                               longest_response() + timing_.longest_gap(1) + timing_.wire_time(8);
        return frame * steps::urgent_frames + quarantine();
    }

    /// The longest time between two frames of a stop that nobody answers, while nobody orders anything: what
    /// is not urgent waits for its turn, behind a read and a frame of each facade.
    constexpr duration longest_stop_pause(const absence& rules = {}) const {
        duration read{};
        for (const poll& p : polls) read = longer_of(read, longest(p));
        return rules.stop_every + (read + longest_command()) * drives_.count;
    }

    /// The most of the line's time, in thousandths, that the reads of absent drives take from the others,
    /// however many they are. Orders to them, and stops that are repeated, come on top: a frame of each
    /// facade between two reads, and three for a new stop.
    constexpr std::uint32_t absent_load_per_mille(const absence& rules = {}) const {
        duration most{};
        for (const poll& p : polls) most = longer_of(most, longest(p));
        if (rules.retry_every <= most) return 1000;
        return static_cast<std::uint32_t>(std::uint64_t{most.us} * 1000u / rules.retry_every.us + 1u);
    }

    /// The longest time from a drive's return to the read that finds it, while `absent` reads of the plan,
    /// its own among them, get no reply: they are tried in turn.
    constexpr duration found_within(std::uint32_t absent = size, const absence& rules = {}) const {
        duration period{};
        duration turn{}; // of the others before it, once it may be tried
        for (const poll& p : polls) {
            period = longer_of(period, p.period);
            turn = longer_of(turn, longest_gap(p) - p.period);
        }
        return period + (rules.retry_every + turn) * absent;
    }

    /// From the order of a stop to the last bit of its frame on the wire, while another frame has just begun.
    /// `drives`: so many stop at once, and this is for the last of them.
    constexpr duration worst_case_stop_latency(std::uint32_t drives = 1) const {
        duration in_flight = command_in_flight();
        for (const poll& p : polls) in_flight = longer_of(in_flight, unanswered(p));
        return in_flight + (longest_silence() + timing_.wire_time(longest_stop_frame)) +
               (command_in_flight() + longest_silence()) * (drives - 1u);
    }

    std::array<poll, size> polls;

  private:
    static constexpr std::size_t longest_write = 9 + 2 * steps::max_arguments;
    static constexpr std::size_t longest_stop_frame = 13; // two words
    static constexpr std::size_t longest_look = 5 + 2 * steps::max_words;

    constexpr duration gap(const poll& p) const { return longer_of(duration{timing_.t3_5}, p.quiet.gap); }
    // Whoever is asked next waits for the longer of its own and that of the node before.
    constexpr duration quarantine() const {
        duration longest = longer_of(timing_.visible_silence(), drives_.quarantine);
        for (const poll& p : polls) longest = longer_of(longest, p.quiet.quarantine);
        return longest;
    }
    constexpr duration unanswered(const poll& p) const {
        return timing_.wire_time(8) + p.limits.response +
               longer_of(timing_.longest_gap(1) + timing_.wire_time(p.reply_size()), duration{timing_.t3_5});
    }
    constexpr duration longest_silence() const {
        duration longest = longer_of(duration{timing_.t3_5}, drives_.gap);
        for (const poll& p : polls) longest = longer_of(longest, p.quiet.gap);
        return longest;
    }
    // A facade's frame to a drive that answers at the last moment, or not at all.
    constexpr duration command_in_flight() const {
        return drives_.count == 0 ? duration{}
                                  : timing_.wire_time(longest_write) + longest_response() +
                                        timing_.longest_gap(1) + timing_.wire_time(longest_look);
    }
    constexpr duration longest_response() const {
        duration response = drives_.response;
        for (const poll& p : polls) response = longer_of(response, p.limits.response);
        return response;
    }
    constexpr duration longest_command() const {
        return drives_.count == 0 ? duration{} : longest_silence() + command_in_flight() + quarantine();
    }

    modbus::rtu_timing timing_;
    drives_with_a_facade drives_;
};

} // namespace servobus
