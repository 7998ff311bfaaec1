// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades against their simulators, on a line without faults: relative and absolute moves, jogs,
// homing by every method, and the moves that inputs start. Each sends the manual's own frames.
#include <array>
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace drive_yako_moves_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::gentle;
using enabled_yako::quick_stop_frame;
using enabled_yako::start_homing_frame;
using enabled_yako::start_relative_frame;
using enabled_yako::stop_frame;
using enabled_yako::whole_rpm;
using enabled_yako::state_checked::take;
using enabled_yako::state_checked::take_homed;
using simulated::closed_axis;
using simulated::open_axis;

TEST_CASE("4.1: a relative move sends start speed, ramps, speed and target in the manual's frame, then the "
          "start") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(move_by{1000 * pulse, gentle}));
    CHECK(a.sent(hex("01 10 00 20 00 06 0C 00 0A 00 64 00 64 00 3C 00 00 03 E8 DD 68")) == 1);
    CHECK(a.sent(start_relative_frame) == 1);
    CHECK(a.drive.motion() == motion_check::seen);
    CHECK(a.is_moving());
    CHECK(a.drive.run(move_by{1000 * pulse, gentle}).error() == errc::busy);
    CHECK(a.drive.run(move_by{1000 * pulse}).error() == errc::busy);
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 1000);
    REQUIRE(a.drive.run(move_by{-300 * pulse})); // with the profile that the drive has
    CHECK(a.sent(hex("01 10 00 20 00 06 0C 00 0A 00 64 00 64 00 3C 00 00 03 E8 DD 68")) == 1);
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 700);
    CHECK(a.model.starts() == 2);
}

TEST_CASE("4.1: what was seen of a move is known until the next motion is commanded") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(move_by{1000 * pulse, brisk}));
    REQUIRE(a.drive.motion() == motion_check::seen);
    REQUIRE(a.drive.read());
    REQUIRE(a.drive.run(wait_reached{}));
    CHECK(a.drive.motion() == motion_check::seen);
    REQUIRE(a.drive.run(set_profile{gentle}));
    CHECK(a.drive.motion() == motion_check::seen);
}

TEST_CASE("4.1: a short move that is over before the first read counts as made") {
    for (const std::int32_t way : {1, 2, 6, 7, -8, 20}) {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(move_by{way * pulse, brisk}));
        REQUIRE(a.drive.run(wait_standstill{}));
        CHECK(a.place() == way);
        open_axis o;
        take(o);
        REQUIRE(o.drive.run(move_by{way * pulse, brisk}));
        REQUIRE(o.drive.run(wait_standstill{}));
        CHECK(o.place() == way);
    }
}

TEST_CASE("4.1: absolute moves are refused until the position is homed or declared, and then reach their "
          "targets") {
    closed_axis a;
    take(a);
    const auto frames = a.requests.size();
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(declare_position{500 * pulse}));
    CHECK(a.place() == 500);
    REQUIRE(a.drive.run(move_to{2500 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 2500);
    REQUIRE(a.drive.run(move_to{2500 * pulse, brisk})); // it is already there
    REQUIRE(a.drive.run(move_to{0 * pulse}));
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 0);
}

TEST_CASE("4.1: a new target replaces that of the current move only if the program requests it by name") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(move_to{20'000 * pulse, brisk}));
    a.run(300);
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::busy);
    REQUIRE(a.drive.run(move_to{-400 * pulse, brisk, while_moving::interrupt}));
    CHECK(a.sent(modbus::write_frame(1, 0x0027, 0x000D)) == 1);
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == -400);
    REQUIRE(a.drive.run(relative_move{.way = 400 * pulse, .then = while_moving::interrupt}));
    CHECK(a.sent(modbus::write_frame(1, 0x0027, 0x0009)) == 1);
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 0);
}

