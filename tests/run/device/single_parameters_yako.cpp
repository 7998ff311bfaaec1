// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// `set<row>` of YAKOTEC steppers, microsteps and direction, which make each position another one, collision homing and
// the gains of the current loop. Judged by the frames, the registers and the shaft of the simulated drive.
#include <array>
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/control/take_over.hpp>
#include <servobus/device/yako/arguments.hpp>
#include <servobus/device/yako/axis_drive.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace single_parameters_yako_tests {

using namespace servobus;
using namespace servobus::literals;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using simulated::closed_axis;
using simulated::open_axis;

namespace {

template <const auto& R> register_value<R> value_of(std::int64_t count) {
    using type = typename row_type<R>::value_type;
    if constexpr (wire_integer<type>)
        return checked(raw(static_cast<std::int32_t>(count)));
    else
        return checked(from_bits<type>(static_cast<u32>(count)));
}

// Returns how many rows need a free motor.
template <const auto& R, class Axis> unsigned play() {
    CAPTURE(R.address);
    const std::int64_t count = R.initial == R.limits.low ? R.limits.high : R.limits.low + 1;
    const set<R> wanted{value_of<R>(count)};
    Axis a;
    CHECK(a.drive.run(wanted).error() == errc::needs_init);
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(wanted));
    const auto word = static_cast<u16>(count);
    CHECK(a.model.peek(R.address) == word);
    CHECK(a.sent(modbus::write_frame(1, R.address, word)) == 1);
    CHECK(same_bytes(a.requests.back(), modbus::read_frame(1, R.address, 1)));
    CHECK(a.drive.state() == drive_state::disabled);

    Axis e;
    enabled_yako::take(e);
    REQUIRE(e.drive.run(velocity{60 * r_per_min}));
    const errc why = e.drive.run(wanted).error();
    const bool is_tuned = R.address != 0x0100 && R.address != 0x0101;
    CHECK(why == (is_tuned ? errc::ok : errc::wrong_state));
    CHECK((e.model.peek(R.address) == word) == is_tuned);
    CHECK(e.sent(modbus::write_frame(1, R.address, word)) == (is_tuned ? 1u : 0u));
    return is_tuned ? 0 : 1;
}

} // namespace

TEST_CASE("each row that set takes is written once and read back, where the drive's state allows it") {
    namespace cl = yako::closed_loop;
    unsigned free_motors = 0;
    const auto play_closed = [&]<const auto&... Rs>() { ((free_motors += play<Rs, closed_axis>()), ...); };
    play_closed.operator()<cl::collision_threshold, cl::collision_current, cl::closed_loop_algorithm,
                           cl::encoder_resolution, cl::max_current, cl::closed_loop_max_current, base_current,
                           open_loop_max_current, cl::holding_current, cl::holding_delay, io_filter_factor,
                           pulse_low_pass_factor, cl::following_error_limit, cl::position_window,
                           in_position_time, pulse_averaging_factor, current_loop_kp_multiplier,
                           current_loop_kc, cl::la_speed_kp_1, cl::la_position_ki>();
    CHECK(free_motors == 2);
    namespace ol = yako::open_loop;
    CHECK(play<ol::max_current, open_axis>() == 0);
    CHECK(play<ol::holding_current, open_axis>() == 0);
    CHECK(play<at<ol::segment_start_speeds, 3>, open_axis>() == 0);
    CHECK(play<base_current, open_axis>() == 0);
}

