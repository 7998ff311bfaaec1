// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the benches of the simulated drives share: a drive with its clock, without a line, and access to its
// registers.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include <servobus/servobus.hpp>

namespace tests {

template <class Model> struct model_bench {
    Model drive;
    servobus::instant now{0xFFFF'0000u}; // the clock wraps in every test

    template <class Options> explicit model_bench(const Options& options) : drive{options} {
        drive.advance(now);
    }

    std::uint8_t write(std::uint16_t address, std::initializer_list<std::int64_t> words) {
        std::vector<std::uint8_t> raw;
        for (const std::int64_t w : words) {
            const auto bits = static_cast<std::uint16_t>(static_cast<std::uint64_t>(w));
            raw.push_back(static_cast<std::uint8_t>(bits >> 8));
            raw.push_back(static_cast<std::uint8_t>(bits & 0xFFu));
        }
        return drive.write(address, servobus::words_view{raw});
    }
    std::uint8_t write(std::uint16_t address, std::int64_t word) { return write(address, {word}); }
    /// Writes a value of one or two words, the high word first.
    template <class Row> void set(const Row& row, std::int64_t value) {
        CAPTURE(row.address);
        CHECK((Row::words == 2 ? write(row.address, {value >> 16, value & 0xFFFF})
                               : write(row.address, value)) == 0);
    }
    template <class Row>
    auto get(const Row& row, servobus::word_order order = servobus::word_order::high_first) {
        std::array<std::uint16_t, Row::words> words{};
        CHECK(drive.read(row.address, words) == 0);
        const std::uint32_t bits =
            Row::words == 2 ? servobus::join_words(words[0], words[Row::words - 1], order) : words[0];
        return servobus::from_bits<typename Row::value_type>(bits);
    }

    /// Advances the drive's time, millisecond by millisecond.
    void pass(std::uint32_t ms) {
        for (; ms != 0; --ms) {
            now = now + servobus::milliseconds(1);
            drive.advance(now);
        }
    }
};

} // namespace tests
