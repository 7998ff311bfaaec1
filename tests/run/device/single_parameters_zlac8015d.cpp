// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// `set<row>` of a ZLAC8015D: each row that it takes is written and read back in one state of the drive and refused in
// another; the rows that it does not take are in tests/fail. The currents of both motors.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <doctest/doctest.h>

#include <servobus/control/command_text.hpp>
#include <servobus/device/zlac8015d/arguments.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_zlac8015d.hpp>
#include <tests/support/frame_port.hpp>

namespace single_parameters_zlac8015d_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using rig = simulated::driven_zlac8015d;

namespace {

template <const auto& R> register_value<R> value_of(std::int64_t count) {
    using type = typename row_type<R>::value_type;
    if constexpr (wire_integer<type>)
        return checked(raw(static_cast<std::int32_t>(count)));
    else
        return checked(from_bits<type>(static_cast<u32>(count)));
}
// Another value than the drive has.
template <const auto& R> constexpr std::int64_t another() {
    return R.initial == R.limits.low ? R.limits.high : R.limits.low;
}

// Rows that are set while the wheels turn, too: of the left motor 2032h..2040h and 2046h..204Ah, and the driver's
// temperature limit.
constexpr bool is_tuned(u16 address) {
    const unsigned left = address >= 0x2060 ? address - 0x30u : address;
    return (left >= 0x2032 && left <= 0x2040) || (left >= 0x2046 && left <= 0x204A) || address == 0x201E;
}
constexpr bool is_line_count(u16 address) { return address == 0x2030 || address == 0x2060; }

struct counts {
    unsigned rows = 0, tuned = 0, forgotten = 0;
};

template <const auto& R> void play(counts& seen) {
    CAPTURE(R.address);
    const auto bits = static_cast<u16>(another<R>());
    const set<R> wanted{value_of<R>(another<R>())};
    rig r;
    CHECK(r.drive.run(wanted).error() == errc::needs_init);
    REQUIRE(r.drive.run(init{}));
    r.log.frames.clear();
    REQUIRE(r.drive.run(wanted));
    CHECK(r.model.peek(R.address) == bits);
    // One write, and the last frame reads it back.
    CHECK(r.sent(modbus::write_frame(1, R.address, bits)) == 1);
    CHECK(same_bytes(r.log.frames.back(), modbus::read_frame(1, R.address, 1)));
    CHECK(r.log.frames.size() == (is_tuned(R.address) ? 2u : 3u));
    CHECK((r.drive.state() == drive_state::needs_init) == is_line_count(R.address));
    ++seen.rows;
    if (is_line_count(R.address)) ++seen.forgotten;

    rig e;
    enabled_zlac8015d::be_enabled_in(e, operating_mode::velocity);
    REQUIRE(e.drive.run(velocity{20 * r_per_min, 20 * r_per_min}));
    const std::size_t frames = e.log.frames.size();
    const errc why = e.drive.run(wanted).error();
    if (is_tuned(R.address)) {
        ++seen.tuned;
        CHECK(why == errc::ok);
        CHECK(e.model.peek(R.address) == bits);
        CHECK(e.drive.state() == drive_state::enabled);
    } else {
        CHECK(why == errc::wrong_state);
        CHECK(e.log.frames.size() == frames);
        const refusal said = servobus::why(e.drive, wanted);
        CHECK(said.is_of_state());
        CHECK(said.states.has(drive_state::disabled));
        CHECK_FALSE(said.states.has(drive_state::enabled));
    }
}
template <const auto&... Rs> counts play_all() {
    counts seen;
    (play<Rs>(seen), ...);
    return seen;
}

/// A drive of which one register reads as another word than was written, or that refuses to write it.
struct odd_drive : sim::zlac8015d {
    u16 odd = 0;
    bool refuses = false;

    static constexpr modbus::server_rules rules() { return {}; }
    constexpr std::uint8_t read(u16 address, slice<u16> to) {
        const std::uint8_t exception = sim::zlac8015d::read(address, to);
        if (odd >= address && odd < address + to.size()) to[odd - address] = 7;
        return exception;
    }
    constexpr std::uint8_t write(u16 address, words_view from) {
        return refuses ? std::uint8_t{3} : sim::zlac8015d::write(address, from);
    }
};

} // namespace

TEST_CASE("each row that set takes is written once and read back, where the drive's state allows it") {
    const counts seen =
        play_all<shaft_at_power_on, max_motor_speed, can_node_address, can_baud, shutdown_option_code,
                 disable_option_code, halt_option_code, input_polarity, x0_function, x1_function,
                 output_polarities, y0_function, y1_function, driver_temperature_limit, pwm_on_alarm,
                 overload_handling, speed_deviation_monitoring, left_encoder_lines, left_hall_offset_angle,
                 left_overload_factor, left_rated_current, left_max_current, left_overload_time,
                 left_following_error_limit, left_speed_smoothing, left_current_loop_kp, left_current_loop_ki,
                 left_feedforward_smoothing, left_torque_smoothing, left_speed_kp, left_speed_ki,
                 left_speed_kf, left_position_kp, left_position_kf, left_start_speed,
                 left_position_start_speed, left_pole_pairs, left_motor_temperature_limit,
                 left_speed_observer_1, left_speed_observer_4, right_encoder_lines, right_hall_offset_angle,
                 right_overload_factor, right_max_current, right_position_kf, right_start_speed,
                 right_pole_pairs, right_motor_temperature_limit, right_speed_observer_4>();
    CHECK(seen.rows == 49);
    CHECK(seen.tuned == 24);
    CHECK(seen.forgotten == 2);
}

