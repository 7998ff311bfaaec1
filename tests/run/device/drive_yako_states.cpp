// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades where the drive's word is not what happens: registers that read as what they cannot
// hold, a homing that the drive still reports of an earlier one, motions that inputs begin in between.
#include <doctest/doctest.h>

#include <tests/support/yako_axis.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using simulated::closed_axis;
using simulated::open_axis;

namespace {

const motion_profile brisk{10 * r_per_min, 50 * millisecond, 50 * millisecond, 600 * r_per_min};

template <class Axis> void take(Axis& a) {
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.model.enabled());
}
template <class Axis> void take_homed(Axis& a) {
    take(a);
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
}

/// A drive of which one register may read as something that it cannot hold.
template <class Model> struct odd : Model {
    using Model::Model;
    u16 odd_address = 0;
    u16 odd_word = 0; // none as long as it is 0

    constexpr std::uint8_t read(u16 address, std::span<u16> to) {
        const std::uint8_t exception = Model::read(address, to);
        if (odd_word != 0 && odd_address >= address && odd_address < address + to.size())
            to[odd_address - address] = odd_word;
        return exception;
    }
};
using odd_axis = simulated::yako_axis<odd<sim::yako_closed_loop>, closed_loop::drive>;

} // namespace

TEST_CASE("a drive whose settings read as none of their values is not taken over, and not moved") {
    for (const u16 address :
         {software_limits.address, pair_word_order.address, closed_loop::speed_resolution.address}) {
        CAPTURE(address);
        odd_axis a;
        take_homed(a);
        const std::uint32_t starts = a.model.starts();
        a.model.odd_address = address;
        a.model.odd_word = 2;
        CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
        const report got = a.drive.run(init{});
        CHECK(got.error() == errc::unexpected_value);
        CHECK(a.drive.state() == drive_state::needs_init);
        CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
        CHECK(a.model.starts() == starts);
        a.model.odd_word = 0;
        REQUIRE(a.drive.run(init{}));
    }
}

TEST_CASE("4.1 a move in reverse that begins late is waited for") {
    closed_axis a{{.start_delay = milliseconds(50)}};
    take(a);
    REQUIRE(a.drive.run(move_by{-1000 * pulse, brisk}));
    CHECK(a.drive.motion() == motion_check::seen);
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == -1000);
}

TEST_CASE("4.3 a homing is not taken for done because the drive still reports the one before") {
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
    CHECK(a.drive.known().is_homed);
}

TEST_CASE("S4: a declaration that the drive acknowledges and does not carry out is told") {
    closed_axis a{{.start_delay = milliseconds(3000)}};
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    CHECK(a.drive.run(declare_position{0 * pulse}).error() == errc::not_executed);
    a.run(4000); // now it is: the drive says that it is homed
    REQUIRE(a.model.view().is_homed);
    CHECK(a.drive.run(declare_position{500 * pulse}).error() == errc::not_executed);
    CHECK_FALSE(a.drive.known().is_homed);
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
}

TEST_CASE("4.3 a homing ends when the motor stands, though an input moves it on from home") {
    closed_axis a;
    a.model.attach(simulated::yako_slide());
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(release{}));
    REQUIRE(a.drive.run(set_input{input::x3, input_function::jog_positive}));
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
    CHECK(a.drive.known().is_homed);
}

TEST_CASE("4.3 a homing beyond its time is reported as such, and the lost stop behind it too") {
    closed_axis a; // no machine: it turns for ever
    take(a);
    REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
    const closed_loop::home wanted{
        homing::home_24, {}, offset_handling::move_position_zero, milliseconds(1000)};
    REQUIRE(a.drive.begin(wanted) == errc::ok);
    const auto stop_frame = hex("01 06 00 27 01 00 38 51");
    while (!a.drive.is_idle()) {
        if (a.sent(stop_frame) > 1) a.wire.faults().lost_response = 1000; // one stopped it for init
        a.turn();
    }
    a.wire.faults() = {};
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.drive.last().error() == errc::timeout);
    CHECK(a.drive.motion() != motion_check::not_asked);
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.model.starts() == 1);
    REQUIRE(a.drive.run(init{}));
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("S4: an open loop that an input has freed takes no absolute place for its input move") {
    open_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(release{}));
    REQUIRE(a.drive.run(set_input{input::x3, input_function::motor_free}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
    REQUIRE(a.drive.run(set_input_move{700 * pulse, brisk, positioning::absolute}));
    a.model.set_input(3, true);
    a.run(10);
    const auto held = a.model.peek(target_position.address);
    CHECK(a.drive.run(set_input_move{900 * pulse, brisk, positioning::absolute}).error() ==
          errc::needs_homing);
    CHECK(a.model.peek(target_position.address) == held);
    CHECK_FALSE(a.drive.known().is_homed);
}

TEST_CASE("5.1 a position that does not stay at zero was not cleared") {
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(release{}));
    a.begin_up_to(clear_position{}, 3);
    while (a.model.writes_to(auxiliary_command.address) < 2) a.turn(); // the release was the first
    a.model.push_shaft(100);
    a.finish();
    CHECK(a.drive.last().error() == errc::not_executed);
    CHECK(a.drive.last().outcome() == outcome::unknown);
}

