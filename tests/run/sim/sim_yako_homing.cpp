// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The limits and the homing of the simulated YAKOTEC steppers: limit switches, software limits, every homing
// method, the offset, and the ends of a homing.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>

#include <servobus/sim/yako.hpp>

#include <tests/support/simulated_yako.hpp>
#include <tests/support/yako_bench.hpp>

namespace sim_yako_homing_tests {

using namespace servobus;
using namespace yako_bench;

// Limits

TEST_CASE_TEMPLATE("a limit stops its own direction as 0017h defines", B, BOTH) {
    for (const bool coasts : {true, false}) {
        for (const int direction : {1, -1}) {
            CAPTURE(coasts);
            CAPTURE(direction);
            B b;
            b.set(cl::over_travel_stop_mode, coasts ? 0 : 1);
            b.set(cl::jog_speed, 60 * direction);
            b.command(motion_code::jog());
            b.run(200);
            b.drive.set_input(direction > 0 ? 2 : 1, true); // the other one
            b.run(10);
            CHECK(b.status().is_moving());
            b.drive.set_input(direction > 0 ? 1 : 2, true);
            const std::int64_t at = b.drive.view().shaft;
            b.run(1);
            CHECK(b.status().is_enabled() == !coasts);
            b.run(3000);
            CHECK(!b.status().is_moving());
            CHECK((b.drive.view().shaft == at) == !coasts);
            b.command(auxiliary::enable);
            const std::int64_t rest = b.drive.view().shaft;
            b.command(motion_code::jog());
            b.run(100);
            CHECK(b.drive.view().shaft == rest);
            b.drive.set_input(direction > 0 ? 2 : 1, false);
            b.command(auxiliary::enable);
            b.set(cl::jog_speed, -60 * direction); // away from it
            b.command(motion_code::jog());
            b.run(100);
            CHECK(b.drive.view().shaft != rest);
        }
    }
}

TEST_CASE_TEMPLATE("software limits apply after homing", B, BOTH) {
    B b;
    b.set(cl::over_travel_stop_mode, 1);
    b.set(cl::positive_software_limit, 500);
    b.set(cl::negative_software_limit, -400);
    b.set(cl::software_limits, 1);
    b.move(1000);
    b.run_until_still();
    CHECK(b.position() == 1000);
    CHECK(!b.status().is_beyond_positive_limit());
    b.set(cl::homing_method, 35);
    b.command(motion_code::home());
    b.run(10);
    b.move(1000);
    b.run_until_still();
    CHECK(about(b.position(), 502, 2));
    CHECK(b.status().is_beyond_positive_limit());
    b.move(10);
    b.run(100);
    CHECK(about(b.position(), 502, 2));
    b.move(-5000);
    b.run(200);
    CHECK(!b.status().is_beyond_positive_limit());
    b.run_until_still();
    CHECK(about(b.position(), -402, 2));
    CHECK(b.status().is_beyond_negative_limit());
    CHECK(b.status().is_enabled());
    b.set(cl::software_limits, 0);
    CHECK(!b.status().is_beyond_negative_limit());
}

// Homing

namespace {

enum class edge { left, right, positive_limit, negative_limit };

// The home position of each method, by the summary of appendix 1 and by CiA 402.
struct expected_home {
    int method; // without index; method - 16 is with index
    edge at;
    int direction;
    bool is_rising;
};
constexpr expected_home homes[] = {
    {17, edge::negative_limit, 1, false},
    {18, edge::positive_limit, -1, false},
    {19, edge::left, -1, false},
    {20, edge::left, 1, true},
    {21, edge::right, 1, false},
    {22, edge::right, -1, true},
    {23, edge::left, -1, false},
    {24, edge::left, 1, true},
    {25, edge::right, -1, true},
    {26, edge::right, 1, false},
    {27, edge::right, 1, false},
    {28, edge::right, -1, true},
    {29, edge::left, 1, true},
    {30, edge::left, -1, false},
};

sim::yako_machine machine_for(int method) {
    sim::yako_machine m = simulated::yako_slide();
    if (method == 19 || method == 20) m.home_to = sim::yako_machine::nowhere;
    if (method == 21 || method == 22) m.home_from = -sim::yako_machine::nowhere;
    return m;
}

std::int64_t place_of(const expected_home& h, const sim::yako_machine& m) {
    const int beyond = h.is_rising ? 0 : h.direction; // the first pulse at which it is inactive
    switch (h.at) {
    case edge::left: return m.home_from + beyond;
    case edge::right: return m.home_to + beyond;
    case edge::positive_limit: return m.positive_limit + beyond;
    default: return m.negative_limit + beyond;
    }
}

std::int64_t next_index(std::int64_t at, int direction, const sim::yako_machine& m) {
    do { at += direction; } while ((at - m.index) % 1000 != 0);
    return at;
}

template <class B> void stand_at(B& b, const sim::yako_machine& m, std::int64_t place) {
    b.drive.attach(m);
    b.drive.push_shaft(place);
    b.drive.power_cycle();
    REQUIRE(b.drive.view().shaft == place);
    REQUIRE(b.position() == 0);
}

template <class B> void home(B& b, int method) {
    b.set(cl::over_travel_stop_mode, 1);
    b.set(cl::homing_fast_speed, 300);
    b.set(cl::homing_slow_speed, 60);
    b.set(cl::homing_ramp_time, 50);
    b.set(cl::homing_method, method);
    b.command(motion_code::home());
    b.run(5);
    b.run_until_still();
}

template <class B> void check_homing(int method, const expected_home& h) {
    const sim::yako_machine m = machine_for(h.method);
    for (const std::int64_t start : {-4200, -3000, -100, 240, 3100, 4200}) {
        // Methods 19..22 search on one side only.
        if ((h.method == 21 || h.method == 22 || h.method == 17) && start > m.positive_limit) continue;
        if ((h.method == 19 || h.method == 20 || h.method == 18) && start < m.negative_limit) continue;
        CAPTURE(method);
        CAPTURE(start);
        B b;
        stand_at(b, m, start);
        home(b, method);
        const std::int64_t place = place_of(h, m);
        CHECK(b.status().is_homed());
        CHECK(b.status().is_in_position());
        CHECK(b.drive.view().home == (method < 17 ? next_index(place, h.direction, m) : place));
        CHECK(b.drive.view().home_direction == h.direction);
        CHECK(b.drive.view().shaft == b.drive.view().home);
        CHECK(b.position() == 0);
    }
}

} // namespace

TEST_CASE_TEMPLATE("homing to an edge ends there, wherever it starts", B, BOTH) {
    for (const expected_home& h : homes) check_homing<B>(h.method, h);
}

TEST_CASE("homing to an index pulse ends at the first one after the edge") {
    for (const expected_home& h : homes) check_homing<closed>(h.method - 16, h);
}

TEST_CASE("homing finds a switch that is narrower than the stopping distance") {
    for (const expected_home& h : homes) {
        if (h.method < 23) continue;
        CAPTURE(h.method);
        for (const int start : {-3000, 3000}) {
            sim::yako_machine m = simulated::yako_slide();
            m.home_from = -5;
            m.home_to = 5;
            open b;
            stand_at(b, m, start);
            home(b, h.method);
            CHECK(b.status().is_homed());
            CHECK(b.drive.view().home == place_of(h, m));
        }
    }
}

TEST_CASE("methods 33 and 34 end at the next index pulse, 35 at the present position") {
    for (const int method : {33, 34, 35}) {
        CAPTURE(method);
        closed b;
        stand_at(b, simulated::yako_slide(), 350);
        home(b, method);
        CHECK(b.status().is_homed());
        CHECK(b.drive.view().home == (method == 33 ? 100 : method == 34 ? 1100 : 350));
        CHECK(b.position() == 0);
    }
}

TEST_CASE("collision homing moves against the hard stop, and back to the index pulse for -1 and -2") {
    constexpr std::int64_t wanted[] = {-4900, 4100, -5000, 5000};
    for (int i = 0; i < 4; ++i) {
        CAPTURE(i);
        closed b;
        sim::yako_machine m = simulated::yako_slide();
        m.negative_limit = -m.nowhere;
        m.positive_limit = m.nowhere;
        stand_at(b, m, 350);
        home(b, -1 - i);
        CHECK(b.status().is_homed());
        CHECK(!b.status().has_alarm());
        CHECK(b.drive.view().home == wanted[i]);
        CHECK(b.drive.view().shaft == wanted[i]);
    }
}

TEST_CASE("0030h: each of the twelve modes gives the right offset move and position") {
    for (int mode = 0; mode < 12; ++mode) {
        CAPTURE(mode);
        constexpr std::int64_t offset = -120;
        open b;
        stand_at(b, simulated::yako_slide(), -1000);
        b.set(cl::homing_offset_mode, mode);
        b.set(cl::home_offset, offset);
        home(b, 24);
        const bool moves = mode < 6;
        const std::int64_t actual = -250 + 1000 + (moves ? offset : 0); // the counter's own
        const std::int64_t wanted[] = {offset, 0, -offset, actual, actual + offset, actual - offset};
        CHECK(b.status().is_homed());
        CHECK(b.drive.view().home == -250);
        CHECK(b.drive.view().shaft == -250 + (moves ? offset : 0));
        CHECK(b.position() == wanted[mode % 6]);
    }
}

TEST_CASE("homing uses the parameters of the time of its command") {
    open b;
    stand_at(b, simulated::yako_slide(), -1000);
    b.set(cl::homing_fast_speed, 60);
    b.set(cl::home_offset, 100);
    b.set(cl::homing_offset_mode, 8);
    b.command(motion_code::home());
    b.run(300);
    b.set(cl::homing_fast_speed, 3000);
    b.set(cl::homing_method, 17);
    b.set(cl::home_offset, 200);
    b.set(cl::homing_offset_mode, 0);
    CHECK(b.speed() == 60);
    b.run_until_still();
    CHECK(b.drive.view().home == -250);
    CHECK(b.position() == -100);
}

TEST_CASE("the counter of an open loop drive continues during a homing, and lost steps do not disturb the "
          "homing") {
    open b;
    stand_at(b, simulated::yako_slide(), -1000);
    b.drive.push_shaft(77);
    b.set(cl::homing_offset_mode, 9);
    home(b, 24);
    CHECK(b.drive.view().shaft == -250);
    CHECK(b.position() == 1000 - 250 - 77);
}

TEST_CASE("the homed bit falls when homing begins, and stays 0 after a stop or at a limit on the wrong "
          "side") {
    open b;
    stand_at(b, simulated::yako_slide(), -1000);
    home(b, 24);
    CHECK(b.status().is_homed());
    b.command(motion_code::home());
    b.run(10);
    CHECK(!b.status().is_homed());
    CHECK(b.status().is_moving());
    b.command(motion_code::stop());
    b.run_until_still();
    CHECK(!b.status().is_homed());

    open c; // method 19 searches forward only
    sim::yako_machine m = simulated::yako_slide();
    stand_at(c, m, 1000);
    home(c, 19);
    CHECK(!c.status().is_homed());
    CHECK(!c.status().is_moving());
    CHECK(c.drive.view().shaft >= m.positive_limit);
}

TEST_CASE("homing methods 5, 6, 21 and 22 that begin on the wrong side end at the limit") {
    for (const int method : {5, 6, 21, 22}) {
        closed b;
        sim::yako_machine m = simulated::yako_slide();
        stand_at(b, m, -1000);
        home(b, method);
        CHECK(!b.status().is_homed());
        CHECK(about(b.drive.view().shaft, m.negative_limit, 3));
    }
}

TEST_CASE("homing that meets both limits and no switch ends at the second limit") {
    open b;
    sim::yako_machine m = simulated::yako_slide();
    m.home_from = m.home_to = m.nowhere;
    stand_at(b, m, 0);
    home(b, 23);
    CHECK(!b.status().is_homed());
    CHECK(!b.status().is_moving());
    CHECK(about(b.drive.view().shaft, m.negative_limit, 3));
}

TEST_CASE("homing works with a home switch that the test sets at a terminal") {
    open b;
    b.set(cl::homing_method, 19);
    b.command(motion_code::home());
    b.run(500);
    b.drive.set_input(0, true);
    b.run(1);
    b.drive.set_input(0, false); // before the motor has reversed
    b.run(500);
    CHECK(b.speed() == -60);
    b.drive.set_input(0, true);
    b.run(10);
    b.drive.set_input(0, false);
    b.run(2);
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home_direction == -1);
}

