// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the simulation does to a line, each by its name, and how often it did.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>

namespace trial {

/// A fault, or something unusual that a client must bear as if nothing had happened.
enum class strike : std::uint8_t {
    lost_request,
    corrupted_request,
    lost_reply,
    late_reply,
    doubled_reply,
    cut_reply,
    corrupted_reply,
    short_pause,
    long_pause,
    noise_before,
    noise_after,
    glitch_before,
    glitch_after,
    foreign_before,
    foreign_unit,
    misshapen_reply,
    collision,
    flood,
    rubbish,
    stuck_line,
    reboot,
    new_address,
    slow_drive,
    lost_port,
    clock_forward,
    clock_back,
    clock_stopped,
    long_rest,
    count_,
};

constexpr const char* text(strike s) {
    constexpr const char* names[] = {
        "lost request",    "corrupted request", "lost reply",      "late reply",      "doubled reply",
        "cut reply",       "corrupted reply",   "short pause",     "long pause",      "noise before",
        "noise after",     "glitch before",     "glitch after",    "foreign frame",   "foreign reply",
        "misshapen reply", "collision",         "flood",           "rubbish between", "stuck line",
        "reboot",          "new address",       "slow drive",      "lost port",       "clock forward",
        "clock back",      "clock stopped",     "rest of an hour",
    };
    return names[static_cast<unsigned>(s)];
}

struct tally {
    static constexpr std::size_t strikes = static_cast<std::size_t>(strike::count_);

    std::uint64_t runs = 0;
    std::uint64_t operations = 0;
    std::uint64_t transactions = 0;
    std::uint64_t succeeded = 0;
    std::uint64_t had_to_succeed = 0; ///< operations that met nothing which could excuse a failure
    std::uint64_t crc_chances = 0;    ///< spoiled bytes that fitted a CRC: one in 65536 must
    std::array<std::uint64_t, strikes> struck{};

    void note(strike s) { ++struck[static_cast<std::size_t>(s)]; }

    void print() const {
        std::printf("sim: %llu runs, %llu operations, %llu transactions (%llu operations succeeded, %llu met "
                    "nothing that excused a failure); struck:",
                    static_cast<unsigned long long>(runs), static_cast<unsigned long long>(operations),
                    static_cast<unsigned long long>(transactions), static_cast<unsigned long long>(succeeded),
                    static_cast<unsigned long long>(had_to_succeed));
        for (std::size_t i = 0; i < strikes; ++i)
            std::printf("%s %s %llu", i == 0 ? "" : ",", text(static_cast<strike>(i)),
                        static_cast<unsigned long long>(struck[i]));
        std::printf("; %llu spoiled frames fitted their CRC by chance; no promise was broken\n",
                    static_cast<unsigned long long>(crc_chances));
    }
};

} // namespace trial
