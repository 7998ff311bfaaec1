// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade against its simulator: speed, torque, position and speed segments, steps, jog and homing,
// 64-bit positions, and the stop after a command timeout.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/enabled_c630s.hpp>

namespace drive_c630s_motion_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using enabled_c630s::be_enabled_in;
using enabled_c630s::p31;
using rig = simulated::driven_c630s;

namespace {

// The model's gear rounds a position to one unit.
bool is_about(std::int64_t a, std::int64_t b) { return a - b <= 3 && b - a <= 3; }

} // namespace

TEST_CASE("S2: segments run cyclically only if the program requests it by name") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(segment{1, 1000 * reference_unit, 300 * r_per_min}));
    REQUIRE(r.drive.run(position_segments{}));
    REQUIRE(r.drive.run(enable_in{control_mode::position, position_source::segments, segment_mode::cyclic}));
    REQUIRE(r.drive.run(start_segments{}));
    r.wire.pass(milliseconds(3000));
    REQUIRE(r.drive.read());
    CHECK(r.drive.feedback(milliseconds(2000))->position.count() > 3000);
    REQUIRE(r.drive.run(quick_stop{}));
    CHECK(r.model.stands_still());
    CHECK(r.drive.state() == drive_state::disabled); // the run would otherwise continue by itself
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.run(start_segments{}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.stands_still());
}

