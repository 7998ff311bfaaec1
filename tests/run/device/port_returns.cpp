// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive without a watchdog whose port was lost while its motor moves: the first step with a port stops it. Judged by
// the frames on the wire and by the simulated motor.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/control/setpoint_loop.hpp>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_c630s.hpp>
#include <tests/support/enabled_yako.hpp>
#include <tests/support/loop_bound.hpp>

namespace port_returns_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

// Steps the drive for a time. Returns when its first request left, in us after the begin; 0 if none did.
template <class R> std::uint64_t live(R& r, std::uint32_t ms) {
    const std::uint64_t begin = r.wire.time_us();
    const std::size_t before = r.requests.size();
    std::uint64_t first = 0;
    while (r.wire.time_us() < begin + std::uint64_t{ms} * 1000u) {
        const duration idle = r.drive.step();
        if (first == 0 && r.requests.size() != before) first = r.wire.time_us() - begin;
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    return first;
}

struct stepper : simulated::closed_axis {
    bool moves() const { return model.view().is_moving; }
    void take() { enabled_yako::take(*this); }
    void begin_motion() { REQUIRE(drive.run(velocity{60 * r_per_min})); }
    void begin_move() { REQUIRE(drive.run(move_by{20'000 * yako::pulse})); }
    static bool stops(const std::vector<std::uint8_t>& f) { return same_bytes(f, enabled_yako::stop_frame); }
};
struct servo : simulated::driven_c630s {
    bool moves() const { return !model.stands_still(); }
    void take() { enabled_c630s::be_enabled_in(*this, c630s::control_mode::speed); }
    void begin_motion() { REQUIRE(drive.run(velocity{300 * units::r_per_min})); }
    // P0D-05, which the drive does not keep in its EEPROM
    static bool stops(const std::vector<std::uint8_t>& f) {
        return same_bytes(f, modbus::write_frame(1, c630s::emergency_stop.address, u16{1}));
    }
};

} // namespace

TEST_CASE_TEMPLATE("G45: a drive that moves is stopped by the first step that has a port again", S, stepper,
                   servo) {
    for (const std::uint32_t lost : {1u, 20u, 300u, 3000u}) {
        for (const bool is_stepped : {true, false}) {
            CAPTURE(lost);
            CAPTURE(is_stepped);
            S s;
            s.take();
            s.begin_motion();
            (void)live(s, 400);
            REQUIRE(s.moves());
            s.wire.unplug();
            CHECK(s.drive.run(read_feedback{}).error() ==
                  errc::port_lost); // a loss that no call meets is none
            if (is_stepped)
                CHECK(live(s, lost) == 0);
            else
                s.wire.pass(milliseconds(lost));
            REQUIRE(s.moves());
            s.wire.plug();
            const std::size_t before = s.requests.size();
            const std::uint64_t first = live(s, 100);
            CHECK(first != 0);
            CHECK(first <= 6000); // a gap of t3.5 and the frame
            REQUIRE(s.requests.size() > before);
            CHECK(S::stops(s.requests[before]));
            (void)live(s, 1500);
            CHECK_FALSE(s.moves());
            CHECK(s.drive.state() == drive_state::needs_init); // nothing moves by itself
            CHECK(live(s, 100) == 0);                          // the stop was confirmed, and is not repeated
        }
    }
}

TEST_CASE("G45: a velocity that had left as a halt replaced it, and the port was lost, is stopped") {
    servo s;
    s.take();
    REQUIRE(s.drive.begin(velocity{300 * units::r_per_min}) == errc::ok);
    const auto is_velocity = [&] {
        return !s.requests.empty() && modbus::is_write(s.requests.back()[1]) &&
               load_word(s.requests.back(), 2) == c630s::target_speed.address;
    };
    for (tests::loop_bound left{"the velocity leaves"}; !is_velocity(); left.use()) {
        (void)s.drive.step();
        s.wire.wait(microseconds(20));
    }
    REQUIRE(s.drive.begin(halt{}) == errc::ok);
    s.wire.unplug();
    (void)live(s, 300);
    REQUIRE(s.moves());
    s.wire.plug();
    const std::size_t before = s.requests.size();
    (void)live(s, 1500);
    REQUIRE(s.requests.size() > before);
    CHECK(servo::stops(s.requests[before]));
    CHECK_FALSE(s.moves());
}

TEST_CASE_TEMPLATE("G45: a drive that was seen at rest is sent nothing as its port returns", S, stepper,
                   servo) {
    S s;
    s.take();
    SUBCASE("it was never moved") {}
    SUBCASE("after a stop") {
        s.begin_motion();
        (void)live(s, 200);
        REQUIRE(s.drive.run(halt{}));
    }
    SUBCASE("after a wait") {
        s.begin_motion();
        (void)live(s, 200);
        REQUIRE(s.drive.run(halt{}));
        s.begin_motion();
        (void)live(s, 200);
        REQUIRE(s.drive.run(disable{}));
    }
    s.wire.unplug();
    (void)live(s, 300);
    (void)s.drive.run(read_feedback{});
    s.wire.plug();
    CHECK(live(s, 3000) == 0);
}

TEST_CASE("G45: a disable that the lost port did not take is what stops the drive as it returns") {
    for (const bool is_disabled : {true, false}) {
        CAPTURE(is_disabled);
        stepper s;
        s.take();
        s.begin_motion();
        (void)live(s, 400);
        REQUIRE(s.moves());
        s.wire.unplug();
        const errc why = is_disabled ? s.drive.run(disable{}).error() : s.drive.run(read_feedback{}).error();
        CHECK(why == errc::port_lost);
        s.wire.plug();
        (void)live(s, 3000);
        CHECK_FALSE(s.moves());
        REQUIRE(s.drive.run(init{}));
        CHECK(s.drive.state() == (is_disabled ? drive_state::disabled : drive_state::enabled));
    }
}

TEST_CASE("G45: a move that a wait has seen at its target is not stopped, one that was not is") {
    for (const bool waits : {true, false}) {
        CAPTURE(waits);
        stepper s;
        s.take();
        s.begin_move();
        if (waits) REQUIRE(s.drive.run(wait_reached{}));
        s.wire.unplug();
        (void)s.drive.run(read_feedback{});
        s.wire.plug();
        const std::size_t before = s.requests.size();
        CHECK((live(s, 1000) == 0) == waits);
        if (!waits) CHECK(stepper::stops(s.requests[before]));
    }
}

TEST_CASE("G45: which commands show that a motor stands which has come to rest by itself") {
    // Runs `command` after the motion. True if the drive is stopped all the same as its port returns.
    const auto is_stopped_after = [](auto& s, const auto& command, errc ends = errc::ok) {
        CHECK(s.drive.run(command).error() == ends);
        s.wire.unplug();
        (void)s.drive.run(read_feedback{});
        s.wire.plug();
        const std::size_t before = s.requests.size();
        const bool is_sent = live(s, 300) != 0;
        if (is_sent) CHECK(s.stops(s.requests[before]));
        return is_sent;
    };
    const auto moved = [](stepper& s) {
        s.take();
        REQUIRE(s.drive.run(move_by{200 * yako::pulse}));
        (void)live(s, 1000);
        REQUIRE_FALSE(s.moves());
    };
    const auto after = [&](const auto& command, errc ends = errc::ok) {
        stepper s;
        moved(s);
        return is_stopped_after(s, command, ends);
    };
    CHECK_FALSE(after(wait_reached{}));
    CHECK_FALSE(after(wait_standstill{}));
    CHECK_FALSE(after(halt{}));
    CHECK_FALSE(after(quick_stop{}));
    CHECK_FALSE(after(disable{}));
    CHECK_FALSE(after(init{}));
    CHECK(after(read_feedback{}));
    CHECK(after(enable{}));
    CHECK(after(yako::clear_position{}));
    CHECK(after(yako::set_profile{{10 * r_per_min, 90 * millisecond, 80 * millisecond, 60 * r_per_min}}));
    CHECK(after(velocity{3001 * r_per_min}, errc::out_of_range));
    {
        stepper s; // a wait that has seen nothing yet
        s.take();
        s.begin_motion();
        CHECK(is_stopped_after(s, wait_standstill{milliseconds(50)}, errc::not_reached));
    }
    const auto turned = [&](const auto& command) {
        servo s;
        s.take();
        s.begin_motion();
        (void)live(s, 300);
        REQUIRE(s.drive.run(velocity{0 * units::r_per_min}));
        (void)live(s, 1500);
        REQUIRE_FALSE(s.moves());
        return is_stopped_after(s, command);
    };
    CHECK_FALSE(turned(wait_standstill{}));
    CHECK_FALSE(turned(halt{}));
    CHECK(turned(c630s::read_status{}));
    CHECK(turned(c630s::read_wide_position{c630s::wide_position::load}));
    CHECK(turned(c630s::torque_limits{90 * percent, 90 * percent}));
    CHECK(turned(c630s::set_home{})); // which reads that it stands, and writes
}

TEST_CASE("G45: a loop stops its drive within a few ms of the port's return, and takes it over after that") {
    stepper s;
    yako::closed_loop::drive<stepper::line_type> polled{s.line, 1};
    setpoint_loop loop{polled, take_over{disable{}}};
    const auto turn = [&](std::uint32_t ms) {
        const std::uint64_t end = s.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (s.wire.time_us() < end) {
            (void)loop.step();
            (void)loop.take_report();
            s.wire.pass(microseconds(100));
        }
    };
    turn(500);
    loop.enable();
    turn(500);
    REQUIRE(loop.begin(velocity{60 * r_per_min}) == errc::ok);
    turn(600);
    REQUIRE(s.moves());
    s.wire.unplug();
    turn(730);
    REQUIRE(s.moves());
    s.wire.plug();
    const std::size_t before = s.requests.size();
    turn(10);
    REQUIRE(s.requests.size() > before);
    CHECK(stepper::stops(s.requests[before]));
    turn(1500);
    CHECK_FALSE(s.moves());
    CHECK(loop.is_taken_over());
    CHECK_FALSE(loop.is_motion_allowed());
}

} // namespace port_returns_tests
