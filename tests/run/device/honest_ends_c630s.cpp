// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The end of moves of a C630S that something interrupts: the position of the simulated motor, and the
// result of `wait_standstill`. At standstill the drive shows "positioning completed" also after an emergency
// stop.
#include <doctest/doctest.h>

#include <string>

#include <tests/support/driven_c630s.hpp>

namespace honest_ends_c630s_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using rig = simulated::driven_c630s;

namespace {

constexpr distance way = 100'000 * reference_unit;

/// A move that FunIN.34 interrupts, and the result of `wait_standstill`.
struct cut_move {
    rig machine;
    command_status end{};
    std::int64_t went = 0; ///< reference units, 10000 for a revolution of 131072 encoder counts
    bool has_alarm = false;
    bool is_still = false;
    bool has_begun = false;

    cut_move() {
        const bool is_ready = machine.make_ready() && machine.drive.run(enable_in{control_mode::position}) &&
                              machine.drive.run(segment{1, way, 600 * r_per_min, 100 * millisecond});
        const std::int64_t from = machine.model.position();
        if (!is_ready || !machine.drive.run(start_segment{1})) return;
        machine.run(250);
        has_begun = !machine.model.stands_still();
        machine.model.set_input(6, true); // DI6 is the emergency stop from the factory
        end = machine.drive.run(wait_standstill{});
        went = (machine.model.position() - from) * 10'000 / 131'072;
        has_alarm = machine.model.has_alarm(0x900);
        is_still = machine.model.stands_still();
    }
};

} // namespace

TEST_CASE("FunIN.34 interrupts a move: the motor stops before its target, with Er.900") {
    cut_move m;
    REQUIRE(m.has_begun);
    MESSAGE("the motor went " << m.went << " of " << way.count()
                              << " reference units; wait_standstill ended with: "
                                 ""
                              << std::string{text(m.end.error())});
    CHECK(m.is_still);
    CHECK(m.has_alarm);
    CHECK(m.went > 0);
    CHECK(m.went < way.count() / 2);
    // It stays there: the rest of the move is not made when the input becomes inactive.
    m.machine.model.set_input(6, false);
    const std::int64_t rested = m.machine.model.position();
    m.machine.run(2000);
    CHECK(m.machine.model.position() - rested <= 2);
}

TEST_CASE("wait_standstill does not return ok for a move that FunIN.34 interrupted") {
    const cut_move m;
    CHECK(m.end.error() == errc::stopped_short);
    const arrival there = m.machine.drive.arrival();
    CHECK(there.how == arrival_state::stopped_short);
    CHECK(there.cause == stop_cause::input);
    CHECK(there.missing.count() + m.went >= way.count() - 60); // within P05-21 of the command
    CHECK(there.missing.count() + m.went <= way.count() + 60);
}

namespace {

/// A ready drive in position control, with a segment of so many reference units.
void begin_move(rig& r, std::int32_t units, speed at = 600 * r_per_min) {
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.run(segment{1, units * reference_unit, at, 100 * millisecond}));
    REQUIRE(r.drive.run(start_segment{1}));
}

} // namespace

