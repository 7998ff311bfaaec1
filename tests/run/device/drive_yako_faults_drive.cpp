// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades where it is easiest to be wrong: commands that are acknowledged and ignored, frames
// lost at every step, a drive that restarts, a stop during everything, answers that come too late.
#include <initializer_list>

#include <doctest/doctest.h>

#include <tests/support/yako_axis.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using simulated::closed_axis;
using simulated::open_axis;
using simulated::writes_to;

namespace {

constexpr auto enable_frame = hex("01 06 00 2D 00 12 99 CE");
constexpr auto stop_frame = hex("01 06 00 27 01 00 38 51");
constexpr auto quick_stop_frame = hex("01 06 00 27 02 00 38 A1");
constexpr auto start_relative_frame = hex("01 06 00 27 00 01 F8 01");
constexpr auto start_jog_frame = hex("01 06 00 27 00 02 B8 00");
constexpr auto start_homing_frame = hex("01 06 00 27 00 10 38 0D");
constexpr auto save_frame = hex("01 06 00 2D 00 42 99 F2");
constexpr auto clear_alarm_frame = hex("01 06 00 2D 00 21 D9 DB");

const motion_profile gentle{10 * r_per_min, 100 * millisecond, 100 * millisecond, 60 * r_per_min};
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

// The first frame of `order` whose request, or whose response, is lost is number `lost`.
template <class Axis, class Order>
void run_with_a_loss(Axis& a, const Order& wanted, std::uint32_t lost, bool is_response) {
    const std::uint32_t first = a.wire.requests();
    REQUIRE(a.drive.begin(wanted) == errc::ok);
    while (!a.drive.is_idle()) {
        const std::uint32_t passed = a.wire.requests() - first;
        a.wire.faults().lost_request = passed == lost && !is_response ? 1000 : 0;
        a.wire.faults().lost_response = passed == lost + 1 && is_response ? 1000 : 0;
        (void)a.drive.step();
        a.wire.wait(microseconds(20));
    }
    a.wire.faults() = {};
}

bool is_32_bit_write(bytes f) {
    for (const u16 pair : std::initializer_list<u16>{0x24, 0x35, 0x37, 0x39, 0x60}) {
        if (writes_to(f, pair)) return true;
    }
    return false;
}
bool is_speed_write(bytes f) {
    for (const u16 at : std::initializer_list<u16>{0x1D, 0x20, 0x23, 0x32, 0x33, 0x62, 0xC0}) {
        if (writes_to(f, at)) return true;
    }
    return false;
}

} // namespace

TEST_CASE("S4: a start that is acknowledged and not carried out is told, whatever kind it is") {
    closed_axis a{{.start_delay = milliseconds(3000)}};
    take(a);
    REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
    const auto check = [&](const report& r) {
        CHECK(r.error() == errc::not_executed);
        CHECK(a.drive.motion() == motion_check::not_seen);
        CHECK(a.drive.state() == drive_state::enabled); // nothing else is in doubt
        REQUIRE(a.drive.run(stop{}));
    };
    const std::uint64_t start = a.wire.time_us();
    check(a.drive.run(move_by{1000 * pulse, brisk}));
    CHECK(a.wire.time_us() - start > 200'000);
    CHECK(a.wire.time_us() - start < 300'000);
    check(a.drive.run(jog{60 * r_per_min}));
    check(a.drive.run(bounded_jog{1000 * pulse, brisk}));
    check(a.drive.run(closed_loop::home{homing::home_24}));
    CHECK(a.sent(start_relative_frame) == 2);
    CHECK(a.sent(start_jog_frame) == 1);
    CHECK(a.sent(start_homing_frame) == 1);
    CHECK(a.place() == 0);
}

TEST_CASE("S4: a stop input that is active makes the drive ignore a move") {
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(release{}));
    REQUIRE(a.drive.run(set_input{input::x3, input_function::stop}));
    REQUIRE(a.drive.run(enable{}));
    a.model.set_input(3, true);
    a.run(10);
    CHECK(a.drive.run(move_by{1000 * pulse, brisk}).error() == errc::not_executed);
    CHECK(a.drive.run(move_by{1000 * pulse, brisk}).outcome() == outcome::unknown);
    a.model.set_input(3, false);
    a.run(10);
    REQUIRE(a.drive.run(move_by{1000 * pulse, brisk}));
}

TEST_CASE("S4: a save that the drive acknowledges and ignores, since an input moved the motor meanwhile") {
    for (const bool is_reset : {false, true}) {
        closed_axis a;
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(release{}));
        REQUIRE(a.drive.run(set_input{input::x3, input_function::jog_positive}));
        REQUIRE(a.drive.run(enable{}));
        const std::uint32_t before = a.wire.requests();
        if (is_reset) {
            REQUIRE(a.drive.begin(factory_reset{sole_drive_on_the_line{}}) == errc::ok);
        } else {
            REQUIRE(a.drive.begin(save{}) == errc::ok);
        }
        while (a.wire.requests() < before + 2) a.turn(); // it was looked at
        a.model.set_input(3, true);
        a.run(5);
        REQUIRE(a.is_moving());
        a.finish();
        CHECK(a.drive.last().error() == errc::not_executed);
        CHECK(a.model.saves() == 0);
        CHECK(a.drive.state() == drive_state::enabled);
        CHECK(a.sent(save_frame) == (is_reset ? 0 : 1));
        CHECK(a.model.peek(0x0044) == 9); // nothing was reset
    }
}