TEST_CASE("set changes what the facade has cached: the top speed limits the next speeds") {
    rig r;
    r.have_resolution(10);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(set<max_motor_speed>{300}));
    REQUIRE(r.drive.run(enable{}));
    const std::size_t frames = r.log.frames.size();
    CHECK(r.drive.run(velocity{301 * r_per_min, 0 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.log.frames.size() == frames);
    REQUIRE(r.drive.run(velocity{300 * r_per_min, 0 * r_per_min}));
    CHECK(r.model.peek(0x2088) == 3000); // tenths, as before
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(resolution{10})); // as it is
    CHECK(r.drive.cached().max_speed == 300);
}

TEST_CASE("G32: a value out of range is refused by set, and why names the register and its range") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    const std::size_t frames = r.log.frames.size();
    const set<left_max_current> wanted{checked(30'100 * milliampere)};
    CHECK(r.drive.run(wanted).error() == errc::out_of_range);
    const refusal said = why(r.drive, wanted);
    CHECK(said.is_of_value());
    CHECK(said.argument.address == 0x2034);
    CHECK(said.argument.limits.high == 300);
    CHECK(r.drive.run(set<left_max_current>{checked(1'050 * milliampere)}).error() == errc::inexact);
    CHECK(r.log.frames.size() == frames);
    CHECK(std::string_view{command_text<set<left_max_current>>} == "set");
}

TEST_CASE("G16: set ends as unexpected, refused or unknown where the drive does not do it") {
    SUBCASE("the register holds another value afterwards") {
        simulated::frame_port<odd_drive> port{odd_drive{}};
        line on{port, modbus::timing_at(port.baud)};
        zlac8015d::drive drive{on, 1, unsupervised};
        REQUIRE(drive.run(init{}));
        port.model.odd = left_speed_kp.address;
        const command_status got = drive.run(set<left_speed_kp>{600});
        CHECK(got.error() == errc::unexpected_value);
        CHECK(got.outcome() == outcome::unknown);
        CHECK(got.register_address() == left_speed_kp.address);
        CHECK(drive.state() == drive_state::needs_init);
    }
    SUBCASE("it is refused") {
        simulated::frame_port<odd_drive> port{odd_drive{}};
        line on{port, modbus::timing_at(port.baud)};
        zlac8015d::drive drive{on, 1, unsupervised};
        REQUIRE(drive.run(init{}));
        port.model.refuses = true;
        const command_status got = drive.run(set<left_speed_kp>{600});
        CHECK(got.outcome() == outcome::refused);
        CHECK(got.exception() == 3);
        CHECK(drive.state() == drive_state::disabled);
    }
    SUBCASE("its response is lost") {
        rig r;
        REQUIRE(r.drive.run(init{}));
        r.wire.faults().lost_response = 1000;
        const command_status got = r.drive.run(set<left_speed_kp>{600});
        r.wire.faults() = {};
        CHECK(got.outcome() == outcome::unknown);
        CHECK(r.sent(modbus::write_frame(1, left_speed_kp.address, 600)) == 1); // G15
        CHECK(r.drive.state() == drive_state::needs_init);
    }
}

TEST_CASE("a row that is set at standstill is not written while a wheel turns") {
    simulated::frame_port<odd_drive> port{odd_drive{}};
    line on{port, modbus::timing_at(port.baud)};
    zlac8015d::drive drive{on, 1, unsupervised};
    REQUIRE(drive.run(init{}));
    port.model.odd = status_word.address; // 7: the right wheel turns
    CHECK(drive.run(set<left_pole_pairs>{10}).error() == errc::busy);
    CHECK(port.model.peek(left_pole_pairs.address) == 15);
    CHECK(drive.state() == drive_state::disabled);
    REQUIRE(drive.run(set<left_speed_kp>{600}));
}

TEST_CASE("current_limits sets both currents of both motors, each pair in one frame") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(current_limits{12 * ampere, 24'500 * milliampere}));
    CHECK(r.sent(modbus::write_frame(1, 0x2033, std::array<u16, 2>{120, 245})) == 1);
    CHECK(r.sent(modbus::write_frame(1, 0x2063, std::array<u16, 2>{120, 245})) == 1);
    for (const u16 a : {u16{0x2033}, u16{0x2063}}) CHECK(r.model.peek(a) == 120);
    for (const u16 a : {u16{0x2034}, u16{0x2064}}) CHECK(r.model.peek(a) == 245);
    const std::size_t frames = r.log.frames.size();
    const current_limits upside_down{12 * ampere, 10 * ampere};
    CHECK(r.drive.run(upside_down).error() == errc::bad_argument);
    CHECK(why(r.drive, upside_down).argument.address == 0x2034);
    CHECK(r.drive.run(current_limits{16 * ampere, 20 * ampere}).error() == errc::out_of_range);
    CHECK(r.drive.run(current_limits{12 * ampere, 31 * ampere}).error() == errc::out_of_range);
    CHECK(r.drive.run(current_limits{12'050 * milliampere, 20 * ampere}).error() == errc::inexact);
    CHECK(r.log.frames.size() == frames);
    const current_limits as_much{12 * ampere, 12 * ampere};
    CHECK(why(r.drive, as_much).argument.address == 0);
    REQUIRE(r.drive.run(as_much));
    REQUIRE(r.drive.run(enable{}));
    CHECK(r.drive.run(current_limits{12 * ampere, 20 * ampere}).error() == errc::wrong_state);
}

} // namespace single_parameters_zlac8015d_tests
