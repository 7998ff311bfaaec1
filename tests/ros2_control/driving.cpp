// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The hardware interface drives: positions and velocities are those of the simulated wheels, commands have one factor
// at a limit, and no call waits.
#include "robot.hpp"

#include <algorithm>
#include <limits>

namespace robots::driving {

TEST_CASE("a drive is taken over and enabled without a motion, and driven at 100 Hz") {
    world w;
    w.begin();
    REQUIRE(w.component.is_active());
    CHECK(w.drive.enabled());
    CHECK(w.drive.left().position == 0);
    CHECK(w.component.names() ==
          std::vector<std::string>{"left_wheel_joint/position", "left_wheel_joint/velocity",
                                   "right_wheel_joint/position", "right_wheel_joint/velocity",
                                   "drive/is_faulted", "drive/position_gaps", "left_wheel_joint/velocity",
                                   "right_wheel_joint/velocity"});
    w.component.command(3.0, -2.0);
    REQUIRE(w.run(3000) == return_type::OK);
    // 0.1 r/min is 0.0105 rad/s.
    CHECK(w.velocity("left") == doctest::Approx(3.0).epsilon(0.01));
    CHECK(w.velocity("right") == doctest::Approx(-2.0).epsilon(0.01));
    CHECK(w.drive.left().speed > 0);
    CHECK(w.drive.right().speed > 0); // mirrored: it counts up as it goes back
    w.component.command(0, 0);
    REQUIRE(w.run(2000) == return_type::OK);
    CHECK(w.drive.stands_still());
    CHECK(w.position("left") == doctest::Approx(w.left()).epsilon(1e-9));
    CHECK(w.position("right") == doctest::Approx(w.right()).epsilon(1e-9));
    CHECK(w.position("left") > 7);
    CHECK(w.position("right") < -4.5);
    CHECK(w.errors().empty());
}

TEST_CASE("read and write do not wait, and the feedback is young, at each rate of the loop") {
    struct rate {
        std::uint32_t hz;
        double oldest_ms; // as README.md says
    };
    for (const auto [hz, oldest_ms] :
         {rate{20, 470}, rate{50, 190}, rate{100, 95}, rate{200, 50}, rate{500, 50}, rate{1000, 50}}) {
        world w;
        w.begin();
        REQUIRE(w.component.is_active());
        double late = 0;
        const std::uint32_t before = w.wire.requests();
        const std::uint64_t end = w.wire.time_us() + 4'000'000;
        for (int i = 0; w.wire.time_us() < end; ++i) {
            w.component.command(4 + i % 7 * 0.05,
                                4 - i % 5 * 0.05); // a command that changes in each iteration
            REQUIRE(w.cycle(microseconds(1'000'000 / hz)) == return_type::OK);
            if (w.wire.time_us() + 2'000'000 > end) late = std::max(late, w.left() - w.position("left"));
        }
        MESSAGE(hz, " Hz: at most ", w.longest_us, " us in read and write; the position is at most ",
                late / 4 * 1000, " ms old; ", (w.wire.requests() - before) / 4, " requests a second");
        CHECK(w.longest_us < 200);
        CHECK(late / 4 * 1000 < oldest_ms);
    }
}

TEST_CASE("commands that change at 50 Hz are followed within the limits, whatever the drive's ramps are") {
    using ramp = sim::zlac8015d_options::ramp;
    for (const ramp reading : {ramp::begins_anew, ramp::linear}) {
        sim::zlac8015d_options options;
        options.speed_ramp = reading;
        world w{options};
        w.begin();
        double fastest = 0, steepest = 0, before = 0;
        for (int i = 0; i < 200; ++i) {
            const double wanted = 8 * std::sin(world::turn * i / 100); // 25 rad/s in a second, a turn in 2 s
            w.component.command(wanted, wanted);
            REQUIRE(w.cycle(milliseconds(20)) == return_type::OK);
            const double now = static_cast<double>(w.drive.left().speed) / 1e6 * world::turn / 60;
            fastest = std::max(fastest, now);
            steepest = std::max(steepest, std::abs(now - before) * 50);
            before = now;
            if (i > 10)
                CHECK(std::abs(now - 8 * std::sin(world::turn * (i - 3) / 100)) <
                      2.6); // a command takes some iterations
        }
        CHECK(fastest > 7.5);
        CHECK(steepest < 3.2 * 50); // between two looks a step for three iterations
        w.component.command(20, 20);
        REQUIRE(w.run(200) == return_type::OK);
        CHECK(w.velocity("left") < 12); // 50 rad/s in a second
        REQUIRE(w.run(400) == return_type::OK);
        CHECK(w.velocity("left") == doctest::Approx(20).epsilon(0.01));
    }
}

TEST_CASE("a pair above the drive's limit slows down by one factor") {
    world w;
    w.begin();
    w.component.command(100, 50);
    REQUIRE(w.run(3000) == return_type::OK);
    const double left = w.velocity("left"), right = w.velocity("right");
    CHECK(left < 32);
    CHECK(left > 20);
    CHECK(left / right == doctest::Approx(2.0).epsilon(0.005));
    w.component.command(1e12, -1e12);
    REQUIRE(w.run(3000) == return_type::OK);
    CHECK(w.velocity("left") == doctest::Approx(left).epsilon(0.001));
    CHECK(w.velocity("right") == doctest::Approx(-left).epsilon(0.001));
    w.component.command(std::numeric_limits<double>::max(), std::numeric_limits<double>::denorm_min());
    REQUIRE(w.run(3000) == return_type::OK);
    CHECK(w.velocity("left") == doctest::Approx(left).epsilon(0.001));
    CHECK(w.velocity("right") == doctest::Approx(0.0));
}

TEST_CASE("a command that is no finite number is not sent, and ends in a stop") {
    for (const double wrong :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
          -std::numeric_limits<double>::infinity()}) {
        world w;
        w.begin();
        w.component.command(3, 3);
        REQUIRE(w.run(1000) == return_type::OK);
        w.component.command(3, wrong);
        CHECK(w.cycle() == return_type::ERROR);
        CHECK(w.component.state() == primary::PRIMARY_STATE_UNCONFIGURED);
        CHECK(!w.drive.enabled());
        CHECK(w.drive.stands_still());
        REQUIRE(w.errors().size() == 1);
        CHECK(w.errors()[0].find("a command is no finite number: 3.000000, ") != std::string::npos);
    }
}