TEST_CASE("S4, G15: a move is made at most once, whichever frame is lost; an open start compares positions") {
    unsigned seen = 0;
    unsigned not_seen = 0;
    unsigned unknown = 0;
    for (std::uint32_t lost = 0; lost < 8; ++lost) {
        for (const bool is_response : {false, true}) {
            closed_axis a;
            take_homed(a);
            run_with_a_loss(a, move_by{1000 * pulse, brisk}, lost, is_response);
            CHECK(a.sent(start_relative_frame) <= 1);
            const report ended = a.drive.last();
            a.run(3000);
            const bool was_made = a.place() == 1000;
            CHECK((was_made || a.place() == 0));
            if (ended) CHECK(was_made);
            if (ended.outcome() == outcome::not_sent || ended.outcome() == outcome::refused)
                CHECK_FALSE(was_made);
            if (ended.outcome() != outcome::unknown) continue;
            ++unknown;
            CHECK(a.drive.state() == drive_state::needs_init);
            CHECK(a.drive.run(move_by{1000 * pulse, brisk}).error() == errc::needs_init);
            if (a.drive.motion() == motion_check::not_asked) CHECK_FALSE(was_made);
        }
    }
    for (const bool is_response : {false, true}) { // the start is the fourth frame
        closed_axis a;
        take_homed(a);
        run_with_a_loss(a, move_by{1000 * pulse, brisk}, 3, is_response);
        CHECK(a.drive.last().outcome() == outcome::unknown);
        if (a.drive.motion() == motion_check::seen) ++seen;
        if (a.drive.motion() == motion_check::not_seen) ++not_seen;
        a.run(3000);
        CHECK(a.place() == (is_response ? 1000 : 0));
        REQUIRE(a.drive.run(init{}));
        CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing); // and not by itself
    }
    CHECK(unknown == 4);
    CHECK(seen == 1);
    CHECK(not_seen == 1);
}

TEST_CASE("the line breaks between the start's acknowledgement and the look that would confirm it") {
    for (const bool is_homing : {false, true}) {
        closed_axis a;
        take(a);
        const std::uint32_t before = a.wire.requests();
        if (is_homing) {
            REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
        } else {
            REQUIRE(a.drive.begin(jog{60 * r_per_min}) == errc::ok);
        }
        while (a.model.starts() == 0) a.turn();
        REQUIRE(a.wire.requests() > before);
        a.run(1);
        a.wire.cut_for(milliseconds(5000));
        a.finish();
        CHECK(a.drive.last().outcome() == outcome::unknown);
        CHECK(a.drive.state() == drive_state::needs_init);
        a.run(6000);
        REQUIRE(a.drive.run(init{}));
        CHECK_FALSE(a.is_moving());
    }
}

