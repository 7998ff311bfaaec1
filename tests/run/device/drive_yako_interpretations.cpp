// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Machine safety of the YAKOTEC facades under every interpretation of the manual
// (tests/support/yako_interpretations.hpp): under each one the promises hold, or the command fails and reports it. The
// tests check the simulated shaft.
#include <iterator>
#include <string>

#include <doctest/doctest.h>

#include <servobus/client/change_address.hpp>

#include <tests/support/driven_yako.hpp>
#include <tests/support/yako_interpretations.hpp>

namespace drive_yako_interpretations_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using simulated::closed_axis;
using simulated::open_axis;
using drive_options = sim::yako_options;

namespace {

constexpr auto stop_frame = hex("01 06 00 27 01 00 38 51");

const motion_profile gentle{10 * r_per_min, 100 * millisecond, 100 * millisecond, 60 * r_per_min};
const motion_profile brisk{10 * r_per_min, 50 * millisecond, 50 * millisecond, 600 * r_per_min};

template <class A> constexpr bool is_closed = std::is_same_v<A, closed_axis>;

template <class A> void take(A& a) {
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.model.enabled());
}
/// Declares a position that is also the shaft's, counted from where the model started.
template <class A> void take_homed(A& a) {
    take(a);
    REQUIRE(a.drive.run(move_by{30 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
    REQUIRE(a.drive.run(declare_position{30 * pulse}));
}
template <class A> void take_with_input(A& a, input_function as) {
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x3, as}));
    REQUIRE(a.drive.run(enable{}));
}
command_status home_by_24(closed_axis& a) { return a.drive.run(closed_loop::home{homing::home_24}); }
command_status home_by_24(open_axis& a) { return a.drive.run(open_loop::home{homing::home_24}); }
command_status begin_home_by_24(closed_axis& a) { return a.drive.begin(closed_loop::home{homing::home_24}); }
command_status begin_home_by_24(open_axis& a) { return a.drive.begin(open_loop::home{homing::home_24}); }

/// Checks that an absolute move reaches its target, or is refused before anything has moved.
template <class A> void check_absolute_move(A& a, std::int32_t place) {
    const std::int64_t before = a.model.view().shaft;
    const command_status r = a.drive.run(move_to{place * pulse, brisk});
    if (!r) {
        CHECK(r.outcome() == outcome::not_sent);
        CHECK(a.model.view().shaft == before);
        return;
    }
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.model.view().shaft == place);
}
// A55: a program cannot detect a restart of such a drive.
bool may_restart_unseen(const drive_options& by) { return by.restart_keeps_homed && !by.restart_keeps_place; }

