// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated C630S without a line. The test advances its clock and reaches its parameters by their rows.
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

#include <tests/support/model_bench.hpp>

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

/// A simulated drive with its clock, without a line.
struct bench : tests::model_bench<sim::c630s> {
    explicit bench(sim::c630s::options options = {}) : model_bench{options} {}

    word_order current_word_order() {
        return drive.peek(map::pair_word_order.address) != 0 ? word_order::low_first : word_order::high_first;
    }
    std::uint8_t put(std::uint16_t address, std::int64_t value, bool is_pair = false) {
        if (!is_pair) return write(address, {value});
        const word_pair words =
            split_words(static_cast<u32>(static_cast<std::uint64_t>(value)), current_word_order());
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

    template <class Row> auto get(const Row& row) { return model_bench::get(row, current_word_order()); }

    void run(std::uint32_t ms) { pass(ms); }
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

    // Takes the functions from the real inputs. Assigns S-ON to VDI1 and `functions` to VDI2 and up.
    // Functions that act on an edge get edge logic.
    void assign(const std::vector<in>& functions) {
        for (unsigned n = 0; n < 8; ++n)
            CHECK(put(static_cast<std::uint16_t>(map::di1_function.address + 2 * n), 0) == 0);
        set(map::virtual_input_functions[0], in::servo_on);
        std::size_t n = 1;
        for (const in f : functions) {
            const bool is_edge = f == in::alarm_reset || f == in::step_enable ||
                                 f == in::position_segment_start || f == in::homing_start ||
                                 f == in::clear_following_error;
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
    // Position control by segments, with S-ON on VDI1 and the start on VDI2.
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
