// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The command timeout of a program that commands in time on a line that loses responses, and of one that hangs; the
// state of a drive that has a fault before `init`, and while the stop for a fault is under way.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/servobus.hpp>

#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/driven_machine.hpp>

namespace signs_of_life_tests {

using namespace servobus;
using namespace servobus::units;
namespace y = servobus::yako;
namespace z = servobus::zlac8015d;
namespace c = servobus::c630s;

namespace {

using tests::on_wire;
const velocity turning{30 * r_per_min, 30 * r_per_min};

struct wheels_bench : tests::driven_machine<sim::zlac8015d, z::drive<on_wire>> {
    explicit wheels_bench(duration timeout)
        : driven_machine{115200, sim::zlac8015d_options{}, supervision{.command_timeout = timeout}} {
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable{}));
    }
};

} // namespace

TEST_CASE("G40: a program that commands every 20 ms is not stopped by its command timeout where responses "
          "are lost") {
    // A lost response: the limit and the quarantine; the frames take less than 10 ms.
    const node<z::device> at{1};
    const std::uint32_t loss = (at.limits.response + at.gaps.quarantine).us / 1000;
    for (const std::uint32_t timeout : {loss, loss + 10, 2 * loss, 1000u}) {
        CAPTURE(timeout);
        wheels_bench b{milliseconds(timeout)};
        CHECK(b.drive.is_command_timeout_short() == (timeout == loss));
        REQUIRE(b.drive.run(turning));
        const std::uint64_t begin = b.wire.time_us();
        b.wire.faults().lost_response = 20;
        std::uint64_t next = begin;
        unsigned ends = 0;
        unsigned lost = 0;
        bool is_open = false;
        while (b.wire.time_us() < begin + 20'000'000) {
            b.step();
            if (!b.drive.is_idle()) continue;
            if (is_open) {
                is_open = false;
                REQUIRE(b.drive.last().error() != errc::preempted);
                REQUIRE(b.drive.last().error() != errc::command_timeout);
                ends += b.drive.last() ? 1u : 0u;
            }
            if (b.wire.time_us() < next) continue;
            next = b.wire.time_us() + 20'000;
            is_open = b.drive.begin(turning) == errc::ok;
            REQUIRE(is_open);
            lost = b.on.observer().timeouts;
            if (b.wire.time_us() > begin + 1'000'000) REQUIRE(b.machine.left().speed > 20'000'000);
        }
        CHECK(lost > 10); // the line was as bad as that
        CHECK(ends > 30 * 20);
    }
}

TEST_CASE("G20, G40: a program that hangs after `begin` is stopped at the latest after the timeout and one "
          "setpoint") {
    for (std::uint32_t phase = 0; phase < 20; ++phase) {
        for (const bool is_lost : {false, true}) {
            wheels_bench b{milliseconds(200)};
            REQUIRE(b.drive.run(turning));
            for (const std::uint64_t end = b.wire.time_us() + 300'000 + phase * 1700;
                 b.wire.time_us() < end;) {
                b.step();
                if (b.drive.is_idle()) REQUIRE(b.drive.begin(turning) == errc::ok);
            }
            while (!b.drive.is_idle()) b.step();
            REQUIRE(b.machine.left().speed > 10'000'000);
            REQUIRE(b.drive.begin(turning) == errc::ok);
            const std::uint64_t begun = b.wire.time_us();
            const auto zeros = [&] {
                std::uint16_t target = 1;
                REQUIRE(b.machine.read(0x2088, slice<std::uint16_t>{&target, 1}) == 0);
                return target == 0;
            };
            if (is_lost) b.wire.faults().lost_response = 1000;
            bool was_lost = false;
            std::uint64_t stopped = 0;
            while (b.wire.time_us() < begun + 3'000'000 && stopped == 0) { // the program only steps
                b.step();
                if (b.on.observer().timeouts != 0 && !was_lost) {
                    was_lost = true;
                    b.wire.faults().lost_response = 0;
                }
                if (zeros()) stopped = b.wire.time_us();
            }
            REQUIRE(stopped != 0);
            CHECK(was_lost == is_lost);
            CHECK(stopped - begun <= 200'000 + b.drive.longest_setpoint().us + 20'000);
        }
    }
}

