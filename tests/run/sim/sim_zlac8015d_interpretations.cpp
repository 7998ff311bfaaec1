// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Interpretations of the ZLAC8015D manual to which the simulated drive can be switched: what the running bits say of
// wheels without power, and which wheel a fault switches off. Each is compared with its comment in
// sim/zlac8015d/options.hpp.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/zlac8015d_bench.hpp>

namespace sim_zlac8015d_interpretations_tests {

using namespace servobus;
using namespace zlac8015d_bench;
using switches = sim::zlac8015d_options;

TEST_CASE(
    "B31: after a stop input that releases the shafts the running bits are set while the wheels roll, or "
    "they are 0 without power") {
    for (const auto interpretation :
         {switches::running::turns, switches::running::driven, switches::running::enabled}) {
        CAPTURE(static_cast<int>(interpretation));
        bench b{{.bit = interpretation}};
        b.set(map::input_stop, 1);
        b.set(map::quick_stop_option_code, 7); // immediate
        b.begin(operating_mode::velocity);
        CHECK(b.write(0x2088, {100, 100}) == 0);
        b.run(1500);
        CHECK(b.status().left.is_running);
        CHECK(b.status().right.is_running);
        b.drive.set_input(true, false);
        b.run(5);
        CHECK(b.get(map::left_actual_speed) > 900); // 0.1 r/min
        CHECK(b.get(map::right_actual_speed) > 900);
        const bool is_set = interpretation == switches::running::turns;
        CHECK(b.status().left.is_running == is_set);
        CHECK(b.status().right.is_running == is_set);
        b.run(5000);
        CHECK(b.get(map::left_actual_speed) == 0);
        CHECK_FALSE(b.status().is_running());
    }
}

TEST_CASE("B31: during a quick stop that brakes the wheels the running bits are set if they say that the "
          "wheels are driven") {
    bench b{{.bit = switches::running::driven}};
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, 100}) == 0);
    b.run(1500);
    b.command(control_code::quick_stop);
    b.run(2);
    CHECK(b.status().left.is_running);
    b.run(500);
    CHECK_FALSE(b.status().is_running());
}

TEST_CASE("B33: if a fault switches only its wheel off, a start moves the other wheel alone") {
    for (const bool is_left : {true, false}) {
        CAPTURE(is_left);
        bench b{{.by_fault = switches::switched_off::its_wheel}};
        b.set(map::position_synchronisation, 1);
        b.begin(operating_mode::relative_position);
        b.drive.raise(is_left ? fault::overcurrent : fault::none, is_left ? fault::none : fault::overcurrent);
        CHECK(b.drive.enabled());
        CHECK((b.status().left.shaft == shaft_state::alarm) == is_left);
        CHECK((b.status().right.shaft == shaft_state::alarm) == !is_left);
        CHECK(b.write(0x208A, {0, 1000, 0, 1000}) == 0);
        b.command(control_code::start_both);
        b.run(2000);
        CHECK(b.get(map::left_actual_position) == (is_left ? 0 : 1000));
        CHECK(b.get(map::right_actual_position) == (is_left ? 1000 : 0));
        b.set(map::position_synchronisation, 0);
        b.command(is_left ? control_code::start_left : control_code::start_right);
        b.run(2000);
        CHECK(b.get(map::left_actual_position) == (is_left ? 0 : 1000));
        CHECK(b.get(map::right_actual_position) == (is_left ? 1000 : 0));
        CHECK(b.drive.starts() == 1);
    }
}

TEST_CASE("B33: if a fault switches only its wheel off, faults of both wheels disable the drive") {
    for (const bool is_left_first : {true, false}) {
        CAPTURE(is_left_first);
        bench b{{.by_fault = switches::switched_off::its_wheel}};
        b.begin(operating_mode::velocity);
        CHECK(b.write(0x2088, {100, 100}) == 0);
        b.run(1500);
        b.drive.raise(is_left_first ? fault::hall : fault::none, is_left_first ? fault::none : fault::hall);
        b.run(500);
        CHECK(b.drive.enabled());
        const int left = is_left_first ? 0 : 1000; // 0.1 r/min
        CHECK(b.get(map::left_actual_speed) == left);
        CHECK(b.get(map::right_actual_speed) == 1000 - left);
        b.drive.raise(fault::hall, fault::hall);
        CHECK_FALSE(b.drive.enabled());
        CHECK(b.status().left.shaft == shaft_state::alarm);
        CHECK(b.status().right.shaft == shaft_state::alarm);
        b.command(control_code::enable);
        CHECK_FALSE(b.drive.enabled());
        b.drive.end_faults();
        b.command(control_code::fault_reset);
        CHECK(b.status().left.shaft == shaft_state::released); // and not enabled by itself
        CHECK(b.status().right.shaft == shaft_state::released);
    }
}

} // namespace sim_zlac8015d_interpretations_tests
