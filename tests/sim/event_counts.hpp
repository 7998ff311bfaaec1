// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The faults that the simulation can cause, their names, and how often each occurred.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "played.hpp"
#include "switches.hpp"

namespace trial {

/// A fault, or an unusual event in spite of which a client must succeed.
enum class strike : std::uint8_t {
    lost_request,
    corrupted_request,
    lost_response,
    late_response,
    doubled_response,
    cut_response,
    corrupted_response,
    short_pause,
    long_pause,
    noise_before,
    noise_after,
    glitch_before,
    glitch_after,
    foreign_before,
    foreign_unit,
    misshapen_response,
    collision,
    flood,
    rubbish,
    stuck_line,
    stuck_talker,
    babbling_node,
    reboot,
    new_address,
    slow_drive,
    lost_port,
    clock_forward,
    clock_back,
    clock_stopped,
    clock_wrap,
    long_rest,
    changed_echo,
    lost_echo,
    late_echo,
    returned_request,
    absent_drive,
    stall,
    plight,
    count_,
};

constexpr const char* text(strike s) {
    constexpr const char* names[] = {
        "lost request",
        "corrupted request",
        "lost response",
        "late response",
        "doubled response",
        "cut response",
        "corrupted response",
        "short pause",
        "long pause",
        "noise before",
        "noise after",
        "glitch before",
        "glitch after",
        "foreign frame",
        "foreign response",
        "misshapen response",
        "collision",
        "flood",
        "noise between",
        "cut line",
        "stuck transmitter",
        "babbling node",
        "reboot",
        "new address",
        "slow drive",
        "lost port",
        "clock forward",
        "clock back",
        "clock stopped",
        "clock wrap",
        "rest of an hour",
        "changed echo",
        "lost echo",
        "late echo",
        "returned request",
        "absent drive",
        "stall",
        "fault or wired stop",
    };
    return names[static_cast<unsigned>(s)];
}

/// Where in a transaction the client's program is.
enum class place : std::uint8_t {
    between,   ///< two transactions, or waiting to send
    leaving,   ///< some bytes of the request are taken, and its last bit is not yet reported as sent
    awaiting,  ///< no byte of the response has been received yet
    receiving, ///< a part of the response has been received
    count_,
};
constexpr const char* text(place p) {
    constexpr const char* names[] = {"between two", "leaving", "awaiting", "receiving"};
    return names[static_cast<unsigned>(p)];
}

/// What a run tests.
enum class kind_of_run : std::uint8_t { plain, echo, small, bus, facade, scan, fleet, life, count_ };

constexpr const char* text(kind_of_run k) {
    constexpr const char* names[] = {"plain",   "echo", "blocking_line", "bus",
                                     "facades", "scan", "fleet",         "lives"};
    return names[static_cast<unsigned>(k)];
}

struct event_counts {
    static constexpr std::size_t kinds = static_cast<std::size_t>(kind_of_run::count_);
    static constexpr std::size_t strikes = static_cast<std::size_t>(strike::count_);
    static constexpr std::size_t places = static_cast<std::size_t>(place::count_);
    static constexpr std::size_t drives = static_cast<std::size_t>(drive_kind::count_);

    std::uint64_t runs = 0;
    std::uint64_t operations = 0;
    std::uint64_t transactions = 0;
    std::uint64_t succeeded = 0;
    std::uint64_t had_to_succeed = 0; ///< operations that met nothing that excuses a failure
    std::uint64_t wire_frames = 0;    ///< that were judged on the wire, in runs of fleets
    std::uint64_t arrivals = 0;       ///< waits for the end of a move that were reported done
    std::uint64_t plights = 0;        ///< faults and inputs that made a drive of a facade unable to move
    std::uint64_t enabled_over_targets = 0; ///< enables of a drive whose targets were not zero
    std::uint64_t beside_the_bus = 0;       ///< requests of the program's own that got a response
    std::uint64_t not_in_plan = 0;          ///< that the plan refused
    std::uint64_t gone_asked = 0;           ///< that were sent to a node that is gone
    std::uint64_t undetected_returns =
        0; ///< returned writes that no earlier failure shows to be possible echoes
    std::uint64_t detected_returns = 0; ///< and those that one does
    std::uint64_t crc_chances = 0;      ///< damaged frames that matched a CRC by chance, about one in 65536
    std::array<std::uint64_t, strikes> struck{};
    std::array<std::uint64_t, kinds> transactions_of{};
    std::array<std::array<std::uint64_t, places>, drives> stalls{};
    switch_count switches;
    played lives;

    void note(strike s) { ++struck[static_cast<std::size_t>(s)]; }
    void note(drive_kind k, place p) { ++stalls[static_cast<std::size_t>(k)][static_cast<std::size_t>(p)]; }