TEST_CASE("homing without a wired switch ends at the hard stop, where open loop loses steps unnoticed") {
    open b;
    sim::yako_machine m = simulated::yako_slide();
    m.home_input = m.positive_limit_input = m.negative_limit_input = m.not_wired;
    stand_at(b, m, 0);
    home(b, 24);
    CHECK(b.drive.view().shaft == 5000);
    CHECK(b.drive.view().position > 50'000);
    CHECK(b.status().is_moving());
}

TEST_CASE(
    "one limit switch that is wired stops the motor there, and the other direction ends at the hard stop") {
    for (const int wired : {1, -1}) {
        for (const int direction : {1, -1}) {
            CAPTURE(wired);
            CAPTURE(direction);
            open b;
            sim::yako_machine m = simulated::yako_slide();
            m.home_input = (wired > 0 ? m.negative_limit_input : m.positive_limit_input) = m.not_wired;
            stand_at(b, m, 0);
            b.set(cl::over_travel_stop_mode, 1);
            b.set(cl::jog_speed, 300 * direction);
            b.command(motion_code::jog());
            b.run(5000);
            CHECK(b.status().is_moving() == (wired != direction));
            CHECK(about(b.drive.view().shaft, (wired == direction ? 4000 : 5000) * direction, 10));
        }
    }
}

TEST_CASE("normally closed switches need their polarity set") {
    sim::yako_machine m = simulated::yako_slide();
    m.are_normally_closed = true;
    open b;
    stand_at(b, m, -1000);
    CHECK(b.get(ol::input_state).to_word() == 7); // all read as active
    b.set(ol::input_polarity, 7);
    CHECK(b.get(ol::input_state).to_word() == 0);
    home(b, 24);
    CHECK(b.drive.view().home == -250);
}

TEST_CASE("homing with reversed direction works if the limit inputs are swapped") {
    sim::yako_machine m = simulated::yako_slide();
    m.positive_limit_input = 2;
    m.negative_limit_input = 1;
    open b;
    stand_at(b, m, 2000);
    b.set(cl::motion_direction, 1);
    home(b, 24); // its left edge is the machine's right one
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home == 250);
    CHECK(b.drive.view().home_direction == 1);
}

TEST_CASE("an input starts homing") {
    open b;
    stand_at(b, simulated::yako_slide(), 1000);
    assign(b, 4, input_function::homing);
    press(b, 4);
    b.run_until_still();
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home == -250);
}

} // namespace sim_yako_homing_tests
