// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G21, G35: a restart of a YAKO shows by a marker, the target of position segment 16: what `init` writes, what
// the facade reads, and where a restart cannot show. Judged by the frames and the simulated registers.
#include <array>
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace restart_yako_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::take;
using simulated::closed_axis;
using simulated::open_axis;

namespace {

constexpr u16 segment_16 = 0x00BA;

/// An axis whose feedback is polled.
struct polled_axis : simulated::simulated_closed_loop {
    closed_loop::drive<line_type> drive{
        line, 1, supervision{.feedback = milliseconds(8), .command_timeout = no_command_timeout}};

    void step() {
        (void)drive.step();
        wire.wait(microseconds(100));
    }
};

template <class A> std::int32_t held(A& a) {
    const bool is_high_first = a.model.peek(0x0019) == 0;
    const word_order order = is_high_first ? word_order::high_first : word_order::low_first;
    return static_cast<std::int32_t>(
        join_words(a.model.peek(segment_16), a.model.peek(segment_16 + 1), order));
}
template <class A> void hold(A& a, std::int32_t target) {
    const auto word = static_cast<u32>(target);
    const std::uint8_t words[] = {
        static_cast<std::uint8_t>(word >> 24), static_cast<std::uint8_t>(word >> 16 & 0xFF),
        static_cast<std::uint8_t>(word >> 8 & 0xFF), static_cast<std::uint8_t>(word & 0xFF)};
    REQUIRE(a.model.write(segment_16, words_view{words}) == 0);
}

} // namespace

TEST_CASE_TEMPLATE("init writes a marker that the drive does not hold, and leaves a target that is in use", A,
                   closed_axis, open_axis) {
    for (std::int32_t found = 0; found <= 15; ++found) {
        A a;
        hold(a, found);
        REQUIRE(a.drive.run(init{}));
        CHECK(held(a) != found);
        CHECK(held(a) >= 1);
        CHECK(held(a) <= 15);
        CHECK(a.drive.restart_visible());
        CHECK((a.drive.state() == drive_state::enabled) == a.model.enabled());
    }
    for (const std::int32_t used : {16, -1, 4999, 5001, 70'000, -70'000}) {
        CAPTURE(used);
        A a;
        hold(a, used);
        REQUIRE(a.drive.run(init{}));
        CHECK(held(a) == used);
        CHECK_FALSE(a.drive.restart_visible());
        REQUIRE(a.drive.run(enable{}));
        REQUIRE(a.drive.run(move_by{100 * pulse, brisk}));
    }
    A a;
    CHECK_FALSE(a.drive.restart_visible());
    REQUIRE(a.drive.run(init{})); // the factory's 5000
    CHECK(held(a) == 1);
    REQUIRE(a.drive.run(set_word_order{word_order_setting::low_first}));
    CHECK(held(a) == 1);
    REQUIRE(a.drive.run(enable{})); // the marker is what it was
    REQUIRE(a.drive.run(set_position_segment{15, 700 * pulse, 60 * r_per_min}));
    CHECK(a.drive.restart_visible());
    REQUIRE(a.drive.run(set_position_segment{16, 700 * pulse, 60 * r_per_min}));
    CHECK_FALSE(a.drive.restart_visible());
    REQUIRE(a.drive.run(move_by{100 * pulse, brisk}));
}

TEST_CASE("the marker stays valid where the word order is low first, and where it is set to what it is") {
    for (const auto order : {word_order_setting::high_first, word_order_setting::low_first}) {
        CAPTURE(static_cast<int>(order));
        closed_axis a;
        REQUIRE(a.model.write(0x0019, words_view{std::array<std::uint8_t, 2>{
                                          0, static_cast<std::uint8_t>(order)}}) == 0);
        take(a);
        REQUIRE(a.drive.restart_visible());
        REQUIRE(a.drive.run(move_by{100 * pulse, brisk}, wait_reached{}).how == arrival_state::reached);
        REQUIRE(a.drive.run(set_word_order{order}));
        CHECK(a.drive.run(move_by{100 * pulse, brisk}, wait_reached{}).how == arrival_state::reached);
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
    }
}

