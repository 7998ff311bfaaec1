// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade's promises of machine safety, on the wire and under the interpretations of the manual
// (tests/support/c630s_interpretations.hpp); and the commands that cannot work under an interpretation: how they fail,
// and what makes them work.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <tests/support/c630s_interpretations.hpp>
#include <tests/support/c630s_states.hpp>
#include <tests/support/driven_c630s.hpp>

namespace interpretations_c630s_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using c630s_scenes::can_enable;
using rig = simulated::driven_c630s;
using read_so = c630s_interpretations::interpretation;

namespace {

constexpr u16 p31 = virtual_input_levels.address;

/// Sets up the drive, and its outputs as errata C77 and C78 describe.
bool make_ready(rig& r, const sim::c630s_options& how) {
    if (!r.make_ready()) return false;
    if (how.first_output_shows) {
        const bool is_free = r.drive.run(keep<do1_function>{output_function::none}) &&
                             r.drive.run(keep<do2_function>{output_function::none}) &&
                             r.drive.run(keep<do3_function>{output_function::none}) &&
                             r.drive.run(keep<do4_function>{output_function::none}) &&
                             r.drive.run(keep<do5_function>{output_function::none});
        if (!is_free) return false;
    }
    return how.brake != sim::c630s_brake::wired_only ||
           r.drive.run(keep<do2_function>{output_function::brake});
}
/// Enables the drive, or checks that the enable fails where nothing can confirm it, and that the power is
/// then off.
bool enables(rig& r, const sim::c630s_options& how, control_mode mode) {
    const command_status got = r.drive.run(enable_in{mode});
    CHECK(static_cast<bool>(got) == can_enable(how));
    if (got) return true;
    CHECK((got.error() == errc::wrong_state || got.error() == errc::not_reached));
    CHECK_FALSE(r.model.enabled());
    CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
    CHECK(r.drive.state() != drive_state::enabled);
    return false;
}

constexpr control_mode modes[] = {control_mode::speed, control_mode::torque, control_mode::position};

/// In the whole product each interpretation takes part in one of the four tests.
bool is_left_out(const read_so& how, unsigned test) {
    return how.share_of_rows > 1 && how.number % 4 != test;
}

} // namespace