TEST_CASE("G20, G40: a command that the timeout cuts has an error of its own") {
    wheels_bench b{milliseconds(200)};
    REQUIRE(b.drive.run(turning));
    for (const std::uint64_t end = b.wire.time_us() + 60'000; b.wire.time_us() < end;) b.step(); // it turns
    REQUIRE(b.drive.begin(wait_standstill{}) == errc::ok); // it does not come
    while (!b.drive.is_idle()) b.step();
    CHECK(b.drive.last().error() == errc::command_timeout);
    while (b.machine.left().speed != 0) b.step();
}

TEST_CASE("G20: the command timeout of a motion before a restart stops no command after it") {
    for (const std::uint32_t wait : {20u, 100u, 150u, 190u}) {
        for (std::uint32_t phase = 0; phase < 20; ++phase) {
            wheels_bench b{milliseconds(200)};
            REQUIRE(b.drive.run(turning));
            for (const std::uint64_t end = b.wire.time_us() + wait * 1000 + phase * 200;
                 b.wire.time_us() < end;)
                b.step();
            b.machine.power_cycle();
            while (b.drive.state() != z::drive_state::needs_init || !b.drive.is_idle()) b.step();
            REQUIRE(b.drive.begin(init{}) == errc::ok);
            while (!b.drive.is_idle()) b.step();
            REQUIRE(b.drive.last());
            REQUIRE(b.drive.begin(enable{}) == errc::ok);
            while (!b.drive.is_idle()) b.step();
            CHECK(b.drive.last());
            CHECK(b.machine.enabled());
        }
    }
}

TEST_CASE("G35: after `init` a drive that has a fault is faulted, before any feedback is read") {
    {
        sim::zlac8015d machine;
        sim::station station{machine};
        sim::virtual_line wire{115200};
        wire.attach(station);
        line on{wire, modbus::timing_at(115200)};
        z::drive drive{on, 1, {.command_timeout = no_command_timeout}};
        machine.raise(z::fault::overcurrent, z::fault::none);
        wire.pass(milliseconds(100));
        REQUIRE(drive.run(init{}));
        CHECK(drive.state() == z::drive_state::faulted);
        CHECK(drive.run(enable{}).error() == errc::faulted);
    }
    {
        sim::yako_closed_loop machine;
        sim::station station{machine};
        sim::virtual_line wire{115200};
        wire.attach(station);
        line on{wire, modbus::timing_at(115200)};
        y::closed_loop::drive drive{on, 1};
        machine.raise_alarm(4);
        wire.pass(milliseconds(100));
        REQUIRE(drive.run(init{}));
        CHECK(drive.state() == y::drive_state::faulted);
        CHECK(drive.run(enable{}).error() == errc::faulted);
    }
    {
        sim::c630s machine;
        sim::station station{machine};
        sim::virtual_line wire{57600};
        wire.attach(station);
        line on{wire, modbus::timing_at(57600)};
        c::drive drive{on, 1};
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(c::set_up{}));
        machine.power_cycle();
        machine.raise(0x620, true);
        wire.pass(milliseconds(100));
        REQUIRE(drive.run(init{}));
        CHECK(drive.state() == c::drive_state::faulted);
        CHECK(drive.run(c::enable_in{c::control_mode::speed}).error() == errc::faulted);
    }
}