TEST_CASE_TEMPLATE("S4: after a start without a response a marker is read only where there is one", A,
                   closed_axis, open_axis) {
    for (const bool is_marked : {false, true}) {
        for (const bool is_made : {false, true}) {
            CAPTURE(is_marked);
            CAPTURE(is_made);
            A a;
            if (!is_marked) hold(a, 700);
            take(a);
            REQUIRE(a.drive.restart_visible() == is_marked);
            a.requests.clear();
            REQUIRE(simulated::run_with_a_loss(a, move_by{400 * pulse, brisk}, 3,
                                               is_made)); // the start is the fourth frame
            CHECK(a.drive.last().outcome() == outcome::unknown);
            CHECK(a.drive.motion() == (is_made ? motion_check::seen : motion_check::not_seen));
            const bool has_read = load_word(a.requests.back(), 2) == segment_16;
            CHECK(has_read == is_marked);
        }
    }
}

TEST_CASE("a save does not keep the marker, and leaves one") {
    for (const auto kept : {sim::yako_kept::saved, sim::yako_kept::marked, sim::yako_kept::line_settings}) {
        closed_axis a{{.kept = kept}};
        take(a);
        REQUIRE(a.drive.run(save{}));
        CHECK(a.drive.restart_visible());
        const std::int32_t marker = held(a);
        CHECK(marker >= 1);
        a.model.power_cycle();
        CHECK(held(a) != marker);
        CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
        CHECK(a.place() == 0);
    }
}

TEST_CASE_TEMPLATE("a polled drive that has restarted shows it within 500 ms and two frames", A, closed_axis,
                   open_axis) {
    for (const bool is_enabled : {false, true}) {
        for (std::uint32_t after_ms = 0; after_ms < 600; after_ms += 37) {
            CAPTURE(after_ms);
            A a{{.restart_keeps_place = true, .restart_keeps_homed = true}};
            decltype(a.drive) polled{a.line, 1}; // the other one sends nothing
            REQUIRE(polled.run(init{}));
            if (is_enabled) REQUIRE(polled.run(enable{}));
            const auto loop = [&](std::uint32_t ms) {
                const std::uint64_t end = a.wire.time_us() + std::uint64_t{ms} * 1000u;
                while (a.wire.time_us() < end && polled.state() != drive_state::needs_init) {
                    const duration idle = polled.step();
                    a.wire.wait(idle.us == 0 ? microseconds(10) : idle);
                }
            };
            loop(after_ms);
            REQUIRE(polled.state() != drive_state::needs_init);
            a.model.power_cycle();
            const std::uint64_t restarted = a.wire.time_us();
            loop(2000);
            CHECK(polled.state() == drive_state::needs_init);
            CHECK(polled.cause() == stop_cause::restart);
            CHECK(a.wire.time_us() - restarted < 500'000 + 2 * 20'000);
        }
    }
}

TEST_CASE("a restart between the frames of a move is found by the command or the next one, and nothing is "
          "sent twice") {
    for (std::size_t n = 0; n < 6; ++n) {
        CAPTURE(n);
        closed_axis a{{.restart_keeps_place = true, .restart_keeps_homed = true}};
        take(a);
        a.begin_up_to(move_by{1000 * pulse, brisk}, n);
        while (a.wire.requests() > a.wire.responses()) a.turn(); // it restarts between two frames
        a.model.power_cycle();
        a.finish();
        // In the last frame the motor is not seen to move, and the marker is not read again.
        CHECK(a.drive.last().error() == (n == 5 ? errc::not_executed : errc::needs_init));
        CHECK(a.drive.run(move_by{1000 * pulse, brisk}).error() == errc::needs_init);
        CHECK(a.model.starts() <= 1);
    }
}

TEST_CASE("G21, G35: a restart during a save shows, but from the read of its marker until it is set again") {
    unsigned shown = 0;
    for (std::uint32_t phase = 0; phase < 160; ++phase) {
        CAPTURE(phase);
        closed_axis a;
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(disable{}));
        a.requests.clear();
        REQUIRE(a.drive.begin(save{}) == errc::ok);
        const std::uint64_t end = a.wire.time_us() + 250 * phase;
        const auto turn = [&] {
            const duration idle = a.drive.step();
            a.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        };
        while (a.wire.time_us() < end && !a.drive.is_idle()) turn();
        if (a.drive.is_idle()) break;
        const std::size_t before = a.requests.size();
        const bool is_cleared = held(a) == 0;
        a.model.power_cycle();
        while (!a.drive.is_idle()) turn();
        const command_status next = a.drive.run(enable{});
        if (!next) {
            ++shown;
            CHECK(a.drive.state() == drive_state::needs_init);
            continue;
        }
        if (is_cleared) continue;
        REQUIRE(before != 0);
        CHECK(same_bytes(a.requests[before - 1], modbus::read_frame(1, segment_16, 2)));
        CHECK(same_bytes(a.requests[before], modbus::write_frame(1, segment_16, std::array<u16, 2>{0, 0})));
    }
    CHECK(shown > 60);
}