TEST_CASE(
    "S4: an absolute move needs homing again after a quick stop, or after an open loop motor was released") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(move_to{5000 * pulse, brisk}));
    a.run(100);
    REQUIRE(a.drive.run(quick_stop{}));
    CHECK(a.sent(quick_stop_frame) == 1);
    CHECK_FALSE(a.is_moving());
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
    REQUIRE(a.drive.run(move_by{100 * pulse, brisk})); // a relative move needs no homing
    REQUIRE(a.drive.run(wait_standstill{}));
    REQUIRE(a.drive.run(declare_position{0 * pulse}));

    REQUIRE(a.drive.run(disable{})); // the encoder follows the shaft
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(move_to{50 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));

    open_axis o;
    take_homed(o);
    REQUIRE(o.drive.run(move_to{50 * pulse, brisk}));
    REQUIRE(o.drive.run(disable{}));
    CHECK_FALSE(o.drive.cached().is_homed);
    REQUIRE(o.drive.run(enable{}));
    CHECK(o.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
    REQUIRE(o.drive.run(declare_position{0 * pulse}));
    // An input that frees the motor has the same effect, if a read shows it.
    REQUIRE(o.drive.run(disable{}));
    REQUIRE(o.drive.run(set_input{input_terminal::x3, input_function::motor_free}));
    REQUIRE(o.drive.run(enable{}));
    REQUIRE(o.drive.run(declare_position{0 * pulse}));
    o.model.set_input(3, true);
    o.run(10);
    REQUIRE(o.drive.read());
    CHECK(o.drive.state() == drive_state::disabled);
    o.model.set_input(3, false);
    o.run(10);
    CHECK(o.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
    REQUIRE(o.drive.run(move_by{1 * pulse, brisk}));
    CHECK(o.drive.state() == drive_state::enabled);
}

TEST_CASE("a position that an earlier program left is accepted only by accept_position") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(move_to{300 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.cached().was_homed);
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
    REQUIRE(a.drive.run(accept_position{}));
    REQUIRE(a.drive.run(move_to{0 * pulse, brisk}));
    closed_axis b;
    take(b);
    CHECK(b.drive.run(accept_position{}).error() == errc::needs_homing);
    CHECK(b.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
}

TEST_CASE("4.2: a jog sends the manual's frames, runs at 60 r/min, is reported by the drive, and ends with a "
          "stop") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    CHECK(a.sent(hex("01 10 00 1D 00 03 06 00 3C 00 64 00 64 66 DE")) == 1);
    CHECK(a.sent(hex("01 06 00 27 00 02 B8 00")) == 1);
    a.run(1000);
    CHECK(whole_rpm(a.model.view().speed) == 60);
    const auto f = a.drive.read();
    REQUIRE(f);
    CHECK(f->speed == 60 * r_per_min);
    CHECK(f->state.is_moving());
    CHECK(a.drive.run(velocity{-60 * r_per_min}).error() == errc::busy);
    CHECK(a.drive.run(move_by{10 * pulse, brisk}).error() == errc::busy);
    REQUIRE(a.drive.run(halt{}));
    CHECK(a.sent(stop_frame) == 2); // one by init
    CHECK_FALSE(a.is_moving());
    CHECK(a.model.enabled());
    REQUIRE(a.drive.run(velocity{-500 * r_per_min}));
    CHECK(a.sent(modbus::write_frame(1, 0x001D, std::array<u16, 3>{0xFE0C, 100, 100})) == 1);
    a.run(1000);
    CHECK(a.drive.read()->speed == -500 * r_per_min);
    REQUIRE(a.drive.run(halt{}));
    CHECK(a.drive.run(velocity{0 * r_per_min}).error() == errc::out_of_range);
    CHECK(a.drive.run(velocity{3001 * r_per_min}).error() == errc::out_of_range);
    CHECK(a.drive.run(velocity{2'000'000'000 * r_per_min}).error() == errc::out_of_range);
    CHECK(a.drive.run(velocity{5 * part<10>(r_per_min)}).error() == errc::inexact);
}

TEST_CASE("S4: a bounded jog ends by itself, and continues if it is commanded again") {
    closed_axis a;
    take(a);
    const bounded_jog on{500 * pulse, gentle};
    REQUIRE(a.drive.run(on));
    a.run(200);
    const std::uint32_t starts = a.model.starts();
    REQUIRE(a.drive.run(on)); // it is still running: only reads are sent
    CHECK(a.model.starts() == starts);
    CHECK(a.drive.motion() == motion_check::seen);
    a.run(5000);
    CHECK_FALSE(a.is_moving());
    CHECK(a.place() == 500);
    for (int i = 0; i < 40; ++i) {
        REQUIRE(a.drive.run(on));
        a.run(100);
    }
    CHECK(a.model.starts() > starts + 2);
    CHECK(a.place() > 2000);
    const std::int64_t last = a.place();
    a.run(10'000); // without further commands the motor stops
    CHECK(a.place() - last <= 500);
    // A motion of another kind is not taken for a bounded jog.
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    CHECK(a.drive.run(on).error() == errc::busy);
    REQUIRE(a.drive.run(halt{}));
    REQUIRE(a.drive.run(on));
    REQUIRE(a.drive.run(halt{}));
    REQUIRE(a.drive.run(move_by{4000 * pulse, gentle}));
    CHECK(a.drive.run(on).error() == errc::busy);
}

TEST_CASE("S4: a bounded jog continues also after one that was refused") {
    closed_axis a;
    take(a);
    const bounded_jog on{500 * pulse, gentle};
    REQUIRE(a.drive.run(on));
    a.run(200);
    CHECK(a.drive.run(bounded_jog{500 * pulse, {{}, {}, {}, 30'000 * r_per_min}}).error() ==
          errc::out_of_range);
    const std::uint32_t starts = a.model.starts();
    CHECK(a.is_moving());
    CHECK(a.drive.run(on));
    CHECK(a.model.starts() == starts);
}

TEST_CASE("4.3: homing by every method of the variant ends at the position that CiA 402 defines") {
    for (int n = 1; n <= 35; ++n) {
        const auto m = static_cast<homing>(n);
        closed_axis a;
        a.model.attach(simulated::yako_slide());
        take(a);
        REQUIRE(a.drive.run(set_homing_profile{120 * r_per_min, 30 * r_per_min}));
        const auto frames = a.requests.size();
        const command_status r = a.drive.run(closed_loop::home{checked(m)});
        if (!closed_loop::is_valid(m)) {
            CHECK(r.error() == errc::out_of_range);
            CHECK(a.requests.size() == frames);
            continue;
        }
        REQUIRE_MESSAGE(r, n);
        CHECK(a.drive.cached().is_homed);
        CHECK_FALSE(a.is_moving());
        CHECK(a.model.view().is_homed);
        CHECK(a.place() == 0);
        CHECK(a.model.view().shaft == a.model.view().home);
        CHECK(a.sent(start_homing_frame) == 1);
        REQUIRE(a.drive.run(move_to{100 * pulse, brisk}));
    }
    for (int n = 1; n <= 35; ++n) {
        const auto m = static_cast<homing>(n);
        open_axis a;
        a.model.attach(simulated::yako_slide());
        take(a);
        REQUIRE(a.drive.run(set_homing_profile{120 * r_per_min, 30 * r_per_min}));
        const auto frames = a.requests.size();
        const command_status r = a.drive.run(open_loop::home{checked(m)});
        if (!open_loop::is_valid(m)) {
            CHECK(r.error() == errc::out_of_range);
            CHECK(a.requests.size() == frames);
            continue;
        }
        REQUIRE_MESSAGE(r, n);
        CHECK(a.model.view().shaft == a.model.view().home);
    }
}

TEST_CASE("4.3: homing sends the manual's frames, works a second time, and treats offsets as in CiA 402") {
    closed_axis a;
    a.model.attach(simulated::yako_slide());
    take(a);
    REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min, 100 * millisecond}));
    CHECK(a.model.peek(0x0032) == 60);
    CHECK(a.model.peek(0x0033) == 30);
    CHECK(a.model.peek(0x0034) == 100);
    REQUIRE(a.drive.run(closed_loop::home{homing::home_24}));
    CHECK(a.sent(modbus::write_frame(1, 0x0030, std::array<u16, 2>{1, 24})) == 1);
    const std::int64_t home = a.model.view().home;
    CHECK(a.model.view().shaft == home);
    REQUIRE(a.drive.run(closed_loop::home{homing::home_24, 100 * pulse}));
    CHECK(a.place() == 0);
    CHECK(a.model.view().shaft == home + 100);
    REQUIRE(a.drive.run(
        closed_loop::home{homing::home_24, 100 * pulse, offset_handling::stay_position_negative_offset}));
    CHECK(a.place() == -100);
    CHECK(a.model.view().shaft == home);
}

TEST_CASE("4.3: homing methods without a documented direction are accepted only as named constants") {
    closed_axis a;
    auto hard_stops = simulated::yako_slide();
    hard_stops.negative_limit = -sim::yako_machine::nowhere;
    a.model.attach(hard_stops);
    take(a);
    REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
    for (int n = -6; n <= 0; ++n) {
        const auto m = static_cast<homing>(n);
        CHECK(a.drive.run(closed_loop::home{checked(m)}).error() == errc::out_of_range);
    }
    CHECK(a.sent(start_homing_frame) == 0);
    CHECK(a.drive.run(closed_loop::home{homing::mechanical_stop_3}));
    CHECK(a.model.view().is_homed);
}

TEST_CASE("4.3: a homing fails if it finds no switch in time, meets the wrong limit, or does not begin") {
    SUBCASE("time limit") {
        closed_axis a; // no machine is attached: the motor would turn for ever
        take(a);
        REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
        const command_status r = a.drive.run(
            closed_loop::home{homing::home_24, {}, offset_handling::move_position_zero, milliseconds(3000)});
        CHECK(r.error() == errc::not_reached);
        CHECK_FALSE(a.is_moving()); // the facade has stopped it
        CHECK(a.drive.state() == drive_state::enabled);
        CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
    }
    SUBCASE("the wrong limit") {
        closed_axis a;
        auto m = simulated::yako_slide();
        m.home_from = m.home_to = sim::yako_machine::nowhere;
        a.model.attach(m);
        take(a);
        REQUIRE(a.drive.run(set_homing_profile{300 * r_per_min, 30 * r_per_min}));
        const command_status r = a.drive.run(closed_loop::home{homing::positive_home_19});
        CHECK((r.error() == errc::not_reached || r.error() == errc::faulted));
        CHECK_FALSE(a.drive.cached().is_homed);
    }
    SUBCASE("ignored") {
        closed_axis a{{.start_delay = milliseconds(400)}};
        a.model.attach(simulated::yako_slide());
        take(a);
        const command_status r = a.drive.run(closed_loop::home{homing::home_24});
        CHECK(r.error() == errc::not_executed);
        CHECK_FALSE(a.drive.cached().is_homed);
        CHECK(a.drive.motion() == motion_check::not_seen);
    }
}

TEST_CASE("4.4, 4.5: a segment is written in one frame, and only inputs start it") {
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x1, input_function::pt_trigger}));
    REQUIRE(a.drive.run(set_input{input_terminal::x2, input_function::pin0}));
    REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::pv_trigger}));
    REQUIRE(a.drive.run(set_pv_trigger{pv_trigger::level}));
    REQUIRE(a.drive.run(enable{}));
    for (std::uint16_t n = 1; n <= 16; ++n) {
        REQUIRE(a.drive.run(set_position_segment{checked(n), -1000 * n * pulse, 300 * r_per_min}));
        const auto at = static_cast<u16>(0x0060 + 6 * (n - 1));
        const word_pair words = split_words(static_cast<u32>(-1000 * n), word_order::high_first);
        CHECK(a.model.peek(at) == words.first);
        CHECK(a.model.peek(static_cast<u16>(at + 1)) == words.second);
        CHECK(a.model.peek(static_cast<u16>(at + 2)) == 300);
        CHECK(a.sent(modbus::write_frame(
                  1, at, std::array<u16, 6>{words.first, words.second, 300, 100, 100, 0})) == 1);
        REQUIRE(a.drive.run(set_speed_segment{checked(n), -10 * n * r_per_min}));
        CHECK(a.model.peek(static_cast<u16>(0x00C0 + 3 * (n - 1))) == static_cast<u16>(-10 * n));
    }
    CHECK(a.model.starts() == 0);
    a.model.set_input(2, true); // PIN0: segment 2
    a.run(20);
    a.model.set_input(1, true);
    a.run(10'000);
    CHECK(a.place() == -2000);
    a.model.set_input(3, true);
    a.run(500);
    CHECK(whole_rpm(a.model.view().speed) == -20);
    CHECK(a.drive.run(move_by{10 * pulse, brisk}).error() == errc::busy);
    const auto frames = a.requests.size();
    CHECK(a.drive.run(set_position_segment{checked(17), 1 * pulse, 1 * r_per_min}).error() ==
          errc::bad_argument);
    CHECK(a.drive.run(set_speed_segment{checked(0), 1 * r_per_min}).error() == errc::bad_argument);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(set_position_segment{16, 1 * pulse, 1 * r_per_min}));
}

