// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How much of a line's time a bus uses: the reads that it makes in a simulated minute, as a share of those
// that wire time, t3.5 and the drives' own delays allow. The time is virtual, so the result is the same in
// every run and on every machine. The first program wakes exactly when its wait ends; the others wake
// later, as under an operating system. The status is 1 if the first uses less than 98 %.
//   bus [--record]    --record prints the table as tab-separated values, for bench/figures/bus.tsv
#include <cstdint>
#include <cstdio>
#include <cstring>

#include <servobus/sim/line.hpp>

#include "bus_plan.hpp"

using namespace servobus;

namespace {

/// A port whose `wait` ends `latency` late, whether a byte or the time limit ends it.
class late_port {
  public:
    late_port(sim::virtual_line& wire, duration latency) : wire_{&wire}, latency_{latency} {}

    transfer send(bytes out) { return wire_->send(out); }
    bool sent() { return wire_->sent(); }
    transfer receive(byte_buffer in) { return wire_->receive(in); }
    instant now() { return wire_->now(); }
    void wait(duration longest) {
        const std::uint64_t before = wire_->time_us();
        wire_->wait(longest);
        if (wire_->time_us() != before) wire_->pass(latency_); // only if it slept
    }

  private:
    sim::virtual_line* wire_;
    duration latency_;
};
static_assert(waiting_port<late_port>);

// The share in tenths of a per cent.
template <const auto& Plan> std::uint64_t used(std::uint32_t baud, duration delay, duration latency) {
    bench::store registers;
    sim::station<bench::store> first{registers, 1, baud, delay};
    sim::station<bench::store> second{registers, 2, baud, delay};
    sim::virtual_line wire{baud};
    wire.attach(first);
    wire.attach(second);
    late_port port{wire, latency};
    line on{port, Plan.timing()};
    bus<Plan, decltype(on)> all{on};
    constexpr std::uint64_t time = 60'000'000;
    all.run_for(duration{time});
    duration both{};
    for (const poll& p : Plan.polls) both = both + bench::least_time(Plan, p, delay);
    const std::uint64_t made = all.count(0) + all.count(1);
    return made * both.us * 1000u / (2u * wire.time_us());
}

constexpr duration delays[] = {microseconds(0), milliseconds(3), milliseconds(10)};
constexpr duration latencies[] = {microseconds(0), microseconds(60), microseconds(150), milliseconds(1)};

// Prints a row for each latency. Returns false if the first row is below the limit or any share is above
// 100 %.
template <const auto& Plan> bool print(std::uint32_t baud, bool is_recording) {
    bool is_enough = true;
    for (const duration latency : latencies) {
        std::printf(is_recording ? "%u\t%u us" : "%9u%12u us", baud, latency.us);
        for (const duration delay : delays) {
            const std::uint64_t share = used<Plan>(baud, delay, latency);
            std::printf(is_recording ? "\t%.1f %%" : "%14.1f %%", static_cast<double>(share) / 10);
            is_enough = is_enough && share <= 1000 && (share >= 980 || latency != duration{});
        }
        std::printf("\n");
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
    if (slow && middle && fast) return 0;
    std::fprintf(stderr, "a program that is woken in time uses less than 98 %%\n");
    return 1;
}