TEST_CASE("velocity commands obey the limits and ramps of the drive in both directions") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    CHECK(r.drive.run(velocity{5001 * r_per_min}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(top_speeds{1000 * r_per_min, 800 * r_per_min, 200 * r_per_min}));
    const auto frames = r.requests.size();
    CHECK(r.drive.run(velocity{801 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{-201 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{2'000'000'000 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.requests.size() == frames);
    REQUIRE(r.drive.run(ramps{100 * millisecond, 100 * millisecond}));
    REQUIRE(r.drive.run(velocity{-200 * r_per_min}));
    REQUIRE(r.live(milliseconds(800)));
    CHECK(r.r_per_min() == -200);
    CHECK(r.drive.run(torque{1 * percent}).error() == errc::wrong_state);
    CHECK(r.drive.run(start_segment{1}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.model.stands_still());
}

TEST_CASE("torque commands obey the torque limits, and the speed is limited") {
    rig r;
    be_enabled_in(r, control_mode::torque);
    REQUIRE(r.drive.run(torque_speed_limits{100 * r_per_min, 100 * r_per_min}));
    REQUIRE(r.drive.run(torque_limits{30 * percent, 20 * percent}));
    CHECK(r.drive.run(torque{31 * percent}).error() == errc::out_of_range);
    CHECK(r.drive.run(torque{-21 * percent}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(torque{255 * part<10>(percent)}));
    CHECK(r.model.peek(target_torque.address) == 255);
    REQUIRE(r.live(milliseconds(1000)));
    CHECK(r.r_per_min() == 100);
    REQUIRE(r.drive.run(halt{}));
    CHECK(r.r_per_min() <= 2); // the motor coasts without torque
    CHECK(r.model.enabled());
}

TEST_CASE("6.1.3: the manual's example of 80000 units, and moves by each of the sixteen segments") {
    rig r;
    be_enabled_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{1, 80'000 * reference_unit, 3000 * r_per_min}));
    CHECK(r.model.peek(position_segment_displacements[0].address) == 80'000);
    std::int64_t at = 0;
    for (int n = 1; n <= 16; ++n) {
        CAPTURE(n);
        const distance way = (n % 2 == 0 ? -100 : 300) * n * reference_unit;
        REQUIRE(r.drive.run(segment{checked(n), way, 600 * r_per_min, 10 * millisecond, 0 * millisecond}));
        REQUIRE(r.drive.run(start_segment{checked(n)}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.drive.read());
        at += way.count();
        CHECK(is_about(r.drive.feedback(milliseconds(2000))->position.count(), at));
        CHECK(r.drive.feedback(milliseconds(2000))->following_error.count() == 0);
    }
    CHECK(r.model.starts() == 16);
    CHECK(r.drive.run(segment{checked(17), 1 * reference_unit, 1 * r_per_min}).error() == errc::bad_argument);
    CHECK(r.drive.run(start_segment{checked(0)}).error() == errc::bad_argument);
    CHECK(r.drive.run(start_segment{checked(-1)}).error() == errc::bad_argument);
    CHECK(r.drive.run(segment{1, 1 * reference_unit, 0 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(segment{1, 1 * reference_unit, 1 * r_per_min, 0 * millisecond, 10'001 * millisecond})
              .error() == errc::out_of_range);
    CHECK(r.drive.run(segment{1, 1'073'741'825 * reference_unit, 1 * r_per_min}).error() ==
          errc::out_of_range);
}

TEST_CASE("6.1.3: a start while the motor moves is refused; the displacement of an absolute segment is a "
          "position") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(position_segments{displacement_type::absolute}));
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.run(segment{2, 50'000 * reference_unit, 600 * r_per_min, 100 * millisecond}));
    REQUIRE(r.drive.run(segment{3, 1000 * reference_unit, 600 * r_per_min, 100 * millisecond}));
    REQUIRE(r.drive.run(start_segment{2}));
    r.wire.pass(milliseconds(200));
    CHECK(r.drive.run(start_segment{3}).error() == errc::busy);
    CHECK(r.drive.run(halt{}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.run(start_segment{3}));
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.read());
    CHECK(is_about(r.drive.feedback(milliseconds(2000))->position.count(), 1000));
    CHECK(r.model.starts() == 2);
    CHECK(r.drive.run(position_segments{}).error() == errc::wrong_state); // only with the servo off
}

TEST_CASE("the segment inputs hold for at least 5 ms before the start, and so does the start input") {
    rig r;
    be_enabled_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{5, 100 * reference_unit, 60 * r_per_min}));
    struct watcher {
        std::vector<std::uint64_t> times; // when a write of P31-00 was on the wire
        rig::frame open;
    } seen;
    r.wire.set_hook(
        [](void* self, const sim::wire_byte& b) {
            if (!b.is_from_client) return;
            auto& w = *static_cast<watcher*>(self);
            w.open.push_back(b.value);
            if (w.open.size() != modbus::request_length(w.open)) return;
            if (w.open[1] == 0x06 && load_word(w.open, 2) == p31) w.times.push_back(b.at_us);
            w.open.clear();
        },
        &seen);
    REQUIRE(r.drive.run(start_segment{5}));
    REQUIRE(seen.times.size() == 3);
    CHECK(seen.times[1] - seen.times[0] >= 5000);
    CHECK(seen.times[2] - seen.times[1] >= 5000);
}

TEST_CASE("make_step moves by one step with an edge of FunIN.20") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(step_size{-1234 * reference_unit}));
    CHECK(r.drive.run(step_size{10'000 * reference_unit}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(enable_in{control_mode::position, position_source::step}));
    CHECK(r.drive.run(start_segment{1}).error() == errc::wrong_state);
    for (int i = 0; i < 3; ++i) {
        REQUIRE(r.drive.run(make_step{}));
        REQUIRE(r.drive.run(wait_standstill{}));
    }
    REQUIRE(r.drive.read());
    CHECK(is_about(r.drive.feedback(milliseconds(2000))->position.count(), -3702));
    CHECK(r.drive.run(step_size{5 * reference_unit}).error() == errc::wrong_state);
}

TEST_CASE("6.2.3: speed segments run only by their own command, and inputs change them") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(speed_segment{3, 120 * r_per_min, 5 * second}));
    REQUIRE(r.drive.run(speed_segment{4, -60 * r_per_min, 5 * second, segment_ramp::ramp_2}));
    REQUIRE(r.drive.run(segment_ramp_times{segment_ramp::ramp_2, 20 * millisecond, 20 * millisecond}));
    CHECK(r.model.peek(segment_acceleration_time_2.address) == 20);
    CHECK(r.drive.run(speed_segment{3, 1 * r_per_min, 50 * millisecond}).error() == errc::inexact);
    CHECK(r.drive.run(select_speed_segment{4}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(run_speed_segments{segment_mode::by_input, 3}));
    REQUIRE(r.live(milliseconds(800)));
    CHECK(r.r_per_min() == 120);
    CHECK(r.drive.run(velocity{1 * r_per_min}).error() == errc::wrong_state);
    CHECK(r.drive.run(halt{}).error() == errc::wrong_state);
    CHECK(r.drive.run(speed_segment{3, 1 * r_per_min, 1 * second}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(select_speed_segment{4}));
    REQUIRE(r.live(milliseconds(800)));
    CHECK(r.r_per_min() == -60);
    SUBCASE("disable") { REQUIRE(r.drive.run(disable{})); }
    SUBCASE("emergency stop") { REQUIRE(r.drive.run(quick_stop{})); }
    CHECK(r.model.stands_still());
    CHECK_FALSE(r.model.enabled());
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.stands_still());
}

TEST_CASE("6.2.3: a speed segment is selected only in the mode in which inputs select it") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(run_speed_segments{segment_mode::cyclic, 1, 2}));
    const std::uint16_t inputs = r.drive.cached().inputs;
    CHECK(r.drive.run(select_speed_segment{3}).error() == errc::wrong_state);
    CHECK(r.model.peek(virtual_input_levels.address) == inputs);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(run_speed_segments{segment_mode::by_input, 1}));
    REQUIRE(r.drive.run(select_speed_segment{3}));
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    CHECK(r.drive.run(select_speed_segment{3}).error() == errc::wrong_state);
}

TEST_CASE("a jog runs until a halt, in both directions") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    CHECK(r.drive.run(jog{5001 * r_per_min}).error() == errc::out_of_range);
    for (const int way : {30, -20}) {
        REQUIRE(r.drive.run(jog{way * r_per_min}));
        REQUIRE(r.live(milliseconds(600)));
        CHECK(r.r_per_min() == way);
        REQUIRE(r.drive.run(halt{}));
        CHECK(r.model.stands_still());
        CHECK(r.model.enabled());
        CHECK(r.model.peek(p31) == (terminal::servo_on | terminal::marker));
    }
    REQUIRE(r.drive.run(velocity{10 * r_per_min}));
    REQUIRE(r.live(milliseconds(300)));
    CHECK(r.r_per_min() == 10);
}

namespace {

void be_before_home_switch(rig& r) {
    REQUIRE(r.make_ready());
    r.model.attach(
        {.home_from = 200'000, .home_to = 260'000, .negative_limit = -900'000, .positive_limit = 900'000});
    REQUIRE(r.drive.run(homing_by{homing_mode::forward_home_switch, 300 * r_per_min, 60 * r_per_min,
                                  100 * millisecond, 30'000}));
}

} // namespace

TEST_CASE("a homing whose start got no response is stopped") {
    rig r;
    be_before_home_switch(r);
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.begin(home{30 * second}) == errc::ok);
    bool was_struck = false;
    for (int i = 0; i < 100'000 && !r.drive.is_idle(); ++i) {
        const auto& f = r.requests.back();
        const bool is_start =
            f[1] != 0x03 && load_word(bytes{f}, 2) == homing_control.address && f[f.size() - 3] != 0;
        was_struck = was_struck || is_start;
        r.wire.faults().lost_response = is_start ? 1000 : 0;
        r.turn();
    }
    CHECK(was_struck);
    CHECK(r.drive.last().outcome() == outcome::unknown);
    r.wire.faults().lost_response = 0;
    r.loop(3000);
    CHECK(r.model.stands_still());
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("homing on a switch waits for the end and confirms it; a homing that does not end is switched "
          "off") {
    rig r;
    be_before_home_switch(r);
    CHECK(r.drive.run(home{10 * second}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    SUBCASE("found") {
        REQUIRE(r.drive.run(home{30 * second}));
        REQUIRE(r.drive.read());
        CHECK(r.drive.feedback(milliseconds(2000))->state.is_home());
        CHECK(r.drive.feedback(milliseconds(2000))->position.count() == 0);
        CHECK(r.model.homings() == 1);
        CHECK(r.model.peek(homing_control.address) == 0);
        REQUIRE(r.drive.run(segment{1, 300 * reference_unit, 60 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.drive.run(home_electrically{10 * second}));
        REQUIRE(r.drive.read());
        CHECK(r.drive.feedback(milliseconds(2000))->state.is_electrically_home());
    }
    SUBCASE("not found in time") {
        CHECK(r.drive.run(home{200 * millisecond}).error() == errc::not_reached);
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        CHECK(r.drive.state() == drive_state::needs_init);
    }
    SUBCASE("the present position") {
        REQUIRE(r.drive.run(segment{1, 300 * reference_unit, 60 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.drive.run(set_home{}));
        REQUIRE(r.drive.read());
        CHECK(r.drive.feedback(milliseconds(2000))->position.count() == 0);
    }
    CHECK(r.drive.run(home{0 * second}).outcome() == outcome::not_sent);
}

TEST_CASE("64-bit positions are read in one frame, in either word order") {
    for (const word_order_setting order : {word_order_setting::low_first, word_order_setting::high_first}) {
        rig r;
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.store<pair_word_order>(checked(order)));
        be_enabled_in(r, control_mode::position);
        REQUIRE(r.drive.run(segment{1, -25'000 * reference_unit, 3000 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        const auto frames = r.requests.size();
        const auto there = r.drive.read(wide_position::mechanical);
        REQUIRE(there);
        CHECK(r.requests.size() == frames + 2); // one of them reads the word order
        CHECK(*there == r.model.position());
        CHECK(*there < 0);
        REQUIRE(r.drive.read(wide_position::encoder));
        REQUIRE(r.drive.read(wide_position::load));
        REQUIRE(r.drive.read());
        CHECK(is_about(r.drive.feedback(milliseconds(2000))->position.count(), -25'000));
        r.wire.faults().lost_response = 1000;
        CHECK(r.drive.read(wide_position::mechanical).error() == errc::timeout);
    }
}

TEST_CASE("a response to 10h that carries the byte count, as the manual prints it, is accepted") {
    rig r{{.echoes_byte_count = true}};
    be_enabled_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{16, 500 * reference_unit, 60 * r_per_min}));
    REQUIRE(r.drive.run(start_segment{16}));
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.run(disable{}));
}

TEST_CASE("G20: after the command timeout the drive is stopped: by a halt, or in position mode by an "
          "emergency stop") {
    rig r;
    SUBCASE("speed") {
        be_enabled_in(r, control_mode::speed);
        r.drive.set_command_timeout(milliseconds(400));
        REQUIRE(r.drive.run(velocity{300 * r_per_min}));
        r.loop(200);
        CHECK_FALSE(r.model.stands_still());
        r.loop(2000);
        CHECK(r.model.enabled());
    }
    SUBCASE("jog") {
        be_enabled_in(r, control_mode::speed);
        r.drive.set_command_timeout(milliseconds(400));
        REQUIRE(r.drive.run(jog{50 * r_per_min}));
        r.loop(200);
        CHECK_FALSE(r.model.stands_still());
        r.loop(2000);
        CHECK(r.model.peek(p31) == (terminal::servo_on | terminal::marker));
    }
    SUBCASE("a run of segments") {
        REQUIRE(r.make_ready());
        REQUIRE(
            r.drive.run(enable_in{control_mode::position, position_source::segments, segment_mode::cyclic}));
        r.drive.set_command_timeout(milliseconds(400));
        REQUIRE(r.drive.run(segment{1, 500'000 * reference_unit, 300 * r_per_min}));
        REQUIRE(r.drive.run(start_segments{}));
        r.loop(200);
        CHECK_FALSE(r.model.stands_still());
        r.loop(2000);
        CHECK(r.drive.state() == drive_state::disabled); // the run would continue after a quick stop
    }
    SUBCASE("a single move ends by itself") {
        be_enabled_in(r, control_mode::position);
        r.drive.set_command_timeout(milliseconds(400));
        REQUIRE(r.drive.run(segment{1, 20'000 * reference_unit, 60 * r_per_min}));
        REQUIRE(r.drive.begin(start_segment{1}) == errc::ok);
        r.loop(1000);
        CHECK_FALSE(r.model.stands_still());
        REQUIRE(r.drive.run(wait_reached{}));
        CHECK(r.drive.arrival().how == arrival_state::reached);
    }
    CHECK(r.model.stands_still());
    r.loop(1000);
    CHECK(r.model.stands_still());
}

TEST_CASE("each field of the feedback is what the motor does, in both directions") {
    for (const std::int32_t speed : {300, -450}) {
        CAPTURE(speed);
        rig r;
        be_enabled_in(r, control_mode::speed);
        REQUIRE(r.drive.run(velocity{speed * r_per_min}));
        r.wire.pass(milliseconds(1000));
        const auto seen = r.drive.read();
        REQUIRE(seen);
        CHECK(seen->commanded_speed == speed * r_per_min);
        CHECK(seen->speed == speed * r_per_min);
        CHECK(seen->fine_speed.count() == 10 * speed); // in 0.1 r/min
        CHECK(seen->state.is_rotating());
        CHECK(seen->state.is_brake_released());
        CHECK(seen->alarm_code == 0);
        const std::int64_t units = r.model.position() * 10'000 / 131'072; // a turn in the factory's gear
        CHECK(seen->position.count() / 1000 ==
              doctest::Approx(static_cast<double>(units / 1000)).epsilon(0.02));
        CHECK((seen->position.count() < 0) == (speed < 0));
    }
}

TEST_CASE("S1: the first write of a disable is what stops the motor in its mode") {
    struct scene {
        control_mode mode;
        u16 address;
        u16 word;
    };
    for (const scene& s : {scene{control_mode::position, emergency_stop.address, 1},
                           scene{control_mode::speed, target_speed.address, 0},
                           scene{control_mode::torque, target_torque.address, 0}}) {
        CAPTURE(s.address);
        rig r;
        be_enabled_in(r, s.mode);
        r.requests.clear();
        REQUIRE(r.drive.run(disable{}));
        std::size_t first = 0;
        while (first < r.requests.size() && !modbus::is_write(r.requests[first][1])) ++first;
        REQUIRE(first < r.requests.size());
        CHECK(load_word(r.requests[first], 2) == s.address);
        const bool is_single = r.requests[first][1] == 0x06;
        CHECK(load_word(r.requests[first], is_single ? 4 : 7) == s.word);
        CHECK_FALSE(r.model.enabled());
    }
}

TEST_CASE("a drive that has run speed segments takes speeds again once it is enabled for them") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(run_speed_segments{}));
    r.wire.pass(milliseconds(300));
    CHECK(r.drive.begin(velocity{100 * r_per_min}) != errc::ok);
    CHECK(r.drive.begin(halt{}) != errc::ok);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.drive.run(velocity{100 * r_per_min}));
    r.wire.pass(milliseconds(500));
    CHECK(r.r_per_min() == 100);
    REQUIRE(r.drive.run(halt{}));
    CHECK(r.model.stands_still());
    r.requests.clear();
    REQUIRE(r.drive.run(disable{}));
    CHECK(load_word(r.requests.front(), 2) == target_speed.address); // as in speed mode
}

} // namespace drive_c630s_motion_tests