TEST_CASE("microsteps and direction are set while the motor is free, and no position outlives them") {
    for (const bool is_direction : {false, true}) {
        CAPTURE(is_direction);
        closed_axis a;
        enabled_yako::take_homed(a);
        REQUIRE(a.drive.run(move_to{500 * pulse, brisk}));
        REQUIRE(a.drive.run(wait_reached{}));
        const auto put = [&] {
            return is_direction ? a.drive.run(set_direction{direction::reversed})
                                : a.drive.run(set_microsteps{2000});
        };
        CHECK(put().error() == errc::wrong_state); // energised
        REQUIRE(a.drive.run(disable{}));
        const std::size_t frames = a.requests.size();
        REQUIRE(put());
        CHECK(a.requests.size() > frames);
        CHECK(a.model.peek(is_direction ? 0x0010 : 0x0011) == (is_direction ? 1 : 2000));
        CHECK(a.drive.state() == drive_state::needs_init);
        CHECK(a.drive.arrival().how == arrival_state::none);
        CHECK(a.drive.feedback(milliseconds(10'000)).error() == errc::needs_init);
        CHECK(a.drive.run(move_to{500 * pulse, brisk}).error() == errc::needs_init);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(enable{}));
        CHECK(a.drive.run(move_to{500 * pulse, brisk}).error() == errc::needs_homing);
        CHECK(a.drive.cached().microsteps == (is_direction ? 1000 : 2000));
    }
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.run(set_microsteps{checked(399)}).error() == errc::out_of_range);
    CHECK(why(a.drive, set_microsteps{checked(399)}).argument.address == 0x0011);
    CHECK(a.drive.run(set_direction{static_cast<direction>(2)}).error() == errc::out_of_range);
    CHECK(why(a.drive, set_direction{static_cast<direction>(2)}).argument.address == 0x0010);
}

TEST_CASE(
    "G42: an axis keeps no rest over new microsteps, and is not taken over with a number that it denies") {
    static constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000})); // 5 um a pulse
    // Four ways of 2 um are 1.6 pulses, which are two.
    const auto moved = [](bool sets) {
        simulated::simulated_closed_loop world;
        yako::closed_loop::axis_drive lift{world.line, 1, screw, unsupervised};
        const auto take = [&] { return lift.run(init{}) && lift.run(enable{}); };
        REQUIRE(take());
        for (int i = 0; i < 4; ++i) {
            REQUIRE(
                lift.run(move_by{2_um, {.top = 50_mm_per_s, .acceleration = 50_ms, .deceleration = 50_ms}}));
            REQUIRE(lift.run(wait_standstill{}));
            if (!sets) continue;
            REQUIRE(lift.run(disable{}));
            REQUIRE(lift.run(set_microsteps{1000}));
            REQUIRE(take());
        }
        return world.model.view().position;
    };
    CHECK(moved(false) == 2);
    CHECK(moved(true) == 0);

    simulated::simulated_closed_loop world;
    yako::closed_loop::axis_drive lift{world.line, 1, screw, unsupervised};
    REQUIRE(lift.run(init{}));
    REQUIRE(lift.run(disable{}));
    REQUIRE(lift.run(set_microsteps{2000}));
    CHECK(lift.run(init{}).error() == errc::unexpected_value);
    CHECK(lift.state() == drive_state::needs_init);
}

TEST_CASE("collision homing and the current loop are set in one frame each") {
    namespace cl = yako::closed_loop;
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(cl::set_collision_homing{300, 40 * percent}));
    CHECK(a.sent(modbus::write_frame(1, 0x003B, std::array<u16, 2>{300, 40})) == 1);
    CHECK(a.model.peek(0x003C) == 40);
    REQUIRE(a.drive.run(set_current_loop{1, 900, 40, 5}));
    CHECK(a.sent(modbus::write_frame(1, 0x010E, std::array<u16, 4>{1, 900, 40, 5})) == 1);
    CHECK(a.model.peek(0x0111) == 5);
    const std::size_t frames = a.requests.size();
    const cl::set_collision_homing weak{300, checked(10 * percent)};
    CHECK(a.drive.run(weak).error() == errc::out_of_range);
    CHECK(why(a.drive, weak).argument.address == 0x003C);
    CHECK(a.drive.run(set_current_loop{1, checked(-1), 40, 5}).error() == errc::out_of_range);
    CHECK(why(a.drive, set_current_loop{1, checked(-1), 40, 5}).argument.address == 0x010F);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    CHECK(a.drive.run(cl::set_collision_homing{300, 40 * percent}).error() == errc::busy);
}

TEST_CASE("single parameters are settings of a take-over") {
    closed_axis a;
    const auto ready = a.drive.run(take_over{disable{}, set<yako::closed_loop::max_current>{3 * ampere},
                                             set<yako::closed_loop::holding_current>{60 * percent}, save{}});
    CHECK(ready);
    CHECK(a.model.peek(0x0102) == 3000);
    CHECK(a.model.peek(0x0106) == 60);
    CHECK(a.model.saves() == 1);
    CHECK_FALSE(a.model.enabled());
}

} // namespace single_parameters_yako_tests
