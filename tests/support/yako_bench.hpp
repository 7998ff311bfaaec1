// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated YAKOTEC drive without a line. The test advances its clock and reaches its registers by their
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

#include <tests/support/model_bench.hpp>

namespace yako_bench {

using namespace servobus;
namespace cl = servobus::yako::closed_loop;
namespace ol = servobus::yako::open_loop;
using servobus::yako::auxiliary;
using servobus::yako::input_function;
using servobus::yako::motion_code;
using servobus::yako::motion_status;
using servobus::yako::output_function;
using servobus::yako::positioning;
using servobus::yako::while_moving;

inline constexpr std::int64_t one_r_per_min = 1'000'000;

template <class Model> inline constexpr const catalogue& map_of = cl::catalogue;
template <> inline constexpr const catalogue& map_of<sim::yako_open_loop> = ol::catalogue;

/// A simulated drive with its clock, without a line.
template <class Model> struct bench : tests::model_bench<Model> {
    using base = tests::model_bench<Model>;
    using base::drive;
    using base::get;
    using base::now;
    using base::set;
    using base::write;

    explicit bench(sim::yako_options options = {}) : base{options} {}

    template <class Row, class Value>
    requires(!std::is_arithmetic_v<Value>) void set(const Row& row, Value value) {
        set(row, static_cast<std::int64_t>(to_bits(value)));
    }
    void command(motion_code c) { set(cl::motion_command, c); }
    void command(auxiliary a) { set(cl::auxiliary_command, a); }
    void move(std::int64_t target, positioning from = positioning::relative,
              while_moving then = while_moving::ignore) {
        set(cl::target_position, target);
        command(motion_code::move(from, then));
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
    // Runs from a command until standstill and "in position". Returns the time in ms.
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
