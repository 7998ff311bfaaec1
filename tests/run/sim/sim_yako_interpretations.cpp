// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The interpretations of the YAKOTEC manual to which the simulated steppers can be switched. Each is compared with
// its comment in sim/yako/options.hpp.
#include <doctest/doctest.h>

#include <tests/support/simulated_yako.hpp>
#include <tests/support/yako_bench.hpp>

namespace sim_yako_interpretations_tests {

using namespace servobus;
using namespace yako_bench;
using sim::yako_alarm;
using sim::yako_homed;
using sim::yako_in_position;
using sim::yako_kept;

namespace {

// 0023h is RW, 0062h RW/S; the line's settings and 0019h, 001Ah are RW.
constexpr std::uint16_t plain = 0x0023;
constexpr std::uint16_t marked = 0x0062;
constexpr std::uint16_t format = 0x0015;
constexpr std::uint16_t pairs = 0x0019;

template <class B> std::vector<std::uint16_t> after_a_restart(yako_kept kept, bool is_saved) {
    B b{{.kept = kept}};
    for (const std::uint16_t at : {plain, marked}) CHECK(b.write(at, 77) == 0);
    for (const std::uint16_t at : {format, pairs}) CHECK(b.write(at, 1) == 0);
    if (is_saved) b.command(auxiliary::save_parameters);
    b.drive.power_cycle();
    return {b.drive.peek(plain), b.drive.peek(marked), b.drive.peek(format), b.drive.peek(pairs)};
}

template <class B> void declare(B& b, std::int32_t place) {
    b.set(cl::homing_offset_mode, 6);
    b.set(cl::home_offset, place);
    b.set(cl::homing_method, 35);
    b.command(motion_code::home());
    b.run(30);
    CHECK(b.status().is_homed());
}

} // namespace

TEST_CASE_TEMPLATE("A53, A55: which registers a restart keeps, with a save and without one", B, BOTH) {
    using words = std::vector<std::uint16_t>;
    CHECK(after_a_restart<B>(yako_kept::saved, false) == words{60, 120, 0, 0});
    CHECK(after_a_restart<B>(yako_kept::saved, true) == words{77, 77, 1, 1});
    CHECK(after_a_restart<B>(yako_kept::marked, false) == words{60, 120, 0, 0});
    CHECK(after_a_restart<B>(yako_kept::marked, true) == words{60, 77, 1, 0});
    CHECK(after_a_restart<B>(yako_kept::line_settings, false) == words{60, 120, 1, 1});
    CHECK(after_a_restart<B>(yako_kept::line_settings, true) == words{77, 77, 1, 1});
    CHECK(after_a_restart<B>(yako_kept::written, false) == words{77, 77, 1, 1});
}

TEST_CASE_TEMPLATE("A55: whether a restart keeps the position and the homed bit", B, BOTH) {
    for (const bool keeps_place : {false, true}) {
        for (const bool keeps_homed : {false, true}) {
            B b{{.restart_keeps_place = keeps_place, .restart_keeps_homed = keeps_homed}};
            declare(b, 700);
            b.drive.power_cycle();
            b.run(30);
            CHECK(b.position() == (keeps_place ? 700 : 0));
            CHECK(b.status().is_homed() == keeps_homed);
            b.move(100);
            b.run_until_still();
            CHECK(b.position() == (keeps_place ? 800 : 100));
        }
    }
}

TEST_CASE_TEMPLATE("A55: a restore that does not reach the EEPROM lasts until the next restart", B, BOTH) {
    for (const bool reaches : {false, true}) {
        B b{{.restores_eeprom = reaches}};
        CHECK(b.write(plain, 77) == 0);
        b.command(auxiliary::save_parameters);
        b.command(auxiliary::restore_parameters);
        CHECK(b.drive.peek(plain) == 60);
        b.drive.power_cycle();
        CHECK(b.drive.peek(plain) == (reaches ? 60 : 77));
    }
}

TEST_CASE_TEMPLATE("A54: in position is set at standstill, until a command, after the first move, at the "
                   "target, or until the next move",
                   B, BOTH) {
    struct expected {
        yako_in_position of;
        bool at_first, ordered, jogged, short_of_it, there, jogging_on;
    };
    using enum yako_in_position;
    for (const expected& e : {expected{at_rest, true, true, true, true, true, false},
                              expected{until_commanded, true, false, true, true, true, false},
                              expected{after_first_move, false, false, false, true, true, false},
                              expected{at_target, false, false, false, false, true, false},
                              expected{until_next_move, false, false, false, false, true, true}}) {
        CAPTURE(static_cast<int>(e.of));
        B b{{.start_delay = milliseconds(20), .in_position = e.of}};
        const auto is_there = [&b] { return b.status().is_in_position(); };
        b.run(50);
        CHECK(is_there() == e.at_first);
        b.command(motion_code::jog());
        b.run(5);
        CHECK(is_there() == e.ordered);
        b.run(100);
        CHECK_FALSE(is_there());
        b.command(motion_code::stop());
        b.run_until_still();
        CHECK(is_there() == e.jogged);
        b.move(5000);
        b.run(300);
        b.command(motion_code::stop());
        b.run_until_still();
        CHECK(is_there() == e.short_of_it);
        b.move(100);
        b.run(30);
        CHECK_FALSE(is_there());
        b.run_until_still();
        CHECK(is_there() == e.there);
        b.command(motion_code::jog());
        b.run(100);
        CHECK(is_there() == e.jogging_on);
    }
}

TEST_CASE_TEMPLATE("A54: the homed bit is set until a homing begins, until the position is lost, or "
                   "always",
                   B, BOTH) {
    for (const yako_homed interpretation :
         {yako_homed::until_homing, yako_homed::until_place_lost, yako_homed::always}) {
        CAPTURE(static_cast<int>(interpretation));
        const bool is_lost = interpretation == yako_homed::until_place_lost;
        for (const auxiliary what : {auxiliary::release, auxiliary::clear_position}) {
            B b{{.homed = interpretation}};
            declare(b, 10);
            b.command(what);
            CHECK(b.status().is_homed() != is_lost);
        }
        B b{{.homed = interpretation}};
        declare(b, 10);
        b.command(motion_code::emergency_stop());
        CHECK(b.status().is_homed() != is_lost);
        declare(b, 10);
        b.set(cl::homing_method, 24); // there is no switch: the motor turns for ever
        b.command(motion_code::home());
        b.run(50);
        CHECK(b.status().is_moving());
        CHECK(b.status().is_homed() == (interpretation == yako_homed::always));
        b.command(motion_code::stop());
        b.run_until_still();
        CHECK(b.status().is_homed() == (interpretation == yako_homed::always));
    }
}

TEST_CASE_TEMPLATE("A54: the homed bit is set before or after the offset move", B, BOTH) {
    for (const bool is_before : {false, true}) {
        B b{{.is_homed_before_offset = is_before}};
        b.set(cl::home_offset, 2000);
        b.set(cl::homing_method, 35);
        b.command(motion_code::home());
        b.run(50);
        CHECK(b.status().is_moving());
        CHECK(b.status().is_homed() == is_before);
        b.run_until_still();
        CHECK(b.status().is_homed());
    }
}

TEST_CASE_TEMPLATE("A57: an alarm releases the motor until an enable or until it is cleared, or the motor "
                   "holds",
                   B, BOTH) {
    for (const yako_alarm interpretation :
         {yako_alarm::releases, yako_alarm::clearing_enables, yako_alarm::holds}) {
        CAPTURE(static_cast<int>(interpretation));
        for (const bool was_enabled : {false, true}) {
            B b{{.alarm = interpretation}};
            if (!was_enabled) b.command(auxiliary::release);
            if (was_enabled) b.command(motion_code::jog());
            b.run(100);
            b.drive.raise_alarm(3);
            b.run(20);
            CHECK(b.get(cl::error_code) == 3);
            CHECK(b.drive.enabled() == (was_enabled && interpretation == yako_alarm::holds));
            if (interpretation == yako_alarm::holds) CHECK_FALSE(b.status().is_moving());
            const std::uint32_t starts = b.drive.starts();
            b.command(auxiliary::clear_alarm); // its cause is still present
            b.command(auxiliary::enable);
            b.command(motion_code::jog());
            CHECK(b.drive.starts() == starts);
            b.drive.end_alarm();
            b.command(auxiliary::clear_alarm);
            CHECK(b.get(cl::error_code) == 0);
            CHECK(b.drive.enabled() == (was_enabled && interpretation != yako_alarm::releases));
        }
    }
}

TEST_CASE_TEMPLATE("A57: after a second alarm, clearing enables the motor only if it was enabled before the "
                   "first",
                   B, BOTH) {
    for (const bool was_enabled : {false, true}) {
        CAPTURE(was_enabled);
        B b{{.alarm = yako_alarm::clearing_enables}};
        if (!was_enabled) b.command(auxiliary::release);
        b.run(20);
        for (const std::uint16_t code : {std::uint16_t{3}, std::uint16_t{2}}) {
            b.drive.raise_alarm(code);
            b.run(20);
            CHECK(b.get(cl::error_code) == 3); // the first one
            CHECK_FALSE(b.status().is_enabled());
        }
        b.drive.end_alarm();
        b.command(auxiliary::clear_alarm);
        CHECK(b.get(cl::error_code) == 0);
        CHECK(b.status().is_enabled() == was_enabled);
    }
}

TEST_CASE_TEMPLATE("A56: a command that does not fit is acknowledged and ignored, or refused", B, BOTH) {
    for (const bool refuses : {false, true}) {
        const int answer = refuses ? 7 : 0;
        B b{{.refuses_unfit = refuses}};
        const auto command = [&b](auto what) { return b.write(0x0027, to_bits(what)); };
        const auto help = [&b](auto what) { return b.write(0x002D, to_bits(what)); };
        CHECK(command(motion_code::jog()) == 0);
        b.run(100);
        CHECK(command(motion_code::jog()) == answer);
        CHECK(command(motion_code::move(positioning::relative, while_moving::interrupt)) == 0);
        CHECK(command(motion_code::home()) == answer);
        CHECK(help(auxiliary::save_parameters) == answer);
        CHECK(help(auxiliary::restore_parameters) == answer);
        CHECK(b.drive.saves() == 0);
        CHECK(help(auxiliary::release) == 0);
        b.run(3000);
        CHECK(command(motion_code::jog()) == answer);
        b.drive.raise_alarm(1);
        CHECK(help(auxiliary::enable) == answer);
        CHECK(command(motion_code::stop()) == 0);
        CHECK(b.drive.starts() == 2);
    }
}

TEST_CASE_TEMPLATE("A56: with its option set, a save is executed while the motor moves", B, BOTH) {
    for (const bool refuses : {false, true}) {
        B b{{.refuses_unfit = refuses, .saves_while_moving = true}};
        b.command(motion_code::jog());
        b.run(100);
        b.command(auxiliary::save_parameters);
        CHECK(b.drive.saves() == 1);
    }
}

TEST_CASE_TEMPLATE("A47: 0027h and 002Dh read as 0, or until a restart as the last value written", B, BOTH) {
    for (const bool is_read_back : {false, true}) {
        B b{{.commands_read_back = is_read_back}};
        b.command(motion_code::jog());
        b.command(auxiliary::enable);
        CHECK(b.drive.peek(0x0027) == (is_read_back ? 2 : 0));
        CHECK(b.drive.peek(0x002D) == (is_read_back ? 0x12 : 0));
        CHECK(b.drive.starts() == 1);
        b.drive.power_cycle();
        CHECK(b.drive.peek(0x0027) == 0);
    }
}

TEST_CASE_TEMPLATE("A58: a release ends a homing that no stop command can end", B, BOTH) {
    for (const bool is_stopped : {true, false}) {
        for (const motion_code what : {motion_code::stop(), motion_code::emergency_stop()}) {
            B b{{.stops_homing = is_stopped}};
            b.command(motion_code::home());
            b.run(300);
            b.command(what);
            b.run(300);
            CHECK(b.status().is_moving() != is_stopped);
            b.command(auxiliary::release);
            b.run(3000);
            CHECK_FALSE(b.status().is_moving());
        }
    }
}

TEST_CASE_TEMPLATE("A59: a relative move that interrupts another one starts at the motor's position or at "
                   "the old target",
                   B, BOTH) {
    for (const bool from_target : {false, true}) {
        B b{{.interrupts_from_target = from_target}};
        b.set(servobus::yako::acceleration_time, 0);
        b.set(servobus::yako::deceleration_time, 0);
        b.move(1000);
        b.run(300);
        const std::int32_t there = b.position();
        REQUIRE(there < 1000);
        b.move(500, positioning::relative, while_moving::interrupt);
        b.run_until_still();
        CHECK(about(b.position(), (from_target ? 1000 : there) + 500, 2));
    }
}

TEST_CASE_TEMPLATE("A32: ramp times refer to the speed of the motion, or to 1000 r/min", B, BOTH) {
    for (const bool to_1000 : {false, true}) {
        B b{{.start_delay = {}, .ramps_to_1000_r_per_min = to_1000}};
        b.set(cl::jog_speed, 500);
        b.set(servobus::yako::jog_acceleration_time, 1000);
        b.command(motion_code::jog());
        b.run(250);
        CHECK(about(b.drive.view().speed, (to_1000 ? 250 : 125) * one_r_per_min, 2 * one_r_per_min));
    }
}

TEST_CASE("A37: 001Ah rescales every speed, or only the feedback") {
    for (const bool is_feedback : {false, true}) {
        closed b{{.rescales_feedback_only = is_feedback}};
        b.set(cl::speed_resolution, 1);
        b.set(cl::jog_speed, 200);
        b.command(motion_code::jog());
        b.run(500);
        CHECK(about(b.drive.view().speed, (is_feedback ? 200 : 20) * one_r_per_min, one_r_per_min));
        CHECK(b.speed() == (is_feedback ? 2000 : 200));
    }
}

TEST_CASE_TEMPLATE("A60: while the switches are off, 0013h takes effect at the next power-on or immediately",
                   B, BOTH) {
    for (const bool is_early : {false, true}) {
        B b{{.switches = 0, .kept = yako_kept::written, .moves_address_immediately = is_early}};
        b.set(servobus::yako::node_address, 9);
        CHECK(b.drive.address() == (is_early ? 9 : 0));
        b.drive.power_cycle();
        CHECK(b.drive.address() == 9);
        b.drive.set_switches(5);
        b.set(servobus::yako::node_address, 7);
        CHECK(b.drive.address() == (is_early ? 5 : 9));
    }
}

} // namespace sim_yako_interpretations_tests