TEST_CASE("G15: whatever the line does, starts, enable, alarm clear and save go out at most once a call") {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        closed_axis a;
        take(a);
        a.wire.faults() = {.lost_request = 50,
                           .corrupted_request = 50,
                           .lost_response = 100,
                           .late_response = 50,
                           .doubled_response = 50,
                           .corrupted_response = 50};
        for (std::uint64_t i = 0; i < seed % 7; ++i) (void)a.drive.read(); // other faults for other seeds
        const auto once = [&](bytes frame, const auto& wanted) {
            if (a.drive.state() == drive_state::needs_init) (void)a.drive.run(init{});
            a.requests.clear();
            const std::uint32_t starts = a.model.starts();
            (void)a.drive.run(wanted);
            CHECK(a.sent(frame) <= 1);
            CHECK(a.model.starts() <= starts + 1);
            (void)a.drive.run(stop{});
        };
        once(start_relative_frame, move_by{100 * pulse, brisk});
        once(start_jog_frame, jog{60 * r_per_min});
        once(start_relative_frame, bounded_jog{100 * pulse, brisk});
        once(start_homing_frame,
             closed_loop::home{homing::home_24, {}, offset_handling::stay_position_zero, milliseconds(500)});
        once(save_frame, save{});
        once(clear_alarm_frame, fault_reset{});
        once(enable_frame, enable{});
    }
}

TEST_CASE("S6: while the word order is unknown no 32-bit value is sent; a lost answer makes it unknown") {
    closed_axis a;
    take_homed(a);
    a.wire.faults().lost_response = 0;
    run_with_a_loss(a, set_word_order{pair_order::low_first}, 2, true);
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.model.peek(0x0019) == 1); // it was done
    CHECK(a.drive.known().order == word_order::unknown);
    const auto frames = a.requests.size();
    CHECK(a.drive.run(move_by{70'000 * pulse, brisk}).error() == errc::needs_init);
    CHECK(a.drive.run(declare_position{0 * pulse}).error() == errc::needs_init);
    CHECK(a.drive.run(limit_travel{1 * pulse, 0 * pulse}).error() == errc::needs_init);
    CHECK(a.drive.run(set_position_segment{1, 1 * pulse, 1 * r_per_min}).error() == errc::needs_init);
    CHECK(a.drive.read().error() == errc::needs_init);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.known().order == word_order::low_first);
    REQUIRE(a.drive.run(move_by{70'000 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 70'000);
}

TEST_CASE("S6, A37: a drive that restarted gets neither a torn place nor a speed in another count") {
    SUBCASE("the word order fell back") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(set_word_order{pair_order::low_first}));
        a.model.power_cycle();
        a.requests.clear();
        CHECK(a.drive.run(move_by{70'000 * pulse, brisk}).error() == errc::needs_init);
        for (const auto& f : a.requests) CHECK_FALSE(is_32_bit_write(f));
    }
    SUBCASE("the speed resolution fell back") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
        a.model.power_cycle();
        a.requests.clear();
        CHECK(a.drive.run(jog{60 * r_per_min}).error() == errc::needs_init);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
        for (const auto& f : a.requests) CHECK_FALSE(is_speed_write(f));
    }
    SUBCASE("the homing is gone: a move, a look and a setting find it") {
        for (const int how : {0, 1, 2}) {
            closed_axis a;
            take_homed(a);
            a.model.power_cycle();
            if (how == 0) CHECK(a.drive.run(move_to{500 * pulse, brisk}).error() == errc::needs_init);
            if (how == 1) REQUIRE(a.drive.read());
            if (how == 2) CHECK(a.drive.run(set_profile{brisk}).error() == errc::needs_init);
            CHECK(a.drive.state() == drive_state::needs_init);
            CHECK(a.place() == 0);
            CHECK(a.model.starts() == 1); // the declaration
        }
    }
    SUBCASE("the stored profile and the homing speeds fell back") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(set_profile{brisk}));
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{500 * pulse}).error() == errc::needs_init);
        CHECK(a.drive.state() == drive_state::needs_init);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(move_by{500 * pulse, brisk}));
        REQUIRE(a.drive.run(wait_standstill{}));
        const std::uint32_t starts = a.model.starts();
        a.model.power_cycle();
        CHECK(a.drive.run(bounded_jog{500 * pulse}).error() == errc::needs_init);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(set_homing_profile{20 * r_per_min, 10 * r_per_min}));
        a.model.power_cycle();
        CHECK(a.drive.run(closed_loop::home{homing::home_24}).error() == errc::needs_init);
        CHECK(a.model.starts() == starts);
    }
    SUBCASE("it comes up released") {
        closed_axis a{{.is_enabled_at_power_on = false}};
        take(a);
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{500 * pulse, brisk}).error() == errc::wrong_state);
        CHECK(a.drive.state() == drive_state::released);
        CHECK(a.model.starts() == 0);
    }
}

