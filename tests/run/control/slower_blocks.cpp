// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A facade whose feedback has blocks that are read less often, the C630S's: how old they may be, what the loss of one
// costs, and what a restart during a halt means.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/driven_c630s.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

namespace {

constexpr supervision often{.feedback = milliseconds(20), .command_timeout = no_command_timeout};

struct rig : simulated::c630s_rig {
    c630s::drive<line_type> servo;

    explicit rig(const optional_supervision& by = often) : servo{line, 1, by} {
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
    bool is_slower(const std::vector<std::uint8_t>& request) const {
        return request[1] == 0x03 && load_word(request, 2) != virtual_output_levels.address;
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

TEST_CASE("G36: a block of the feedback that gets no response is read when it is its turn again, and the "
          "state stays") {
    rig r;
    r.loop(500);
    std::size_t seen = r.requests.size();
    unsigned lost = 0;
    r.loop(2000, [&] {
        const bool is_next = r.requests.size() > seen;
        if (is_next) seen = r.requests.size();
        const bool is_due = !r.requests.empty() && r.is_slower(r.requests.back()) && lost < 3;
        if (is_next && is_due) ++lost;
        r.wire.faults().lost_response = is_due ? 1000 : 0;
    });
    CHECK(lost == 3);
    CHECK(r.servo.state() == drive_state::disabled);
    CHECK(r.servo.feedback(milliseconds(400)));
}

TEST_CASE("G36: blocks of the feedback that get no response make it old, however often the status is read") {
    rig r;
    r.loop(500);
    r.loop(2000, [&] {
        const bool is_next = !r.requests.empty() && r.is_slower(r.requests.back());
        r.wire.faults().lost_response = is_next ? 1000 : 0;
    });
    CHECK(r.servo.feedback(milliseconds(1000)).error() == errc::timeout);
    CHECK(r.servo.feedback(milliseconds(3000)));
    CHECK(r.servo.state() == drive_state::disabled);
}

TEST_CASE("G21, S5: a restart during a halt is found before the motor could have come to rest by its ramp") {
    rig r;
    REQUIRE(r.servo.run(ramps{20 * millisecond, 3000 * millisecond}));
    REQUIRE(r.servo.run(enable{control_mode::speed}));
    REQUIRE(r.servo.run(velocity{600 * r_per_min}));
    r.loop(200);
    REQUIRE(r.servo.begin(halt{}) == errc::ok);
    r.loop(100);
    REQUIRE_FALSE(r.servo.is_idle());
    r.model.power_cycle(); // it responds again at once
    r.loop(700);
    CHECK(r.servo.state() == drive_state::needs_init);
    CHECK_FALSE(r.model.enabled());
    r.loop(5000);
    CHECK(r.servo.is_idle());
    CHECK_FALSE(r.model.enabled());
    CHECK(r.servo.begin(velocity{10 * r_per_min}) == errc::needs_init);
}