TEST_CASE("G34, G35: while the stop for a fault is under way a wait for the move is refused for the fault") {
    wheels_bench b{milliseconds(500)};
    REQUIRE(b.drive.run(disable{}));
    REQUIRE(b.drive.run(z::enable_in{z::operating_mode::relative_position}));
    REQUIRE(b.drive.run(move_by{200'000 * pulse, 200'000 * pulse}));
    for (const std::uint64_t end = b.wire.time_us() + 300'000; b.wire.time_us() < end;) b.step();
    REQUIRE(b.drive.arrival().how == arrival_state::under_way);
    b.machine.raise(z::fault::overcurrent, z::fault::none);
    while (b.drive.is_idle()) b.step(); // until its stop begins
    CHECK(b.drive.state() == z::drive_state::faulted);
    CHECK(b.drive.begin(wait_reached{}) == errc::faulted);
    CHECK(b.drive.arrival().how == arrival_state::stopped_short);
    CHECK(b.drive.arrival().cause == stop_cause::fault);
}

TEST_CASE(
    "G21, S3: a command during whose frame the watchdog's time passes is no success, and nothing is known") {
    // The program stands still while a frame is under way; its response is there when it goes on.
    unsigned ended = 0;
    unsigned went_on = 0;
    for (std::uint32_t us = 0; us < 80'000; us += 400) {
        for (const std::uint32_t stall_ms : {925u, 930u, 936u, 940u}) {
            CAPTURE(us);
            CAPTURE(stall_ms);
            wheels_bench b{milliseconds(500)};
            REQUIRE(b.drive.run(disable{}));
            const z::cached_settings before = b.drive.cached();
            REQUIRE(before.max_speed != 0);
            REQUIRE(b.drive.begin(z::enable_in{z::operating_mode::velocity}) == errc::ok);
            for (const std::uint64_t end = b.wire.time_us() + us; b.wire.time_us() < end;) {
                (void)b.drive.step();
                b.wire.wait(microseconds(50));
            }
            if (b.drive.is_idle()) continue;
            b.wire.pass(milliseconds(stall_ms));
            while (!b.drive.is_idle()) b.step();
            const bool is_done = static_cast<bool>(b.drive.last());
            (is_done ? went_on : ended) += 1;
            if (!is_done) CHECK(b.drive.last().error() == errc::needs_init);
            CHECK((b.drive.state() == z::drive_state::enabled) == is_done);
            if (is_done) CHECK(b.drive.cached().max_speed == before.max_speed);
        }
    }
    CHECK(ended > 100);
    CHECK(went_on > 100);
}

TEST_CASE("G34: a YAKO that an input or a software limit stops says so as the cause") {
    const auto cause_of = [](auto&& disturb) {
        sim::yako_closed_loop machine;
        sim::station station{machine};
        sim::virtual_line wire{115200};
        wire.attach(station);
        line on{wire, modbus::timing_at(115200)};
        y::closed_loop::drive drive{on, 1};
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(disable{}));
        REQUIRE(drive.run(y::set_input{y::input_terminal::x3, y::input_function::stop}));
        REQUIRE(drive.run(enable{}));
        REQUIRE(drive.run(declare_position{0 * pulse}));
        return disturb(machine, drive, on, wire);
    };
    const auto moved = [](auto& drive, auto& on, auto& wire, auto&& at_half) {
        REQUIRE(drive.run(move_by{20'000 * pulse}));
        for (const std::uint64_t end = wire.time_us() + 300'000; wire.time_us() < end;)
            on.sleep(drive.step());
        at_half();
        CHECK(drive.run(wait_reached{}).error() == errc::stopped_short);
        return drive.arrival();
    };
    const auto by_input = cause_of([&](auto& machine, auto& drive, auto& on, auto& wire) {
        return moved(drive, on, wire, [&] { machine.set_input(3, true); });
    });
    CHECK(by_input.how == arrival_state::stopped_short);
    CHECK(by_input.cause == stop_cause::input);
    const auto by_limit = cause_of([&](auto&, auto& drive, auto& on, auto& wire) {
        REQUIRE(drive.run(limit_travel{-5'000 * pulse, 8'000 * pulse}));
        return moved(drive, on, wire, [] {});
    });
    CHECK(by_limit.how == arrival_state::stopped_short);
    CHECK(by_limit.cause == stop_cause::software_limit);
}

} // namespace signs_of_life_tests