TEST_CASE("G20, G21: a motor that a restarted drive turns, since the restart is found after the start, is "
          "stopped") {
    unsigned turned = 0;
    for (std::size_t n = 1; n <= 12; ++n) {
        CAPTURE(n);
        closed_axis a;
        take(a);
        a.begin_up_to(velocity{60 * r_per_min, 30 * millisecond, 30 * millisecond}, n);
        if (a.drive.is_idle()) break;
        a.model.power_cycle(); // it is energised again
        for (int i = 0; i < 100'000 && !a.drive.is_idle(); ++i) {
            a.turn();
            turned += a.is_moving() ? 1u : 0u;
        }
        a.run(1'000);
        CHECK_FALSE(a.is_moving());
    }
    CHECK(turned != 0);
}

TEST_CASE(
    "S1: the frame before the start of a homing is the read of the marker, whenever the feedback is due") {
    unsigned due = 0;
    for (unsigned ms = 0; ms < 60; ++ms) {
        CAPTURE(ms);
        polled_axis a;
        a.model.attach(simulated::yako_slide());
        take(a);
        REQUIRE(a.drive.run(set_homing_profile{120 * r_per_min, 30 * r_per_min}));
        for (unsigned i = 0; i < ms * 10; ++i) a.step();
        REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
        while (a.sent(enabled_yako::start_homing_frame) == 0) a.step();
        const std::size_t start = a.requests.size() - 1;
        REQUIRE(same_bytes(a.requests[start], enabled_yako::start_homing_frame));
        CHECK(same_bytes(a.requests[start - 1], modbus::read_frame(1, segment_16, 2)));
        const bool is_read_between = same_bytes(a.requests[start - 3], modbus::read_frame(1, 0x0006, 7));
        due += is_read_between ? 1u : 0u;
    }
    CHECK(due > 40);
}

TEST_CASE_TEMPLATE("G21, G26: a stop that finds a restart goes on, and is sent once", Stop, halt, disable) {
    unsigned found = 0;
    for (std::size_t n = 1; n <= 8; ++n) {
        CAPTURE(n);
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(velocity{600 * r_per_min, 1'000 * millisecond, 1'000 * millisecond}));
        a.run(500);
        const std::size_t before = a.sent(enabled_yako::stop_frame);
        a.begin_up_to(Stop{}, n);
        if (a.drive.is_idle()) break;
        a.model.power_cycle();
        a.finish();
        a.run(100);
        CHECK(a.drive.last());
        CHECK(a.sent(enabled_yako::stop_frame) == before + 1);
        found += a.drive.state() == drive_state::needs_init ? 1u : 0u;
    }
    CHECK(found != 0);
}

TEST_CASE("S1: a drive that restarts before the start of a homing is not sent the start") {
    unsigned restarts = 0;
    for (std::size_t n = 1; n <= 20; ++n) {
        CAPTURE(n);
        closed_axis a;
        take(a);
        a.begin_up_to(declare_position{500 * pulse}, n);
        if (a.drive.is_idle()) break;
        // The restart comes after the response has begun, before the next request.
        while (a.requests.size() == n && a.wire.responses() < a.wire.requests()) a.turn();
        const bool is_started = a.sent(enabled_yako::start_homing_frame) != 0;
        const bool was_last_before_start = a.requests.back()[1] == 0x03;
        a.model.power_cycle();
        const std::int64_t before = a.model.view().shaft;
        a.finish();
        a.run(2'000);
        ++restarts;
        // Only what was read in the frame before the start hides a restart after it.
        if (!is_started && a.sent(enabled_yako::start_homing_frame) != 0) CHECK(was_last_before_start);
        if (!is_started && a.sent(enabled_yako::start_homing_frame) == 0)
            CHECK(a.model.view().shaft == before);
    }
    CHECK(restarts >= 6);
}

TEST_CASE("S8: an axis that the program has stopped was stopped by that, though it has restarted since") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    REQUIRE(a.drive.run(halt{}));
    REQUIRE(a.drive.cause() == stop_cause::command);
    a.model.power_cycle();
    a.wire.pass(milliseconds(1000));
    CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
    CHECK(a.drive.cause() == stop_cause::command);
}

} // namespace restart_yako_tests
