// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Speeds and torques of a ZLAC8015D whose frames get lost: what the facade reports is compared with the
// registers of the simulated drive and with the requests on the wire.
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>

namespace setpoints_zlac8015d_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;

namespace {

constexpr node<device> prompt_node = [] {
    node<device> n{1};
    n.limits.response = milliseconds(10);
    n.gaps.quarantine = milliseconds(10);
    return n;
}();
constexpr supervision supervised{.feedback = milliseconds(20), .command_timeout = milliseconds(300)};

/// A program that steps its drive in a loop and commands speeds.
struct program {
    using line_type = line<sim::virtual_line>;
    sim::zlac8015d model;
    sim::station<sim::zlac8015d> station{model};
    sim::virtual_line wire;
    line_type on{wire, modbus::timing_at(115200)};
    zlac8015d::drive<line_type> wheels{on, prompt_node, supervised};
    simulated::request_log log;

    explicit program(std::uint64_t seed = 1) : wire{115200, seed} {
        wire.attach(station);
        wire.set_hook(&simulated::request_log::note, &log);
        REQUIRE(wheels.run(init{}));
        REQUIRE(wheels.run(enable_in{operating_mode::velocity}));
    }
    program(const program&) = delete;

    void turn() {
        const duration idle = wheels.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void step_for(std::uint64_t us) {
        const std::uint64_t end = wire.time_us() + us;
        while (wire.time_us() < end) turn();
    }
    void step_to_end() {
        while (!wheels.is_idle()) turn();
    }
    bool is_write_to(std::uint16_t address, bytes f) const {
        return f.size() >= 4 && modbus::is_write(f[1]) && load_word(f, 2) == address;
    }
    /// Writes to a register on the wire since the log was cleared.
    std::size_t writes_to(std::uint16_t address) const {
        std::size_t n = 0;
        for (const simulated::frame& f : log.frames) n += is_write_to(address, f) ? 1u : 0u;
        return n;
    }
    std::size_t speed_writes() const { return writes_to(left_target_speed.address); }
    enum class loss { request, response };
    /// Steps until a write to this register has lost its request or its response.
    void lose(loss what, std::uint16_t address) {
        log.frames.clear();
        while (writes_to(address) == 0) {
            if (what == loss::request && is_write_to(address, log.open)) wire.set_connected(0, false);
            turn();
        }
        if (what == loss::response) wire.faults().lost_response = 1000;
        step_for(1'500);
        CHECK((wire.struck() != 0) == (what == loss::response));
        wire.faults() = {};
        wire.set_connected(0, true);
    }
    std::uint16_t commanded() { return model.peek(left_target_speed.address); }
};

} // namespace

TEST_CASE("G21: with 8 % of the transactions lost, 40 of 50 speeds a second are carried out and nothing is "
          "enabled again") {
    for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
        CAPTURE(seed);
        program p{seed};
        p.wire.faults().lost_request = 40;
        p.wire.faults().lost_response = 40;
        constexpr unsigned seconds = 20;
        unsigned carried_out = 0;
        std::int32_t speed = 0;
        for (unsigned i = 0; i < 50 * seconds; ++i) {
            const std::uint64_t next = p.wire.time_us() + 20'000;
            speed = speed % 150 + 1;
            bool began = false;
            while (p.wire.time_us() < next) {
                if (!began)
                    began = p.wheels.begin(velocity{speed * r_per_min, speed * r_per_min}) == errc::ok;
                p.turn();
            }
            carried_out += began && p.commanded() == speed ? 1u : 0u;
        }
        REQUIRE(p.wire.struck() > 40);
        CHECK(carried_out >= 40 * seconds);
        CHECK(p.model.enables() == 1);
        CHECK(p.wheels.state() == drive_state::enabled);
    }
}

TEST_CASE(
    "G16, G21: a speed whose request or response is lost is read back and reported as it is in the drive") {
    for (const program::loss what : {program::loss::request, program::loss::response}) {
        const bool is_response = what == program::loss::response;
        CAPTURE(is_response);
        program p;
        REQUIRE(p.wheels.run(velocity{20 * r_per_min, 20 * r_per_min}));
        REQUIRE(p.wheels.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::ok);
        p.lose(what, left_target_speed.address);
        p.step_to_end();
        CHECK(p.wheels.last().error() == (is_response ? errc::ok : errc::not_executed));
        CHECK(p.commanded() == (is_response ? 30 : 20));
        CHECK(p.speed_writes() == 1); // it is not sent again
        CHECK(p.wheels.state() == drive_state::enabled);
        CHECK(p.wheels.run(velocity{40 * r_per_min, 40 * r_per_min}));
    }
}

TEST_CASE("G21: a setpoint that got no response is unknown if the drive restarts before it was verified") {
    for (std::uint64_t us = 0; us < 30'000; us += 250) {
        CAPTURE(us);
        program p;
        REQUIRE(p.wheels.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::ok);
        p.lose(program::loss::response, left_target_speed.address);
        p.step_for(us);
        if (p.wheels.is_idle()) break;
        const bool was_verified = same_bytes(p.log.frames.back(), modbus::read_frame(1, 0x200D, 1));
        p.model.power_cycle();
        p.step_to_end();
        if (!was_verified) CHECK_FALSE(p.wheels.last());
        p.step_for(600'000);
        CHECK(p.wheels.state() == drive_state::needs_init);
        CHECK(p.model.stands_still());
    }
}

TEST_CASE("G25: a stop pre-empts the verification of a setpoint, and is confirmed by itself") {
    for (std::uint64_t us = 0; us < 25'000; us += 250) {
        CAPTURE(us);
        program p;
        REQUIRE(p.wheels.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::ok);
        p.lose(program::loss::response, left_target_speed.address);
        p.step_for(us);
        p.log.frames.clear();
        REQUIRE(p.wheels.begin(halt{}) == errc::ok);
        p.step_to_end();
        CHECK(p.wheels.last());
        CHECK(p.commanded() == 0);
        CHECK(p.model.stands_still());
        REQUIRE(p.log.frames.size() >= 2); // at most the frame in flight comes before it
        const auto is_halt = [&](std::size_t i) {
            return same_bytes(p.log.frames[i], simulated::zero_targets);
        };
        CHECK((is_halt(0) || is_halt(1)));
    }
}

TEST_CASE("G21: ramps that got no response are read back while the drive is disabled too") {
    for (const program::loss what : {program::loss::request, program::loss::response}) {
        const bool is_response = what == program::loss::response;
        CAPTURE(is_response);
        program p;
        REQUIRE(p.wheels.run(disable{}));
        REQUIRE(p.wheels.begin(quick_stop_ramp{77 * millisecond}) == errc::ok);
        p.lose(what, left_quick_stop_time.address);
        p.step_to_end();
        CHECK(static_cast<bool>(p.wheels.last()) == is_response);
        CHECK((p.model.peek(left_quick_stop_time.address) == 77) == is_response);
    }
}

} // namespace setpoints_zlac8015d_tests
