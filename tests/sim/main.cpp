// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many runs on a hostile line, in virtual time: clients, adapters with a local echo, blocking lines, a bus,
// facades, fleets, scans, lives of a drive. Every promise is checked throughout. One seed is one run of one kind. A run
// that breaks a promise is printed in words.
//     sim [--seeds N] [--from S]     N runs from seed S on
//         [--least N]            exits 1 unless N transactions met each position of each drive's switches,
//                                and N stalls of the program each place in a transaction with each drive
//     sim --seed S [--trace]         one run; its frames in words
//     --only KIND[,KIND...]          runs of these kinds: plain, echo, blocking_line, bus, facades, scan, fleet (three
//                                    drives), lives (a drive that restarts, is away and has faults)
// Prints how often each kind of event was played, and exits 1 if 1000 seeds or more have played one too seldom.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>
#include <string_view>
#include <vector>

#include "bus_run.hpp"
#include "facade_run.hpp"
#include "fleet_run.hpp"
#include "life_run.hpp"
#include "scan_run.hpp"
#include "traffic.hpp"

namespace {

constexpr std::uint64_t standard_seeds = 1600;

struct ending {
    std::uint64_t hash = 0;
    bool is_broken = false;
};

template <class Run> ending carry_out(std::uint64_t seed, trial::event_counts& count, std::size_t notes) {
    Run under_way{seed, count, notes};
    trial::world& of = under_way.place();
    ending e;
    try {
        under_way.go();
    } catch (const trial::broken& b) {
        e.is_broken = true;
        if (notes != 0) of.print();
        std::printf("sim: seed %llu, %llu us: %s\n", static_cast<unsigned long long>(seed),
                    static_cast<unsigned long long>(of.wire().time_us()), b.promise.c_str());
    }
    if (!e.is_broken && notes != 0) of.print();
    of.log().mix(of.wire().time_us());
    e.hash = of.log().hash();
    return e;
}

/// --only: all runs are of these kinds.
std::vector<trial::kind_of_run> only;

bool limit_to(std::string_view kinds) {
    while (!kinds.empty()) {
        const std::string_view name = kinds.substr(0, kinds.find(','));
        kinds.remove_prefix(name.size() < kinds.size() ? name.size() + 1 : name.size());
        std::size_t k = 0;
        while (k < trial::event_counts::kinds && name != text(static_cast<trial::kind_of_run>(k))) ++k;
        if (k == trial::event_counts::kinds) return false;
        only.push_back(static_cast<trial::kind_of_run>(k));
    }
    return !only.empty();
}

trial::kind_of_run kind_of(std::uint64_t seed) {
    using enum trial::kind_of_run;
    constexpr trial::kind_of_run kinds[] = {plain,  small, echo,  life,  plain, fleet, facade, plain,
                                            plain,  life,  echo,  plain, plain, scan,  echo,   life,
                                            facade, plain, small, plain, echo,  life,  plain,  bus};
    const trial::kind_of_run kind = kinds[seed % std::size(kinds)];
    const bool is_wanted = only.empty() || std::find(only.begin(), only.end(), kind) != only.end();
    return is_wanted ? kind : only[seed % only.size()];
}

ending run(std::uint64_t seed, trial::event_counts& count, std::size_t notes) {
    using enum trial::kind_of_run;
    const trial::kind_of_run kind = kind_of(seed);
    const std::uint64_t before = count.transactions;
    ending e;
    switch (kind) {
    case echo: e = carry_out<trial::echo_run>(seed, count, notes); break;
    case small: e = carry_out<trial::small_run>(seed, count, notes); break;
    case bus: e = carry_out<trial::bus_run>(seed, count, notes); break;
    case facade: e = carry_out<trial::facade_run>(seed, count, notes); break;
    case fleet: e = carry_out<trial::fleet_run>(seed, count, notes); break;
    case life: e = carry_out<trial::life_run>(seed, count, notes); break;
    case scan: e = carry_out<trial::scan_run>(seed, count, notes); break;
    default: e = carry_out<trial::plain_run>(seed, count, notes);
    }
    ++count.runs;
    count.transactions_of[static_cast<std::size_t>(kind)] += count.transactions - before;
    return e;
}

bool replays(std::uint64_t seed, std::uint64_t hash) {
    trial::event_counts ignored;
    if (run(seed, ignored, 0).hash == hash) return true;
    std::printf("sim: seed %llu does not replay: its second run differs\n",
                static_cast<unsigned long long>(seed));
    return false;
}

int run_many(std::uint64_t from, std::uint64_t seeds, std::uint64_t least) {
    trial::event_counts count;
    for (std::uint64_t seed = from; seed - from < seeds; ++seed) {
        const ending e = run(seed, count, 0);
        if (e.is_broken) {
            trial::event_counts ignored;
            std::puts("sim: the end of that run:");
            (void)run(seed, ignored, 40);
            return 1;
        }
        if (seed % 50 == 0 && !replays(seed, e.hash)) return 1;
    }
    count.print();
    const bool has_met = count.has_met_all(least) && (!only.empty() || count.has_struck_all());
    return has_met && count.lives.has_met_floors(seeds, only.empty()) ? 0 : 1;
}

std::uint64_t number(const char* text) { return std::strtoull(text, nullptr, 10); }

} // namespace

int main(int argc, char** argv) {
    std::uint64_t from = 1;
    std::uint64_t seeds = standard_seeds;
    std::uint64_t least = 0;
    bool is_one = false;
    bool is_traced = false;
    for (int i = 1; i < argc; ++i) {
        const bool has_value = i + 1 < argc;
        if (std::strcmp(argv[i], "--trace") == 0) {
            is_traced = true;
        } else if (has_value && std::strcmp(argv[i], "--only") == 0 && limit_to(argv[i + 1])) {
            ++i;
        } else if (has_value && std::strcmp(argv[i], "--seeds") == 0) {
            seeds = number(argv[++i]);
        } else if (has_value && std::strcmp(argv[i], "--from") == 0) {
            from = number(argv[++i]);
        } else if (has_value && std::strcmp(argv[i], "--least") == 0) {
            least = number(argv[++i]);
        } else if (has_value && std::strcmp(argv[i], "--seed") == 0) {
            from = number(argv[++i]);
            is_one = true;
        } else {
            std::puts("usage: sim [--only KIND[,KIND...]] [--seeds N] [--from S] [--least N]\n"
                      "       sim [--only KIND[,KIND...]] --seed S [--trace]\n"
                      "KIND: plain, echo, blocking_line, bus, facades, scan, fleet, lives");
            return 2;
        }
    }
    if (!is_one) return run_many(from, seeds, least);
    trial::event_counts count;
    const ending e = run(from, count, is_traced ? (std::numeric_limits<std::size_t>::max)() : 40);
    if (e.is_broken || !replays(from, e.hash)) return 1;
    count.print();
    return 0;
}
