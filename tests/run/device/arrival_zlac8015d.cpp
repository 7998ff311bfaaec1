// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How moves of a ZLAC8015D end: the state, the cause and what is missing are compared with the positions of the
// simulated wheels; the frames of a wait are counted on the wire.
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>

namespace arrival_zlac8015d_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using rig = simulated::driven_zlac8015d;

namespace {

constexpr supervision supervised{.feedback = milliseconds(20), .command_timeout = milliseconds(300)};

struct enabled : rig {
    explicit enabled(operating_mode mode = operating_mode::relative_position,
                     synchronisation starts = synchronisation::synchronous)
        : rig{{}, supervised} {
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable_in{checked(mode), starts}));
    }
    void turn() {
        const duration idle = drive.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void step_for(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + ms * 1000u;
        while (wire.time_us() < end) turn();
    }
    void step_to_end() {
        while (!drive.is_idle()) turn();
    }
};

} // namespace

TEST_CASE("G34: a move is reached when both wheels are at rest at their targets") {
    for (const operating_mode mode : {operating_mode::relative_position, operating_mode::absolute_position}) {
        CAPTURE(static_cast<int>(mode));
        enabled r{mode};
        const bool is_relative = mode == operating_mode::relative_position;
        const arrival came =
            is_relative
                ? r.drive.run(move_by{8192 * pulse, -4096 * pulse}, wait_reached{milliseconds(10'000)})
                : r.drive.run(move_to{8192 * pulse, -4096 * pulse}, wait_reached{milliseconds(10'000)});
        CHECK(r.drive.last());
        CHECK(came.how == arrival_state::reached);
        CHECK(came.cause == stop_cause::unknown);
        CHECK(r.model.stands_still());
        CHECK(r.model.left().position == 8192);
        CHECK(r.model.right().position == -4096);
        // The next one counts from there.
        const arrival next =
            is_relative
                ? r.drive.run(move_by{-92 * pulse, 96 * pulse}, wait_reached{milliseconds(10'000)})
                : r.drive.run(move_to{8100 * pulse, -4000 * pulse}, wait_reached{milliseconds(10'000)});
        CHECK(next.how == arrival_state::reached);
        CHECK(r.model.left().position == 8100);
    }
}

TEST_CASE("G34: a move that ends before its target says where, what is missing and why") {
    struct scene {
        const char* name;
        void (*happens)(enabled&);
        stop_cause cause;
        errc error;
    };
    const scene all[] = {
        {"input", [](enabled& r) { r.model.set_input(true, false); }, stop_cause::input, errc::stopped_short},
        {"fault",
         [](enabled& r) {
             r.model.raise(fault::overcurrent, fault::none);
             r.model.end_faults();
         },
         stop_cause::fault, errc::faulted},
    };
    for (const scene& s : all) {
        CAPTURE(s.name);
        enabled r;
        REQUIRE(r.drive.run(move_by{40960 * pulse, 30000 * pulse}));
        r.step_for(600);
        REQUIRE(r.drive.begin(wait_reached{milliseconds(20'000)}) == errc::ok);
        s.happens(r);
        const std::uint64_t since = r.wire.time_us();
        r.step_to_end();
        CHECK(r.wire.time_us() - since < 3'000'000);
        CHECK(r.drive.last().error() == s.error);
        r.step_for(500);
        const arrival came = r.drive.arrival();
        CHECK(came.how == arrival_state::stopped_short);
        CHECK(came.cause == s.cause);
        CHECK(r.model.stands_still());
        CHECK(r.model.left().position < 40960);
        CHECK(came.left_missing.count() == 40960 - r.model.left().position);
        CHECK(came.right_missing.count() == 30000 - r.model.right().position);
    }
}

TEST_CASE(
    "G34, G35: as soon as a fault shows, the move that it cuts has ended short, although the motor runs") {
    for (const bool is_left : {true, false}) {
        CAPTURE(is_left);
        enabled r;
        REQUIRE(r.drive.run(move_by{40'960 * pulse, 40'960 * pulse}));
        r.step_for(300);
        REQUIRE(r.drive.arrival().how == arrival_state::under_way);
        r.model.raise(is_left ? fault::overcurrent : fault::none, is_left ? fault::none : fault::overcurrent);
        for (int i = 0; i < 100'000 && r.drive.cause() != stop_cause::fault; ++i) r.turn();
        REQUIRE(r.drive.cause() == stop_cause::fault);
        CHECK(r.drive.state() == drive_state::faulted);
        CHECK(r.drive.arrival().how == arrival_state::stopped_short);
        CHECK(r.drive.arrival().cause == stop_cause::fault);
    }
}

TEST_CASE("G34: a move whose targets got no response is not looked for: it has not begun") {
    enabled r;
    REQUIRE(r.drive.run(move_by{2048 * pulse, 2048 * pulse}, wait_reached{}).how == arrival_state::reached);
    r.log.frames.clear();
    REQUIRE(r.drive.begin(move_by{1000 * pulse, 1000 * pulse}) == errc::ok);
    const auto is_target = [](const auto& f) { return modbus::is_write(f[1]) && load_word(f, 2) == 0x208A; };
    while (!r.drive.is_idle()) {
        if (!r.log.frames.empty() && is_target(r.log.frames.back())) r.wire.faults().lost_response = 1000;
        r.turn();
    }
    r.wire.faults() = {};
    REQUIRE(r.drive.last().outcome() == outcome::unknown);
    CHECK(r.drive.motion() == motion_check::not_asked);
    CHECK(r.model.starts() == 1);
}

TEST_CASE("G34: a stop of the program ends a move, and the wait for it does not succeed") {
    enabled r;
    REQUIRE(r.drive.run(move_by{40960 * pulse, 40960 * pulse}));
    r.step_for(600);
    REQUIRE(r.drive.run(quick_stop{}));
    CHECK(r.drive.run(wait_standstill{}).error() == errc::stopped_short);
    CHECK(r.drive.arrival().how == arrival_state::stopped_short);
    CHECK(r.drive.arrival().cause == stop_cause::command);
    CHECK(r.drive.arrival().left_missing.count() == 40960 - r.model.left().position);
}

TEST_CASE("G34: a restart during a move is no arrival") {
    for (const std::int32_t way : {40960, 30, 10}) {
        CAPTURE(way);
        enabled r;
        REQUIRE(r.drive.run(move_by{way * pulse, way * pulse}));
        REQUIRE(r.drive.begin(wait_reached{milliseconds(20'000)}) == errc::ok);
        r.model.power_cycle();
        r.step_to_end();
        CHECK_FALSE(r.drive.last());
        CHECK(r.drive.state() == drive_state::needs_init);
        CHECK(r.drive.arrival().how != arrival_state::reached);
    }
}

TEST_CASE("G21, G34: a wait ends as the drive needs an init once a restart shows") {
    enabled r;
    REQUIRE(r.drive.run(move_by{40'960 * pulse, 40'960 * pulse}));
    REQUIRE(r.drive.begin(wait_reached{}) == errc::ok);
    const std::uint64_t start = r.wire.time_us();
    while (!r.drive.is_idle()) {
        if (r.wire.time_us() - start > 100'000 && r.model.enabled()) r.model.power_cycle();
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(r.drive.last().error() == errc::needs_init);
    CHECK(r.drive.cause() == stop_cause::restart);
    CHECK(r.drive.arrival(wheels::both).how == arrival_state::none);
}

TEST_CASE("G34: a wait does not succeed after a restart that locks the shafts where a short move would end") {
    for (const bool is_standstill : {false, true}) {
        for (const std::int32_t way : {4, 10, 20}) {
            CAPTURE(way);
            enabled r;
            client direct{r.line, node<device>{1}};
            REQUIRE(r.drive.run(disable{}));
            REQUIRE(direct.write<shaft_at_power_on>(power_on_shaft::locked));
            REQUIRE(r.drive.run(save{}));
            REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
            REQUIRE(r.drive.run(move_by{way * pulse, way * pulse}));
            r.model.power_cycle(); // the positions are 0 again
            const command_status waited = is_standstill ? r.drive.run(wait_standstill{})
                                                        : r.drive.run(wait_reached{milliseconds(2'000)});
            CHECK_FALSE(waited);
            CHECK(r.drive.arrival().how != arrival_state::reached);
            CHECK(r.drive.state() == drive_state::needs_init);
        }
    }
}

TEST_CASE("G34: a wait that is too short ends with not_reached, and the move goes on") {
    enabled r;
    REQUIRE(r.drive.run(move_by{40960 * pulse, 40960 * pulse}));
    CHECK(r.drive.run(wait_reached{milliseconds(500)}).error() == errc::not_reached);
    CHECK(r.drive.arrival().how == arrival_state::under_way);
    CHECK(r.drive.run(wait_reached{milliseconds(20'000)}));
    CHECK(r.model.left().position == 40960);
}

TEST_CASE("a feedback period that is shorter than its frames is refused before anything is sent") {
    // 8 bytes and 27 bytes of 11 bits at 115200 Bd: 3342 us.
    for (const std::uint32_t us : {1u, 3000u, 4000u}) {
        CAPTURE(us);
        rig r{{}, {.feedback = microseconds(us), .command_timeout = no_command_timeout}};
        const command_status got = r.drive.run(init{});
        CHECK(got.error() == (us < 3342 ? errc::bad_argument : errc::ok));
        CHECK((r.log.frames.size() == 0) == (us < 3342));
    }
}

TEST_CASE("G34: a move that is refused has no arrival, and last() says why") {
    enabled r;
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.drive.run(move_by{100 * pulse, 100 * pulse}, wait_reached{}).how == arrival_state::none);
    CHECK(r.drive.last().error() == errc::wrong_state);
    CHECK(r.drive.last().outcome() == outcome::not_sent);
    // Nor that of the move before it.
    REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
    REQUIRE(r.drive.run(move_by{100 * pulse, 100 * pulse}, wait_reached{}).how == arrival_state::reached);
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.drive.run(move_by{100 * pulse, 100 * pulse}, wait_reached{}).how == arrival_state::none);
    CHECK(r.drive.last().error() == errc::wrong_state);
}

TEST_CASE("G34: an absolute move arrives at its target from wherever zero is") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    const enable_in absolute{operating_mode::absolute_position};
    const auto go = [&](std::int32_t left, std::int32_t right) {
        REQUIRE(r.drive.run(absolute));
        const arrival came =
            r.drive.run(move_to{left * pulse, right * pulse}, wait_reached{milliseconds(20'000)});
        CHECK(came.how == arrival_state::reached);
        CHECK(came.left_missing.count() == 0);
        CHECK(came.right_missing.count() == 0);
        REQUIRE(r.drive.run(disable{}));
    };
    go(3000, -2000);
    REQUIRE(r.drive.run(clear_position{wheels::left}));
    go(1000, -1000);
    CHECK(r.model.left().position == 4000); // of the simulated wheel, whose zero stays
    CHECK(r.model.right().position == -1000);
    REQUIRE(r.drive.run(clear_position{}));
    go(-500, 500);
    CHECK(r.model.left().position == 3500);
    CHECK(r.model.right().position == -500);
    r.model.power_cycle();
    REQUIRE(r.drive.run(init{}));
    go(250, -250);
}

TEST_CASE("G34: without a move there is nothing to wait for") {
    enabled r;
    const std::size_t frames = r.log.frames.size();
    CHECK(r.drive.run(wait_reached{milliseconds(500)}).error() == errc::wrong_state);
    CHECK(r.drive.arrival().how == arrival_state::none);
    CHECK(r.log.frames.size() == frames);
    REQUIRE(r.drive.run(move_by{100 * pulse, 100 * pulse}, wait_reached{milliseconds(5'000)}).how ==
            arrival_state::reached);
    REQUIRE(r.drive.run(clear_position{})); // its positions mean something else now
    CHECK(r.drive.run(wait_reached{milliseconds(500)}).error() == errc::wrong_state);
}

TEST_CASE("G34: after an init there is no move to wait for, since a restart before it may have changed the "
          "positions") {
    for (const std::int32_t way : {10, 4096}) {
        CAPTURE(way);
        enabled r;
        REQUIRE(r.drive.run(move_by{way * pulse, way * pulse}, wait_reached{milliseconds(5'000)}).how ==
                arrival_state::reached);
        r.model.power_cycle(); // the positions are 0 again
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.read());
        CHECK(r.drive.arrival().how == arrival_state::none);
        CHECK(r.drive.run(wait_reached{milliseconds(500)}).error() == errc::wrong_state);
    }
    rig fresh;
    REQUIRE(fresh.drive.run(init{}));
    CHECK(fresh.drive.run(wait_reached{milliseconds(500)}).error() == errc::wrong_state);
}

TEST_CASE("G34: a move of one wheel that is refused leaves the other wheel its target") {
    enabled r{operating_mode::relative_position, synchronisation::asynchronous};
    for (const bool is_left_first : {true, false}) {
        CAPTURE(is_left_first);
        const wheels first = is_left_first ? wheels::left : wheels::right;
        const wheels second = is_left_first ? wheels::right : wheels::left;
        const distance too_far{-0x7FFF'FFFF - 1};
        if (is_left_first)
            REQUIRE(r.drive.run(move_left_by{4096 * pulse}));
        else
            REQUIRE(r.drive.run(move_right_by{4096 * pulse}));
        REQUIRE(r.drive.run(wait_wheels_reached{first}));
        const command_status refused =
            is_left_first ? r.drive.run(move_right_by{too_far}) : r.drive.run(move_left_by{too_far});
        CHECK(refused.error() == errc::out_of_range);
        CHECK(r.drive.arrival(second).how == arrival_state::none);
        CHECK(r.drive.arrival(first).how == arrival_state::reached);
        CHECK(r.drive.arrival().how == arrival_state::none);
        CHECK(r.drive.run(wait_wheels_reached{first}));
    }
}

TEST_CASE("G34: in the asynchronous mode each wheel has its own move and its own end") {
    enabled r{operating_mode::relative_position, synchronisation::asynchronous};
    REQUIRE(r.drive.run(move_left_by{40960 * pulse}));
    r.step_for(300);
    REQUIRE_FALSE(r.model.stands_still());
    REQUIRE(r.drive.run(move_right_by{4096 * pulse}));
    CHECK(r.model.starts() == 2);
    CHECK(r.drive.run(move_left_by{1 * pulse}).error() == errc::busy);
    REQUIRE(r.drive.run(wait_wheels_reached{wheels::right}));
    CHECK(r.model.right().position == 4096);
    CHECK(r.drive.arrival(wheels::right).how == arrival_state::reached);
    CHECK(r.drive.arrival(wheels::left).how == arrival_state::under_way);
    CHECK(r.drive.arrival().how == arrival_state::under_way);
    REQUIRE(r.drive.run(wait_wheels_reached{wheels::left}));
    CHECK(r.model.left().position == 40960);
    CHECK(r.model.starts() == 2);
}

TEST_CASE(
    "G34: a move that a fault has replaced has no arrival, and that of the other wheel is not its own") {
    enabled r{operating_mode::relative_position, synchronisation::asynchronous};
    CHECK(r.drive.run(move_right_by{300 * pulse}, wait_wheels_reached{wheels::right, milliseconds(5'000)})
              .how == arrival_state::reached);
    REQUIRE(r.drive.begin(move_left_by{4000 * pulse}) == errc::ok);
    r.model.raise(fault::none, fault::overcurrent);
    r.step_to_end();
    CHECK(r.drive.last().error() == errc::faulted);
    CHECK(r.drive.arrival().how == arrival_state::none);
    CHECK(r.drive.arrival(wheels::left).how == arrival_state::none);
    CHECK(r.drive.arrival(wheels::right).how == arrival_state::reached);
    CHECK(r.drive.begin(wait_reached{milliseconds(100)}) == errc::wrong_state);

    r.model.end_faults();
    (void)r.drive.run(fault_reset{});
    REQUIRE(r.drive.run(init{}));
    REQUIRE(
        r.drive.run(enable_in{checked(operating_mode::relative_position), synchronisation::asynchronous}));
    CHECK(r.drive.run(move_right_by{300 * pulse}, wait_reached{milliseconds(5'000)}).how ==
          arrival_state::reached);
}

TEST_CASE("a wait of 40960 counts takes at most 300 frames, and a halt 30") {
    enabled r;
    REQUIRE(r.drive.run(move_by{40960 * pulse, 40960 * pulse}));
    r.log.frames.clear();
    REQUIRE(r.drive.run(wait_reached{milliseconds(20'000)}));
    CHECK(r.log.frames.size() <= 300);
    enabled s{operating_mode::velocity};
    REQUIRE(s.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    s.step_for(1000);
    s.log.frames.clear();
    REQUIRE(s.drive.run(halt{}));
    CHECK(s.log.frames.size() <= 30);
    MESSAGE("frames of the wait: ", r.log.frames.size(), ", of the halt: ", s.log.frames.size());
}

TEST_CASE("G35: a restart of an enabled drive shows within a feedback period and two frames") {
    for (std::uint32_t us = 0; us < 25'000; us += 500) {
        CAPTURE(us);
        enabled r{operating_mode::velocity};
        REQUIRE(r.drive.run(velocity{20 * r_per_min, 20 * r_per_min}));
        r.step_for(100);
        const std::uint64_t at = r.wire.time_us() + us;
        while (r.wire.time_us() < at) r.turn();
        r.model.power_cycle();
        r.step_for(20 + 2 * 6);
        CHECK(r.drive.state() == drive_state::needs_init);
    }
}

TEST_CASE("G20: polling does not keep the wheels of a program alive that has stopped commanding") {
    enabled r{operating_mode::velocity};
    REQUIRE(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}));
    r.step_for(200);
    REQUIRE_FALSE(r.model.stands_still());
    r.step_for(3000); // it steps its drive, and commands nothing
    CHECK(r.model.stands_still());
    CHECK(r.drive.state() == drive_state::enabled);
    CHECK_FALSE(r.model.in_watchdog_stop());
}

} // namespace arrival_zlac8015d_tests
