// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated ZLAC8015D without a line. The test advances its clock and reaches its registers by their rows.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/model_bench.hpp>

namespace zlac8015d_bench {

using namespace servobus;
namespace map = servobus::zlac8015d;
using control_code = map::control_code;
using map::fault;
using map::operating_mode;
using map::shaft_state;

inline constexpr std::int64_t one_r_per_min = 1'000'000;

/// A simulated drive with its clock, without a line. During `run` requests of the host keep coming, during
/// `silent` none do.
struct bench : tests::model_bench<sim::zlac8015d> {
    explicit bench(sim::zlac8015d::options options = {}) : model_bench{options} {}

    void command(control_code c) { set(map::control_word, static_cast<int>(c)); }
    void mode(operating_mode m) { set(map::mode_of_operation, static_cast<int>(m)); }

    void have_resolution(std::int64_t n) {
        drive.store(map::speed_resolution.address, static_cast<std::uint16_t>(n));
        drive.power_cycle();
    }
    map::status_flags status() { return get(map::status_word); }

    void silent(std::uint32_t ms) { pass(ms); }
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
        command(control_code::enable);
        CHECK(drive.enabled());
    }
};

inline bool about(std::int64_t value, std::int64_t wanted, std::int64_t tolerance) {
    return std::llabs(value - wanted) <= tolerance;
}

} // namespace zlac8015d_bench
