// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades with a drive that reports something else than what happens: registers that read as
// values that they cannot have, a homed state that is left from an earlier homing, motions that inputs begin.
#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace drive_yako_states_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::take;
using enabled_yako::take_homed;
using simulated::closed_axis;
using simulated::open_axis;

namespace {

/// A drive of which one register may read as a value that it cannot have.
template <class Model> struct odd : Model {
    using Model::Model;
    u16 odd_address = 0;
    u16 odd_word = 0; // 0: the register reads normally

    constexpr std::uint8_t read(u16 address, std::span<u16> to) {
        const std::uint8_t exception = Model::read(address, to);
        if (odd_word != 0 && odd_address >= address && odd_address < address + to.size())
            to[odd_address - address] = odd_word;
        return exception;
    }
};
using odd_axis = simulated::driven_yako<odd<sim::yako_closed_loop>, closed_loop::drive>;

} // namespace

TEST_CASE("init refuses a drive whose settings read as invalid values, and the drive is not moved") {
    for (const u16 address :
         {software_limits.address, pair_word_order.address, closed_loop::speed_resolution.address}) {
        CAPTURE(address);
        odd_axis a;
        take_homed(a);
        const std::uint32_t starts = a.model.starts();
        a.model.odd_address = address;
        a.model.odd_word = 2;
        const command_status got = a.drive.run(init{});
        CHECK(got.error() == errc::unexpected_value);
        CHECK(a.drive.state() == drive_state::needs_init);
        CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
        CHECK(a.model.starts() == starts);
        a.model.odd_word = 0;
        REQUIRE(a.drive.run(init{}));
    }
}

TEST_CASE("4.1: a command waits for a move in reverse that begins late") {
    closed_axis a{{.start_delay = milliseconds(50)}};
    take(a);
    REQUIRE(a.drive.run(move_by{-1000 * pulse, brisk}));
    CHECK(a.drive.motion() == motion_check::seen);
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == -1000);
}

TEST_CASE_TEMPLATE("4.1: a wait for standstill shows an alarm, which frees the motor", A, closed_axis,
                   open_axis) {
    A a;
    take(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    a.run(500);
    REQUIRE(a.is_moving());
    a.model.raise_alarm(1);
    const command_status seen = a.drive.run(wait_standstill{});
    CHECK(seen.error() == errc::faulted);
    CHECK(seen.register_address() == status_word.address); // the alarm is there
    CHECK(a.model.alarm() == 1);
    CHECK_FALSE(a.model.enabled());
}

TEST_CASE("4.3: a homing does not count as done while the drive still reports the previous one") {
    closed_axis a{{.start_delay = milliseconds(150)}};
    a.model.attach(simulated::yako_slide());
    take(a);
    REQUIRE(a.drive.run(declare_position{3000 * pulse}));
    REQUIRE(a.model.view().is_homed);
    REQUIRE(a.drive.run(set_homing_profile{300 * r_per_min, 60 * r_per_min}));
    const std::uint64_t start = a.wire.time_us();
    REQUIRE(a.drive.run(closed_loop::home{homing::home_24}));
    CHECK(a.wire.time_us() - start > 200'000);
    CHECK(a.place() == 0);
    CHECK(a.drive.cached().is_homed);
}

TEST_CASE("S4: a declare_position that the drive acknowledges and does not execute is reported") {
    closed_axis a{{.start_delay = milliseconds(3000)}};
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    CHECK(a.drive.run(declare_position{0 * pulse}).error() == errc::not_executed);
    a.run(4000); // now it is executed: the drive reports that it is homed
    REQUIRE(a.model.view().is_homed);
    CHECK(a.drive.run(declare_position{500 * pulse}).error() == errc::not_executed);
    CHECK_FALSE(a.drive.cached().is_homed);
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
}

TEST_CASE("4.3: a homing ends only at standstill, also if an input moves the motor away from home") {
    closed_axis a;
    a.model.attach(simulated::yako_slide());
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::jog_positive}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(set_homing_profile{300 * r_per_min, 60 * r_per_min}));
    REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
    while (!a.model.view().is_homed) a.turn();
    a.model.set_input(3, true);
    for (int i = 0; i < 2000; ++i) a.turn();
    REQUIRE(a.is_moving());
    CHECK_FALSE(a.drive.is_idle());
    a.model.set_input(3, false);
    a.finish();
    CHECK(a.drive.last());
    CHECK_FALSE(a.is_moving());
    CHECK(a.drive.cached().is_homed);
}

