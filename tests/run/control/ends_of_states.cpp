// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An absence ends with the next response, and the repetition of a stop with the command that replaces it. A command
// that is given up has the outcome of what it had sent.
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace ends_of_states_tests {

using namespace servobus;

namespace {

void turn(simulated::driven_zlac8015d& r) {
    const duration idle = r.drive.step();
    r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
}
void loop(simulated::driven_zlac8015d& r, std::uint32_t ms) {
    const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000u;
    while (r.wire.time_us() < end) turn(r);
}

} // namespace

TEST_CASE("G28: a drive that responded to its last request is not absent, though its watchdog has passed") {
    simulated::driven_zlac8015d r;
    REQUIRE(r.drive.run(init{}));
    r.wire.faults().lost_response = 1000;
    REQUIRE_FALSE(r.drive.read());
    r.wire.faults().lost_response = 0;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.read());
    r.wire.pass(milliseconds(2000)); // the program rests
    (void)r.drive.step();
    REQUIRE(r.drive.state() == drive_state::needs_init);
    CHECK_FALSE(r.drive.is_absent());
}

TEST_CASE("G26: an init ends the repetition of a stop that was not confirmed") {
    simulated::driven_zlac8015d r{{}, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    r.wire.faults().lost_response = 1000;
    REQUIRE_FALSE(r.drive.run(disable{}));
    r.wire.faults().lost_response = 0;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    loop(r, 1000);
    CHECK(r.drive.state() == drive_state::enabled);
    CHECK(r.model.enabled());
}

TEST_CASE("G16: a command that is given up while a read of it is on the wire has sent nothing") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.begin(c630s::read_wide_position{c630s::wide_position::mechanical}) == errc::ok);
    auto& m = r.drive.machine();
    for (int i = 0; i < 100'000 && !(m.is_on_the_wire() && m.purpose() == flight::step); ++i) {
        (void)r.drive.step();
        r.wire.wait(microseconds(10));
    }
    REQUIRE(m.exchange().request()[1] == 0x03);
    m.give_up(errc::clock_stopped, r.line.now()); // as a blocking call does
    m.notify(r.line);
    CHECK(r.drive.last().error() == errc::clock_stopped);
    CHECK(r.drive.last().outcome() == outcome::not_sent);
}

TEST_CASE("G26: the quick stop of a stepper that was not confirmed is repeated as a quick stop") {
    using namespace units;
    for (const bool is_quick : {true, false}) {
        CAPTURE(is_quick);
        simulated::closed_axis a;
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(enable{}));
        REQUIRE(a.drive.run(velocity{60 * r_per_min}));
        a.drive.repeat_stops(milliseconds(300));
        a.wire.faults().lost_request = 1000;
        const command_status ended = is_quick ? a.drive.run(quick_stop{}) : a.drive.run(halt{});
        REQUIRE_FALSE(ended);
        a.wire.faults() = {};
        a.requests.clear();
        for (int i = 0; i < 100'000 && a.is_moving(); ++i) a.turn();
        CHECK_FALSE(a.is_moving());
        CHECK(a.sent(modbus::write_frame(1, 0x0027, u16{0x0200})) == (is_quick ? 1u : 0u));
        CHECK(a.sent(modbus::write_frame(1, 0x0027, u16{0x0100})) == (is_quick ? 0u : 1u));
    }
}

TEST_CASE("G26: a stop that was not confirmed is repeated as what it was") {
    using namespace units;
    for (const bool is_disable : {false, true}) {
        CAPTURE(is_disable);
        simulated::driven_zlac8015d r{{},
                                      {.feedback = milliseconds(50), .command_timeout = no_command_timeout}};
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(zlac8015d::watchdog{8000 * millisecond}));
        REQUIRE(r.drive.run(enable{}));
        REQUIRE(r.drive.run(velocity{60 * r_per_min, -90 * r_per_min}));
        r.drive.repeat_stops(milliseconds(300));
        r.wire.faults().lost_request = 1000;
        if (is_disable)
            REQUIRE_FALSE(r.drive.run(disable{}));
        else
            REQUIRE_FALSE(r.drive.run(quick_stop{}));
        REQUIRE(r.model.enabled());
        r.wire.faults() = {};
        r.log.frames.clear();
        loop(r, 1500);
        CHECK(r.sent(modbus::write_frame(1, 0x200E, u16{0x05})) == (is_disable ? 0u : 1u));
        CHECK_FALSE(r.model.enabled());
        CHECK(r.model.stands_still());
        CHECK(r.drive.cause() == stop_cause::command);
    }
}

} // namespace ends_of_states_tests
