// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plays a shard of every pair of mishaps, or all single mishaps under one interpretation of the manual, by the judges
// for everybody (sim/conformance.hpp). tests/pairs.sh runs it.
//   pairs DRIVE mishaps SHARD/SHARDS | pairs DRIVE interpretations SHARD/SHARDS
//   pairs DRIVE count | pairs DRIVE choices
// DRIVE: zlac8015d, yako_closed_loop, yako_open_loop, c630s, winch. The last line has the shard, and how many runs,
// findings and seconds it was; `count` prints how many pairs there are, `choices` how many interpretations.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string_view>

#define DOCTEST_CONFIG_IMPLEMENT // the tables of interpretations are those of the tests
#include <doctest/doctest.h>

#include <servobus/servobus.hpp>

#include <examples/own_device/own_subject.hpp>
#include <tests/support/conformance_interpretations.hpp>
#include <tests/support/conformance_subjects.hpp>

namespace {

namespace sim = servobus::sim;

void show(void*, const sim::finding& f) {
    std::printf("%s: %s (%s, request %u: %s, request %u: %s, interpretation %u)\n", f.promise, f.what,
                f.command, f.first.request, sim::text(f.first.what), f.second.request,
                sim::text(f.second.what), f.interpretation);
}
double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <class Subject> int play(std::size_t choices, int count, char** words) {
    const std::string_view what = words[2];
    sim::conformance<Subject> kit{&show};
    if (what == "choices") return std::printf("%zu\n", choices), 0;
    if (what == "count") {
        // A part of 1 of 17 has every mishap at some request.
        const std::uint64_t pairs = 17 * kit.count_pairs(0, {0, 17});
        return std::printf("about %" PRIu64 " pairs\n", pairs), 0;
    }
    char* end = nullptr;
    const unsigned long shard = count == 4 ? std::strtoul(words[3], &end, 10) : 0;
    if (end == nullptr || *end != '/') return 2;
    const unsigned long of = std::strtoul(end + 1, nullptr, 10);
    sim::played all{};
    if (what == "mishaps") {
        if (shard >= of) return 2;
        all = kit.every_pair(0, {static_cast<std::uint32_t>(shard), static_cast<std::uint32_t>(of)});
    } else if (what == "interpretations") {
        if (shard >= choices) return 2;
        all = kit.singles(static_cast<unsigned>(shard));
    } else {
        return 2;
    }
    for (const sim::mishap m : sim::all_mishaps) {
        if (all.runs < 500 || all.happened[static_cast<unsigned>(m)] != 0) continue;
        ++all.findings;
        std::printf("kit: this never happened: %s\n", sim::text(m));
    }
    std::printf("%s %s %s %u runs, %u findings, %.1f s\n", words[1], words[2], words[3], all.runs,
                all.findings, seconds());
    return all.findings == 0 ? 0 : 1;
}

template <template <class> class Subject, class Manual> int play(int count, char** words) {
    using read = subjects::interpretations<Manual>;
    return play<Subject<read>>(read::choices().size(), count, words);
}

} // namespace

int main(int count, char** words) {
    if (count < 3) return 2;
    const std::string_view drive = words[1];
    if (drive == "zlac8015d") return play<subjects::wheels, subjects::zlac8015d_manual>(count, words);
    if (drive == "yako_closed_loop") return play<subjects::closed_axis, subjects::yako_manual>(count, words);
    if (drive == "yako_open_loop") return play<subjects::open_axis, subjects::yako_manual>(count, words);
    if (drive == "c630s") return play<subjects::servo, subjects::c630s_manual>(count, words);
    if (drive == "winch") return play<winch::subject>(1, count, words);
    return 2;
}
