// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The EEPROM writes of a C630S as from the factory, which keeps each write, by what tries again in an hour without a
// response, whatever part of the requests arrives. Judged by the simulated drive's count and by the frames.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/control/setpoint_loop.hpp>

#include <tests/support/driven_c630s.hpp>

namespace wear_c630s_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

struct rig : simulated::simulated_c630s {
    c630s::drive<line_type> servo{line, 1, {.command_timeout = milliseconds(300)}};
    using frame = std::vector<std::uint8_t>;

    explicit rig(std::uint64_t seed = 1) : simulated_model{{}, seed} {}
    static bool is_write(const frame& f) { return modbus::is_write(f[1]); }
    static bool spares(const frame& f) {
        return same_bytes(f, modbus::write_frame(1, c630s::eeprom_update.address, u16{0}));
    }
};
template <class Loop> void play(rig& r, Loop& loop, std::uint32_t seconds) {
    const std::uint64_t end = r.wire.time_us() + std::uint64_t{seconds} * 1'000'000u;
    while (r.wire.time_us() < end) {
        const duration idle = loop.step();
        (void)loop.take_report();
        r.wire.wait(idle.us == 0 ? microseconds(50) : idle);
    }
}

} // namespace

TEST_CASE("G17: a loop without a response wears the EEPROM by at most 20 writes an hour, whatever arrives") {
    std::uint64_t most = 0;
    for (const std::uint16_t arrive :
         {std::uint16_t{0}, std::uint16_t{100}, std::uint16_t{500}, std::uint16_t{1000}}) {
        for (std::uint64_t seed = 1; seed <= 5; ++seed) {
            CAPTURE(arrive);
            CAPTURE(seed);
            rig r{seed};
            setpoint_loop loop{r.servo, take_over{}, c630s::enable_in{c630s::control_mode::speed},
                               setpoints<c630s::motor_velocity>{}};
            r.wire.faults().lost_response = 1000;
            r.wire.faults().lost_request = static_cast<std::uint16_t>(1000 - arrive);
            const auto before = r.model.eeprom_writes();
            play(r, loop, 3600);
            const auto worn = r.model.eeprom_writes() - before;
            CHECK(worn <= 20);
            most = worn > most ? worn : most;
            CHECK(r.wire.requests() > 1000); // it tries on
            r.wire.faults() = {};
            play(r, loop, 15); // and finds the drive once that responds
            CHECK(r.servo.state() != drive_state::needs_init);
        }
    }
    MESSAGE("EEPROM writes in an hour, at most: ", most);
    CHECK(most > 3); // the first stops are kept
}

TEST_CASE("G17: from the second attempt on P0C-13 = 0 goes before the stops, and the attempts back off to "
          "one in 10 s") {
    rig r;
    setpoint_loop loop{r.servo, take_over{}};
    r.wire.faults().lost_response = 1000;
    std::vector<std::uint64_t> begins; // of attempts, in ms
    std::vector<std::size_t> attempts; // their first requests
    std::size_t seen = 0;
    std::uint64_t last = 0;
    for (std::uint32_t ms = 0; ms < 120'000; ++ms) {
        for (std::uint64_t end = r.wire.time_us() + 1000; r.wire.time_us() < end;) {
            (void)loop.step();
            r.wire.pass(microseconds(100));
        }
        (void)loop.take_report();
        for (; seen < r.requests.size(); ++seen) {
            if (begins.empty() || ms - last > 900) { // a pause: an attempt begins
                begins.push_back(ms);
                REQUIRE(rig::is_write(r.requests[seen]));
                attempts.push_back(seen);
            }
            last = ms;
        }
    }
    for (std::size_t i = 0; i < attempts.size(); ++i) {
        const auto& second = r.requests.at(attempts[i] + 1);
        CHECK(rig::spares(second) == (i != 0));
    }
    REQUIRE(begins.size() > 10);
    CHECK(begins.size() < 20);
    CHECK(begins[1] - begins[0] < 15'000); // the first attempts follow each other without a pause
    for (std::size_t i = 6; i < begins.size(); ++i) {
        CHECK(begins[i] - begins[i - 1] >= 9'700);
        CHECK(begins[i] - begins[i - 1] <= 10'100);
    }
}

TEST_CASE(
    "G25: a stop that the program asks for is the next frame, also between attempts without a response") {
    rig r;
    setpoint_loop loop{r.servo, take_over{}};
    r.wire.faults().lost_response = 1000;
    play(r, loop, 60);
    for (unsigned i = 0; !r.servo.is_idle(); ++i) {
        REQUIRE(i < 100'000);
        (void)loop.step();
        r.wire.pass(microseconds(100));
    }
    const std::size_t before = r.requests.size();
    REQUIRE(loop.disable() == errc::ok);
    for (unsigned i = 0; r.requests.size() == before; ++i) {
        REQUIRE(i < 100); // 10 ms
        (void)loop.step();
        r.wire.pass(microseconds(100));
    }
    CHECK(
        same_bytes(r.requests[before], modbus::write_frame(1, c630s::virtual_input_levels.address, u16{0})));
}

} // namespace wear_c630s_tests
