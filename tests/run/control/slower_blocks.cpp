// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A facade whose feedback has blocks that are read less often, the C630S's: how old they may be, what the loss of one
// costs, what a read of all of them takes, and what a restart during a halt means.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/frame_port.hpp>

namespace slower_blocks_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

namespace {

constexpr supervision often{.feedback = milliseconds(20), .command_timeout = no_command_timeout};

struct rig : simulated::simulated_c630s {
    c630s::drive<line_type> servo;

    explicit rig(const supervision& by = often) : servo{line, 1, by} {
        REQUIRE(servo.run(init{}));
        REQUIRE(servo.run(set_up{}));
        model.power_cycle();
        REQUIRE(servo.run(init{}));
    }
    template <class Before> void loop(std::uint32_t ms, const Before& before_each_turn) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) {
            before_each_turn();
            const duration idle = servo.step();
            wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    }
    void loop(std::uint32_t ms) {
        loop(ms, [] {});
    }
};

} // namespace

TEST_CASE("G36: the feedback is complete when each of its blocks was read, and no longer ago than asked") {
    rig r;
    // Four blocks, one with every second status: 160 ms.
    const std::uint64_t begun = r.wire.time_us();
    while (!r.servo.feedback(milliseconds(400))) {
        REQUIRE(r.wire.time_us() - begun < 400'000);
        CHECK(r.servo.feedback(milliseconds(400)).error() == errc::timeout);
        r.loop(1);
    }
    r.loop(500);
    CHECK(r.servo.feedback(milliseconds(300)));
    CHECK(r.servo.feedback(milliseconds(100)).error() ==
          errc::timeout); // the status is young, the oldest block not
}

TEST_CASE("G36: the feedback is as old as its oldest block, whichever that is, and a position that was held "
          "back is as old as its request") {
    for (const bool is_enabled : {false, true}) {
        CAPTURE(is_enabled);
        rig r;
        if (is_enabled) REQUIRE(r.servo.run(enable_in{control_mode::speed}));
        r.requests.clear();
        constexpr std::size_t blocks = c630s::model::blocks.size();
        std::uint64_t asked[blocks]{}; // when the block's request had left
        std::size_t seen = 0;
        const auto look = [&] {
            r.loop(1);
            for (; seen < r.requests.size(); ++seen) {
                const auto& f = r.requests[seen];
                for (std::size_t b = 1; b < blocks; ++b) {
                    const bool is_it = f[1] == 0x03 && load_word(f, 2) == c630s::model::blocks[b].address;
                    if (is_it) asked[b] = r.wire.time_us();
                }
            }
        };
        for (unsigned ms = 0; ms < 500; ++ms) look();
        unsigned is_oldest[blocks]{};
        for (unsigned ms = 0; ms < 330; ++ms) { // each block twice
            look();
            std::size_t oldest = 1;
            std::uint64_t last = asked[1];
            for (std::size_t b = 2; b < blocks; ++b) {
                if (asked[b] < asked[oldest]) oldest = b;
                last = std::max(last, asked[b]);
            }
            ++is_oldest[oldest];
            CAPTURE(oldest);
            const auto age = static_cast<std::uint32_t>(r.wire.time_us() - asked[oldest]);
            CHECK(r.servo.feedback(microseconds(age)).error() == errc::timeout); // the request took 1.4 ms
            const bool has_come = r.wire.time_us() - last > 30'000;              // with the status after it
            if (has_come) CHECK(r.servo.feedback(microseconds(age + 8000)));
        }
        for (std::size_t b = 1; b < blocks; ++b) CHECK(is_oldest[b] > 50);
    }
}

TEST_CASE("G36: whichever frame of the feedback loses its response, it is read again in its turn, and the "
          "state stays") {
    rig r;
    for (std::size_t lost = 0; lost < 20; ++lost) {
        CAPTURE(lost);
        simulated::frame_port<sim::c630s> port{r.model};
        servobus::line line{port, modbus::timing_at(port.baud)};
        c630s::drive servo{line, 1, often};
        const auto loop = [&](std::uint64_t us) {
            const std::uint64_t end = port.time_us() + us;
            while (port.time_us() < end) port.wait(servo.step());
        };
        REQUIRE(servo.run(init{}));
        loop(500'000);
        port.plan(simulated::mishap::response_lost, lost);
        loop(1'000'000);
        CHECK(port.has_struck());
        CHECK(servo.state() == drive_state::disabled);
        CHECK(servo.feedback(milliseconds(400)));
    }
}

TEST_CASE("G21, S5: a restart during a halt is found, after a lost response at once") {
    for (const bool loses_response : {false, true}) {
        CAPTURE(loses_response);
        rig r;
        REQUIRE(r.servo.run(ramps{20 * millisecond, 3000 * millisecond}));
        REQUIRE(r.servo.run(enable_in{control_mode::speed}));
        REQUIRE(r.servo.run(velocity{600 * r_per_min}));
        r.loop(200);
        REQUIRE(r.servo.begin(halt{}) == errc::ok);
        r.loop(100);
        REQUIRE_FALSE(r.servo.is_idle());
        r.model.power_cycle(); // it responds again at once
        r.wire.faults().lost_response = loses_response ? 1000 : 0;
        if (loses_response) r.loop(15);
        CHECK((r.wire.struck() != 0) == loses_response);
        r.wire.faults() = {};
        r.loop(700);
        CHECK(r.servo.state() == drive_state::needs_init);
        CHECK_FALSE(r.model.enabled());
        r.loop(5000);
        CHECK(r.servo.is_idle());
        CHECK_FALSE(r.model.enabled());
        CHECK(r.servo.begin(velocity{10 * r_per_min}) == errc::needs_init);
    }
}

TEST_CASE("a read of the whole feedback takes five frames, whatever is polled beside it, and one of the "
          "status takes one") {
    rig r;
    r.loop(500);
    const std::uint64_t begun = r.wire.time_us();
    std::uint32_t whole = 0;
    std::uint32_t light = 0;
    constexpr unsigned reads = 400;
    for (unsigned i = 0; i < reads; ++i) {
        r.loop(3 + i * 37 % 31); // at all phases of the polls
        std::uint32_t before = r.wire.requests();
        REQUIRE(r.servo.read());
        whole += r.wire.requests() - before;
        r.loop(3 + i * 17 % 31);
        before = r.wire.requests();
        REQUIRE(r.servo.read_status());
        light += r.wire.requests() - before;
    }
    // The witness is read besides, twice a second; a frame that is on its way already serves a read too.
    const auto witnesses = static_cast<std::uint32_t>((r.wire.time_us() - begun) / 500'000 + 1);
    CHECK(whole <= 5 * reads + witnesses);
    CHECK(whole > 4 * reads);
    CHECK(light <= reads + witnesses);
}

TEST_CASE("G35: a fault shows within two periods also to a program that does nothing but read the feedback") {
    rig r;
    r.station.set_response_delay(milliseconds(20)); // a read takes 125 ms
    REQUIRE(r.servo.run(enable_in{control_mode::speed}));
    for (unsigned i = 0; i < 30; ++i) {
        CAPTURE(i);
        r.loop(300);
        REQUIRE(r.servo.begin(read_feedback{}) == errc::ok);
        r.loop(i / 3);
        r.model.raise(0x610);
        const std::uint64_t raised = r.wire.time_us();
        while (r.servo.cause() != stop_cause::fault && r.wire.time_us() - raised < 200'000) {
            if (r.servo.is_idle()) (void)r.servo.begin(read_feedback{});
            r.loop(1);
        }
        CHECK(r.wire.time_us() - raised < 2 * 20'000 + 2 * 26'000 + 26'000); // with the witness
        r.loop(1000);
        REQUIRE(r.servo.run(fault_reset{}));
        REQUIRE(r.servo.run(enable_in{control_mode::speed}));
    }
}

TEST_CASE("G35: the status is polled between the blocks of a read that takes longer than two periods") {
    rig r;
    r.station.set_response_delay(milliseconds(20));
    r.loop(500);
    // The longest time without a status, over reads at all phases.
    constexpr std::uint16_t status = model::blocks.image().address;
    std::uint64_t last = 0;
    std::uint64_t longest = 0;
    std::size_t seen = r.requests.size();
    for (unsigned i = 0; i < 40; ++i) {
        r.loop(3 + i);
        REQUIRE(r.servo.begin(read_feedback{}) == errc::ok);
        while (!r.servo.is_idle()) {
            r.loop(1);
            for (; seen < r.requests.size(); ++seen) {
                if (load_word(r.requests[seen], 2) != status) continue;
                if (last != 0) longest = std::max(longest, r.wire.time_us() - last);
                last = r.wire.time_us();
            }
        }
        last = 0;
    }
    CAPTURE(longest);
    constexpr std::uint64_t frame = 26'000; // with its response: one on its way, and the witness
    CHECK(longest <= 2 * 20'000 + 2 * frame);
    CHECK(longest > 20'000);
}

TEST_CASE(
    "G36: while a command waits for a register of a slower block, that is read with each feedback, and the "
    "others in their turn") {
    for (const std::uint32_t period_ms : {20u, 50u, 100u, 0u}) {
        CAPTURE(period_ms);
        rig r{supervision{.feedback = milliseconds(period_ms), .command_timeout = no_command_timeout}};
        REQUIRE(r.servo.run(ramps{2000 * millisecond, 2000 * millisecond}));
        REQUIRE(r.servo.run(enable{}));
        REQUIRE(r.servo.run(velocity{1000 * r_per_min}));
        r.loop(3000);
        r.requests.clear();
        const std::uint64_t begun = r.wire.time_us();
        // The whole feedback takes eight periods, and the frames of the command.
        const duration oldest = milliseconds(10 * period_ms + 100);
        REQUIRE(r.servo.begin(halt{}) == errc::ok); // until it stands
        while (!r.servo.is_idle()) {
            r.loop(1);
            if (period_ms != 0) REQUIRE(r.servo.feedback(oldest));
        }
        REQUIRE(r.servo.last());
        const auto ms = static_cast<std::uint32_t>((r.wire.time_us() - begun) / 1000);
        REQUIRE(ms > 300);
        std::uint32_t speeds = 0, states = 0;
        for (const auto& f : r.requests) {
            speeds += load_word(f, 2) == 0x0B00 ? 1u : 0u;
            states += load_word(f, 2) == 0x1720 ? 1u : 0u;
        }
        const std::uint32_t expected = ms / (period_ms == 0 ? 20 : period_ms);
        CHECK(speeds + 2 >= expected * 2 / 3);
        CHECK(speeds <= expected * 5 / 4 + 2); // as a step, and in its own turn
        CHECK(states <= (period_ms == 0 ? 0 : expected + 2));
    }
}

} // namespace slower_blocks_tests