TEST_CASE("S1: under each interpretation init stops the motion that a crashed program left, and starts none" *
          doctest::test_suite("interpretations")) {
    c630s_interpretations::under([](const read_so& how) -> std::size_t {
        if (is_left_out(how, 0)) return 0;
        const control_mode mode = modes[how.number % 3];
        rig r{how.options};
        REQUIRE(make_ready(r, how.options));
        if (!enables(r, how.options, mode)) return 1;
        if (mode == control_mode::speed) REQUIRE(r.drive.run(velocity{300 * r_per_min}));
        if (mode == control_mode::torque) REQUIRE(r.drive.run(torque{20 * percent}));
        if (mode == control_mode::position) {
            REQUIRE(r.drive.run(segment{1, 500'000 * reference_unit, 300 * r_per_min}));
            REQUIRE(r.drive.run(start_segment{1}));
        }
        r.wire.pass(milliseconds(300));
        const bool is_level = mode == control_mode::position && how.options.segment_start_is_level;
        CHECK(r.model.stands_still() == is_level);
        r.requests.clear();
        rig::drive_type successor{r.line, 1, unsupervised};
        REQUIRE(successor.run(init{}));
        CHECK(same_bytes(r.requests[0],
                         modbus::write_frame(1, target_speed.address, std::array<u16, 2>{0, 0})));
        CHECK(same_bytes(r.requests[1], modbus::write_frame(1, p31, 0)));
        for (const u16 address : {target_speed.address, target_torque.address, jog_speed.address}) {
            for (const std::uint16_t word : r.written_to(address)) CHECK(word == 0);
        }
        for (const std::uint16_t word : r.written_to(p31)) CHECK((word & ~terminal::marker) == 0);
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        return 1;
    });
}

TEST_CASE(
    "S2: under each interpretation an enable starts nothing that the EEPROM or another program has set" *
    doctest::test_suite("interpretations")) {
    c630s_interpretations::under([](const read_so& how) -> std::size_t {
        if (is_left_out(how, 1)) return 0;
        rig r{how.options};
        REQUIRE(make_ready(r, how.options));
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.store<eeprom_update>(off_on::on));
        REQUIRE(direct.store<target_speed>(200));
        REQUIRE(direct.store<target_torque>(50 * percent));
        REQUIRE(direct.store<position_segment_mode>(segment_mode::cyclic));
        REQUIRE(direct.store<speed_segment_mode>(segment_mode::cyclic));
        REQUIRE(direct.store<speed_command_selection>(command_selection::auxiliary));
        REQUIRE(direct.store<auxiliary_speed_source>(speed_source::segments));
        REQUIRE(
            direct.store<homing_control>(checked(how.number % 2 == 0 ? homing::at_power_on : homing::start)));
        r.model.power_cycle();
        r.run(100);
        CHECK_FALSE(r.model.enabled());
        REQUIRE(r.drive.run(init{}));
        if (r.drive.state() != drive_state::disabled) { // P05-30 is part of the set-up
            REQUIRE(r.drive.run(set_up{}));
            r.model.power_cycle();
            REQUIRE(r.drive.run(init{}));
        }
        if (!enables(r, how.options, modes[how.number % 3])) return 1;
        r.run(600);
        CHECK(r.model.enabled());
        CHECK(r.model.stands_still());
        CHECK(r.model.homings() == 0);
        CHECK(r.model.peek(target_speed.address) == 0);
        CHECK(r.model.peek(target_torque.address) == 0);
        CHECK(r.model.peek(homing_control.address) == 0);
        return 1;
    });
}

TEST_CASE("S5: under each interpretation a restart is detected and does not energise the motor" *
          doctest::test_suite("interpretations")) {
    c630s_interpretations::under([](const read_so& how) -> std::size_t {
        if (is_left_out(how, 2)) return 0;
        const control_mode mode = modes[how.number % 3];
        rig r{how.options};
        REQUIRE(make_ready(r, how.options));
        if (!enables(r, how.options, mode)) return 1;
        if (mode == control_mode::speed) REQUIRE(r.drive.run(velocity{100 * r_per_min}));
        r.wire.pass(milliseconds(600));
        r.model.power_cycle();
        r.wire.pass(milliseconds(600));
        const std::uint32_t enables_before = r.model.enables();
        errc found = errc::ok;
        switch ((how.number / 3) % 3) {
        case 0: found = r.drive.read().error(); break;
        case 1:
            found = mode == control_mode::position ? r.drive.run(start_segment{1}).error()
                    : mode == control_mode::speed  ? r.drive.run(velocity{100 * r_per_min}).error()
                                                   : r.drive.run(torque{1 * percent}).error();
            break;
        default:
            found = mode == control_mode::position ? r.drive.run(home{1 * second}).error()
                    : mode == control_mode::speed  ? r.drive.run(jog{10 * r_per_min}).error()
                                                   : r.drive.run(torque{1 * percent}).error();
        }
        CHECK(found == errc::needs_init);
        CHECK(r.drive.state() == drive_state::needs_init);
        r.run(300);
        CHECK(r.model.enables() == enables_before);
        CHECK_FALSE(r.model.enabled());
        CHECK(r.model.stands_still());
        CHECK(r.model.stored(p31) == 0);
        CHECK(r.model.homings() == 0);
        return 1;
    });
}

TEST_CASE(
    "S5, S6: under each interpretation a fault reset leaves the servo off, and no 32-bit value is sent in a "
    "stale word order" *
    doctest::test_suite("interpretations")) {
    c630s_interpretations::under([](const read_so& how) -> std::size_t {
        if (is_left_out(how, 3)) return 0;
        rig r{how.options};
        REQUIRE(make_ready(r, how.options));
        if (!enables(r, how.options, control_mode::speed)) return 1;
        REQUIRE(r.drive.run(velocity{100 * r_per_min}));
        r.run(200);
        r.model.raise(0x620);
        (void)r.drive.read();
        r.run(50);
        CHECK_FALSE(r.model.enabled());
        const std::uint32_t enables_before = r.model.enables();
        if (r.drive.state() == drive_state::needs_init) REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.run(fault_reset{}));
        r.run(300);
        CHECK_FALSE(r.model.has_alarm(0x620));
        CHECK_FALSE(r.model.enabled());
        CHECK(r.model.enables() == enables_before);
        // Another program changes the word order. The facade detects it before a 32-bit value is sent.
        client direct{r.line, node<device>{1}};
        const auto token = direct.ram_only();
        REQUIRE(token);
        REQUIRE(direct.write<pair_word_order>(word_order_setting::high_first, *token));
        r.requests.clear();
        CHECK(r.drive.run(set<home_offset>{70'000}).error() == errc::needs_init);
        CHECK(r.written_to(home_offset.address).empty());
        return 1;
    });
}

// Commands that cannot work under an interpretation

TEST_CASE("C77: if the drive needs a wired brake output and has none, an enable is not confirmed and the "
          "power is switched off") {
    rig r{{.brake = sim::c630s_brake::wired_only}};
    REQUIRE(r.make_ready());
    CHECK(r.drive.run(enable_in{control_mode::speed}).error() == errc::not_reached);
    CHECK_FALSE(r.model.enabled());
    CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
    CHECK(r.drive.state() == drive_state::needs_init);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(keep<do2_function>{output_function::brake})); // this makes it work
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    CHECK(r.model.enabled());
}

TEST_CASE("C77: if the brake output is already active before an enable, the enable is refused") {
    rig r{{.brake = sim::c630s_brake::always_released}};
    REQUIRE(r.make_ready());
    const std::uint32_t enables_before = r.model.enables();
    for (const control_mode mode : modes) {
        CHECK(r.drive.run(enable_in{mode}).error() == errc::wrong_state);
        REQUIRE(r.drive.run(init{}));
    }
    CHECK(r.drive.run(run_speed_segments{}).error() == errc::wrong_state);
    CHECK(r.model.enables() == enables_before);
    CHECK(r.written_to(p31).back() == terminal::marker);
}

TEST_CASE(
    "C78: if only the first output with a function shows it, an enable is refused until no wired output has "
    "it") {
    rig r{{.first_output_shows = true}};
    REQUIRE(r.make_ready());
    CHECK(r.drive.run(enable_in{control_mode::speed}).error() == errc::wrong_state);
    CHECK_FALSE(r.model.enabled());
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(keep<do1_function>{output_function::none}));
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    // VDO11 does not show the fault, since DO4 does. The brake output shows it.
    r.model.raise(0x620);
    r.run(20);
    CHECK_FALSE(r.model.enabled());
    (void)r.drive.read();
    CHECK(r.drive.state() != drive_state::enabled);
    CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
}

TEST_CASE("C78: an input function also conflicts with that of a disabled virtual input") {
    for (const bool counts : {false, true}) {
        CAPTURE(counts);
        rig r{{.disabled_inputs_count = counts}};
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.store<virtual_input_functions>(15, input_function::zero_clamp));
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.state() == drive_state::needs_set_up);
        CHECK(r.drive.run(keep<di1_function>{input_function::zero_clamp}).error() == errc::already_assigned);
        CHECK(r.drive.conflicting_terminal() == "P17-30"_p);
        r.model.power_cycle();
        CHECK_FALSE(r.model.has_alarm(0x130));
    }
}

