// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many runs of a client on a hostile line, in virtual time: every promise that a client makes is checked
// after every operation. One seed is one run; a run that breaks a promise is told in words.
//     sim [--seeds N] [--from S]     N runs from seed S on
//     sim --seed S [--trace]         one run; its frames in words
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "operations.hpp"
#include "world.hpp"

namespace {

constexpr std::uint64_t standard_seeds = 1100;
constexpr int operations_in_a_run = 200;

struct ending {
    std::uint64_t hash = 0;
    bool is_broken = false;
};

ending run(std::uint64_t seed, trial::tally& count, std::size_t notes) {
    trial::world of{seed, count, notes};
    ending e;
    try {
        trial::operations client{of};
        for (int i = 0; i < operations_in_a_run; ++i) client.one();
    } catch (const trial::broken& b) {
        e.is_broken = true;
        if (notes != 0) of.print();
        std::printf("sim: seed %llu, %llu us: %s\n", static_cast<unsigned long long>(seed),
                    static_cast<unsigned long long>(of.wire().time_us()), b.promise.c_str());
    }
    if (!e.is_broken && notes != 0) of.print();
    of.log().mix(of.wire().time_us());
    e.hash = of.log().hash();
    ++count.runs;
    return e;
}

bool replays(std::uint64_t seed, std::uint64_t hash) {
    trial::tally ignored;
    if (run(seed, ignored, 0).hash == hash) return true;
    std::printf("sim: seed %llu does not replay: its second run differs\n",
                static_cast<unsigned long long>(seed));
    return false;
}

int run_many(std::uint64_t from, std::uint64_t seeds) {
    trial::tally count;
    for (std::uint64_t seed = from; seed - from < seeds; ++seed) {
        const ending e = run(seed, count, 0);
        if (e.is_broken) {
            trial::tally ignored;
            std::puts("sim: the end of that run:");
            (void)run(seed, ignored, 40);
            return 1;
        }
        if (seed % 50 == 0 && !replays(seed, e.hash)) return 1;
    }
    count.print();
    return 0;
}

std::uint64_t number(const char* text) { return std::strtoull(text, nullptr, 10); }

} // namespace

int main(int argc, char** argv) {
    std::uint64_t from = 1;
    std::uint64_t seeds = standard_seeds;
    bool is_one = false;
    bool is_traced = false;
    for (int i = 1; i < argc; ++i) {
        const bool has_value = i + 1 < argc;
        if (std::strcmp(argv[i], "--trace") == 0) {
            is_traced = true;
        } else if (has_value && std::strcmp(argv[i], "--seeds") == 0) {
            seeds = number(argv[++i]);
        } else if (has_value && std::strcmp(argv[i], "--from") == 0) {
            from = number(argv[++i]);
        } else if (has_value && std::strcmp(argv[i], "--seed") == 0) {
            from = number(argv[++i]);
            is_one = true;
        } else {
            std::puts("usage: sim [--seeds N] [--from S] | sim --seed S [--trace]");
            return 2;
        }
    }
    if (!is_one) return run_many(from, seeds);
    trial::tally count;
    const ending e = run(from, count, is_traced ? (std::numeric_limits<std::size_t>::max)() : 40);
    if (e.is_broken || !replays(from, e.hash)) return 1;
    count.print();
    return 0;
}
