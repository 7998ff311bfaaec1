// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated C630S on a bench: without a line, with a clock that a test moves on, parameters by their rows.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <type_traits>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/c630s.hpp>

namespace c630s_bench {

using namespace servobus;
namespace map = servobus::c630s;
using in = map::input_function;
using out = map::output_function;

inline constexpr std::int64_t turn = 131'072; // encoder counts
inline constexpr std::int64_t one_r_per_min = 1'000'000;

inline bool about(std::int64_t value, std::int64_t wanted, std::int64_t tolerance) {
    return std::llabs(value - wanted) <= tolerance;
}

/// A drive on its own, with a clock.
struct bench {
    sim::c630s drive;
    instant now{0xFFFF'0000u}; // the clock wraps in every test

    explicit bench(sim::c630s::options options = {}) : drive{options} { drive.advance(now); }

    std::uint8_t write(std::uint16_t address, std::initializer_list<std::int64_t> words) {
        std::vector<std::uint8_t> raw;
        for (const std::int64_t w : words) {
            const auto bits = static_cast<std::uint16_t>(static_cast<std::uint64_t>(w));
            raw.push_back(static_cast<std::uint8_t>(bits >> 8));
            raw.push_back(static_cast<std::uint8_t>(bits & 0xFFu));
        }
        return drive.write(address, words_view{raw});
    }
    word_order order() {
        return drive.peek(map::pair_word_order.address) != 0 ? word_order::low_first : word_order::high_first;
    }
    std::uint8_t put(std::uint16_t address, std::int64_t value, bool is_pair = false) {
        if (!is_pair) return write(address, {value});
        const word_pair words = split_words(static_cast<u32>(static_cast<std::uint64_t>(value)), order());
        return write(address, {words.first, words.second});
    }
    template <class Row> std::uint8_t put(const Row& row, std::int64_t value) {
        return put(row.address, value, Row::words == 2);
    }
    template <class Row> void set(const Row& row, std::int64_t value) {
        CAPTURE(row.address);
        CHECK(put(row, value) == 0);
    }
    template <class Row, class Value>
    requires std::is_enum_v<Value>
    void set(const Row& row, Value value) { set(row, static_cast<std::int64_t>(value)); }

    template <class Row> auto get(const Row& row) {
        std::array<std::uint16_t, Row::words> words{};
        CHECK(drive.read(row.address, words) == 0);
        const u32 bits = Row::words == 2 ? join_words(words[0], words[Row::words - 1], order()) : words[0];
        return from_bits<typename Row::value_type>(bits);
    }

    void run(std::uint32_t ms) {
        for (; ms != 0; --ms) {
            now = now + milliseconds(1);
            drive.advance(now);
        }
    }
    template <class F> std::uint32_t run_until(const F& done, std::uint32_t longest_ms = 100'000) {
        std::uint32_t ms = 0;
        while (ms < longest_ms && !done()) {
            run(1);
            ++ms;
        }
        return ms;
    }
    std::uint32_t run_until_still(std::uint32_t longest_ms = 100'000) {
        run(2);
        return run_until([this] { return drive.stands_still() && !drive.is_positioning(); }, longest_ms);
    }

    // Real inputs lose their functions; VDI1 is S-ON, VDI2.. have these, with edges where they are wanted.
    void assign(const std::vector<in>& functions) {
        for (unsigned n = 0; n < 8; ++n)
            CHECK(put(static_cast<std::uint16_t>(map::di1_function.address + 2 * n), 0) == 0);
        set(map::virtual_input_functions[0], in::servo_on);
        std::size_t n = 1;
        for (const in f : functions) {
            const bool is_edge = f == in::alarm_reset || f == in::step_enable ||
                                 f == in::position_segment_start || f == in::homing_start ||
                                 f == in::clear_position_deviation;
            set(map::virtual_input_functions[n], f);
            set(map::virtual_input_logics[n], is_edge ? 1 : 0);
            ++n;
        }
        set(map::virtual_inputs_enable, 1);
    }
    void restart() { drive.power_cycle(); }
    void virtual_levels(unsigned word) { set(map::virtual_input_levels, word); }
    void enable(unsigned more = 0) {
        virtual_levels(1 | more);
        run(2);
        CHECK(drive.enabled());
    }
    // Position control with the segments, S-ON on VDI1, the start on VDI2.
    void begin_segments(map::segment_mode mode, std::initializer_list<in> more = {}) {
        std::vector<in> all{in::position_segment_start};
        all.insert(all.end(), more);
        assign(all);
        set(map::position_command_source, map::position_source::segments);
        set(map::position_segment_mode, mode);
        restart();
        set(map::eeprom_update, 0);
        enable();
    }
    void start(unsigned more = 0) {
        virtual_levels(3 | more);
        run(1);
        virtual_levels(1 | more);
    }
    std::int64_t reference() { return get(map::absolute_position); }
};

} // namespace c630s_bench
