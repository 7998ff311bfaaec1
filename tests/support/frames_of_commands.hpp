// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The frames of a command as text, and how it ends if the drive reports another word in one of them. A command that
// reads less, or does not judge what it reads, has another text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/servobus.hpp>

namespace frames_of_commands {

using servobus::errc;
using servobus::u16;

struct frame {
    bool is_write = false;
    u16 address = 0;
    std::vector<u16> words{};
};

/// A simulated drive that logs its requests, and reports one word of one of them otherwise.
template <class Model> struct watched : Model {
    using Model::Model;
    std::vector<frame> log{};
    std::size_t wrong_frame = ~std::size_t{0};
    std::size_t wrong_word = 0;
    u16 wrong_bits = 0;  ///< 0: all, and a speed is no trembling
    u16 status_bits = 0; ///< that decide each alone, in a word by which the drive is faulted

    std::uint8_t read(u16 address, servobus::slice<u16> to) {
        const std::uint8_t why = Model::read(address, to);
        if (log.size() == wrong_frame)
            to[wrong_word] =
                static_cast<u16>(to[wrong_word] ^ (wrong_bits != 0 ? wrong_bits : all_of(to[wrong_word])));
        log.push_back({false, address, {to.begin(), to.end()}});
        return why;
    }
    std::uint8_t write(u16 address, servobus::words_view from) {
        frame f{true, address, {}};
        for (std::size_t i = 0; i < from.size(); ++i) f.words.push_back(from[i]);
        log.push_back(f);
        return Model::write(address, from);
    }

  private:
    static u16 all_of(u16 word) {
        const auto is_small = [](int v) { return v < 100 && v > -100; };
        return is_small(static_cast<std::int16_t>(~word)) ? 0x7FFF : 0xFFFF;
    }
};

inline std::string hex_of(unsigned word) {
    char text[8];
    (void)std::snprintf(text, sizeof text, "%04X", word);
    return text;
}

inline std::string word_for(errc e) {
    switch (e) {
    case errc::ok: return "-";
    case errc::busy: return "busy";
    case errc::faulted: return "faulted";
    case errc::needs_init: return "needs_init";
    case errc::not_executed: return "not_executed";
    case errc::unexpected_value: return "unexpected_value";
    case errc::wrong_state: return "wrong_state";
    default: return servobus::text(e);
    }
}

/// The requests, whatever the drive has responded.
inline bool is_same(const std::vector<frame>& one, const std::vector<frame>& other) {
    if (one.size() != other.size()) return false;
    for (std::size_t i = 0; i < one.size(); ++i) {
        const frame &a = one[i], &b = other[i];
        if (a.is_write != b.is_write || a.address != b.address || a.words.size() != b.words.size())
            return false;
        if (a.is_write && a.words != b.words) return false;
    }
    return true;
}

/// `0605=0064 00C8` is a write. `0605: busy` is a read, and the error if it reports another word. Others than errors:
/// - `again`: the command goes on otherwise, as by another read
/// - `-`: nothing depends on it
/// - `"`: as for the word before it
/// - `faulted|busy`: for single bits of a status
///
/// The first of equal reads one after another counts, as in a wait.
template <class Rig, class Prepare, class Command>
std::string frames_of(Rig& r, Prepare prepare, const Command& wanted) {
    const auto play = [&](std::size_t frame, std::size_t word, u16 bits = 0) {
        r.model.wrong_frame = ~std::size_t{0};
        REQUIRE(prepare(r));
        r.model.log.clear();
        r.model.wrong_frame = frame;
        r.model.wrong_word = word;
        r.model.wrong_bits = bits;
        return r.drive.run(wanted).error();
    };
    REQUIRE(play(~std::size_t{0}, 0) == errc::ok);
    const std::vector<frame> all = r.model.log;
    std::string text;
    std::string before;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const frame& f = all[i];
        std::string one = hex_of(f.address) + (f.is_write ? "=" : ":");
        std::string last;
        for (std::size_t k = 0; k < f.words.size(); ++k) {
            std::string word = f.is_write ? hex_of(f.words[k]) : word_for(play(i, k));
            if (word == "-" && !is_same(r.model.log, all)) word = "again";
            for (unsigned bit = 0; !f.is_write && word.starts_with("faulted") && bit < 16; ++bit) {
                if ((r.model.status_bits >> bit & 1u) == 0) continue;
                const std::string more = word_for(play(i, k, static_cast<u16>(1u << bit)));
                if (more != "-" && word.find(more) == std::string::npos) word += "|" + more;
            }
            if (k != 0 || !f.is_write) one += ' ';
            one += !f.is_write && word == last ? "\"" : word;
            last = word;
        }
        if (one == before) continue;
        if (i != 0) text += ", ";
        text += one;
        before = one;
    }
    r.model.wrong_frame = ~std::size_t{0};
    return text;
}

} // namespace frames_of_commands
