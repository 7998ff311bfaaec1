// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade with lost responses, a restarted drive, a drive to which another program has written,
// interrupted commands, programs that crash, and an EEPROM that must not wear out.
#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>

namespace drive_c630s_faults_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using rig = simulated::driven_c630s;

namespace {

constexpr u16 p31 = virtual_input_levels.address;

void be_enabled_in(rig& r, control_mode mode) {
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{mode}));
    REQUIRE(r.model.enabled());
}

/// Which frames of a command are lost: `count` from number `first` on, the requests or the responses.
struct mishap {
    std::size_t first;
    std::size_t count = 1;
    bool loses_request = false;
};

template <class Command> command_status run_with(rig& r, const Command& wanted, const mishap& what) {
    const std::size_t start = r.wire.requests();
    if (const command_status begun = r.drive.begin(wanted); !begun) return begun;
    while (!r.drive.is_idle()) {
        const std::size_t done = r.wire.requests() - start;
        const bool strikes_request = done >= what.first && done < what.first + what.count;
        const bool strikes_response = done > what.first && done <= what.first + what.count;
        r.wire.faults().lost_request = what.loses_request && strikes_request ? 1000 : 0;
        r.wire.faults().lost_response = !what.loses_request && strikes_response ? 1000 : 0;
        r.turn();
    }
    r.wire.faults() = {};
    return r.drive.last();
}

std::size_t count_of(const rig& r, u16 address, u16 bits) {
    std::size_t n = 0;
    for (const u16 word : r.written_to(address)) n += (word & bits) != 0 ? 1u : 0u;
    return n;
}

} // namespace

TEST_CASE("G17: an hour of velocity commands writes nothing to the EEPROM") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    const std::uint32_t before = r.model.eeprom_writes();
    for (int i = 0; i < 1200; ++i) {
        const int wanted = i % 200 - 100;
        if (!r.drive.run(velocity{wanted * r_per_min})) FAIL("a command was refused");
        r.wire.pass(milliseconds(2990));
    }
    CHECK(r.wire.time_us() > 3'600'000'000u);
    CHECK(r.model.eeprom_writes() == before);
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.model.eeprom_writes() == before);
}

TEST_CASE("G17: segments, starts, jogs, gears, torque and reads write nothing to the EEPROM") {
    rig r;
    REQUIRE(r.make_ready());
    const std::uint32_t before = r.model.eeprom_writes();
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    for (int i = 0; i < 20; ++i) {
        REQUIRE(r.drive.run(segment{1, 10 * i * reference_unit, 300 * r_per_min, 5 * millisecond}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.drive.read());
    }
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(homing_by{homing_mode::forward_z}));
    REQUIRE(r.drive.run(gear{131'072, 10'000}));
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.drive.run(jog{20 * r_per_min}));
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.drive.run(quick_stop{}));
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(fault_reset{}));
    REQUIRE(r.drive.fault(1));
    REQUIRE(r.drive.run(enable_in{control_mode::torque}));
    REQUIRE(r.drive.run(torque{5 * percent}));
    REQUIRE(r.drive.run(init{}));
    CHECK(r.model.eeprom_writes() == before);
}

TEST_CASE("G18: init switches off the EEPROM writes of a drive before anything is written repeatedly") {
    rig r;
    REQUIRE(r.make_ready());
    for (int i = 0; i < 20; ++i) {
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.store<eeprom_update>(off_on::on));
        const std::uint32_t before = r.model.eeprom_writes();
        REQUIRE(r.drive.run(init{}));
        CHECK(r.model.eeprom_writes() - before <= 5);
        CHECK(r.model.peek(eeprom_update.address) == 0);
    }
}

