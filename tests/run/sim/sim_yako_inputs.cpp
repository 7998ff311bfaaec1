// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The inputs and outputs of the simulated YAKOTEC steppers: stops, moves, speeds and segments by inputs, and
// the functions of outputs.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>

#include <tests/support/yako_bench.hpp>

namespace sim_yako_inputs_tests {

using namespace servobus;
using namespace yako_bench;

TEST_CASE("0008h shows active inputs, four of closed loop and seven of open loop") {
    closed c;
    open o;
    for (unsigned i = 0; i < 8; ++i) {
        c.drive.set_input(i, true);
        o.drive.set_input(i, true);
    }
    CHECK(c.drive.peek(0x0008) == 0x0F);
    CHECK(o.drive.peek(0x0008) == 0x7F);
    o.set(ol::input_polarity, 0x21);
    CHECK(o.drive.peek(0x0008) == 0x5E);
}

TEST_CASE("an input frees the motor while it is active") {
    closed b;
    assign(b, 3, input_function::motor_free);
    b.command(motion_code::jog());
    b.run(200);
    press(b, 3);
    CHECK(!b.status().is_enabled());
    b.run(3000);
    b.command(motion_code::jog());
    b.run(20);
    CHECK(!b.status().is_moving());
    let_go(b, 3);
    CHECK(b.status().is_enabled());
    CHECK(!b.status().is_moving());

    b.command(motion_code::jog());
    b.run(300);
    press(b, 3);
    b.command(auxiliary::release); // stays in effect after the input
    let_go(b, 3);
    CHECK(!b.status().is_enabled());
    CHECK(b.speed() > 0);
}

TEST_CASE("stop and emergency stop inputs stop the motor, and prevent starts") {
    for (const input_function f : {input_function::stop, input_function::emergency_stop}) {
        closed b;
        assign(b, 3, f);
        b.set(cl::jog_deceleration_time, 500);
        b.command(motion_code::jog());
        b.run(200);
        press(b, 3);
        CHECK(b.status().is_moving() == (f == input_function::stop));
        b.run(600);
        CHECK(!b.status().is_moving());
        CHECK(b.status().is_enabled());
        b.command(motion_code::jog());
        b.run(20);
        CHECK(!b.status().is_moving());
        CHECK(b.drive.starts() == 1);
        let_go(b, 3);
        CHECK(!b.status().is_moving());
        b.command(motion_code::jog());
        b.run(20);
        CHECK(b.status().is_moving());
    }
}

TEST_CASE("the edge of an input starts the position move, relative or absolute by 0050h") {
    open b;
    assign(b, 6, input_function::position_move);
    b.set(cl::target_position, 300);
    press(b, 6);
    CHECK(b.status().is_moving());
    b.run_until_still();
    CHECK(b.position() == 300);
    let_go(b, 6);
    CHECK(b.drive.starts() == 1);
    b.set(cl::io_positioning, 1);
    press(b, 6);
    b.run_until_still();
    CHECK(b.position() == 300);
    b.set(cl::io_positioning, 0);
    let_go(b, 6);
    b.command(motion_code::jog());
    b.run(500);
    const std::int64_t at = b.drive.view().commanded;
    press(b, 6); // 5.4: a fixed length from here
    b.run_until_still();
    CHECK(about(b.drive.view().commanded, at + 300, 2));
}

TEST_CASE("speed inputs run the motor while they are active") {
    struct {
        input_function f;
        int sign;
    } const cases[] = {{input_function::speed_move, -1},
                       {input_function::jog_positive, 1},
                       {input_function::jog_negative, -1}};
    for (const auto& c : cases) {
        closed b;
        assign(b, 3, c.f);
        b.set(cl::jog_speed, -200);
        press(b, 3);
        b.run(200);
        CHECK(b.speed() == 200 * c.sign);
        let_go(b, 3);
        b.run(100);
        CHECK(!b.status().is_moving());
        b.command(auxiliary::release);
        press(b, 3);
        CHECK(!b.status().is_moving());
        b.command(auxiliary::enable); // the input is still active: the motor runs
        b.run(20);
        CHECK(b.status().is_moving());
        b.command(motion_code::stop()); // the motor does not start again by itself
        b.run(500);
        CHECK(!b.status().is_moving());
        CHECK(b.drive.starts() == 2);
    }
}

TEST_CASE("a PT trigger starts the position segment that PIN0..PIN3 select") {
    for (std::size_t segment = 0; segment < 16; ++segment) {
        CAPTURE(segment);
        open b;
        assign(b, 0, input_function::pt_trigger);
        for (unsigned pin = 0; pin < 4; ++pin) {
            assign(b, 3 + pin, static_cast<input_function>(14 + pin));
            b.drive.set_input(3 + pin, (segment >> pin & 1u) != 0);
        }
        const auto target = static_cast<std::int64_t>(100 + 10 * segment);
        b.set(ol::position_segment_targets[segment], target);
        b.set(ol::position_segment_speeds[segment], 90);
        b.set(ol::position_segment_acceleration_times[segment], 0);
        b.run(10);
        press(b, 0);
        CHECK(b.speed() == 90);
        b.run_until_still();
        CHECK(b.position() == target);
        b.set(ol::position_segment_positionings[segment], 1);
        let_go(b, 0);
        press(b, 0);
        b.run_until_still();
        CHECK(b.position() == target); // absolute: it is already there
    }
}

TEST_CASE("a position segment of open loop begins with the start speed at 0130h + n") {
    open b;
    assign(b, 0, input_function::pt_trigger);
    b.set(ol::segment_start_speeds[0], -45);
    b.set(ol::position_segment_acceleration_times[0], 2000);
    b.run(10);
    b.drive.set_input(0, true);
    b.run(8);
    CHECK(about(b.speed(), 45, 1));
}

TEST_CASE("PIN inputs must hold from 5 ms before the trigger to 5 ms after it") {
    for (const int shift : {-6, -4, 4, 6}) { // ms from the trigger to the change
        CAPTURE(shift);
        closed b;
        assign(b, 0, input_function::pt_trigger);
        assign(b, 3, input_function::pin0);
        b.run(30);
        if (shift < 0) {
            b.drive.set_input(3, true);
            b.run(static_cast<std::uint32_t>(-shift));
        }
        b.drive.set_input(0, true);
        b.run(static_cast<std::uint32_t>(shift > 0 ? shift : 1));
        if (shift > 0) b.drive.set_input(3, true);
        b.run(20);
        CHECK(b.status().is_moving() == (std::abs(shift) == 6));
    }
}

TEST_CASE("a PV trigger runs a speed segment while it is active, and changes it with the PIN inputs") {
    closed b;
    assign(b, 0, input_function::pv_trigger);
    assign(b, 3, input_function::pin0);
    b.set(cl::speed_segment_speeds[0], 60);
    b.set(cl::speed_segment_speeds[1], -90);
    b.run(10);
    press(b, 0);
    b.run(100);
    CHECK(b.speed() == 60);
    press(b, 3);
    b.run(300);
    CHECK(b.speed() == -90);
    let_go(b, 0);
    b.run(200);
    CHECK(!b.status().is_moving());
}

TEST_CASE("with 0051h = 1 a PV edge starts a speed segment, and PT may interrupt it") {
    closed b;
    assign(b, 0, input_function::pv_trigger);
    assign(b, 1, input_function::pt_trigger);
    assign(b, 2, input_function::speed_segment_direction);
    b.set(cl::pv_trigger_mode, 1);
    b.set(cl::position_segment_targets[0], 500);
    b.drive.set_input(2, true);
    b.run(10);
    press(b, 0);
    let_go(b, 0);
    b.run(200);
    CHECK(b.speed() == -100);
    const std::int64_t at = b.drive.view().commanded;
    press(b, 1);
    b.run_until_still();
    CHECK(about(b.drive.view().commanded, at + 500, 15));
    CHECK(!b.status().is_moving());
}

TEST_CASE("outputs show their function, and 004Bh inverts their level") {
    open b;
    const auto is_on = [&](output_function f) {
        b.set(ol::y2_function, f);
        CHECK(b.drive.output(2) == (b.drive.peek(0x0009) == 4));
        return b.drive.output(2);
    };
    using enum output_function;
    CHECK(is_on(brake));
    CHECK(!is_on(alarm));
    CHECK(!is_on(driver_status));
    CHECK(!is_on(homing_complete));
    CHECK(!is_on(undefined));
    b.run(20);
    CHECK(is_on(in_position));
    b.set(ol::user_outputs, 5);
    CHECK(is_on(user_0));
    CHECK(!is_on(user_1));
    CHECK(is_on(user_2));
    b.command(motion_code::jog());
    b.run(10);
    CHECK(is_on(driver_status));
    CHECK(!is_on(in_position));
    b.command(motion_code::emergency_stop());
    b.set(ol::homing_method, 35);
    b.command(motion_code::home());
    b.run(10);
    CHECK(is_on(homing_complete));
    b.drive.raise_alarm(3);
    CHECK(is_on(alarm));
    CHECK(!is_on(brake));
    b.set(ol::output_polarity, 7);
    b.set(ol::y2_function, alarm);
    CHECK(!b.drive.output(2));
    CHECK(b.drive.output(0));
    CHECK(b.drive.peek(0x0009) == 4);
    CHECK(!b.drive.output(3));
}

} // namespace sim_yako_inputs_tests
