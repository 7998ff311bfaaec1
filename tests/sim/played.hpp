// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Counts what the runs of lives have exercised: waits by their ends, restarts by the command that they hit, gateway
// exceptions, frames of neighbours, feedback readings. Each has a floor for 1000 lives, and in proportion for others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "drive_kind.hpp"

namespace trial {

/// What the program does with its drive.
enum class doing : std::uint8_t {
    nothing, ///< it polls the drive at standstill
    init,
    enable,
    stop,
    move,
    arrival,    ///< waits by `wait_reached`
    standstill, ///< waits by `wait_standstill`
    homing,
    save,
    setting,
    reading,
    turning, ///< it polls the drive, which turns without an end
    count_,
};
constexpr const char* text(doing d) {
    constexpr const char* names[] = {"idle",       "init",   "enable", "stop",    "move",    "wait_reached",
                                     "standstill", "homing", "save",   "setting", "reading", "turning"};
    return names[static_cast<unsigned>(d)];
}

/// How a wait or a homing ended.
enum class wait_end : std::uint8_t { success, stopped_short, not_reached, needs_init, other, count_ };
constexpr const char* text(wait_end e) {
    constexpr const char* names[] = {"success", "stopped short", "not reached", "needs init", "other"};
    return names[static_cast<unsigned>(e)];
}

/// Why a gateway sent an exception in the place of the drive.
enum class gateway_case : std::uint8_t { lost_request, lost_response, absent_drive, count_ };
constexpr const char* text(gateway_case c) {
    constexpr const char* names[] = {"lost request", "lost response", "absent drive"};
    return names[static_cast<unsigned>(c)];
}

/// A frame of another node.
enum class neighbour : std::uint8_t {
    read_coils,
    read_inputs,
    read_holding,
    write_coil,
    write_word,
    write_coils,
    write_words,
    server_id,
    mask_write,
    read_write,
    user_defined,
    broadcast,
    carrier, ///< its payload contains a valid frame of this program's node
    count_,
};
constexpr const char* text(neighbour n) {
    constexpr const char* names[] = {"01h", "02h", "03h", "05h", "06h",       "0Fh",    "10h",
                                     "11h", "16h", "17h", "65h", "broadcast", "carrier"};
    return names[static_cast<unsigned>(n)];
}

struct played {
    template <class Enum> static constexpr std::size_t size = static_cast<std::size_t>(Enum::count_);
    template <class Enum> using counts = std::array<std::uint64_t, size<Enum>>;
    template <class Enum> using by_drive = std::array<counts<Enum>, size<drive_kind>>;

    std::uint64_t lives = 0;                             ///< runs
    std::array<by_drive<wait_end>, size<doing>> waits{}; ///< by command, drive and end
    by_drive<doing> restarts{};                          ///< by what they hit
    counts<drive_kind> due{};      ///< restarts while the witness of the drive is due to be read
    counts<drive_kind> booting{};  ///< restarts after which the drive is away for a time
    counts<drive_kind> found{};    ///< restarts of an enabled drive that the program has found
    counts<drive_kind> withheld{}; ///< restarts after which no feedback was given until they were found
    counts<drive_kind> hidden{}; ///< restarts that the drive cannot show, by the interpretation of its manual
    counts<drive_kind> feedback{}; ///< refreshes that were compared with the shaft
    std::array<std::array<std::uint64_t, 4>, size<gateway_case>> gateway{}; ///< by the outcome of the write
    counts<gateway_case> over_rtu{}; ///< gateway exceptions over RTU, the others over a port of Modbus TCP
    counts<gateway_case> over_tcp{};
    counts<drive_kind> outages{};   ///< times for which a drive was away that are longer than its watchdog's
    counts<neighbour> awaited{};    ///< frames while a response is awaited
    counts<neighbour> between{};    ///< frames between two exchanges
    counts<neighbour> at_servers{}; ///< frames before a request to a server
    counts<drive_kind> setpoints{}; ///< in time, on a line that loses responses, with a command timeout
    counts<drive_kind> hung{};      ///< programs that stopped commanding
    counts<drive_kind> ill{};       ///< faults and inputs that were active before an init

    void note_wait(doing what, drive_kind k, wait_end e) { ++waits[at(what)][at(k)][at(e)]; }
    template <class Enum> static std::size_t at(Enum e) { return static_cast<std::size_t>(e); }