TEST_CASE("positions are continuous over the wrap of the drive's 32 bits, in both directions") {
    struct wrap {
        u32 from;
        double sign;
    };
    // Of signed numbers, and of numbers without a sign.
    for (const auto [from, sign] : {wrap{0x7FFF'F800u, 1.0}, wrap{0x8000'0800u, -1.0},
                                    wrap{0xFFFF'F800u, 1.0}, wrap{0x0000'0800u, -1.0}}) {
        world w;
        w.drive.shift = from;
        w.begin();
        REQUIRE(w.component.is_active());
        w.component.command(sign * 6, -sign * 6); // both count in one direction
        double last = w.position("left");
        for (int i = 0; i < 400; ++i) {
            REQUIRE(w.cycle() == return_type::OK);
            CHECK(std::abs(w.position("left") - last) < 0.5);
            last = w.position("left");
        }
        w.component.command(0, 0);
        REQUIRE(w.run(1500) == return_type::OK);
        CHECK(std::abs(w.left()) > 20); // 3.14 rad were left to the wrap
        CHECK(w.position("left") == doctest::Approx(w.left()).epsilon(1e-9));
        CHECK(w.position("right") == doctest::Approx(w.right()).epsilon(1e-9));
        CHECK(w.component.value("drive/position_gaps") == 0);
    }
}

TEST_CASE("a command of one wheel is sent as soon as one of both") {
    for (const bool is_left : {true, false}) {
        world w;
        w.begin();
        REQUIRE(w.run(1000) == return_type::OK);
        w.component.command(is_left ? 1 : 0, is_left ? 0 : 1);
        REQUIRE(w.run(60) == return_type::OK);
        CHECK(w.drive.peek(0x2088) == (is_left ? 95 : 0)); // 0.1 r/min
        CHECK(static_cast<std::int16_t>(w.drive.peek(0x2089)) == (is_left ? 0 : -95));
    }
}

TEST_CASE("the wheels stop if the manager no longer calls write, and go on when it does") {
    world w;
    w.begin();
    w.component.command(5, 5);
    REQUIRE(w.run(2000) == return_type::OK);
    for (int i = 0; i < 150; ++i) { // read alone, for 1.5 s
        REQUIRE(w.component.read() == return_type::OK);
        w.wire.pass(milliseconds(10));
    }
    CHECK(w.drive.stands_still());
    CHECK(w.drive.enabled());
    REQUIRE(w.run(1500) == return_type::OK);
    CHECK(w.velocity("left") == doctest::Approx(5).epsilon(0.01));
}

TEST_CASE("the drive's watchdog stops the wheels if the manager calls nothing any more") {
    world w;
    w.begin();
    w.component.command(5, 5);
    REQUIRE(w.run(2000) == return_type::OK);
    w.wire.pass(milliseconds(2500));
    CHECK(w.drive.stands_still());
    // The loop goes on: the outcome is not known, so the component is deactivated and does not move.
    CHECK(w.run(500) == return_type::ERROR);
    w.wire.pass(milliseconds(1000));
    CHECK(!w.drive.enabled());
    CHECK(w.drive.stands_still());
    CHECK(w.errors().size() == 1);
}

} // namespace robots::driving