TEST_CASE("G25: a stop during everything is the next frame after the one in flight, and the axis stands") {
    const auto check = [](const auto& wanted, bool is_quick) {
        for (std::size_t frames = 0; frames < 14; ++frames) {
            closed_axis a;
            a.model.attach(simulated::yako_slide());
            take(a);
            a.begin_up_to(wanted, frames);
            if (a.drive.is_idle()) break;
            a.requests.clear();
            if (is_quick) {
                REQUIRE(a.drive.begin(quick_stop{}) == errc::ok);
            } else {
                REQUIRE(a.drive.begin(stop{}) == errc::ok);
            }
            a.finish();
            REQUIRE(a.drive.last());
            const bytes wanted_frame = is_quick ? bytes{quick_stop_frame} : bytes{stop_frame};
            REQUIRE(a.requests.size() >= 2);
            CHECK((same_bytes(a.requests[0], wanted_frame) || same_bytes(a.requests[1], wanted_frame)));
            CHECK_FALSE(a.is_moving());
            const std::int64_t place = a.place();
            a.run(2000);
            CHECK(a.place() == place);
            CHECK(a.drive.run(move_to{0 * pulse, brisk}).outcome() == outcome::not_sent);
        }
    };
    for (const bool is_quick : {false, true}) {
        check(move_by{3000 * pulse, gentle}, is_quick);
        check(jog{60 * r_per_min}, is_quick);
        check(bounded_jog{3000 * pulse, gentle}, is_quick);
        check(closed_loop::home{homing::home_24}, is_quick);
        check(enable{}, is_quick);
        check(save{}, is_quick);
        check(wait_standstill{}, is_quick);
        check(set_profile{brisk}, is_quick);
        check(set_word_order{pair_order::low_first}, is_quick);
        check(set_speed_resolution{speed_count::tenth_r_per_min}, is_quick);
        check(set_position_segment{3, 100 * pulse, 60 * r_per_min}, is_quick);
        check(init{}, is_quick);
    }
}

TEST_CASE("G21: an order cut short by a stop leaves no false belief") {
    SUBCASE("the word order") {
        for (std::size_t frames = 0; frames < 6; ++frames) {
            closed_axis a;
            take(a);
            a.begin_up_to(set_word_order{pair_order::low_first}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(stop{}) == errc::ok);
            a.finish();
            const bool is_known = a.drive.state() != drive_state::needs_init;
            const auto held = a.model.peek(0x0019) == 0 ? word_order::high_first : word_order::low_first;
            if (is_known) CHECK(a.drive.known().order == held);
        }
    }
    SUBCASE("the speed resolution") {
        for (std::size_t frames = 0; frames < 6; ++frames) {
            closed_axis a;
            take(a);
            a.begin_up_to(set_speed_resolution{speed_count::tenth_r_per_min}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(stop{}) == errc::ok);
            a.finish();
            const bool is_known = a.drive.state() != drive_state::needs_init;
            if (is_known) CHECK(static_cast<u16>(a.drive.known().resolution) == a.model.peek(0x001A));
        }
    }
    SUBCASE("a homing, and a position that is cleared") {
        for (std::size_t frames = 0; frames < 40; ++frames) {
            closed_axis a;
            a.model.attach(simulated::yako_slide());
            take_homed(a);
            a.begin_up_to(closed_loop::home{homing::home_24}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(stop{}) == errc::ok);
            a.finish();
            if (a.drive.known().is_homed) CHECK(a.model.starts() == 1); // the declaration still stands
        }
        for (std::size_t frames = 0; frames < 6; ++frames) {
            closed_axis a;
            take(a);
            REQUIRE(a.drive.run(declare_position{500 * pulse}));
            a.begin_up_to(clear_position{}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(stop{}) == errc::ok);
            a.finish();
            if (a.drive.known().is_homed) CHECK(a.place() == 500);
        }
    }
    SUBCASE("a less urgent stop does not take the place of a more urgent one") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(jog{60 * r_per_min}));
        REQUIRE(a.drive.begin(release{}) == errc::ok);
        CHECK(a.drive.begin(stop{}) == errc::busy);
        a.finish();
        CHECK_FALSE(a.model.enabled());
        CHECK(a.drive.state() == drive_state::released);
    }
}

