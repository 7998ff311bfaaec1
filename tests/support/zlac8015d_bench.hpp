// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated ZLAC8015D on a bench: without a line, with a clock that a test moves on, registers by their
// rows.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/zlac8015d.hpp>

namespace zlac8015d_bench {

using namespace servobus;
namespace map = servobus::zlac8015d;
using command = map::command;
using map::fault;
using map::operating_mode;
using map::shaft_state;

inline constexpr std::int64_t one_r_per_min = 1'000'000;

/// A drive on its own, with a clock. `run` keeps the host's requests coming, `silent` does not.
struct bench {
    sim::zlac8015d drive;
    instant now{0xFFFF'0000u}; // the clock wraps in every test

    explicit bench(sim::zlac8015d::options options = {}) : drive{options} { drive.advance(now); }

    std::uint8_t write(std::uint16_t address, std::initializer_list<std::int64_t> words) {
        std::vector<std::uint8_t> raw;
        for (const std::int64_t w : words) {
            const auto bits = static_cast<std::uint16_t>(static_cast<std::uint64_t>(w));
            raw.push_back(static_cast<std::uint8_t>(bits >> 8));
            raw.push_back(static_cast<std::uint8_t>(bits & 0xFFu));
        }
        return drive.write(address, words_view{raw});
    }
    std::uint8_t write(std::uint16_t address, std::int64_t word) { return write(address, {word}); }
    template <class Row> void set(const Row& row, std::int64_t value) {
        CAPTURE(row.address);
        CHECK((Row::words == 2 ? write(row.address, {value >> 16, value & 0xFFFF})
                               : write(row.address, value)) == 0);
    }
    void order(command c) { set(map::control_word, static_cast<int>(c)); }
    void mode(operating_mode m) { set(map::mode_of_operation, static_cast<int>(m)); }

    template <class Row> auto get(const Row& row) {
        std::array<std::uint16_t, Row::words> words{};
        CHECK(drive.read(row.address, words) == 0);
        const std::uint32_t bits =
            Row::words == 2 ? join_words(words[0], words[Row::words - 1], word_order::high_first) : words[0];
        return from_bits<typename Row::value_type>(bits);
    }
    map::status status() { return get(map::status_word); }

    void silent(std::uint32_t ms) {
        for (; ms != 0; --ms) {
            now = now + milliseconds(1);
            drive.advance(now);
        }
    }
    void run(std::uint32_t ms) {
        for (; ms != 0; --ms) {
            silent(1);
            drive.on_request(now);
        }
    }
    std::uint32_t run_until_still(std::uint32_t longest_ms = 100'000) {
        std::uint32_t ms = 0;
        do {
            run(1);
            ++ms;
        } while (ms < longest_ms && status().is_running());
        return ms;
    }

    void begin(operating_mode m) {
        mode(m);
        order(command::enable);
        CHECK(drive.enabled());
    }
};

inline bool about(std::int64_t value, std::int64_t wanted, std::int64_t tolerance) {
    return std::llabs(value - wanted) <= tolerance;
}

} // namespace zlac8015d_bench
