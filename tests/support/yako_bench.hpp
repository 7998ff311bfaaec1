// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated YAKOTEC drive on a bench: without a line, with a clock that a test moves on, registers by their
// rows.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <type_traits>
#include <vector>

#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/yako.hpp>

namespace yako_bench {

using namespace servobus;
namespace cl = servobus::yako::closed_loop;
namespace ol = servobus::yako::open_loop;
using servobus::yako::auxiliary;
using servobus::yako::command;
using servobus::yako::input_function;
using servobus::yako::motion_status;
using servobus::yako::output_function;
using servobus::yako::positioning;
using servobus::yako::while_moving;

inline constexpr std::int64_t one_r_per_min = 1'000'000;

template <class Model> inline constexpr const catalogue& map_of = cl::catalogue;
template <> inline constexpr const catalogue& map_of<sim::yako_open_loop> = ol::catalogue;

/// A drive on its own, with a clock.
template <class Model> struct bench {
    Model drive;
    instant now{0xFFFF'0000u}; // the clock wraps in every test

    explicit bench(sim::yako_options options = {}) : drive{options} { drive.advance(now); }

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
    template <class Row, class Value>
    requires(!std::is_arithmetic_v<Value>) void set(const Row& row, Value value) {
        set(row, static_cast<std::int64_t>(to_bits(value)));
    }
    void order(command c) { set(cl::motion_command, c); }
    void order(auxiliary a) { set(cl::auxiliary_command, a); }
    void move(std::int64_t target, positioning from = positioning::relative,
              while_moving then = while_moving::ignore) {
        set(cl::target_position, target);
        order(command::move(from, then));
    }

    template <class Row> auto get(const Row& row) {
        std::array<std::uint16_t, Row::words> words{};
        CHECK(drive.read(row.address, words) == 0);
        const std::uint32_t bits =
            Row::words == 2 ? join_words(words[0], words[Row::words - 1], word_order::high_first) : words[0];
        return from_bits<typename Row::value_type>(bits);
    }
    motion_status status() { return get(cl::status_word); }
    std::int32_t position() { return get(cl::actual_position); }
    std::int16_t speed() { return get(cl::actual_speed); }

    void run_us(std::uint32_t us) {
        now = now + microseconds(us);
        drive.advance(now);
    }
    void run(std::uint32_t ms) {
        for (; ms != 0; --ms) run_us(1000);
    }
    // From an order to standstill and "in position". Returns ms.
    std::uint32_t run_until_still(std::uint32_t longest_ms = 60'000) {
        std::uint32_t ms = 0;
        for (; ms < longest_ms && (ms < 4 || drive.view().is_moving); ++ms) run(1);
        run(15);
        return ms;
    }
};

using closed = bench<sim::yako_closed_loop>;
using open = bench<sim::yako_open_loop>;

/// Both variants, for `TEST_CASE_TEMPLATE`.
#define BOTH closed, open

inline bool about(std::int64_t value, std::int64_t wanted, std::int64_t tolerance) {
    return std::llabs(value - wanted) <= tolerance;
}

// Terminals

constexpr std::uint16_t row_of_input(unsigned n) { return static_cast<std::uint16_t>(0x0041 + n); }
template <class B> void assign(B& b, unsigned input, input_function f) {
    CHECK(b.write(row_of_input(input), static_cast<int>(f)) == 0);
}
template <class B> void press(B& b, unsigned input) {
    b.drive.set_input(input, true);
    b.run(20);
}
template <class B> void let_go(B& b, unsigned input) {
    b.drive.set_input(input, false);
    b.run(20);
}

} // namespace yako_bench