    void print() const {
        for (const doing what : {doing::arrival, doing::standstill, doing::homing}) {
            for (std::size_t k = 1; k < size<drive_kind>; ++k)
                print_row<wait_end>(text(what), k, waits[at(what)][k]);
        }
        for (std::size_t k = 1; k < size<drive_kind>; ++k)
            print_row<doing>("restarts during", k, restarts[k]);
        for (std::size_t k = 1; k < size<drive_kind>; ++k) {
            std::printf(
                "sim: %-9s restarts: %llu while a check was due, %llu with a boot time, %llu found, %llu "
                "withheld until then, %llu hidden; %llu refreshes judged; %llu outages; %llu "
                "setpoints in time, %llu hung programs; %llu faults before an init\n",
                text(static_cast<drive_kind>(k)), n(due[k]), n(booting[k]), n(found[k]), n(withheld[k]),
                n(hidden[k]), n(feedback[k]), n(outages[k]), n(setpoints[k]), n(hung[k]), n(ill[k]));
        }
        for (std::size_t c = 0; c < size<gateway_case>; ++c) {
            std::printf(
                "sim: gateway exceptions, %s: %llu over RTU, %llu over Modbus TCP; writes that ended done "
                "%llu, refused %llu, not sent %llu, unknown %llu\n",
                text(static_cast<gateway_case>(c)), n(over_rtu[c]), n(over_tcp[c]), n(gateway[c][0]),
                n(gateway[c][1]), n(gateway[c][2]), n(gateway[c][3]));
        }
        print_neighbours("while a response is awaited", awaited);
        print_neighbours("between two exchanges", between);
        print_neighbours("before a request to a server", at_servers);
    }

    /// Each kind was played as often as its floor demands for so many lives, and so many runs of any kind
    /// (`are_mixed`). Prints those that were not. Fewer than 1000 runs have no floor.
    bool has_met_floors(std::uint64_t runs, bool are_mixed) const {
        if (runs < 1000) return true;
        const bool have_all_lived = have_lived();
        return (!are_mixed || have_spoken(runs)) && have_all_lived;
    }

  private:
    bool have_lived() const {
        floor_of of{lives};
        for (std::size_t k = 1; k < size<drive_kind>; ++k) {
            const auto drive = static_cast<drive_kind>(k);
            const bool can_home = drive != drive_kind::zlac8015d;
            of.check(text(drive), "arrivals", waits[at(doing::arrival)][k][0], 30);
            of.check(text(drive), "waits for standstill", waits[at(doing::standstill)][k][0], 25);
            if (can_home) of.check(text(drive), "homings", waits[at(doing::homing)][k][0], 6);
            for (std::size_t d = 0; d < size<doing>; ++d) {
                if (static_cast<doing>(d) == doing::homing && !can_home) continue;
                of.check(text(drive), text(static_cast<doing>(d)), restarts[k][d], 1);
            }
            of.check(text(drive), "restarts while a check was due", due[k], 5);
            of.check(text(drive), "restarts with a boot time", booting[k], 40);
            of.check(text(drive), "restarts found", found[k], 40);
            of.check(text(drive), "refreshes", feedback[k], 10'000);
            of.check(text(drive), "outages", outages[k], 2);
            of.check(text(drive), "hung programs", hung[k], 5);
            of.check(text(drive), "faults before an init", ill[k], 10);
            if (drive != drive_kind::yako) of.check(text(drive), "setpoints in time", setpoints[k], 500);
        }
        for (std::size_t c = 0; c < size<gateway_case>; ++c) {
            const char* const name = text(static_cast<gateway_case>(c));
            of.check("gateway over RTU", name, over_rtu[c], 20);
            of.check("gateway over Modbus TCP", name, over_tcp[c], 20);
        }
        for (std::size_t i = 0; i < size<neighbour>; ++i) {
            const char* const name = text(static_cast<neighbour>(i));
            of.check("neighbours between two exchanges", name, between[i], 20);
            of.check("neighbours before a request to a server", name, at_servers[i], 20);
        }
        return of.is_met;
    }
    bool have_spoken(std::uint64_t runs) const {
        floor_of of{runs};
        for (std::size_t i = 0; i < size<neighbour>; ++i) {
            const char* const name = text(static_cast<neighbour>(i));
            const bool is_broadcast =
                static_cast<neighbour>(i) == neighbour::broadcast; // a client's, and there is one
            of.check("neighbours while a response is awaited", name, awaited[i], is_broadcast ? 0 : 20);
        }
        return of.is_met;
    }

    struct floor_of {
        std::uint64_t runs;
        bool is_met = true;
        void check(const char* of, const char* what, std::uint64_t count, std::uint64_t in_1000) {
            const std::uint64_t least = in_1000 * runs / 1000;
            if (count >= least) return;
            is_met = false;
            std::printf("sim: %s: %s: only %llu, at least %llu are required\n", of, what, n(count), n(least));
        }
    };

    static unsigned long long n(std::uint64_t v) { return v; }
    template <class Enum> static void print_row(const char* what, std::size_t drive, const counts<Enum>& of) {
        std::printf("sim: %-9s %s:", text(static_cast<drive_kind>(drive)), what);
        print_counts<Enum>(of);
    }
    static void print_neighbours(const char* when, const counts<neighbour>& of) {
        std::printf("sim: neighbours %s:", when);
        print_counts<neighbour>(of);
    }
    template <class Enum> static void print_counts(const counts<Enum>& of) {
        for (std::size_t i = 0; i < of.size(); ++i)
            std::printf("%s %s %llu", i == 0 ? "" : ",", text(static_cast<Enum>(i)), n(of[i]));
        std::puts("");
    }
};

} // namespace trial
