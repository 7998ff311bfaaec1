// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade in difficult cases: a command timeout that must stop the drive in any state, stops on a
// line that loses their first frames, resets that must not report success too early, set-ups and runs that
// are interrupted.
#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>

namespace drive_c630s_care_tests {

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
// Runs a command of which `count` responses are lost, the first of them the response to frame number `first`.
template <class Command>
command_status run_deaf(rig& r, const Command& wanted, std::size_t first, std::size_t count) {
    const std::size_t start = r.wire.requests();
    REQUIRE(r.drive.begin(wanted) == errc::ok);
    while (!r.drive.is_idle()) {
        const std::size_t done = r.wire.requests() - start;
        r.wire.faults().lost_response = done > first && done <= first + count ? 1000 : 0;
        r.turn();
    }
    CHECK(r.wire.struck() != 0);
    r.wire.faults() = {};
    return r.drive.last();
}

} // namespace

TEST_CASE("G20, G26: the command timeout also stops a drive whose cached state is invalid, and the stop is "
          "retried") {
    rig r;
    SUBCASE("one lost response does not disable the command timeout") {
        be_enabled_in(r, control_mode::speed);
        r.drive.set_command_timeout(milliseconds(400));
        REQUIRE(r.drive.run(velocity{300 * r_per_min}));
        CHECK(run_deaf(r, velocity{301 * r_per_min}, 1, 4).outcome() == outcome::unknown);
        r.loop(5000);
    }
    SUBCASE("a stop without a response is sent again") {
        be_enabled_in(r, control_mode::speed);
        r.drive.set_command_timeout(milliseconds(400));
        REQUIRE(r.drive.run(velocity{300 * r_per_min}));
        r.wire.cut_for(milliseconds(1500));
        r.loop(6000);
    }
    SUBCASE("the command timeout also ends segments that run by themselves") {
        REQUIRE(r.make_ready());
        r.drive.set_command_timeout(milliseconds(1500));
        REQUIRE(r.drive.run(speed_segment{1, 120 * r_per_min, 5 * second}));
        REQUIRE(r.drive.run(run_speed_segments{}));
        r.loop(6000);
    }
    CHECK(r.model.stands_still());
}

TEST_CASE("G20, G40: a jog whose command timeout is shorter than its frames begins, and is stopped right "
          "after it") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    r.drive.set_command_timeout(milliseconds(5));
    REQUIRE(r.drive.begin(jog{50 * r_per_min}) == errc::ok);
    r.loop(3000);
    CHECK(r.drive.last());
    CHECK(r.drive.cause() == stop_cause::command);
    CHECK(r.model.stands_still());
}

TEST_CASE("S1, G25: stops that lose their first frames still switch the servo off") {
    rig r;
    be_enabled_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{1, 2'000'000 * reference_unit, 600 * r_per_min, 10 * millisecond}));
    REQUIRE(r.drive.run(start_segment{1}));
    r.run(500);
    rig::drive_type other{r.line, 1, unsupervised}; // another program, which has not initialised the drive
    REQUIRE(other.begin(halt{}) == errc::ok);
    const std::size_t start = r.wire.requests();
    while (!other.is_idle()) {
        r.wire.faults().lost_request = r.wire.requests() - start < 3 ? 1000 : 0;
        const duration idle = other.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(r.wire.struck() == 3);
    CHECK(other.last()); // stops that the read-back did not confirm were sent again
    CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
    r.run(2000);
    CHECK(r.model.stands_still());
}

TEST_CASE("G18: a restart is found although the program keeps beginning commands while one is in progress") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{100 * r_per_min}));
    r.model.power_cycle();
    const std::uint32_t before = r.model.eeprom_writes();
    const std::uint64_t end = r.wire.time_us() + 3'000'000;
    while (r.wire.time_us() < end) {
        (void)r.drive.begin(velocity{101 * r_per_min}); // mostly refused: the last command is still in
                                                        // progress
        r.turn();
    }
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK(r.model.eeprom_writes() - before < 200);
}