TEST_CASE("4.3 a position that is declared again takes its time to be obeyed, as a start does") {
    closed_axis a{{.start_delay = milliseconds(100)}};
    take_homed(a);
    const report r = a.drive.run(declare_position{500 * pulse});
    CHECK(r);
    CHECK(a.drive.known().is_homed);
    REQUIRE(a.drive.read());
    CHECK(a.drive.seen().position == 500 * pulse);
}

TEST_CASE("4.1 a shaft that still comes to rest after a short move has made it") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.begin(move_by{20 * pulse, brisk}) == errc::ok);
    while (a.model.starts() == 0) a.turn();
    while (!a.is_moving()) a.run(1);
    while (a.is_moving()) a.run(1);
    a.model.push_shaft(600); // it turns back
    a.finish();
    CHECK(a.drive.last());
    CHECK(a.drive.motion() == motion_check::seen);
    CHECK(a.place() == 20);
}

TEST_CASE_TEMPLATE("4.1 a move that is found at rest short of its target is told, a jog at rest too", A,
                   closed_axis, open_axis) {
    for (const bool is_jog : {false, true}) {
        A a;
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(release{}));
        REQUIRE(a.drive.run(set_input{input::x3, input_function::stop}));
        REQUIRE(a.drive.run(enable{}));
        REQUIRE((is_jog ? a.drive.begin(jog{600 * r_per_min}) : a.drive.begin(move_by{900 * pulse, brisk})) ==
                errc::ok);
        while (a.model.starts() == 0) a.turn();
        while (a.place() < 8) a.run(1);
        a.model.set_input(3, true);
        while (a.is_moving()) a.run(1);
        a.finish();
        CHECK(a.drive.last().error() == errc::not_reached);
        CHECK(a.drive.last().outcome() == outcome::unknown);
        CHECK(a.drive.motion() == motion_check::unknown);
        CHECK(a.drive.state() == drive_state::enabled); // nothing else is open
    }
}

TEST_CASE_TEMPLATE("A55: a move that a restart cuts short is told, though every register is kept", A,
                   closed_axis, open_axis) {
    A a{{.kept = sim::yako_kept::written}};
    take(a);
    REQUIRE(a.drive.run(move_by{30 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
    REQUIRE(a.drive.begin(move_by{900 * pulse, brisk}) == errc::ok);
    while (a.model.starts() < 2) a.turn();
    a.model.power_cycle(); // its position is zero
    a.finish();
    CHECK(a.drive.last().error() == errc::not_reached);
    CHECK(a.drive.motion() == motion_check::unknown);
    CHECK(a.drive.state() == drive_state::needs_init);
}

TEST_CASE("4.3 a second homing that leaves the position as it is counts where homed was seen to fall") {
    for (const bool falls : {true, false}) {
        closed_axis a{{.homed = falls ? sim::yako_homed::until_homing : sim::yako_homed::always}};
        a.model.attach(simulated::yako_slide());
        take(a);
        REQUIRE(a.drive.run(declare_position{3000 * pulse}));
        REQUIRE(a.drive.run(set_homing_profile{300 * r_per_min, 60 * r_per_min}));
        const report r = a.drive.run(
            closed_loop::home{homing::home_24, 700 * pulse, offset_handling::stay_position_actual});
        CHECK(static_cast<bool>(r) == falls); // A54: else nothing tells it from one that was cut short
        if (!falls) CHECK(r.error() == errc::not_reached);
        CHECK(a.drive.known().is_homed == falls);
        using enum offset_handling;
        for (const auto then : {stay_position_offset, stay_position_zero, stay_position_negative_offset,
                                move_position_offset, move_position_negative_offset}) {
            const bool stays = then >= stay_position_offset;
            REQUIRE(a.drive.run(closed_loop::home{homing::home_24, (stays ? -70'000 : -700) * pulse, then}));
            CHECK(a.drive.known().is_homed);
        }
    }
}