TEST_CASE("G26: a stop gets through where a start's answer comes late, and is confirmed by the status") {
    for (std::uint32_t late = 102; late < 130; late += 4) {
        closed_axis a;
        take(a);
        a.wire.faults().late_response = 1000;
        a.wire.faults().late_by = milliseconds(late);
        (void)a.drive.run(jog{60 * r_per_min});
        a.wire.faults() = {};
        REQUIRE(a.drive.run(stop{}));
        CHECK_FALSE(a.is_moving());
    }
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(jog{60 * r_per_min}));
    run_with_a_loss(a, stop{}, 0, true);
    CHECK(a.drive.last());
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("G16, G21: an unknown outcome voids what is believed; nothing moves before init") {
    closed_axis a;
    take_homed(a);
    run_with_a_loss(a, set_profile{brisk}, 2, true);
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.drive.state() == drive_state::needs_init);
    const auto frames = a.requests.size();
    CHECK(a.drive.run(move_by{1 * pulse, brisk}).outcome() == outcome::not_sent);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.run(move_to{1 * pulse, brisk}).error() == errc::needs_homing);
    REQUIRE(a.drive.run(accept_position{}));
    REQUIRE(a.drive.run(move_to{1 * pulse, brisk}));
}

TEST_CASE("G16: what the drive refuses by an exception was not done, and nothing else is in doubt") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
    // The model keeps the range of its words; whether a drive does is not stated.
    const report r = a.drive.run(jog{3000 * r_per_min});
    CHECK(r.outcome() == outcome::refused);
    CHECK(r.exception() == 7);
    CHECK(a.drive.state() == drive_state::enabled);
    CHECK(a.drive.known().is_homed);
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("G21: a port that went away and came back") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(jog{60 * r_per_min}));
    a.wire.unplug();
    CHECK(a.drive.read().error() == errc::port_lost);
    CHECK(a.drive.run(init{}).error() == errc::port_lost);
    a.run(2000);
    CHECK(a.is_moving()); // S4: no watchdog stops it
    a.wire.plug();
    CHECK(a.drive.run(jog{60 * r_per_min}).error() == errc::needs_init);
    REQUIRE(a.drive.run(init{}));
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("G20, S4: an axis that was lost sight of is stopped as well when the commands end") {
    const auto loop = [](closed_axis& a, std::uint32_t ms) {
        const std::uint64_t end = a.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (a.wire.time_us() < end) a.turn();
    };
    for (const bool takes_over : {false, true}) {
        closed_axis a;
        take(a);
        a.drive.watch_commands(milliseconds(1500));
        REQUIRE(a.drive.run(jog{60 * r_per_min}));
        const auto stops = a.sent(stop_frame);
        a.wire.cut_for(milliseconds(1000));
        CHECK_FALSE(a.drive.read());
        CHECK(a.drive.state() == drive_state::needs_init);
        loop(a, 500);
        CHECK(a.is_moving());
        if (takes_over) {
            loop(a, 300);
            REQUIRE(a.drive.run(init{}));
            CHECK(a.sent(stop_frame) == stops + 1);
        }
        loop(a, 3000);
        CHECK(a.sent(stop_frame) == stops + 1); // once
        CHECK_FALSE(a.is_moving());
    }
    closed_axis a; // an init is not cut short by the stop that it begins with itself
    take(a);
    a.drive.watch_commands(milliseconds(400));
    REQUIRE(a.drive.run(jog{60 * r_per_min}));
    a.wire.cut_for(milliseconds(900));
    CHECK_FALSE(a.drive.read());
    a.run(1000);
    REQUIRE(a.drive.run(init{}));
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("an alarm while the axis homes or has just begun to move ends the order") {
    closed_axis a;
    a.model.attach(simulated::yako_slide());
    take(a);
    REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
    while (!a.is_moving()) a.turn();
    for (int i = 0; i < 20; ++i) a.turn();
    a.model.raise_alarm(1);
    a.finish();
    CHECK(a.drive.last().error() == errc::faulted);
    CHECK_FALSE(a.drive.known().is_homed);
    a.model.end_alarm();
    a.run(2000);
    REQUIRE(a.drive.run(fault_reset{}));
    REQUIRE(a.drive.run(enable{}));
    a.model.block_shaft(true); // closed loop: it begins, and finds out
    (void)a.drive.run(move_by{40'000 * pulse, brisk});
    CHECK(a.drive.run(wait_standstill{}).error() == errc::faulted);
}

TEST_CASE("S1: whatever a program was doing when it crashed, its successor stops the axis first") {
    for (std::size_t crash = 0; crash < 60; ++crash) {
        open_axis a;
        a.model.attach(simulated::yako_slide());
        std::size_t left = crash;
        const auto run_until_crash = [&](const auto& wanted) {
            if (left == 0 || a.drive.begin(wanted) != errc::ok) return;
            const std::size_t before = a.requests.size();
            while (!a.drive.is_idle() && a.requests.size() - before < left) a.turn();
            const std::size_t used = a.requests.size() - before;
            left = used >= left ? 0 : left - used;
        };
        run_until_crash(init{});
        run_until_crash(enable{});
        run_until_crash(open_loop::home{homing::home_24});
        run_until_crash(move_to{300 * pulse, gentle});
        a.run(crash % 2 == 0 ? 20 : 400);
        servobus::line restarted{a.wire, modbus::timing_at(115200)};
        a.run(150);
        a.requests.clear();
        open_loop::drive successor{restarted, 1};
        REQUIRE(successor.run(init{}));
        CHECK_FALSE(a.is_moving());
        REQUIRE_FALSE(a.requests.empty());
        CHECK(same_bytes(a.requests[0], stop_frame));
        for (std::size_t i = 1; i < a.requests.size(); ++i) CHECK(a.requests[i][1] == 0x03);
        CHECK(successor.run(move_to{0 * pulse, gentle}).error() == errc::needs_homing);
    }
}

TEST_CASE("a line with faults: whatever fails, a stop gets through and the axis can be taken over again") {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        sim::yako_closed_loop model;
        sim::station at{model};
        sim::virtual_line wire{115200, seed};
        wire.attach(at);
        servobus::line on{wire, modbus::timing_at(115200)};
        closed_loop::drive axis{on, 1};
        sim::fault_plan plan;
        REQUIRE(sim::parse_faults("late,lossy,noisy,doubled", plan));
        wire.faults() = plan;
        unsigned rounds = 0;
        for (int i = 0; i < 40; ++i) {
            if (!axis.run(init{})) continue;
            CHECK_FALSE(model.view().is_moving);
            if (!axis.run(enable{})) continue;
            const std::int64_t before = model.view().position;
            if (!axis.run(move_by{200 * pulse, brisk})) continue;
            if (!axis.run(wait_standstill{})) continue;
            CHECK(model.view().position == before + 200);
            ++rounds;
        }
        CHECK(rounds > 5);
        wire.faults() = {};
        REQUIRE(axis.run(init{}));
        CHECK_FALSE(model.view().is_moving);
    }
}

TEST_CASE("G25, A4: a stop that the drive calls corrupted is repeated, and a look too") {
    closed_axis a{{.answers_bad_crc = true}};
    take(a);
    REQUIRE(a.drive.run(jog{60 * r_per_min}));
    const auto damaged_first = [&](const auto& wanted) {
        a.wire.faults().corrupted_request = 1000;
        REQUIRE(a.drive.begin(wanted) == errc::ok);
        const std::uint32_t first = a.wire.requests();
        while (!a.drive.is_idle()) {
            if (a.wire.requests() > first) a.wire.faults().corrupted_request = 0;
            a.turn();
        }
        return a.drive.last();
    };
    CHECK(damaged_first(stop{}));
    CHECK_FALSE(a.is_moving());
    CHECK(damaged_first(release{}));
    CHECK_FALSE(a.model.enabled());
    client direct{a.line, node<closed_loop::device>{1}};
    a.wire.faults().corrupted_request = 1000; // each of its tries
    const auto refused = direct.read<error_code>();
    CHECK(refused.error() == errc::exception);
    CHECK(refused.exception() == 1);
}

TEST_CASE("S4: an earlier homing cannot be trusted after what may have lost it") {
    SUBCASE("a quick stop") {
        closed_axis a;
        take_homed(a);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(jog{60 * r_per_min}));
        REQUIRE(a.drive.run(quick_stop{}));
        CHECK(a.drive.run(accept_position{}).error() == errc::needs_homing);
        CHECK(a.drive.run(move_to{500 * pulse}).error() == errc::needs_homing);
    }
    SUBCASE("an open loop that was released") {
        open_axis a;
        take_homed(a);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(release{}));
        REQUIRE(a.drive.run(enable{}));
        CHECK(a.drive.run(accept_position{}).error() == errc::needs_homing);
    }
}