TEST_CASE("5.2.4: before the set-up a reset is checked by the alarm code, since no output shows a fault "
          "yet") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.state() == drive_state::needs_set_up);
    r.model.raise(0x620, true);
    CHECK(r.drive.run(fault_reset{}).error() == errc::faulted);
    r.model.end_causes();
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.has_alarm(0x620));
    r.model.raise(0x731);
    REQUIRE(r.drive.run(reset_encoder{}));
    CHECK_FALSE(r.model.has_alarm(0x731));
    // Before each 1, 0 was written to P0D-01.
    const auto words = r.written_to(alarm_reset.address);
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i] == 1) CHECK((i > 0 && words[i - 1] == 0));
    }
}

TEST_CASE("a single segment is started only if inputs select it, and a run of segments only if they do not") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{control_mode::position, position_source::segments, segment_mode::cyclic}));
    CHECK(r.drive.run(start_segment{3}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    CHECK(r.drive.run(start_segments{}).error() == errc::wrong_state);
}

TEST_CASE("wait_standstill ends after the move, not right after its start") {
    rig r;
    be_enabled_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{1, 50'000 * reference_unit, 600 * r_per_min, 20'000 * millisecond}));
    const auto from = r.model.position();
    REQUIRE(r.drive.run(start_segment{1}));
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.position() - from > 655'000); // five turns of 131072 counts
}

TEST_CASE("a velocity command is refused during a jog, and repeated velocity commands find a fault") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(jog{50 * r_per_min}));
    CHECK(r.drive.run(velocity{0 * r_per_min}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.drive.run(velocity{50 * r_per_min}));
    r.model.raise(0x620, true);
    bool is_found = false;
    for (int i = 0; i < 20 && !is_found; ++i) {
        is_found = !r.drive.run(velocity{50 * r_per_min});
        r.run(100);
    }
    CHECK(is_found);
    CHECK((r.model.peek(p31) & ~terminal::marker) ==
          0); // the servo stays off, also after the fault has ended
}

TEST_CASE("quick stop stops a motor that wired inputs run before the set-up") {
    rig r;
    r.model.set_input(1, true); // DI1 is servo-on from the factory
    r.wire.pass(milliseconds(100));
    REQUIRE(r.drive.run(init{}));
    if (r.drive.state() == drive_state::needs_set_up) (void)r.drive.run(quick_stop{});
    CHECK(r.model.peek(emergency_stop.address) == 1);
}

TEST_CASE("keep refuses the function servo-on for a wired input") {
    rig r;
    REQUIRE(r.make_ready());
    CHECK(r.drive.run(keep<di1_function>{input_function::servo_on}).error() == errc::out_of_range);
    CHECK(r.drive.run(keep<di2_function>{input_function::gain_selection}));
}

TEST_CASE("disable replaces a quick stop that is waiting, and a quick stop replaces a disable") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{3000 * r_per_min}));
    REQUIRE(r.live(milliseconds(3500)));
    const auto wait_for = [&](std::size_t frames) {
        const std::size_t start = r.requests.size();
        while (!r.drive.is_idle() && r.requests.size() < start + frames) r.turn();
        REQUIRE_FALSE(r.drive.is_idle());
    };
    SUBCASE("disable") {
        REQUIRE(r.drive.begin(quick_stop{}) == errc::ok);
        wait_for(6);
        REQUIRE_FALSE(r.model.stands_still());
        CHECK(r.drive.begin(quick_stop{}) == errc::busy);
        CHECK(r.drive.begin(halt{}) == errc::busy);
        REQUIRE(r.drive.begin(disable{}) == errc::ok);
        CHECK(r.drive.begin(disable{}) == errc::busy);
    }
    SUBCASE("quick stop") {
        REQUIRE(r.drive.begin(disable{}) == errc::ok);
        wait_for(3);
        CHECK(r.drive.begin(halt{}) == errc::busy);
        REQUIRE(r.drive.begin(quick_stop{}) == errc::ok);
        wait_for(2);
        REQUIRE(r.drive.begin(disable{}) == errc::ok);
    }
    const std::size_t sent = r.requests.size();
    while (!r.drive.is_idle()) r.turn();
    CHECK(
        same_bytes(r.requests[sent], modbus::write_frame(1, target_speed.address, std::array<u16, 2>{0, 0})));
    CHECK(same_bytes(r.requests[sent + 1], modbus::read_frame(1, p31, 1)));
    CHECK(same_bytes(r.requests[sent + 2], modbus::write_frame(1, p31, terminal::marker)));
    CHECK(r.drive.last());
    CHECK(r.model.stands_still());
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.live(milliseconds(300)));
    CHECK(r.model.stands_still());
}

