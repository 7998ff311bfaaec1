// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Interpretations of the C630S manual to which the simulated drive can be switched: restarts, commands that keep
// their value, the start of segments. Each is compared with its comment in sim/c630s/options.hpp.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_interpretations_tests {

using namespace servobus;
using namespace c630s_bench;
using sim::c630s_restart;

TEST_CASE("C82: after a software reset that is no power-on, a value that waits for the power-on continues to "
          "wait, with Er.941") {
    for (const bool is_power_on : {true, false}) {
        CAPTURE(is_power_on);
        bench b{{.software_reset_is_power_on = is_power_on}};
        const auto alarm = [&b] { return b.get(map::recorded_alarm); };
        b.set(map::software_reset, 1); // nothing waits
        CHECK(alarm() == 0);
        b.set(map::pulses_per_revolution, 20'000);
        CHECK(alarm() == 0x941);
        b.set(map::alarm_reset, 1);
        CHECK(alarm() == 0);
        b.set(map::software_reset, 1);
        CHECK(b.get(map::software_reset) == map::action::none);
        CHECK(b.get(map::pulses_per_revolution) == 20'000);
        CHECK(b.drive.in_force(map::pulses_per_revolution.address) == (is_power_on ? 20'000 : 10'000));
        CHECK(alarm() == (is_power_on ? 0 : 0x941));
        b.restart();
        CHECK(b.drive.in_force(map::pulses_per_revolution.address) == 20'000);
        CHECK(alarm() == 0);
    }
}

TEST_CASE("C80: P0D-20 reads 0 once it is carried out, or keeps its value and the same value is no command") {
    for (const bool ends : {true, false}) {
        CAPTURE(ends);
        bench b{{.commands_end = ends}};
        const auto reset = [&b] {
            b.set(map::alarm_reset, 0);
            b.set(map::alarm_reset, 1);
            return !b.drive.has_fault();
        };
        const auto wanted = map::encoder_reset::fault_perhaps_turns;
        b.set(map::encoder_type, map::encoder_kind::absolute);
        b.restart();
        b.drive.raise(0x731);
        CHECK_FALSE(reset());
        b.set(map::reset_absolute_encoder, wanted);
        CHECK(b.get(map::reset_absolute_encoder) == (ends ? map::encoder_reset::none : wanted));
        CHECK(reset());
        b.drive.raise(0x731);
        b.set(map::reset_absolute_encoder, wanted);
        CHECK(reset() == ends);
        b.set(map::reset_absolute_encoder, 0);
        b.set(map::reset_absolute_encoder, wanted); // another value than before
        CHECK(reset());
    }
}

TEST_CASE("C80: P02-31 reads 0 once it is carried out, or keeps its value and the same value is no command") {
    for (const bool ends : {true, false}) {
        CAPTURE(ends);
        bench b{{.commands_end = ends}};
        const auto wanted = map::initialisation::factory_defaults;
        const std::int64_t factory = b.drive.stored(map::target_speed.address);
        const auto is_restored_by = [&](auto value) {
            b.set(map::target_speed, 777);
            b.set(map::initialise_parameters, value);
            return b.drive.stored(map::target_speed.address) == factory;
        };
        CHECK(is_restored_by(wanted));
        CHECK(b.get(map::initialise_parameters) == (ends ? map::initialisation::none : wanted));
        CHECK(is_restored_by(wanted) == ends);
        CHECK_FALSE(is_restored_by(map::initialisation::none));
        CHECK(is_restored_by(wanted));
        b.restart();
        CHECK(b.get(map::target_speed) == factory);
    }
}

TEST_CASE("C80: a restart discards a homing command that the EEPROM keeps, or carries it out") {
    for (const c630s_restart kept : {c630s_restart::parameters, c630s_restart::homing_command}) {
        const bool is_kept = kept == c630s_restart::homing_command;
        CAPTURE(is_kept);
        bench b{{.restart_keeps = kept}};
        b.assign({});
        b.restart();
        b.set(map::homing_control, map::homing::start);
        b.restart();
        CHECK(b.get(map::homing_control) == (is_kept ? map::homing::start : map::homing::off));
        b.run(100);
        CHECK_FALSE(b.drive.is_homing()); // it waits for S-ON
        b.enable();
        b.run(100);
        CHECK(b.drive.is_homing() == is_kept);
        CHECK((b.get(map::actual_speed) != 0) == is_kept);

        bench here{{.restart_keeps = kept, .homing_command_ends = true}};
        here.set(map::homing_control, map::homing::set_home);
        here.run(2);
        CHECK(here.drive.is_active(out::home_attained));
        here.restart();
        CHECK(here.drive.is_active(out::home_attained) == is_kept); // only this command needs no S-ON
        CHECK(here.get(map::homing_control) == map::homing::off);
    }
}

TEST_CASE("C23: FunIN.28 on a level starts segments in both interpretations, on an edge only in one") {
    for (const bool needs_level : {false, true}) {
        for (const bool is_edge : {false, true}) {
            CAPTURE(needs_level);
            CAPTURE(is_edge);
            bench b{{.segment_start_is_level = needs_level}};
            b.assign({in::position_segment_start});
            b.set(map::virtual_input_logics[1], is_edge ? 1 : 0);
            b.set(map::position_command_source, map::position_source::segments);
            b.set(map::position_segment_mode, map::segment_mode::single);
            b.restart();
            b.set(map::eeprom_update, 0);
            b.enable();
            const bool starts = !needs_level || !is_edge;
            for (const int runs : {1, 2}) {
                b.start();
                b.run_until_still();
                CHECK(b.reference() == (starts ? runs * 10'000 : 0));
            }
            CHECK(b.drive.starts() == (starts ? 2 : 0));
        }
    }
}

} // namespace sim_c630s_interpretations_tests