TEST_CASE("C79: P0C-25, added to the drive's own response time, is added to the time limit after init") {
    rig r{{.delay_is_additional = true}};
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.store<response_delay>(50)); // the response takes 90 ms
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    CHECK(r.model.enabled());
}

TEST_CASE("C43: the drive defines the count of a recorded voltage: tenths of a volt, or volts") {
    for (const bool in_volts : {false, true}) {
        CAPTURE(in_volts);
        rig r{{.bus_voltage_in_volts = in_volts}};
        REQUIRE(r.make_ready());
        r.model.raise(0x620);
        const auto entry = r.drive.fault(0);
        REQUIRE(entry);
        CHECK(r.model.peek(recorded_bus_voltage.address) == (in_volts ? 310 : 3100));
        CHECK(r.model.peek(bus_voltage.address) == 3100);
    }
}

TEST_CASE("C82: if a software reset is no power-on, a drive that waits for a power-on is not enabled after "
          "it") {
    for (const bool is_power_on : {true, false}) {
        CAPTURE(is_power_on);
        rig r{{.software_reset_is_power_on = is_power_on}};
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(set_up{}));
        (void)r.drive.run(restart{});
        r.run(100);
        REQUIRE(r.drive.run(init{}));
        const command_status got = r.drive.run(enable_in{control_mode::speed});
        CHECK(static_cast<bool>(got) == is_power_on);
        CHECK(r.model.enabled() == is_power_on);
        if (is_power_on) continue;
        CHECK(got.error() == errc::not_reached);
        CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
        r.model.power_cycle();
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    }
}

TEST_CASE("C83, C23: a jog or a start that the drive interprets differently moves nothing") {
    rig r{{.segment_start_is_level = true, .jog_follows_command = true}};
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.drive.run(jog{60 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.stands_still());
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.run(segment{1, 1000 * reference_unit, 60 * r_per_min}));
    REQUIRE(r.drive.run(start_segment{1}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.starts() == 0);
    CHECK(r.model.stands_still());
}

} // namespace interpretations_c630s_tests