template <class A> void quick_stop_loses_the_place(const drive_options& by) {
    A a{by};
    take_homed(a);
    REQUIRE(a.drive.run(move_to{5000 * pulse, brisk}));
    a.run(100);
    REQUIRE(a.drive.run(quick_stop{}));
    CHECK_FALSE(a.is_moving());
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
    CHECK(a.drive.run(accept_position{}).error() == errc::needs_homing);
    REQUIRE(a.drive.run(move_by{100 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
}

template <class A> void release_loses_the_place_of_an_open_loop(const drive_options& by) {
    A a{by};
    take_homed(a);
    REQUIRE(a.drive.run(disable{}));
    CHECK_FALSE(a.model.enabled());
    const command_status r = a.drive.run(enable{});
    if (!r) {
        CHECK(by.homed == sim::yako_homed::until_place_lost);
        CHECK(r.error() == errc::needs_init);
        take(a);
    }
    const std::uint32_t starts = a.model.starts();
    if (is_closed<A>) {
        check_absolute_move(a, 500);
    } else {
        CHECK(a.drive.run(move_to{500 * pulse, brisk}).error() == errc::needs_homing);
        CHECK(a.model.starts() == starts);
    }
}

template <class A> void clearing_keeps_no_place_that_the_drive_has_lost(const drive_options& by) {
    A a{by};
    take_homed(a);
    REQUIRE(a.drive.run(clear_position{}));
    CHECK(a.place() == 0);
    if (a.drive.cached().is_homed) CHECK(a.model.view().is_homed);
}

template <class A> void creep_ends_by_itself(const drive_options& by) {
    A a{by};
    take(a);
    REQUIRE(a.drive.run(bounded_jog{500 * pulse, gentle}));
    a.run(200);
    const std::uint32_t starts = a.model.starts();
    REQUIRE(a.drive.run(bounded_jog{500 * pulse, gentle}));
    CHECK(a.model.starts() == starts);
    a.run(10'000);
    CHECK_FALSE(a.is_moving());
    CHECK(a.model.view().shaft == 500);
}

template <class A> void init_stops_what_runs(const drive_options& by) {
    for (const int what : {0, 1, 2}) {
        CAPTURE(what);
        A a{by};
        take(a);
        if (what == 0) REQUIRE(a.drive.run(velocity{100 * r_per_min}));
        if (what == 1) REQUIRE(a.drive.run(move_by{3000 * pulse, gentle}));
        // there is no switch: the motor would turn for ever
        if (what == 2) REQUIRE(begin_home_by_24(a) == errc::ok);
        while (!a.is_moving()) a.turn();
        line restarted{a.wire, modbus::timing_at(115200)};
        a.run(20);
        a.requests.clear();
        decltype(a.drive) successor{restarted, 1};
        const command_status r = successor.run(init{});
        CHECK(same_bytes(a.requests[0], stop_frame));
        for (std::size_t i = 1; i < a.requests.size(); ++i)
            CHECK((a.requests[i][1] == 0x03 || simulated::is_marker(a.requests[i])));
        const bool can_stop = what != 2 || by.stops_homing;
        CHECK(static_cast<bool>(r) == can_stop); // A58
        CHECK(a.is_moving() != can_stop);
        if (!r) CHECK(successor.state() == drive_state::needs_init);
    }
}

template <class A> void a_stop_that_a_homing_ignores_says_so(const drive_options& by) {
    A a{by};
    take(a);
    REQUIRE(begin_home_by_24(a) == errc::ok);
    while (!a.is_moving()) a.turn();
    CHECK(static_cast<bool>(a.drive.run(quick_stop{})) == by.stops_homing);
    CHECK(a.is_moving() != by.stops_homing);
    CHECK(static_cast<bool>(a.drive.run(disable{})) == by.stops_homing);
    if (by.stops_homing) return;
    client direct{a.line, node<device>{1}}; // as erratum A58 describes
    REQUIRE(direct.template write<auxiliary_command>(auxiliary::release));
    a.run(3000);
    CHECK_FALSE(a.is_moving());
}

template <class A> void a_start_that_is_not_carried_out_is_told(drive_options by) {
    by.start_delay = milliseconds(3000);
    A a{by};
    take(a);
    CHECK(a.drive.run(move_by{1000 * pulse, brisk}).error() == errc::not_executed);
    CHECK(a.drive.motion() == motion_check::not_seen);
    REQUIRE(a.drive.run(halt{}));
    CHECK(a.drive.run(velocity{60 * r_per_min}).error() == errc::not_executed);
    REQUIRE(a.drive.run(halt{}));
    a.run(4000);
    CHECK(a.model.view().shaft == 0);
}

template <class A> void a_start_while_a_stop_input_is_active_is_told(const drive_options& by) {
    A a{by};
    take_with_input(a, input_function::stop);
    a.model.set_input(3, true);
    a.run(10);
    const command_status r = a.drive.run(move_by{1000 * pulse, brisk});
    CHECK(r.error() == (by.refuses_unfit ? errc::exception : errc::not_executed));
    CHECK_FALSE(r);
    a.model.set_input(3, false);
    a.run(3000);
    CHECK(a.model.view().shaft == 0);
    if (a.drive.state() == drive_state::needs_init) take(a);
    REQUIRE(a.drive.run(move_by{1000 * pulse, brisk}));
}

template <class A> void a_save_that_is_not_certain_is_told(const drive_options& by) {
    for (const bool is_reset : {false, true}) {
        A a{by};
        take_with_input(a, input_function::jog_positive);
        const std::uint32_t before = a.wire.requests();
        const command_status begun =
            is_reset ? a.drive.begin(factory_reset{sole_drive_on_the_line{}}) : a.drive.begin(save{});
        REQUIRE(begun == errc::ok);
        while (a.wire.requests() < before + 2) a.turn(); // the status was read
        a.model.set_input(3, true);
        a.run(5);
        REQUIRE(a.is_moving());
        a.finish();
        CHECK_FALSE(a.drive.last());
        if (a.drive.last().outcome() == outcome::refused) CHECK(a.model.saves() == 0);
        CHECK(a.model.peek(0x0044) == 9); // nothing was reset
    }
    A a{by};
    take(a);
    REQUIRE(a.drive.run(save{}));
    CHECK(a.model.saves() == 1);
}

template <class A> void a_restart_tears_no_32_bit_value(const drive_options& by) {
    A a{by};
    take(a);
    REQUIRE(a.drive.run(set_word_order{word_order_setting::low_first}));
    a.model.power_cycle();
    const command_status r = a.drive.run(move_by{70'000 * pulse, brisk});
    if (!r) CHECK(r.outcome() == outcome::not_sent);
    a.run(10'000);
    CHECK(a.model.view().shaft == (r ? 70'000 : 0));
}

template <class A> void a_restart_turns_at_no_other_speed(const drive_options& by) {
    A a{by};
    take(a);
    if (is_closed<A>) REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
    a.model.power_cycle();
    const command_status r = a.drive.run(velocity{60 * r_per_min});
    if (!r) CHECK(r.outcome() == outcome::not_sent);
    a.run(1000);
    CHECK((a.model.view().speed + 500'000) / 1'000'000 == (r ? 60 : 0));
}

template <class A> void a_restart_moves_to_no_wrong_place(const drive_options& by) {
    for (const int when : {0, 1, 2}) { // at standstill, during a move, during a wait for its end
        CAPTURE(when);
        A a{by};
        take_homed(a);
        if (when != 0) REQUIRE(a.drive.run(move_to{5000 * pulse, brisk}));
        a.run(60);
        a.model.power_cycle();
        if (when == 2) (void)a.drive.run(wait_standstill{});
        if (may_restart_unseen(by)) return;
        check_absolute_move(a, 500);
    }
}

template <class A> void limits_that_a_restart_lost_are_found_out(const drive_options& by) {
    A a{by};
    take(a);
    REQUIRE(a.drive.run(limit_travel{-5000 * pulse, 5000 * pulse}));
    a.model.power_cycle();
    const command_status r = a.drive.run(move_by{10 * pulse, brisk});
    if (r) CHECK(a.model.peek(0x0018) == 1);
    if (!r) CHECK(r.outcome() == outcome::not_sent);
}

template <class A> void a_declaration_that_is_not_carried_out_is_told(drive_options by) {
    by.start_delay = milliseconds(3000);
    A a{by};
    take(a);
    CHECK(a.drive.run(declare_position{0 * pulse}).error() == errc::not_executed);
    a.run(4000); // now it is executed
    REQUIRE(a.model.view().is_homed);
    CHECK(a.drive.run(declare_position{500 * pulse}).error() == errc::not_executed);
    CHECK_FALSE(a.drive.cached().is_homed);
    CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
}

command_status begin_home_by_24(closed_axis& a, offset_handling then) {
    return a.drive.begin(closed_loop::home{homing::home_24, 7 * pulse, then});
}
command_status begin_home_by_24(open_axis& a, offset_handling then) {
    return a.drive.begin(open_loop::home{homing::home_24, 7 * pulse, then});
}
template <class A> void a_homing_that_is_cut_short_homes_nothing(const drive_options& by) {
    for (unsigned then = 0; then < 12; ++then) {
        CAPTURE(then);
        A a{by};
        take_with_input(a, input_function::stop);
        REQUIRE(a.drive.run(declare_position{30 * pulse}));
        REQUIRE(begin_home_by_24(a, static_cast<offset_handling>(then)) == errc::ok); // there is no switch
        while (!a.is_moving()) a.turn();
        for (int i = 0; i < 200; ++i) a.turn();
        if (then % 2 != 0) a.model.raise_alarm(2);
        if (then % 2 == 0) a.model.set_input(3, true);
        a.finish();
        CHECK_FALSE(a.drive.last());
        CHECK_FALSE(a.drive.cached().is_homed);
        const errc refused = a.drive.run(move_to{0 * pulse, brisk}).error();
        CHECK((refused == errc::needs_homing || refused == errc::faulted));
    }
}

template <class A> void a_homing_ends_at_home(const drive_options& by) {
    A a{by};
    a.model.attach(simulated::yako_slide());
    take(a);
    for (int i = 0; i < 2; ++i) { // in the second round the drive has already been homed
        REQUIRE(a.drive.run(set_homing_profile{120 * r_per_min, 60 * r_per_min}));
        REQUIRE(home_by_24(a));
        CHECK_FALSE(a.is_moving());
        CHECK(a.drive.cached().is_homed);
        CHECK(a.place() == 0);
        CHECK(a.model.view().shaft == a.model.view().home);
        REQUIRE(a.drive.run(move_to{100 * pulse, brisk}));
        REQUIRE(a.drive.run(wait_standstill{}));
        CHECK(a.model.view().shaft == a.model.view().home + 100);
    }
}

template <class A> void an_alarm_holds_until_it_is_cleared(const drive_options& by) {
    A a{by};
    take(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    a.run(300);
    a.model.raise_alarm(2);
    CHECK(a.drive.run(move_by{1 * pulse, brisk}).error() == errc::faulted);
    CHECK(a.drive.run(enable{}).error() == errc::faulted);
    a.run(3000);
    CHECK_FALSE(a.is_moving());
    CHECK(a.drive.run(fault_reset{}).error() == errc::faulted);
    a.model.end_alarm();
    REQUIRE(a.drive.run(fault_reset{}));
    CHECK((a.drive.state() == drive_state::enabled) == a.model.enabled());
    CHECK_FALSE(a.is_moving());
    if (!a.model.enabled()) REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(move_by{100 * pulse, brisk}));
}

template <class A> void an_interrupting_move_ends_where_it_says(const drive_options& by) {
    A a{by};
    take_homed(a);
    REQUIRE(a.drive.run(move_to{20'000 * pulse, gentle}));
    a.run(100);
    REQUIRE(a.drive.run(move_to{-400 * pulse, brisk, while_moving::interrupt}));
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.model.view().shaft == -400);
    REQUIRE(a.drive.run(move_to{20'000 * pulse, gentle}));
    a.run(100);
    REQUIRE(a.drive.run(relative_move{.way = 400 * pulse, .then = while_moving::interrupt}));
    CHECK(a.drive.motion() == motion_check::unknown); // A59: it cannot be known
    REQUIRE(a.drive.run(halt{}));
    REQUIRE(a.drive.run(move_by{20'000 * pulse, gentle}));
    a.run(500);
    // the move is over at the first read
    const motion_profile steep{600 * r_per_min, {}, {}, 600 * r_per_min};
    const command_status r = a.drive.run(move_by{2 * pulse, steep, while_moving::interrupt});
    if (!by.interrupts_from_target) CHECK(r);
    CHECK(a.drive.motion() == motion_check::unknown);
}

template <class A> struct scenario {
    const char* name;
    void (*play)(const drive_options&);
};
template <class A> void late_start(const drive_options& by) {
    a_start_that_is_not_carried_out_is_told<A>(by);
}
template <class A> void late_place(const drive_options& by) {
    a_declaration_that_is_not_carried_out_is_told<A>(by);
}

template <class A>
constexpr scenario<A> scenarios[] = {
    {"S4: a quick stop invalidates the position", quick_stop_loses_the_place<A>},
    {"S4: a release invalidates the position of an open loop", release_loses_the_place_of_an_open_loop<A>},
    {"S4: clearing the position", clearing_keeps_no_place_that_the_drive_has_lost<A>},
    {"S4: a bounded jog ends by itself", creep_ends_by_itself<A>},
    {"S1: init stops a running motor, or fails", init_stops_what_runs<A>},
    {"S1: a stop that a homing ignores", a_stop_that_a_homing_ignores_says_so<A>},
    {"S4: a start that is not executed", late_start<A>},
    {"S4: a start while a stop input is active", a_start_while_a_stop_input_is_active_is_told<A>},
    {"S4: a save or a reset while the motor moves", a_save_that_is_not_certain_is_told<A>},
    {"S6: a restart and a 32-bit value", a_restart_tears_no_32_bit_value<A>},
    {"S6: a restart and a speed", a_restart_turns_at_no_other_speed<A>},
    {"S4: a restart and an absolute move", a_restart_moves_to_no_wrong_place<A>},
    {"S4: a restart and the software limits", limits_that_a_restart_lost_are_found_out<A>},
    {"S4: a declare_position that is not executed", late_place<A>},
    {"S4: a homing that is interrupted", a_homing_that_is_cut_short_homes_nothing<A>},
    {"S4: two homings", a_homing_ends_at_home<A>},
    {"S1: an alarm", an_alarm_holds_until_it_is_cleared<A>},
    {"S4: a move that interrupts another", an_interrupting_move_ends_where_it_says<A>},
};

} // namespace

TEST_CASE_TEMPLATE(
    "S1, S4, S6: an axis is safe, or the command reports that it is not, under every interpretation "
    "of its manual" *
        doctest::test_suite("interpretations"),
    A, closed_axis, open_axis) {
    ::interpretations::under_yako([](const drive_options& by, std::size_t number, bool is_whole) {
        std::size_t played = 0;
        for (std::size_t i = 0; i < std::size(scenarios<A>); ++i) {
            if (is_whole && i != number % std::size(scenarios<A>)) continue;
            const std::string what = scenarios<A>[i].name;
            CAPTURE(what);
            scenarios<A>[i].play(by);
            ++played;
        }
        return played;
    });
}

TEST_CASE("A37: no speed is sent at 0.1 r/min unless requested; a drive that rescales only its feedback "
          "turns ten times as fast") {
    for (const bool is_feedback : {false, true}) {
        closed_axis a{{.rescales_feedback_only = is_feedback}};
        take(a);
        REQUIRE(a.drive.run(velocity{60 * r_per_min})); // with factory settings both are alike
        a.run(500);
        CHECK(a.model.view().speed == 60'000'000);
        REQUIRE(a.drive.run(halt{}));
        client direct{a.line, node<closed_loop::device>{1}};
        REQUIRE(direct.write<closed_loop::speed_resolution>(speed_count::tenth_r_per_min));
        take(a);
        const std::uint32_t starts = a.model.starts();
        CHECK(a.drive.run(velocity{60 * r_per_min}).error() == errc::wrong_state);
        CHECK(a.drive.run(move_by{10 * pulse, brisk}).error() == errc::wrong_state);
        CHECK(a.drive.run(move_by{10 * pulse}).error() == errc::wrong_state);
        CHECK(home_by_24(a).error() == errc::wrong_state);
        CHECK(a.model.starts() == starts);
        // The command cannot detect it, as its doc comment states.
        REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
        REQUIRE(a.drive.run(velocity{6 * r_per_min}));
        a.run(500);
        CHECK(a.model.view().speed == (is_feedback ? 60'000'000 : 6'000'000));
    }
}

TEST_CASE_TEMPLATE("A60, G24, S6: a new address is found, whether it takes effect immediately or at the next "
                   "power-on",
                   A, closed_axis, open_axis) {
    for (const bool is_early : {false, true}) {
        for (const bool is_facade : {false, true}) {
            A a{{.switches = 0, .kept = sim::yako_kept::written, .moves_address_immediately = is_early}};
            const std::uint8_t one[] = {0, 1};
            REQUIRE(a.model.write(node_address.address, words_view{one}) == 0);
            a.model.power_cycle();
            a.run(10);
            if (is_facade) {
                REQUIRE(a.drive.run(init{}));
                (void)a.drive.run(set_node_address{9, sole_drive_on_the_line{}});
                CHECK(a.drive.state() == drive_state::needs_init);
            } else {
                client direct{a.line, node<closed_loop::device>{1}};
                const status w = change_address<node_address>(direct, 9);
                CHECK(static_cast<bool>(w) == is_early);
                if (!is_early) CHECK(w.error() == errc::not_reached);
                CHECK(direct.node().address == (is_early ? 9 : 1));
            }
            a.model.power_cycle();
            a.run(10);
            decltype(a.drive) there{a.line, 9};
            CHECK(there.run(init{}));
        }
    }
}

TEST_CASE_TEMPLATE("A47: the facade reads neither 0027h nor 002Dh", A, closed_axis, open_axis) {
    A a{{.commands_read_back = true}};
    a.model.attach(simulated::yako_slide());
    take_homed(a);
    REQUIRE(a.drive.run(set_homing_profile{120 * r_per_min, 60 * r_per_min}));
    REQUIRE(home_by_24(a));
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    REQUIRE(a.drive.run(quick_stop{}));
    REQUIRE(a.drive.run(save{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(fault_reset{}));
    for (const auto& f : a.requests) {
        if (modbus::is_write(f[1])) continue;
        const unsigned first = load_word(f, 2);
        const unsigned end = first + load_word(f, 4);
        CHECK((end <= motion_command.address || first > auxiliary_command.address));
    }
}

TEST_CASE_TEMPLATE(
    "A55, S6: a factory reset invalidates the cached state, and so does a restart that undoes the reset", A,
    closed_axis, open_axis) {
    for (const bool reaches : {false, true}) {
        A a{{.restores_eeprom = reaches}};
        take(a);
        REQUIRE(a.drive.run(set_word_order{word_order_setting::low_first}));
        REQUIRE(a.drive.run(save{}));
        REQUIRE(a.drive.run(factory_reset{sole_drive_on_the_line{}}));
        CHECK(a.drive.run(move_by{70'000 * pulse, brisk}).error() == errc::needs_init);
        take(a);
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{70'000 * pulse, brisk}).error() == errc::needs_init);
        a.run(10'000);
        CHECK(a.model.view().shaft == 0);
    }
}

} // namespace drive_yako_interpretations_tests