TEST_CASE("4.6: a stop uses the ramp that was set before the start") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(velocity{600 * r_per_min, 50 * millisecond, 1000 * millisecond}));
    a.run(500);
    const std::uint64_t start = a.wire.time_us();
    REQUIRE(a.drive.run(halt{}));
    const std::uint64_t took = a.wire.time_us() - start;
    CHECK(took > 900'000);
    CHECK(took < 1'200'000);
    CHECK(a.model.enabled());
}

TEST_CASE("5.1: clear_position works only at standstill and does not count as homing") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(move_by{700 * pulse, brisk}));
    CHECK(a.drive.run(clear_position{}).error() == errc::busy);
    REQUIRE(a.drive.run(wait_standstill{}));
    REQUIRE(a.drive.run(clear_position{}));
    CHECK(a.place() == 0);
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
}

TEST_CASE("5.4: an input ends a jog by the move that set_input_move has set") {
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::position_move}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(set_input_move{1500 * pulse, brisk}));
    CHECK(a.model.starts() == 0);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    a.run(500);
    const std::int64_t before = a.place();
    a.model.set_input(3, true);
    a.run(5000);
    CHECK_FALSE(a.is_moving());
    CHECK(a.place() >= before + 1500);
    CHECK(a.place() < before + 1520);
    CHECK(a.drive.run(set_input_move{0 * pulse, brisk, positioning::absolute}).error() == errc::needs_homing);
    CHECK(a.drive.run(set_input_move{0 * pulse, {}}).error() == errc::bad_argument);
}

TEST_CASE("a profile that begins faster than it runs, or does not run, is refused before anything is sent") {
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    const std::size_t frames = a.requests.size();
    using yako::motion_profile;
    const auto refusal_of = [&](const motion_profile& by) {
        return a.drive.begin(move_by{5'000 * pulse, by}).error();
    };
    CHECK(refusal_of({600 * r_per_min, 90 * millisecond, 90 * millisecond, 0 * r_per_min}) ==
          errc::out_of_range);
    CHECK(refusal_of({61 * r_per_min, 90 * millisecond, 90 * millisecond, 60 * r_per_min}) ==
          errc::out_of_range);
    CHECK(a.requests.size() == frames);
    CHECK(a.drive.run(move_by{500 * pulse, {60 * r_per_min, {}, {}, 60 * r_per_min}}));
}

} // namespace drive_yako_moves_tests