TEST_CASE("4.3: after a homing beyond its time limit whose stop gets no response, the outcome is unknown and "
          "init is needed") {
    closed_axis a; // no machine is attached: the motor turns for ever
    take(a);
    REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
    const closed_loop::home wanted{
        homing::home_24, {}, offset_handling::move_position_zero, milliseconds(1000)};
    REQUIRE(a.drive.begin(wanted) == errc::ok);
    const auto stop_frame = hex("01 06 00 27 01 00 38 51");
    while (!a.drive.is_idle()) {
        if (a.sent(stop_frame) > 1) a.wire.faults().lost_response = 1000; // the first stop was that of init
        a.turn();
    }
    CHECK(a.wire.struck() != 0);
    a.wire.faults() = {};
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.drive.last().error() == errc::timeout);
    CHECK(a.drive.motion() != motion_check::not_asked);
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.model.starts() == 1);
    REQUIRE(a.drive.run(init{}));
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("S4: an absolute set_input_move is refused for an open loop motor that an input has freed") {
    open_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::motor_free}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
    REQUIRE(a.drive.run(set_input_move{700 * pulse, brisk, positioning::absolute}));
    a.model.set_input(3, true);
    a.run(10);
    const auto held = a.model.peek(target_position.address);
    CHECK(a.drive.run(set_input_move{900 * pulse, brisk, positioning::absolute}).error() ==
          errc::needs_homing);
    CHECK(a.model.peek(target_position.address) == held);
    CHECK_FALSE(a.drive.cached().is_homed);
}

TEST_CASE("5.1: a clear_position after which the position is not zero is reported as not executed") {
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    a.begin_up_to(clear_position{}, 3);
    while (a.model.writes_to(auxiliary_command.address) < 2) a.turn(); // the release was the first
    a.model.push_shaft(100);
    a.finish();
    CHECK(a.drive.last().error() == errc::not_executed);
    CHECK(a.drive.last().outcome() == outcome::unknown);
}

TEST_CASE("4.3: a second declare_position waits for the drive to execute it") {
    closed_axis a{{.start_delay = milliseconds(100)}};
    take_homed(a);
    const command_status r = a.drive.run(declare_position{500 * pulse});
    CHECK(r);
    CHECK(a.drive.cached().is_homed);
    REQUIRE(a.drive.read());
    CHECK(a.drive.feedback(milliseconds(2000))->position == 500 * pulse);
}

TEST_CASE("4.1: a short move counts as made although the shaft has yet to come to rest") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.begin(move_by{20 * pulse, brisk}) == errc::ok);
    while (a.model.starts() == 0) a.turn();
    while (!a.is_moving()) a.run(1);
    while (a.is_moving()) a.run(1);
    a.model.push_shaft(600); // it returns to its position
    a.finish();
    CHECK(a.drive.last());
    CHECK(a.drive.motion() == motion_check::seen);
    CHECK(a.place() == 20);
}

