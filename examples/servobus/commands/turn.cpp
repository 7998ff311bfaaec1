// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus turn: a shaft that a person turns by hand counts its turns.
#include <cstdio>
#include <iostream>
#include <string>

#include "../devices/device.hpp"
#include "../parameters/parameters.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "commands.hpp"

namespace tool {
namespace {

constexpr std::int64_t part_of_a_turn = 20; // a hand is right within a part of 20 of a turn

// Reads the positions of all shafts. Returns `done`, or the exit status after a complaint.
int read_positions(session& on, const target& of, const turned_shafts& shafts, std::vector<u32>& positions) {
    positions.clear();
    for (const turned_shaft& s : shafts.all) {
        const servobus::entry& row = *of.kind->map->find(s.position);
        std::vector<u16> words(2);
        const servobus::status why = on.read(choose(row), words);
        if (why.error() != servobus::errc::ok)
            return complain(failed, std::string{row.name} + ": " + why_text(of, why, on));
        positions.push_back(servobus::join_words(words[0], words[1], servobus::word_order::high_first));
    }
    return done;
}

// Prints what one shaft has counted. False if that is not what the drive's settings say.
bool judge(const turned_shaft& s, std::int64_t counts, std::int64_t turns) {
    const std::int64_t size = counts < 0 ? -counts : counts;
    const std::int64_t a_turn = (size + turns / 2) / turns;
    std::printf("%s: %lld counts, %lld a turn, forward is %s", s.name, static_cast<long long>(counts),
                static_cast<long long>(a_turn), counts < 0 ? "negative" : "positive");
    if (s.counts == 0) {
        (void)std::puts("");
        return true;
    }
    const std::int64_t apart = size - s.counts * turns;
    const bool is_so = (apart < 0 ? -apart : apart) * part_of_a_turn <= s.counts;
    std::printf("; %s is %lld%s\n", s.where_said, static_cast<long long>(s.counts),
                is_so ? "" : ", which is not so");
    return is_so;
}

} // namespace

int turn(const arguments& asked) {
    if (asked.words().size() != 2) return complain(usage, "turn takes PORT DEVICE[:NODE]");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    if (of->kind == nullptr || of->kind->turning == nullptr)
        return complain(usage, asked.words()[1] + " does not count what is turned by hand");
    const auto turns = asked.number("turns", 1, 1000, 10);
    if (!turns) return usage;
    session on;
    if (const int status = on.check(asked, *of); status != done) return status;
    if (const int status = on.open(asked.words()[0].c_str()); status != done) return status;
    const repose rest = of->kind->at_rest(on);
    if (rest.why.error() != servobus::errc::ok)
        return complain(failed, "the drive's state: " + why_text(*of, rest.why, on));
    if (!rest.unrest.empty()) return complain(failed, "refused: " + rest.unrest);
    const turned_shafts shafts = of->kind->turning(on);
    if (shafts.why.error() != servobus::errc::ok)
        return complain(failed, "the drive's settings: " + why_text(*of, shafts.why, on));
    std::vector<u32> before, after;
    if (const int status = read_positions(on, *of, shafts, before); status != done) return status;

    (void)std::fprintf(stderr, "Turn it by hand, %lld turn%s forward, then press Enter: ",
                       static_cast<long long>(*turns), *turns == 1 ? "" : "s");
    (void)std::fflush(stderr);
    std::string line;
    if (!std::getline(std::cin, line)) return complain(failed, "nobody has pressed Enter");

    if (const int status = read_positions(on, *of, shafts, after); status != done) return status;
    bool is_so = true, has_turned = false;
    for (std::size_t i = 0; i < shafts.all.size(); ++i) {
        const std::int64_t counts = static_cast<std::int32_t>(after[i] - before[i]); // it may have wrapped
        if (counts == 0) continue;
        has_turned = true;
        is_so = judge(shafts.all[i], counts, *turns) && is_so;
    }
    if (!streams::flush()) return failed;
    if (!has_turned) return complain(failed, "no position has changed");
    return is_so ? done
                 : complain(failed, "the counts of a turn are not what the drive's settings say; a turn too "
                                    "many or too few?");
}

} // namespace tool