TEST_CASE("a jog beyond the limit of its direction is refused before anything is sent") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(top_speeds{500 * r_per_min, 300 * r_per_min, 100 * r_per_min}));
    const std::size_t sent = r.requests.size();
    CHECK(r.drive.run(jog{301 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(jog{-101 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.requests.size() == sent);
    REQUIRE(r.drive.run(jog{-100 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.r_per_min() == -100);
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.drive.run(jog{300 * r_per_min}));
}

TEST_CASE("an output that an earlier homing left on does not confirm a new homing") {
    for (unsigned n = 0; n < 4; ++n) {
        CAPTURE(n);
        const bool falls = n % 2 == 0;
        rig r{{.home_output_falls = falls}};
        REQUIRE(r.make_ready());
        r.model.attach({.home_from = 200'000,
                        .home_to = 260'000,
                        .negative_limit = -900'000,
                        .positive_limit = 900'000});
        REQUIRE(r.drive.run(homing_by{homing_mode::forward_home_switch, 300 * r_per_min, 60 * r_per_min,
                                      100 * millisecond, 30'000}));
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
        REQUIRE(r.drive.run(home{30 * second}));
        REQUIRE(r.drive.run(home_electrically{10 * second}));
        REQUIRE(r.drive.run(segment{1, -5000 * reference_unit, 300 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.model.is_active(output_function::home_attained));
        const command_status got =
            n < 2 ? r.drive.run(home{30 * second}) : r.drive.run(home_electrically{30 * second});
        CHECK(r.model.homings() == 3);
        CHECK(r.model.stands_still());
        CHECK(static_cast<bool>(got) == falls);
        if (got) continue;
        CHECK(got.error() == errc::not_reached);
        CHECK(got.outcome() == outcome::unknown);
        CHECK_FALSE(r.model.enabled());
        CHECK(r.drive.state() == drive_state::needs_init);
    }
}

TEST_CASE("home_electrically succeeds if the motor is already at the electrical home") {
    rig r;
    be_enabled_in(r, control_mode::position);
    REQUIRE(r.drive.run(home_electrically{1 * second}));
}

TEST_CASE("G18: a write that the drive refuses while it stores writes leaves P0C-13 at 0 and requires init") {
    rig r;
    REQUIRE(r.make_ready());
    const std::array<std::uint8_t, 2> servo_on{0, terminal::servo_on};
    REQUIRE(r.drive.begin(keep<stop_at_servo_off>{stop_mode::zero_speed}) == errc::ok);
    while (!r.drive.is_idle()) { // another program energises the motor, so that the drive refuses the write
        const bool is_kept = r.model.peek(eeprom_update.address) == 1;
        if (is_kept && !r.model.enabled()) REQUIRE(r.model.write(p31, words_view{servo_on}) == 0);
        r.turn();
    }
    const command_status got = r.drive.last();
    CHECK(got.error() == errc::exception);
    CHECK(got.has_changed());
    CHECK(r.model.peek(eeprom_update.address) == 0);
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK(r.drive.run(ramps{1 * millisecond, 1 * millisecond}).error() == errc::needs_init);
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.run(ramps{1 * millisecond, 1 * millisecond}));
}

// A restart puts P0C-13 back to 1. Then the marker would go into the EEPROM, and a drive that keeps its levels would
// show no restart after that.
TEST_CASE(
    "G17, G21: an init that a restart disturbs does not succeed, but between the last read and the marker") {
    const auto frames_of = [](rig& r, std::size_t restart_after) {
        REQUIRE(r.make_ready());
        const std::size_t start = r.wire.requests();
        REQUIRE(r.drive.begin(init{}) == errc::ok);
        for (bool was_restarted = false; !r.drive.is_idle(); r.turn()) {
            if (was_restarted || r.wire.requests() - start != restart_after) continue;
            r.model.power_cycle();
            was_restarted = true;
        }
        return r.wire.requests() - start;
    };
    rig undisturbed;
    const std::size_t frames = frames_of(undisturbed, 0);
    REQUIRE(undisturbed.drive.last());
    unsigned unseen = 0;
    for (std::size_t after = 4; after < frames;
         ++after) { // the first four stop the drive and spare the EEPROM
        CAPTURE(after);
        rig r{{.stores_eeprom_off = false}};
        (void)frames_of(r, after);
        if (!r.drive.last()) continue;
        if (r.model.peek(eeprom_update.address) != 0) ++unseen;
    }
    CHECK(frames > 20);
    CHECK(unseen == 1);
}

TEST_CASE("S5, G35: a restart while an enable waits for the brake ends it, and the servo stays off") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(keep<brake_on_to_command_delay>{400}));
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.begin(enable_in{control_mode::speed}) == errc::ok);
    while (!r.model.enabled()) r.turn();
    r.loop(60);
    REQUIRE_FALSE(r.drive.is_idle());
    r.model.power_cycle();
    const std::uint64_t restarted = r.wire.time_us();
    while (!r.drive.is_idle()) r.turn();
    CHECK(r.drive.last().error() == errc::needs_init);
    CHECK(r.wire.time_us() - restarted < 100'000); // not after the delay of the brake
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("G18: while the drive keeps its writes, during a set-up, it needs an init") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.begin(set_up{}) == errc::ok);
    while (r.written_to(eeprom_update.address).empty()) r.turn();
    while (r.model.peek(eeprom_update.address) == 0) r.turn();
    std::size_t kept = r.requests.size();
    while (r.model.peek(eeprom_update.address) == 1) {
        r.turn();
        // It is known once P0C-13 was written and has been read back.
        if (r.requests.size() > kept + 2) CHECK(r.drive.state() == drive_state::needs_init);
    }
    CHECK(r.requests.size() > kept + 10);
    while (!r.drive.is_idle()) r.turn();
    CHECK(r.drive.needs_power_cycle());
    CHECK(r.drive.cached().positive_torque == r.model.peek(positive_internal_torque_limit.address));
}

TEST_CASE(
    "S4: after a start without a response the motion is unknown if the drive does not respond any more") {
    rig r;
    be_enabled_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{1, 5000 * reference_unit, 600 * r_per_min, 10 * millisecond}));
    const std::size_t start = r.wire.requests();
    REQUIRE(r.drive.begin(start_segment{1}) == errc::ok);
    while (!r.drive.is_idle()) {
        r.wire.faults().lost_response = r.wire.requests() - start >= 12 ? 1000 : 0; // from the start on
        r.turn();
    }
    CHECK(r.drive.last().outcome() == outcome::unknown);
    CHECK(r.model.starts() == 1);
    CHECK(r.drive.motion() == motion_check::unknown);
}

TEST_CASE("before the set-up a quick stop sends the same frames after a disable as before it") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.state() == drive_state::needs_set_up);
    r.requests.clear();
    REQUIRE(r.drive.run(quick_stop{}));
    const auto before = r.requests;
    REQUIRE(r.drive.run(disable{}));
    r.requests.clear();
    REQUIRE(r.drive.run(quick_stop{}));
    CHECK(r.requests == before);
}

} // namespace drive_c630s_care_tests