TEST_CASE_TEMPLATE("4.1: a move that ends before its target is reported, and a jog that stops is too", A,
                   closed_axis, open_axis) {
    for (const bool is_jog : {false, true}) {
        A a;
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(disable{}));
        REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::stop}));
        REQUIRE(a.drive.run(enable{}));
        REQUIRE((is_jog ? a.drive.begin(velocity{600 * r_per_min})
                        : a.drive.begin(move_by{900 * pulse, brisk})) == errc::ok);
        while (a.model.starts() == 0) a.turn();
        while (a.place() < 8) a.run(1);
        a.model.set_input(3, true);
        while (a.is_moving()) a.run(1);
        a.finish();
        CHECK(a.drive.last().error() == errc::not_reached);
        CHECK(a.drive.last().outcome() == outcome::unknown);
        CHECK(a.drive.motion() == motion_check::unknown);
        CHECK(a.drive.state() == drive_state::enabled); // the rest of the cached state is valid
    }
}

TEST_CASE_TEMPLATE("A55: a move that a restart interrupts is reported, although all registers are kept", A,
                   closed_axis, open_axis) {
    for (const std::int32_t sign : {1, -1}) {
        CAPTURE(sign);
        A a{{.kept = sim::yako_kept::written}};
        take(a);
        REQUIRE(a.drive.run(move_by{sign * 30 * pulse, brisk}));
        REQUIRE(a.drive.run(wait_standstill{}));
        REQUIRE(a.drive.begin(move_by{sign * 900 * pulse, brisk}) == errc::ok);
        while (a.model.starts() < 2) a.turn();
        a.model.power_cycle(); // its position is zero
        a.finish();
        CHECK(a.drive.last().error() == errc::not_reached);
        CHECK(a.drive.motion() == motion_check::unknown);
        CHECK(a.drive.state() == drive_state::needs_init);
    }
}

TEST_CASE("4.3: a second homing that does not change the position is confirmed only if the homed bit was "
          "seen to fall") {
    for (const bool falls : {true, false}) {
        closed_axis a{{.homed = falls ? sim::yako_homed::until_homing : sim::yako_homed::always}};
        a.model.attach(simulated::yako_slide());
        take(a);
        REQUIRE(a.drive.run(declare_position{3000 * pulse}));
        REQUIRE(a.drive.run(set_homing_profile{300 * r_per_min, 60 * r_per_min}));
        const command_status r = a.drive.run(
            closed_loop::home{homing::home_24, 700 * pulse, offset_handling::stay_position_actual});
        CHECK(static_cast<bool>(r) == falls); // A54: otherwise it cannot be distinguished from an interrupted
                                              // one short
        if (!falls) CHECK(r.error() == errc::not_reached);
        CHECK(a.drive.cached().is_homed == falls);
        using enum offset_handling;
        for (const auto then : {stay_position_offset, stay_position_zero, stay_position_negative_offset,
                                move_position_offset, move_position_negative_offset}) {
            const bool stays = then >= stay_position_offset;
            REQUIRE(a.drive.run(closed_loop::home{homing::home_24, (stays ? -70'000 : -700) * pulse, then}));
            CHECK(a.drive.cached().is_homed);
        }
    }
}

TEST_CASE("G21: stops of a drive of which nothing is known leave it so") {
    closed_axis a;
    const auto check_unknown = [&] {
        const std::size_t sent = a.requests.size();
        CHECK(a.drive.run(enable{}).error() == errc::needs_init);
        CHECK(a.requests.size() == sent);
    };
    REQUIRE(a.drive.run(halt{}));
    check_unknown();
    REQUIRE(a.drive.run(disable{}));
    check_unknown();
    REQUIRE(a.drive.run(quick_stop{}));
    check_unknown();
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.run(enable{}));
}

TEST_CASE("a homing needs its profile again after the drive counts speeds otherwise") {
    closed_axis a;
    take(a);
    const closed_loop::home here{homing::current_position};
    CHECK(a.drive.run(here));
    REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
    CHECK(a.drive.run(here).error() == errc::wrong_state);
    REQUIRE(a.drive.run(set_homing_profile{90 * r_per_min, 20 * r_per_min}));
    CHECK(a.drive.run(here));
}

} // namespace drive_yako_states_tests