TEST_CASE("G34: a reverse move that the negative limit switch interrupts ends short, late in the move too") {
    for (const std::uint32_t ms : {200u, 900u}) {
        CAPTURE(ms);
        rig r;
        begin_move(r, -120'000);
        r.run(ms);
        r.model.set_input(3, true); // DI3 is the negative limit from the factory
        CHECK(r.drive.run(wait_reached{}).error() == errc::stopped_short);
        const arrival there = r.drive.arrival();
        CHECK(there.how == arrival_state::stopped_short);
        CHECK(there.cause == stop_cause::input);
        CHECK(there.missing < -1000 * reference_unit);
    }
}

TEST_CASE("G34: the cause of a stop is unknown while another fault record is chosen") {
    rig r;
    begin_move(r, 100'000);
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.write<selected_fault_record>(fault_record::ninth_last));
    r.run(200);
    r.model.set_input(6, true);
    CHECK(r.drive.run(wait_reached{}).error() == errc::stopped_short);
    CHECK(r.drive.arrival().cause == stop_cause::unknown);
}

TEST_CASE("G34: a limit switch of a record before the present one does not refuse a move") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.run(segment{1, 20'000 * reference_unit, 600 * r_per_min, 20 * millisecond}));
    r.model.set_input(2, true); // DI2 is the positive limit from the factory
    r.run(100);
    REQUIRE(r.drive.run(start_segment{1}).error() == errc::wrong_state);
    r.model.set_input(2, false);
    r.run(100);
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.write<selected_fault_record>(fault_record::last));
    REQUIRE(r.model.peek(recorded_alarm.address) == 0x950);
    CHECK(r.drive.run(start_segment{1}, wait_reached{}).how == arrival_state::reached);
}

TEST_CASE("a motor that accelerates at its torque limit is not taken to be blocked") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(torque_limits{3 * percent, 3 * percent}));
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.run(segment{1, 20'000 * reference_unit, 900 * r_per_min, 1 * millisecond}));
    const arrival there = r.drive.run(start_segment{1}, wait_reached{});
    CHECK(there.how == arrival_state::reached);
}

TEST_CASE(
    "wait_standstill waits for a run of segments by the drive's own word, and wait_reached is refused") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(position_segments{.last = 2}));
    for (const int n : {1, 2})
        REQUIRE(r.drive.run(segment{checked(n), 10'000 * reference_unit, 600 * r_per_min, 10 * millisecond}));
    REQUIRE(r.drive.run(enable_in{control_mode::position, position_source::segments, segment_mode::single}));
    const std::int64_t from = r.model.position();
    REQUIRE(r.drive.run(start_segments{}));
    CHECK(r.drive.run(wait_reached{}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.drive.arrival().how == arrival_state::none);
    CHECK(r.model.stands_still());
    CHECK(r.model.position() > from);
}

TEST_CASE("a move that is refused has no arrival, and a status that is not read has no value") {
    rig r;
    REQUIRE(r.make_ready());
    CHECK(r.drive.run(start_segment{1}, wait_reached{}).how == arrival_state::none);
    CHECK(r.drive.last().error() == errc::wrong_state);
    r.wire.unplug();
    CHECK_FALSE(r.drive.read_status());
}

TEST_CASE("the word order is known before the set-up, when a restart does not show") {
    rig r;
    CHECK(r.drive.current_word_order() == word_order::unknown);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.state() == drive_state::needs_set_up);
    CHECK_FALSE(r.drive.restart_visible());
    CHECK(r.drive.current_word_order() == word_order::low_first);
}

TEST_CASE("G22: while a read that lost its first response is repeated, the word order is known only where a "
          "restart "
          "does not show") {
    for (const bool is_set_up : {false, true}) {
        CAPTURE(is_set_up);
        rig r;
        if (is_set_up) REQUIRE(r.make_ready());
        if (!is_set_up) REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.restart_visible() == is_set_up);
        const std::size_t start = r.wire.requests();
        REQUIRE(r.drive.begin(read_status{}) == errc::ok);
        CHECK(r.drive.current_word_order() == word_order::low_first);
        bool was_unknown = false;
        while (!r.drive.is_idle()) {
            r.wire.faults().lost_response = r.wire.requests() - start <= 1 ? 1000 : 0;
            r.turn();
            was_unknown = was_unknown || r.drive.current_word_order() == word_order::unknown;
        }
        CHECK(r.drive.last());
        CHECK(r.wire.struck() != 0);
        CHECK(r.wire.requests() - start > 1);
        CHECK(was_unknown == is_set_up);
        CHECK(r.drive.current_word_order() == word_order::low_first);
    }
}

TEST_CASE("G36: feedback of which one part is older than asked is not delivered") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.read());
    r.run(500);
    REQUIRE(r.drive.read_status()); // without position, speed and alarm
    CHECK(r.drive.feedback(milliseconds(300)).error() == errc::timeout);
    CHECK(r.drive.feedback(milliseconds(600)));
}

TEST_CASE("G21: an init that loses the line at any of its frames leaves the drive unknown") {
    std::size_t failures = 0;
    for (std::size_t frame = 1; frame < 45; frame += 3) {
        CAPTURE(frame);
        rig r;
        REQUIRE(r.make_ready());
        const std::size_t start = r.wire.requests();
        REQUIRE(r.drive.begin(init{}) == errc::ok);
        while (!r.drive.is_idle()) {
            r.wire.faults().lost_response = r.wire.requests() - start >= frame ? 1000 : 0;
            r.turn();
        }
        r.wire.faults() = {};
        if (r.drive.last()) continue; // it has fewer frames
        ++failures;
        CHECK(r.drive.state() == drive_state::needs_init);
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.state() == drive_state::disabled);
    }
    CHECK(failures >= 13); // it has 40 frames and more
}

TEST_CASE("G26: a quick stop that is not confirmed is repeated as one") {
    rig r;
    begin_move(r, 200'000);
    r.drive.repeat_stops(milliseconds(200));
    r.wire.cut_for(milliseconds(1200));
    CHECK_FALSE(r.drive.run(quick_stop{}));
    const std::size_t before = r.written_to(emergency_stop.address).size();
    r.loop(2000);
    CHECK(r.written_to(emergency_stop.address).size() > before);
    CHECK(r.model.stands_still());
}

} // namespace honest_ends_c630s_tests