TEST_CASE(
    "G15, S4: a segment is started at most once, whichever frame is lost; after a start of unknown outcome "
    "the motion is checked") {
    unsigned seen = 0;
    unsigned failed = 0;
    for (const bool loses_request : {false, true}) {
        for (const std::size_t losses : {std::size_t{1}, std::size_t{3}}) {
            for (std::size_t first = 0; first < 12; ++first) {
                CAPTURE(first);
                rig r;
                be_enabled_in(r, control_mode::position);
                REQUIRE(r.drive.run(segment{3, 20'000 * reference_unit, 600 * r_per_min, 50 * millisecond}));
                r.requests.clear();
                const command_status got = run_with(r, start_segment{3}, {first, losses, loses_request});
                CHECK(r.model.starts() <= 1);
                CHECK(count_of(r, p31, terminal::segment_start) <= 1);
                if (got) {
                    CHECK(r.model.starts() == 1);
                    CHECK(r.drive.state() == drive_state::enabled);
                    continue;
                }
                ++failed;
                CHECK(r.drive.state() == drive_state::needs_init);
                CHECK(r.drive.run(start_segment{3}).error() == errc::needs_init);
                if (r.drive.motion() == motion_check::seen) {
                    ++seen;
                    CHECK(r.model.starts() == 1);
                }
                if (r.drive.motion() == motion_check::not_asked) CHECK(r.model.starts() == 0);
                REQUIRE(r.drive.run(init{}));
                CHECK(r.model.stands_still());
                CHECK_FALSE(r.model.enabled());
                CHECK(r.drive.state() == drive_state::disabled);
            }
        }
    }
    CHECK(seen > 0);
    CHECK(failed > 10);
}

TEST_CASE("G21: whichever frame of an enable is lost, the cached state is correct or invalid, and servo-on "
          "is sent at most once") {
    unsigned struck = 0;
    for (const std::size_t losses : {std::size_t{1}, std::size_t{3}}) {
        for (std::size_t first = 0; first < 45; ++first) {
            CAPTURE(first);
            rig r;
            REQUIRE(r.make_ready());
            r.requests.clear();
            const command_status got = run_with(r, enable{}, {first, losses});
            struck += r.wire.struck() != 0 ? 1u : 0u;
            CHECK(count_of(r, p31, terminal::servo_on) <= 1);
            CHECK((r.drive.state() == drive_state::enabled) == static_cast<bool>(got));
            if (got) {
                CHECK(r.model.enabled());
                continue;
            }
            CHECK(r.drive.state() == drive_state::needs_init);
            CHECK(r.drive.run(velocity{10 * r_per_min}).error() == errc::needs_init);
            CHECK(r.model.stands_still());
            REQUIRE(r.drive.run(init{}));
            CHECK_FALSE(r.model.enabled());
        }
    }
    CHECK(struck > 40);
}

TEST_CASE("G18: whichever frame of the set-up is lost, another init and set_up complete it") {
    unsigned struck = 0;
    for (std::size_t first = 0; first < 75; first += 2) {
        CAPTURE(first);
        rig r;
        REQUIRE(r.drive.run(init{}));
        const command_status got = run_with(r, set_up{}, {first, 3});
        struck += r.wire.struck() != 0 ? 1u : 0u;
        if (!got) {
            CHECK(r.drive.state() == drive_state::needs_init);
            REQUIRE(r.drive.run(init{}));
            CHECK(r.model.peek(eeprom_update.address) == 0);
            REQUIRE(r.drive.run(set_up{}));
        }
        CHECK(r.model.peek(eeprom_update.address) == 0);
        r.model.power_cycle();
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.state() == drive_state::disabled);
        REQUIRE(r.drive.run(enable{}));
    }
    CHECK(struck > 20);
}

TEST_CASE("S5: a restart is detected, and no cached word energises the motor again") {
    for (const bool keeps_off : {true, false}) {
        CAPTURE(keeps_off);
        rig r{{.stores_eeprom_off = keeps_off}};
        be_enabled_in(r, control_mode::position);
        REQUIRE(r.drive.run(segment{1, 1000 * reference_unit, 60 * r_per_min}));
        r.model.power_cycle();
        r.wire.pass(milliseconds(1000));
        const std::uint32_t enables = r.model.enables();
        const std::uint32_t writes = r.model.eeprom_writes();
        SUBCASE("by a start") { CHECK(r.drive.run(start_segment{1}).error() == errc::needs_init); }
        SUBCASE("by feedback") { CHECK(r.drive.read().error() == errc::needs_init); }
        SUBCASE("by homing") { CHECK(r.drive.run(home{1 * second}).error() == errc::needs_init); }
        SUBCASE("by a segment, if the drive would store it in the EEPROM") {
            if (!keeps_off)
                CHECK(r.drive.run(segment{1, 1 * reference_unit, 1 * r_per_min}).error() == errc::needs_init);
            else
                CHECK(r.drive.read().error() == errc::needs_init);
        }
        CHECK(r.drive.state() == drive_state::needs_init);
        CHECK(r.model.eeprom_writes() == writes + (keeps_off ? 0u : 1u)); // one servo-off
        CHECK(r.drive.run(start_segment{1}).error() == errc::needs_init);
        r.wire.pass(milliseconds(500));
        CHECK(r.model.enables() == enables);
        CHECK(r.model.stands_still());
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.state() == drive_state::disabled);
    }
}

TEST_CASE("S5: a program that only sends velocity commands detects a restart within half a second") {
    rig r{{.stores_eeprom_off = false}};
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{50 * r_per_min}));
    r.model.power_cycle();
    unsigned commands = 0;
    while (r.drive.run(velocity{50 * r_per_min})) {
        ++commands;
        r.wire.pass(milliseconds(20));
        REQUIRE(commands < 30);
    }
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("S5: changes that another program made to the drive are detected, and init is required") {
    rig r;
    REQUIRE(r.make_ready());
    client direct{r.line, node<device>{1}};
    SUBCASE("an input is set before the enable") {
        const auto token = direct.ram_only();
        REQUIRE(token);
        REQUIRE(direct.write<virtual_input_levels>(virtual_inputs{}.with(7), *token));
        CHECK(r.drive.run(enable{}).error() == errc::needs_init);
        CHECK_FALSE(r.model.enabled());
    }
    SUBCASE("writes to the EEPROM are switched on again") {
        REQUIRE(direct.store<eeprom_update>(off_on::on));
        const auto before = r.model.eeprom_writes();
        CHECK(r.drive.run(enable{}).error() == errc::needs_init);
        CHECK(r.model.eeprom_writes() == before);
    }
    SUBCASE("the word order has changed: no 32-bit frame is sent (S6)") {
        REQUIRE(direct.store<pair_word_order>(word_order_setting::high_first));
        const auto before = r.requests.size();
        CHECK(r.drive.run(segment{1, 70'000 * reference_unit, 1 * r_per_min}).error() == errc::needs_init);
        for (std::size_t i = before; i < r.requests.size(); ++i)
            CHECK_FALSE(modbus::is_write(r.requests[i][1]));
    }
    SUBCASE("a virtual input has another function: the drive needs set_up") {
        REQUIRE(direct.store<virtual_input_functions>(4, input_function::none));
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.state() == drive_state::needs_set_up);
        return;
    }
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("S6: before init nothing but stops is sent") {
    rig r;
    const auto wanted_nothing = [&](errc e) {
        CHECK(e == errc::needs_init);
        CHECK(r.requests.empty());
    };
    wanted_nothing(r.drive.read().error());
    wanted_nothing(r.drive.read(wide_position::encoder).error());
    wanted_nothing(r.drive.fault(1).error());
    wanted_nothing(r.drive.run(set_up{}).error());
    wanted_nothing(r.drive.run(enable{}).error());
    wanted_nothing(r.drive.run(velocity{1 * r_per_min}).error());
    wanted_nothing(r.drive.run(segment{1, 1 * reference_unit, 1 * r_per_min}).error());
    wanted_nothing(r.drive.run(start_segment{1}).error());
    wanted_nothing(r.drive.run(set<home_offset>{1}).error());
    wanted_nothing(r.drive.run(keep<max_speed>{1}).error());
    wanted_nothing(r.drive.run(fault_reset{}).error());
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(halt{}));
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("S1: after a program has crashed at any frame of a routine, init of another program stops and "
          "initialises the drive") {
    for (std::size_t crash = 0; crash < 160; crash += 3) {
        CAPTURE(crash);
        rig r;
        REQUIRE(r.make_ready());
        r.requests.clear();
        bool is_over = false;
        // Steps the commands. At the crash the stepping just ends.
        const auto run_until_crash = [&](const auto& command) {
            if (is_over || r.drive.begin(command) != errc::ok) return;
            while (!r.drive.is_idle() && !is_over) {
                r.turn();
                is_over = r.requests.size() > crash;
            }
        };
        run_until_crash(enable_in{control_mode::speed});
        run_until_crash(velocity{250 * r_per_min});
        run_until_crash(disable{});
        run_until_crash(segment{2, 40'000 * reference_unit, 300 * r_per_min});
        run_until_crash(enable_in{control_mode::position});
        run_until_crash(start_segment{2});
        run_until_crash(quick_stop{});
        r.wire.pass(milliseconds(crash % 2 == 0 ? 100 : 1500));
        servobus::line restarted{r.wire, modbus::timing_at(57600)};
        c630s::drive successor{restarted, 1};
        REQUIRE(successor.run(init{}));
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        CHECK(successor.state() == drive_state::disabled);
    }
}

TEST_CASE("G25: a stop replaces any command, immediately after the frame in progress") {
    for (std::size_t frames = 1; frames < 50; frames += 4) {
        CAPTURE(frames);
        rig r;
        REQUIRE(r.make_ready());
        r.requests.clear();
        REQUIRE(r.drive.begin(enable{}) == errc::ok);
        while (!r.drive.is_idle() && r.requests.size() < frames) r.turn();
        if (r.drive.is_idle()) break;
        const std::size_t before = r.requests.size();
        REQUIRE(r.drive.begin(disable{}) == errc::ok);
        while (!r.drive.is_idle()) r.turn();
        REQUIRE(r.requests.size() > before);
        const auto is_servo_off = [&](const auto& frame) { // without the marker where the state is unknown
            return same_bytes(frame, modbus::write_frame(1, p31, terminal::marker)) ||
                   same_bytes(frame, modbus::write_frame(1, p31, 0));
        };
        // Zero targets go before, while the marker is read.
        const auto is_stop = [&](const auto& frame) {
            return is_servo_off(frame) ||
                   same_bytes(frame, modbus::write_frame(1, emergency_stop.address, u16{1})) ||
                   same_bytes(frame, modbus::write_frame(1, target_speed.address, std::array<u16, 2>{0, 0}));
        };
        CHECK((is_stop(r.requests[before]) || is_stop(r.requests[before + 1])));
        bool is_off = false;
        for (std::size_t i = before; i < before + 5; ++i) is_off = is_off || is_servo_off(r.requests[i]);
        CHECK(is_off);
        CHECK_FALSE(r.model.enabled());
        CHECK(r.model.stands_still());
    }
}

TEST_CASE("G26: a stop is repeated until a read confirms it; a late response does not confirm a halt") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    SUBCASE("late") {
        r.wire.faults().late_response = 1000;
        r.wire.faults().late_by = milliseconds(106);
        CHECK_FALSE(r.drive.run(velocity{100 * r_per_min}));
        CHECK(r.wire.struck() != 0);
        r.wire.faults() = {};
        REQUIRE(r.drive.run(halt{}));
        CHECK(r.model.peek(target_speed.address) == 0);
    }
    SUBCASE("lost twice") {
        REQUIRE(r.drive.run(velocity{100 * r_per_min}));
        REQUIRE(run_with(r, disable{}, {0, 2, true}));
        CHECK_FALSE(r.model.enabled());
    }
    CHECK(r.model.stands_still());
}

TEST_CASE("G21: an unplugged line invalidates the cached state, and motion needs init afterwards") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{100 * r_per_min}));
    r.wire.unplug();
    CHECK(r.drive.run(velocity{50 * r_per_min}).error() == errc::port_lost);
    CHECK(r.drive.state() == drive_state::needs_init);
    r.wire.pass(milliseconds(2000));
    CHECK_FALSE(r.model.stands_still()); // the drive has no watchdog
    r.wire.plug();
    CHECK(r.drive.run(velocity{50 * r_per_min}).error() == errc::needs_init);
    REQUIRE(r.drive.run(init{}));
    CHECK(r.model.stands_still());
}

TEST_CASE("a drive that is not energised as expected is switched off, and its cached state is invalid or "
          "disabled") {
    rig r;
    REQUIRE(r.make_ready());
    SUBCASE("a fault occurs during the enable") {
        REQUIRE(r.drive.begin(enable{}) == errc::ok);
        while (!r.drive.is_idle()) {
            if (r.model.peek(p31) != 0) r.model.raise(0x201, true);
            r.turn();
        }
        CHECK_FALSE(r.drive.last());
    }
    SUBCASE("a fault is present when a command begins") {
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
        r.model.raise(0x620);
        CHECK(r.drive.run(start_segment{1}).error() == errc::faulted);
        CHECK(r.drive.state() == drive_state::faulted);
        CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
        REQUIRE(r.drive.run(fault_reset{}));
        CHECK(r.drive.state() == drive_state::disabled);
        r.wire.pass(milliseconds(500));
        CHECK(r.model.enables() == 1);
        return;
    }
    SUBCASE("the drive restarts while it is enabled") {
        REQUIRE(r.drive.run(enable{}));
        r.model.power_cycle();
        (void)r.drive.read();
        CHECK(r.drive.state() == drive_state::needs_init);
    }
    CHECK(r.drive.state() != drive_state::enabled);
    CHECK_FALSE(r.model.enabled());
    CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
}

TEST_CASE("a set_up that begins while init still reads is refused and writes nothing") {
    rig r;
    REQUIRE(r.drive.begin(init{}) == errc::ok);
    while (r.requests.size() < 13) r.turn();
    CHECK(r.drive.begin(set_up{}) == errc::needs_init);
    const auto before = r.model.eeprom_writes();
    while (!r.drive.is_idle()) r.turn();
    REQUIRE(r.drive.last());
    CHECK(r.model.eeprom_writes() == before);
    CHECK(r.drive.state() == drive_state::needs_set_up);
}

} // namespace drive_c630s_faults_tests