    void print() const {
        print_switches();
        lives.print();
        std::printf(
            "sim: %llu runs, %llu operations, %llu transactions:", static_cast<unsigned long long>(runs),
            static_cast<unsigned long long>(operations), static_cast<unsigned long long>(transactions));
        for (std::size_t i = 0; i < kinds; ++i)
            std::printf("%s %llu %s", i == 0 ? "" : ",", static_cast<unsigned long long>(transactions_of[i]),
                        text(static_cast<kind_of_run>(i)));
        std::printf("; %llu frames judged on the wire", static_cast<unsigned long long>(wire_frames));
        std::printf("; beside a bus %llu requests with a response, %llu refused by the plan, %llu to a node "
                    "that is gone",
                    static_cast<unsigned long long>(beside_the_bus),
                    static_cast<unsigned long long>(not_in_plan),
                    static_cast<unsigned long long>(gone_asked));
        std::printf("; %llu arrivals and %llu faults and wired stops of a facade's drive judged",
                    static_cast<unsigned long long>(arrivals), static_cast<unsigned long long>(plights));
        std::printf(", %llu enables over old targets", static_cast<unsigned long long>(enabled_over_targets));
        std::printf(" (%llu operations succeeded, %llu met nothing that excused a failure); struck:",
                    static_cast<unsigned long long>(succeeded),
                    static_cast<unsigned long long>(had_to_succeed));
        for (std::size_t i = 0; i < strikes; ++i)
            std::printf("%s %s %llu", i == 0 ? "" : ",", text(static_cast<strike>(i)),
                        static_cast<unsigned long long>(struck[i]));
        for (std::size_t k = 0; k < drives; ++k) {
            std::printf("; stalls during requests to %s:", text(static_cast<drive_kind>(k)));
            for (std::size_t p = 0; p < places; ++p)
                std::printf("%s %llu %s", p == 0 ? "" : ",", static_cast<unsigned long long>(stalls[k][p]),
                            text(static_cast<place>(p)));
        }
        std::printf("; %llu writes were returned by an adapter after a failure, %llu before one",
                    static_cast<unsigned long long>(detected_returns),
                    static_cast<unsigned long long>(undetected_returns));
        std::printf("; %llu damaged frames matched their CRC by chance; no promise was broken\n",
                    static_cast<unsigned long long>(crc_chances));
    }

    /// Each kind of strike, and writes that an adapter returned after a failure, were played as often as 1000 runs of
    /// all kinds demand, and in proportion for others. Prints those that were not. Fewer runs have no floor.
    bool has_struck_all() const {
        if (runs < 1000) return true;
        bool is_met = true;
        const auto check = [&](const char* what, std::uint64_t n, std::uint64_t in_1000) {
            if (n >= in_1000 * runs / 1000) return;
            is_met = false;
            std::printf("sim: %s: only %llu\n", what, static_cast<unsigned long long>(n));
        };
        for (std::size_t i = 0; i < strikes; ++i) {
            const auto kind = static_cast<strike>(i);
            const bool is_rare =
                kind == strike::clock_wrap || kind == strike::long_rest || kind == strike::clock_stopped;
            check(text(kind), struck[i], is_rare ? 5 : 100);
        }
        check("writes returned after a failure", detected_returns, 25);
        check("enables over old targets", enabled_over_targets, 2);
        return is_met;
    }

    /// Each position of each drive's switches was met by at least `least` transactions, and each place by
    /// at least `least` stalls during requests to each drive. Prints those that were not.
    bool has_met_all(std::uint64_t least) const {
        bool has_met = true;
        switches.each([&](drive_kind k, const char* name, const char* position, std::uint64_t n) {
            if (n >= least) return;
            std::printf("sim: %s: %s: %s: only %llu transactions\n", text(k), name, position,
                        static_cast<unsigned long long>(n));
            has_met = false;
        });
        for (std::size_t k = 1; k < drives; ++k) {
            for (std::size_t p = 0; p < places; ++p) {
                if (stalls[k][p] >= least) continue;
                std::printf("sim: %s: only %llu stalls while %s\n", text(static_cast<drive_kind>(k)),
                            static_cast<unsigned long long>(stalls[k][p]), text(static_cast<place>(p)));
                has_met = false;
            }
        }
        return has_met;
    }

  private:
    void print_switches() const {
        drive_kind last_drive = drive_kind::none;
        const char* last = "";
        switches.each([&](drive_kind k, const char* name, const char* position, std::uint64_t n) {
            const bool is_other_drive = k != last_drive;
            const bool is_other = is_other_drive || std::strcmp(name, last) != 0;
            if (is_other_drive)
                std::printf("%ssim: %s: ", last_drive == drive_kind::none ? "" : "\n", text(k));
            std::printf("%s%s%s %s %llu",
                        is_other_drive ? ""
                        : is_other     ? "; "
                                       : "",
                        is_other ? name : "", is_other ? ":" : ",", position,
                        static_cast<unsigned long long>(n));
            last_drive = k;
            last = name;
        });
        std::puts("");
    }
};

} // namespace trial
