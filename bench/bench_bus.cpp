// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How much of a line's time a bus uses: the reads that it makes in a simulated minute, as a share of those
// that wire time, t3.5 and the drives' own delays allow. The time is virtual, so the result is the same in
// every run and on every machine. The first program wakes exactly when its wait ends; the others wake
// later, as under an operating system. The second table is of programs that wake early by as much and poll, by
// the code of `posix::serial`. The status is 1 if the first program uses less than 98 %, or one that wakes early
// less than its limit.
//   bus [--record]    --record prints the tables as tab-separated values, for bench/figures/bus.tsv
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "late_port.hpp"

#include "bus_plan.hpp"

using namespace servobus;
using bench::early_port;
using bench::late_port;
using bench::lateness;

namespace {

// Both in tenths of a per cent.
struct shares {
    std::uint64_t used;
    std::uint64_t polled; ///< of all time
};

template <class Port, const auto& Plan>
shares used(std::uint32_t baud, duration delay, const lateness& late) {
    bench::store registers;
    sim::station<bench::store> first{registers, 1, baud, delay};
    sim::station<bench::store> second{registers, 2, baud, delay};
    sim::virtual_line wire{baud};
    wire.attach(first);
    wire.attach(second);
    Port port{wire, late, Plan.timing().wire_time(1)};
    scheduled_line on{port, Plan.timing()};
    bus<Plan, decltype(on)> all{on};
    constexpr std::uint64_t time = 60'000'000;
    all.run_for(duration{time});
    duration both{};
    for (const poll& p : Plan.polls) both = both + bench::least_time(Plan, p, delay);
    const std::uint64_t made = all.count(0) + all.count(1);
    return {made * both.us * 1000u / (2u * wire.time_us()), port.polled_us() * 1000u / wire.time_us()};
}

constexpr duration delays[] = {microseconds(0), milliseconds(3), milliseconds(10)};
constexpr duration latencies[] = {microseconds(0), microseconds(60), microseconds(150), milliseconds(1)};

void print_share(std::uint64_t share, bool is_recording) {
    std::printf(is_recording ? "\t%.1f %%" : "%14.1f %%", static_cast<double>(share) / 10);
}

// Prints a row for each latency. Returns false if the first row is below the limit or any share is above
// 100 %.
template <const auto& Plan> bool print(std::uint32_t baud, bool is_recording) {
    bool is_enough = true;
    for (const duration latency : latencies) {
        std::printf(is_recording ? "%u\t%u us" : "%9u%12u us", baud, latency.us);
        for (const duration delay : delays) {
            const std::uint64_t share = used<late_port, Plan>(baud, delay, {latency, latency}).used;
            print_share(share, is_recording);
            is_enough = is_enough && share <= 1000 && (share >= 980 || latency != duration{});
        }
        std::printf("\n");
    }
    return is_enough;
}

struct early_row {
    const char* name;
    lateness late;
    std::uint64_t least; ///< used, with drives that respond after t3.5
};
constexpr early_row early_rows[] = {
    {"60 us", {microseconds(60), microseconds(60)}, 985},
    {"0 to 120 us", {microseconds(0), microseconds(120)}, 980},
    {"60 us, one in a thousand 20 ms", {microseconds(60), microseconds(60), 1000, milliseconds(20)}, 0},
    {"150 us", {microseconds(150), microseconds(150)}, 980},
    {"0 to 300 us", {microseconds(0), microseconds(300)}, 970},
    {"1 ms", {milliseconds(1), milliseconds(1)}, 930},
    {"0 to 1 ms", {microseconds(0), milliseconds(1)}, 0},
};

// Prints a row for each kind of lateness. Returns false if one is below its limit.
template <const auto& Plan> bool print_early(std::uint32_t baud, bool is_recording) {
    bool is_enough = true;
    for (const early_row& row : early_rows) {
        std::printf(is_recording ? "%u\t%s" : "%9u  %-32s", baud, row.name);
        print_share(used<late_port, Plan>(baud, delays[0], row.late).used, is_recording);
        shares early[3]{};
        for (std::size_t i = 0; i < 3; ++i) early[i] = used<early_port, Plan>(baud, delays[i], row.late);
        for (const shares& s : early) print_share(s.used, is_recording);
        for (const shares& s : early) print_share(s.polled, is_recording);
        std::printf("\n");
        is_enough = is_enough && early[0].used >= row.least;
    }
    return is_enough;
}

} // namespace

int main(int argc, char** argv) {
    const bool is_recording = argc == 2 && std::strcmp(argv[1], "--record") == 0;
    if (is_recording) {
        std::printf("# Bd, woken later by, used of what is possible with drives that respond after t3.5, 3 "
                    "ms, 10 ms\n");
    } else {
        std::printf("a line's use by a bus of two drives that respond after\n%9s%15s%16s%16s%16s\n", "Bd",
                    "woken later", "t3.5", "3 ms", "10 ms");
    }
    const bool slow = print<bench::at_9600>(9600, is_recording);
    const bool middle = print<bench::at_57600>(57'600, is_recording);
    const bool fast = print<bench::at_115200>(115'200, is_recording);
    if (is_recording) {
        std::printf(
            "# Bd, woken later by, used by a port that sleeps alone (t3.5), by one that wakes early (t3.5, 3 "
            "ms, 10 ms), time that it polls\n");
    } else {
        std::printf(
            "a port that sleeps alone, one that wakes early, and the part of the time that that polls\n%9s  "
            "%-32s%16s%16s%16s%16s%16s%16s%16s\n",
            "Bd", "woken later", "alone, t3.5", "t3.5", "3 ms", "10 ms", "polls, t3.5", "3 ms", "10 ms");
    }
    const bool early = print_early<bench::at_115200>(115'200, is_recording);
    if (!slow || !middle || !fast)
        std::fprintf(stderr, "a program that is woken in time uses less than 98 %%\n");
    if (!early) std::fprintf(stderr, "a program that wakes early uses less than its limit\n");
    return slow && middle && fast && early ? 0 : 1;
}