TEST_CASE("4.1: a jog is not interrupted by a move, which acts in positioning only") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(jog{60 * r_per_min}));
    const std::size_t before = a.sent(start_relative_frame);
    CHECK(a.drive.run(move_by{.way = 100 * pulse, .then = while_moving::interrupt}).error() == errc::busy);
    CHECK(a.sent(start_relative_frame) == before);
    REQUIRE(a.drive.run(stop{}));
    REQUIRE(a.drive.run(move_by{50'000 * pulse, gentle}));
    CHECK(a.drive.motion() == motion_check::seen);
    REQUIRE(a.drive.run(move_by{.way = -100 * pulse, .then = while_moving::interrupt}));
    CHECK(a.drive.motion() == motion_check::unknown); // which of the two runs cannot be seen
}

TEST_CASE("a homing that is lost sight of is ordered to stop") {
    closed_axis a;
    a.model.attach(simulated::yako_slide());
    take(a);
    REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
    while (!a.is_moving()) a.turn();
    const std::uint64_t acknowledged = a.wire.time_us() + 50'000;
    while (a.wire.time_us() < acknowledged) a.turn();
    a.wire.cut_for(milliseconds(650));
    a.finish();
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.sent(stop_frame) == 2); // init's, and this one
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("limits are set at standstill, and a cleared position is looked at") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(move_by{5000 * pulse, gentle}));
    CHECK(a.drive.run(limit_travel{100 * pulse, -100 * pulse}).error() == errc::busy);
    REQUIRE(a.drive.run(wait_standstill{}));
    REQUIRE(a.drive.run(clear_position{}));
    CHECK(a.drive.seen().position.count() == 0);
}

