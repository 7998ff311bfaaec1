// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated drive that a test puts into states, judged by the checks of `servobus doctor` and then by its facade: the
// doctor says "refused" exactly where `init` and `enable` do not end with an enabled drive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

#include <examples/servobus/doctor/check.hpp>
#include <examples/servobus/doctor/reading.hpp>

namespace doctored {

using servobus::u16;
using tool::diagnosis::check;
using tool::diagnosis::check_list;
using tool::diagnosis::held_registers;

/// A simulated drive some of whose registers read as other words, such as none that a write can put there.
template <class Model> struct odd : Model {
    using Model::Model;
    std::map<u16, u16> forced{};

    std::uint8_t read(u16 address, servobus::slice<u16> to) {
        const std::uint8_t why = Model::read(address, to);
        for (std::size_t i = 0; i < to.size(); ++i) {
            const auto at = forced.find(static_cast<u16>(address + i));
            if (at != forced.end()) to[i] = at->second;
        }
        return why;
    }
    /// Writes without the line, as a person at the drive's panel would. Returns false if the drive refuses it.
    bool put(u16 address, std::initializer_list<u16> words) {
        std::vector<std::uint8_t> payload;
        for (const u16 word : words) {
            payload.push_back(static_cast<std::uint8_t>(word >> 8));
            payload.push_back(static_cast<std::uint8_t>(word & 0xFF));
        }
        for (std::size_t i = 0; i < words.size(); ++i) forced.erase(static_cast<u16>(address + i));
        return Model::write(address, servobus::words_view{servobus::bytes{payload}}) == 0;
    }
};

/// The drive on a virtual line with its facade.
template <class Model, template <class> class Facade> struct bench {
    using model_type = odd<Model>;
    model_type model;
    servobus::sim::station<model_type> station{model};
    servobus::sim::virtual_line wire;
    using line_type = servobus::line<servobus::sim::virtual_line>;
    line_type line;
    Facade<line_type> drive{line, 1, servobus::unsupervised};

    template <class Options>
    explicit bench(Options options)
        : model{options}, wire{model.baud()}, line{wire, servobus::modbus::timing_at(model.baud())} {
        wire.attach(station);
    }
    bench(const bench&) = delete;
    bench& operator=(const bench&) = delete;

    void pass(std::uint32_t ms) { wire.pass(servobus::milliseconds(ms)); }
};

/// Reads the registers of a list, without the line.
template <class Model>
held_registers read_of(Model& model, const check_list& list, const servobus::catalogue& map) {
    held_registers held;
    held.on.baud = model.baud();
    held.on.format = map.device->format;
    held.on.response_ms = map.device->limits.response.us / 1000;
    held.on.quarantine_ms = map.device->quarantine.us / 1000;
    held.on.period_ms = 600; // no ramp from the factory is longer
    const std::uint32_t before = model.writes();
    const auto rows = tool::diagnosis::rows_of(list, map);
    const auto read = [&](std::span<const servobus::entry* const> some, std::span<u16> words) {
        const std::uint8_t why =
            model.read(some[0]->address, servobus::slice<u16>{words.data(), words.size()});
        std::size_t at = 0;
        for (const servobus::entry* e : some) {
            const bool is_low_first = e->words() == 2 && map.device->word_order_register != 0 &&
                                      model.peek(map.device->word_order_register) == 1;
            if (is_low_first) std::swap(words[at], words[at + 1]);
            at += e->words();
        }
        return why == 0 ? servobus::status{} : servobus::status::sent(servobus::errc::exception, why);
    };
    const auto missing = tool::diagnosis::read_into(held, rows, map.device->max_read, read);
    CHECK(missing.empty());
    CHECK(model.writes() == before); // it only reads
    return held;
}

/// A state of the drive, and a check that must apply to it; null: none in particular.
template <class Bench> struct state {
    const char* name;
    bool (*enter)(Bench&);            ///< false if the drive does not let itself be put into it
    const char* expected = "";        ///< the beginning of the name of the register in front of a finding
    bool (*exists)(Bench&) = nullptr; ///< null: in each variant
};

/// How often each state was played, and how its drives ended.
struct tally {
    std::map<std::string, unsigned> played{};
    unsigned refused = 0;
    unsigned enabled = 0;
    unsigned open = 0;                        ///< of these: where the registers do not tell
    std::map<const check*, unsigned> alone{}; ///< how often a check was the only one that refused
};

template <class Map> std::string first_of(const check& c, const Map& map) {
    return static_cast<const char*>(map.find(c.of[0])->name);
}

/// Judges a drive that is in its state, by the doctor and by its facade. `is_open`: true for registers of which a drive
/// may be enabled or not; then a finding that matters has to say so.
template <class Bench>
void compare(Bench& b, const check_list& list, const servobus::catalogue& map, tally& count,
             bool (*is_open)(const held_registers&) = nullptr) {
    const held_registers held = read_of(b.model, list, map);
    const auto found = tool::diagnosis::find(list, held);
    std::string names;
    std::vector<const check*> refusing;
    for (const check* c : found) {
        if (c->is != tool::diagnosis::refuses) continue;
        names += first_of(*c, map) + ' ';
        refusing.push_back(c);
    }
    if (refusing.size() == 1) ++count.alone[refusing[0]];
    CAPTURE(names);
    auto done = b.drive.run(servobus::init{});
    if (done) done = b.drive.run(servobus::enable{});
    CAPTURE(std::string{text(done.error())});
    const bool is_enabled = done && b.model.enabled();
    if (is_open == nullptr || !is_open(held)) {
        CHECK(refusing.empty() == is_enabled);
    } else if (refusing.empty()) { // whatever came of it
        ++count.open;
        bool is_said = false;
        for (const check* c : found)
            is_said = is_said || std::string{c->why}.find("an enable is refused if") != std::string::npos;
        CHECK(is_said);
    } else {
        CHECK(!is_enabled);
    }
    ++(is_enabled ? count.enabled : count.refused);
}

/// Each state alone, each pair of them, and so many random sets. `make` makes a bench with a new drive.
template <class Bench, std::size_t Count, class Make>
tally play(const state<Bench> (&states)[Count], const check_list& list, const servobus::catalogue& map,
           Make make, unsigned sets, bool (*is_open)(const held_registers&) = nullptr) {
    tally count;
    const auto play_set = [&](std::uint64_t chosen) {
        const std::unique_ptr<Bench> b = make();
        std::string entered;
        for (std::size_t i = 0; i < Count; ++i) {
            if ((chosen >> i & 1u) == 0 || !states[i].enter(*b)) continue;
            ++count.played[states[i].name];
            entered += std::string{states[i].name} + "; ";
        }
        CAPTURE(entered);
        b->pass(10); // what has begun shows
        compare(*b, list, map, count, is_open);
    };
    static_assert(Count <= 64);
    for (std::size_t i = 0; i < Count; ++i) {
        for (std::size_t j = 0; j <= i; ++j) play_set(std::uint64_t{1} << i | std::uint64_t{1} << j);
    }
    std::uint64_t seed = 1;
    const auto draw = [&seed] {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        return seed >> 33;
    };
    for (unsigned n = 0; n < sets; ++n) {
        std::uint64_t chosen = 0;
        for (std::size_t i = 0; i < Count; ++i) chosen |= std::uint64_t{draw() % 7 == 0 ? 1u : 0u} << i;
        play_set(chosen);
    }
    // Every state was played, and both ends were met.
    const std::unique_ptr<Bench> probe = make();
    for (const auto& s : states) {
        CAPTURE(std::string{s.name});
        if (s.exists == nullptr || s.exists(*probe)) CHECK(count.played[s.name] > Count / 2);
    }
    CHECK(count.refused > 20);
    CHECK(count.enabled > 20);
    // None of the rows that refuse could be left out.
    for (const check& c : list.checks) {
        if (c.is != tool::diagnosis::refuses) continue;
        CAPTURE(first_of(c, map));
        CAPTURE(std::string{c.why});
        CHECK(count.alone[&c] != 0);
    }
    MESSAGE(count.enabled, " enabled and ", count.refused, " refused, ", count.open, " of them open, of ",
            Count, " states");
    return count;
}

/// Each state alone, under each of these options. `make_of` takes them, and returns what makes a bench with a new
/// drive.
template <class Bench, std::size_t Count, class Options, std::size_t Sets, class Make>
tally play_under(const state<Bench> (&states)[Count], const check_list& list, const servobus::catalogue& map,
                 void (*const (&choices)[Sets])(Options&), Make make_of,
                 bool (*is_open)(const held_registers&)) {
    tally count;
    for (std::size_t i = 0; i < Sets; ++i) {
        CAPTURE(i);
        Options chosen;
        choices[i](chosen);
        const auto make = make_of(chosen);
        for (const auto& s : states) {
            CAPTURE(std::string{s.name});
            const std::unique_ptr<Bench> b = make();
            if ((s.exists != nullptr && !s.exists(*b)) || !s.enter(*b)) continue;
            ++count.played[s.name];
            b->pass(10);
            compare(*b, list, map, count, is_open);
        }
    }
    MESSAGE(count.enabled, " enabled and ", count.refused, " refused, ", count.open, " of them open, under ",
            Sets, " interpretations");
    CHECK(count.refused > Sets);
    CHECK(count.enabled > Sets);
    return count;
}

/// Each state alone shows the finding that it is to show. Adds the sentences of all findings to `said`.
template <class Bench, std::size_t Count, class Make>
void expect_findings(const state<Bench> (&states)[Count], const check_list& list,
                     const servobus::catalogue& map, Make make, std::set<std::string>& said) {
    for (const auto& s : states) {
        CAPTURE(std::string{s.name});
        const std::unique_ptr<Bench> b = make();
        if (s.exists != nullptr && !s.exists(*b)) continue;
        const auto names = [&] {
            std::string all;
            for (const check* c : tool::diagnosis::find(list, read_of(b->model, list, map)))
                all += ' ' + first_of(*c, map) + ": " + c->why + ';';
            return all;
        };
        const std::string before = names();
        REQUIRE(s.enter(*b));
        const std::string after = names();
        CAPTURE(before);
        CAPTURE(after);
        for (const check& c : list.checks) {
            const std::string sentence = first_of(c, map) + ": " + c.why;
            if (after.find(' ' + sentence + ';') != after.npos) said.insert(sentence);
        }
        if (*s.expected == '\0') continue;
        CHECK(before.find(s.expected) == before.npos);
        CHECK(after.find(s.expected) != after.npos);
    }
}

/// Each row of a list was said in a state.
inline void expect_all(const check_list& list, const servobus::catalogue& map,
                       const std::set<std::string>& said) {
    for (const check& c : list.checks) {
        const std::string sentence = first_of(c, map) + ": " + c.why;
        CAPTURE(sentence);
        CHECK(said.contains(sentence));
    }
}

} // namespace doctored
