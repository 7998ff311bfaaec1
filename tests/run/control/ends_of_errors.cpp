// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Kinds of errors decide whether a drive must be initialised again, and whether it is taken over less often. Each kind
// is tried with its first and its last error, and with their neighbours.
#include <cstdint>
#include <functional>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/control/setpoint_loop.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <tests/support/bare_rig.hpp>
#include <tests/support/loop_bound.hpp>

namespace ends_of_errors_tests {

using namespace servobus;
using tests::byte_list;
using tests::scripted_port;
using tests::sent_frame;

namespace {

using device_of_port = std::function<void(scripted_port&, const sent_frame&)>;

/// A response of which the third byte comes 1.2 ms late: t1.5 is 0.75 ms.
void respond_with_a_gap(scripted_port& p, const sent_frame& f) {
    const byte_list whole = f.data[1] == 0x03
                                ? tests::read_response(f.data[0], std::vector<std::uint16_t>(f.data[5]))
                                : tests::acknowledgement(f.data);
    p.say(500, byte_list(whole.begin(), whole.begin() + 2));
    p.say_at(p.last_arrival() + 1200, byte_list(whole.begin() + 2, whole.end()));
}
device_of_port responding_with_exception(std::uint8_t number) {
    return [number](scripted_port& p, const sent_frame& f) {
        p.say(500, tests::framed({f.data[0], static_cast<std::uint8_t>(f.data[1] | 0x80), number}));
    };
}
void be_mute(scripted_port&, const sent_frame&) {}

constexpr modbus::rtu_timing strictly() {
    modbus::rtu_timing t = modbus::timing_at(115200);
    t.mode = modbus::timing_mode::strict;
    return t;
}

/// A line to a drive of which `begin` reads one register.
template <class Echo> struct bare_rig {
    tests::waiting_scripted_port port;
    tests::register_file file;
    using line_type = line<tests::waiting_scripted_port, counters, Echo>;
    line_type on;
    bare::drive<line_type> drive{on, node<bare_rigs::device>{1}};

    explicit bare_rig(const modbus::rtu_timing& timing) : on{port, timing} {
        port.echoes = port.keeps_echo = has_local_echo<Echo>;
        file.words[0x0110] = 0x55;
        port.device = [this](scripted_port& p, const sent_frame& f) { file(p, f); };
        REQUIRE(drive.run(bare_rigs::taking_over));
    }
};

} // namespace

TEST_CASE(
    "G21: a read that fails for the line or without a valid response leaves the drive unknown, one that "
    "the drive refuses does not") {
    const auto expect = [](auto& r, errc why, bool is_known) {
        CHECK(r.drive.run(bare_rigs::look).error() == why);
        CHECK((r.drive.state() == drive_state::needs_init) == !is_known);
    };
    const auto relaxed = modbus::timing_at(115200);
    { // the first one: nothing was sent
        bare_rig<unechoed> r{relaxed};
        for (std::uint64_t at = 0; at < 3'000'000; at += 1000) r.port.arrive(r.port.time + at, 0x55);
        expect(r, errc::line_busy, false);
    }
    {
        bare_rig<unechoed> r{relaxed};
        r.port.takes_nothing_until = ~std::uint64_t{0};
        expect(r, errc::send_failed, false);
    }
    {
        bare_rig<echoed> r{relaxed};
        r.port.echoes = r.port.keeps_echo = false;
        expect(r, errc::no_echo, false);
    }
    {
        bare_rig<unechoed> r{relaxed};
        r.port.device = be_mute;
        expect(r, errc::timeout, false);
    }
    { // the last one
        bare_rig<unechoed> r{strictly()};
        r.port.device = respond_with_a_gap;
        expect(r, errc::bad_gap, false);
    }
    {
        bare_rig<unechoed> r{relaxed};
        r.port.device = responding_with_exception(2);
        expect(r, errc::exception, true);
    }
    // An error that the registers of the drive show leaves its settings known.
    for (const errc why :
         {errc::busy, errc::faulted, errc::wrong_state, errc::unexpected_value, errc::not_reached}) {
        bare_rig<unechoed> r{relaxed};
        step other[] = {steps::expect_bits<bare_rigs::state>(0xFFFF, 0x56, errc::busy)};
        other[0].otherwise = why;
        CHECK(r.drive.run(bare::command{.steps = other}).error() == why);
        CHECK(r.drive.state() == drive_state::enabled);
    }
    { // a command that the drive's state does not allow
        bare_rig<unechoed> r{relaxed};
        CHECK(r.drive.run(bare::command{.steps = bare_rigs::look_steps, .refusal = errc::not_in_plan})
                  .error() == errc::not_in_plan);
        CHECK(r.drive.state() == drive_state::enabled);
    }
}

TEST_CASE("a take-over is tried later and later only where the line works and the drive does not respond") {
    // How often it is tried in 6.8 s: at 0, 2 and 6 s, or each second.
    const auto attempts = [](auto& on, auto& port) {
        zlac8015d::drive wheels{on, 1, unsupervised};
        setpoint_loop loop{wheels, take_over{}};
        unsigned begun = 0;
        const std::uint64_t end = port.time + 6'800'000;
        while (port.time < end) {
            const bool was_idle = wheels.is_idle();
            const duration idle = loop.step();
            if (was_idle && !wheels.is_idle()) ++begun;
            port.wait(idle.us == 0 ? microseconds(20) : idle);
        }
        return begun;
    };
    const auto plain = [&](const modbus::rtu_timing& timing, const device_of_port& device,
                           bool is_lost = false) {
        tests::waiting_scripted_port port;
        port.device = device;
        port.lost_from_call = is_lost ? 1 : 0;
        line on{port, timing};
        return attempts(on, port);
    };
    const auto relaxed = modbus::timing_at(115200);
    tests::waiting_scripted_port without_echo;
    line<tests::waiting_scripted_port, counters, echoed> echoing{without_echo, relaxed};
    CHECK(attempts(echoing, without_echo) == 3); // no_echo
    CHECK(plain(relaxed, be_mute) == 3);         // timeout
    CHECK(plain(strictly(), respond_with_a_gap) == 3);
    CHECK(plain(relaxed, be_mute, true) > 5); // port_lost
    CHECK(plain(relaxed, responding_with_exception(4)) > 5);
    CHECK(plain(relaxed, responding_with_exception(5)) > 4); // acknowledged
}

} // namespace ends_of_errors_tests