TEST_CASE("a creep does not vouch for a motion the other way") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(bounded_jog{2000 * pulse}));
    CHECK(a.drive.run(bounded_jog{-2000 * pulse}).error() == errc::busy);
    CHECK(a.drive.run(bounded_jog{2000 * pulse}));
}

TEST_CASE("S4: software limits that a restart lost are found out by the next order, also without a homing") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(limit_travel{5000 * pulse, -5000 * pulse}));
    REQUIRE(a.drive.run(move_by{10 * pulse, brisk}));
    a.model.power_cycle();
    CHECK(a.drive.run(move_by{10 * pulse, brisk}).error() == errc::needs_init);
    CHECK(a.model.starts() == 1);
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.known().limits == limit_enable::disabled);
    REQUIRE(a.drive.run(move_by{10 * pulse, brisk}));
}

TEST_CASE("5.4: an input's move that is cut short at any frame leaves the old move, the new one, or none") {
    using enum positioning;
    for (const bool is_absolute : {false, true}) {
        std::size_t n = 0;
        for (bool is_over = false; !is_over; ++n) {
            closed_axis a;
            take(a);
            REQUIRE(a.drive.run(release{}));
            REQUIRE(a.drive.run(set_input{input::x3, input_function::position_move}));
            REQUIRE(a.drive.run(enable{}));
            REQUIRE(a.drive.run(declare_position{30 * pulse}));
            const set_input_move by_40{40 * pulse, brisk, relative};
            const set_input_move to_130{130 * pulse, brisk, absolute};
            const set_input_move to_70{70 * pulse, brisk, absolute};
            const set_input_move by_100{100 * pulse, brisk, relative};
            REQUIRE(a.drive.run(is_absolute ? by_40 : to_70));
            a.begin_up_to(is_absolute ? to_130 : by_100, n);
            is_over = a.drive.is_idle();
            a.run(5);
            a.model.set_input(3, true);
            a.run(200);
            const std::int64_t way = a.place() - 30;
            CHECK((way == (is_over ? 100 : 0) || (!is_over && (way == 40 || way == 100))));
        }
        CHECK(n > 4);
    }
}
