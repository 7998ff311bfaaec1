// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D facade with interrupted commands, responses that come too late, a drive whose state has
// changed, and an application that stops commanding but still uses the facade.
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>

namespace drive_zlac8015d_faults_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using rig = simulated::driven_zlac8015d;

namespace {

constexpr auto zero_targets = modbus::write_frame(1, 0x2088, std::array<std::uint16_t, 2>{0, 0});

void be_enabled_in(rig& r, operating_mode mode) {
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(ramps{100 * millisecond, 100 * millisecond}));
    REQUIRE(r.drive.run(enable_in{checked(mode)}));
    REQUIRE(r.model.enabled());
}

void turn(rig& r) {
    const duration idle = r.drive.step();
    r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
}
void loop(rig& r, std::uint32_t ms) {
    const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000u;
    while (r.wire.time_us() < end) turn(r);
}

} // namespace

TEST_CASE("S3: an enabled drive is read four times within its watchdog time, so that one lost response does "
          "no harm") {
    rig r{{}, {.feedback = milliseconds(10'000), .command_timeout = no_command_timeout}};
    be_enabled_in(r, operating_mode::velocity);
    loop(r, 1'000);
    const std::size_t before = r.log.frames.size();
    loop(r, 10'000);
    CHECK(r.log.frames.size() - before >= 38);
    CHECK(r.log.frames.size() - before <= 64); // also the witness, twice a second
}

TEST_CASE("G35: a drive that had a fault before a setting was changed refuses what moves it for that fault") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    r.model.raise(fault::overcurrent, fault::none);
    REQUIRE(r.drive.run(read_feedback{}));
    while (!r.drive.is_idle()) turn(r);
    CHECK(r.drive.run(enable{}).error() == errc::faulted);
    REQUIRE(r.drive.run(watchdog{2'000 * millisecond}));
    CHECK(r.drive.run(velocity{10 * r_per_min, 10 * r_per_min}).error() == errc::faulted);
}

TEST_CASE("G20: after an init nothing is left for the command timeout to stop") {
    rig r{{}, {.command_timeout = milliseconds(400)}};
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    REQUIRE(r.drive.run(init{}));
    const std::size_t before = r.log.frames.size();
    loop(r, 1'000);
    for (std::size_t i = before; i < r.log.frames.size(); ++i)
        CHECK_FALSE(modbus::is_write(r.log.frames[i][1]));
}

TEST_CASE("G20: once a restart is found the command timeout sends nothing more") {
    rig r{{}, {.command_timeout = milliseconds(2'000)}};
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    r.model.power_cycle();
    loop(r, 1'000);
    REQUIRE(r.drive.state() == drive_state::needs_init);
    REQUIRE(r.drive.is_idle());
    const std::size_t before = r.log.frames.size();
    loop(r, 5'000);
    for (std::size_t i = before; i < r.log.frames.size(); ++i)
        CHECK_FALSE(modbus::is_write(r.log.frames[i][1]));
}

TEST_CASE("G20: the command timeout also stops the drive while the application only reads or steps") {
    rig r{{}, {.command_timeout = milliseconds(400)}};
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    SUBCASE("the application reads feedback all the time") {
        const std::uint64_t end = r.wire.time_us() + 2'000'000;
        while (r.wire.time_us() < end) {
            turn(r);
            if (r.drive.is_idle()) (void)r.drive.begin(read_feedback{});
        }
    }
    SUBCASE("the application waits for a standstill that does not come, without a blocking call") {
        REQUIRE(r.drive.begin(wait_standstill{}) == errc::ok);
        while (!r.drive.is_idle()) turn(r);
        CHECK(r.drive.last().error() == errc::command_timeout);
    }
    SUBCASE("no command is refused because of the facade's own reads") {
        unsigned refused = 0;
        for (int i = 0; i < 300; ++i) {
            loop(r, 1);
            if (r.drive.is_idle() && r.drive.begin(left_velocity{100 * r_per_min}) != errc::ok) ++refused;
        }
        CHECK(refused == 0);
        loop(r, 2000);
    }
    CHECK(r.model.stands_still());
    CHECK(r.sent(zero_targets) >= 2);
}

TEST_CASE("G20: a move, which ends by itself, is not cut by the command timeout") {
    rig r{{}, {.command_timeout = milliseconds(400)}};
    be_enabled_in(r, operating_mode::relative_position);
    REQUIRE(r.drive.run(move_by{20'000 * pulse, 20'000 * pulse}));
    loop(r, 200);
    CHECK_FALSE(r.model.stands_still());
    loop(r, 6000);
    CHECK(r.model.stands_still());
    CHECK(r.model.left().position == 20'000);
    CHECK(r.drive.state() == drive_state::enabled);
}

TEST_CASE("G20: a blocking wait is a sign of life of the application") {
    rig r{{}, {.command_timeout = milliseconds(400)}};
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    CHECK(r.drive.run(wait_standstill{}).error() == errc::not_reached);
    CHECK_FALSE(r.model.stands_still());
    loop(r, 1000);
    CHECK(r.model.stands_still());
}

TEST_CASE("G1, G2: a stop waits for no quarantine, but what follows it does") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    client direct{r.line, node<device>{1}};
    direct.node().read_retries = 0;
    r.wire.faults().late_response = 1000;
    r.wire.faults().late_by = milliseconds(112); // after the time-out, within the quarantine
    CHECK(direct.read<host_timeout>().error() == errc::timeout);
    CHECK(r.wire.struck() != 0);
    r.wire.faults() = {};
    REQUIRE(r.drive.run(disable{}));
    const auto volts = direct.read<bus_voltage>();
    REQUIRE(volts);
    CHECK(*volts == 24 * volt);
}

TEST_CASE("G26: the late response to the preceding speed does not confirm a halt") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    r.wire.faults().late_response = 1000;
    r.wire.faults().late_by = milliseconds(106);
    const command_status late = r.drive.run(velocity{100 * r_per_min, 100 * r_per_min});
    CHECK(late.outcome() == outcome::unknown);
    CHECK(r.wire.struck() != 0);
    r.wire.faults() = {};
    const command_status stopped = r.drive.run(halt{});
    REQUIRE(stopped);
    CHECK(r.model.stands_still());
    CHECK(r.model.peek(0x2088) == 0);
}

TEST_CASE("a halt without a preceding init stops the drive in every mode") {
    for (const operating_mode mode : {operating_mode::velocity, operating_mode::torque,
                                      operating_mode::relative_position, operating_mode::absolute_position}) {
        rig r;
        be_enabled_in(r, mode);
        REQUIRE(r.drive.run(torque_slope{30'000 * milliampere_per_second}));
        if (mode == operating_mode::velocity) REQUIRE(r.drive.run(velocity{90 * r_per_min, 90 * r_per_min}));
        if (mode == operating_mode::torque) REQUIRE(r.drive.run(torque{3 * ampere, 3 * ampere}));
        if (mode == operating_mode::relative_position)
            REQUIRE(r.drive.run(move_by{90'000 * pulse, 90'000 * pulse}));
        if (mode == operating_mode::absolute_position)
            REQUIRE(r.drive.run(move_to{90'000 * pulse, 90'000 * pulse}));
        r.wire.pass(milliseconds(300));
        REQUIRE_FALSE(r.model.stands_still());
        zlac8015d::drive<rig::line_type> successor{r.line, 1, unsupervised}; // not initialised
        const std::uint64_t start = r.wire.time_us();
        REQUIRE(successor.run(halt{}));
        CHECK(r.model.stands_still());
        CHECK(r.wire.time_us() - start < 2'000'000);
        CHECK(successor.state() == drive_state::needs_init);
    }
}

TEST_CASE("G2: during an exchange the line refuses another one with busy") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    client direct{r.line, node<device>{1}};
    unsigned busy = 0;
    unsigned right = 0;
    for (std::uint32_t offset = 0; offset < 200; ++offset) {
        REQUIRE(r.drive.begin(wait_standstill{}) == errc::ok);
        const std::uint64_t until = r.wire.time_us() + offset * 20;
        while (r.wire.time_us() < until && !r.drive.is_idle()) {
            (void)r.drive.step();
            r.wire.pass(microseconds(10));
        }
        const auto volts = direct.read<bus_voltage>();
        if (volts) {
            CHECK(*volts == 24 * volt);
            ++right;
        } else {
            CHECK(volts.error() == errc::busy);
            ++busy;
        }
        while (!r.drive.is_idle()) turn(r);
    }
    CHECK(busy > 0);
    CHECK(right > 0);
}

TEST_CASE("G2: the response to an exchange whose facade was destroyed is not delivered to another client") {
    rig r;
    {
        zlac8015d::drive<rig::line_type> passer_by{r.line, 1, unsupervised};
        REQUIRE(passer_by.begin(init{}) == errc::ok);
        for (int i = 0; i < 400 && r.wire.requests() == 0; ++i) {
            const duration idle = passer_by.step();
            r.wire.wait(idle);
        }
        REQUIRE(r.wire.requests() == 1);
    }
    client direct{r.line, node<device>{1}};
    unsigned refusals = 0;
    for (int i = 0; i < 2000; ++i) {
        const auto volts = direct.read<bus_voltage>();
        if (volts) {
            CHECK(*volts == 24 * volt);
            break;
        }
        CHECK(volts.error() == errc::busy);
        ++refusals;
        r.wire.pass(milliseconds(1));
    }
    CHECK(refusals > 0);
    CHECK(refusals < 2000);
}

TEST_CASE("G21: after a stop has pre-empted a command the cached state is correct or invalid") {
    SUBCASE("enable, pre-empted by halt: once anything was written the drive may be energised, so save is "
            "refused") {
        for (std::uint32_t frames = 0; frames < 16; ++frames) {
            rig r;
            REQUIRE(r.drive.run(init{}));
            REQUIRE(r.drive.begin(enable{}) == errc::ok);
            const std::uint32_t before = r.wire.requests();
            while (!r.drive.is_idle() && r.wire.requests() < before + frames) turn(r);
            if (r.drive.is_idle()) break;
            REQUIRE(r.drive.begin(halt{}) == errc::ok);
            while (!r.drive.is_idle()) turn(r);
            const bool has_written = frames > 1; // the first frame reads
            CHECK((r.drive.state() == drive_state::needs_init) == has_written);
            CHECK_FALSE(r.model.enabled());
            CHECK((r.drive.run(save{}).error() == errc::needs_init) == has_written);
        }
    }
    SUBCASE("a watchdog setting, pre-empted by halt") {
        rig r;
        be_enabled_in(r, operating_mode::velocity);
        REQUIRE(r.drive.begin(watchdog{300 * millisecond}) == errc::ok);
        const std::uint32_t before = r.wire.requests();
        while (r.wire.requests() == before) turn(r);
        REQUIRE(r.drive.begin(halt{}) == errc::ok);
        while (!r.drive.is_idle()) turn(r);
        CHECK(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}).error() == errc::needs_init);
    }
    SUBCASE("a stop of lower priority does not replace one of higher priority") {
        rig r;
        be_enabled_in(r, operating_mode::velocity);
        REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        REQUIRE(r.drive.begin(disable{}) == errc::ok);
        CHECK(r.drive.begin(halt{}) == errc::busy);
        while (!r.drive.is_idle()) turn(r);
        CHECK_FALSE(r.model.enabled());
        CHECK(r.drive.state() == drive_state::disabled);
    }
}

TEST_CASE("S3: the pause is counted from the last request that the drive received to the moment of sending") {
    node<zlac8015d::device> slow{1};
    slow.limits.response = milliseconds(100);
    for (std::uint32_t ms = 850; ms < 1010; ms += 5) {
        rig r{{}, unsupervised, 1, slow};
        r.station.set_response_delay(milliseconds(80));
        be_enabled_in(r, operating_mode::velocity);
        REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        r.wire.pass(milliseconds(500));
        REQUIRE(r.drive.read());
        r.wire.pass(milliseconds(ms));
        const bool was_stopped = r.model.in_watchdog_stop();
        const std::size_t before = r.log.frames.size();
        const command_status after = r.drive.run(velocity{100 * r_per_min, 100 * r_per_min});
        if (was_stopped) CHECK(after.error() == errc::needs_init);
        if (was_stopped) CHECK(r.log.frames.size() == before); // any frame would end the drive's stop
    }
}

TEST_CASE("S3: the pause after which the state is unknown is that of the watchdog time which was set last") {
    for (const std::int32_t ms : {300, 1'000, 3'000}) {
        CAPTURE(ms);
        for (const std::int32_t waited : {ms * 3 / 4, ms + 100}) {
            rig r;
            REQUIRE(r.drive.run(init{}));
            REQUIRE(r.drive.run(watchdog{ms * millisecond}));
            r.wire.pass(milliseconds(static_cast<std::uint32_t>(waited)));
            (void)r.drive.step();
            CHECK((r.drive.state() == drive_state::needs_init) == (waited > ms));
        }
    }
}

TEST_CASE("S3: with a short watchdog time, a read that is lost and repeated is not the first frame after the "
          "watchdog stop") {
    for (std::uint32_t ms = 0; ms < 300; ms += 10) {
        rig r;
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(watchdog{300 * millisecond}));
        REQUIRE(r.drive.run(enable{}));
        REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        r.wire.pass(milliseconds(ms));
        r.wire.cut_for(milliseconds(150));
        (void)r.drive.read();
        r.wire.pass(milliseconds(1500));
        CHECK(r.model.stands_still());
        CHECK(r.drive.run(velocity{10 * r_per_min, 10 * r_per_min}).error() == errc::needs_init);
        r.wire.pass(milliseconds(200));
        CHECK(r.model.stands_still());
    }
}

TEST_CASE("S2: an old torque target has no effect when the mode of an enabled drive changes") {
    rig r;
    be_enabled_in(r, operating_mode::torque);
    REQUIRE(r.drive.run(torque_slope{30'000 * milliampere_per_second}));
    REQUIRE(r.drive.run(brakes{brake::code_1, brake::code_1}));
    REQUIRE(r.drive.run(torque{8 * ampere, 8 * ampere}));
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    REQUIRE(r.drive.run(brakes{brake::code_0, brake::code_0}));
    const std::int64_t left = r.model.left().position;
    REQUIRE(r.drive.run(enable_in{operating_mode::torque}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.left().position - left < 3);
    CHECK(r.model.left().position - left > -3);
}

TEST_CASE("a fault reset leaves the drive disabled, whatever it was before") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
}

TEST_CASE("G16: a write that is on the wire when the clock stops is unknown, not unsent") {
    struct stopping_clock {
        bool is_stopped = false;
        std::uint32_t sends = 0;
        instant at{};
        transfer send(bytes b) {
            ++sends;
            is_stopped = true;
            return static_cast<std::uint16_t>(b.size());
        }
        bool sent() { return true; }
        transfer receive(byte_buffer) { return std::uint16_t{0}; }
        instant now() {
            if (!is_stopped) at = at + microseconds(50);
            return at;
        }
    } port;
    servobus::line on{port, modbus::timing_at(115200)};
    zlac8015d::drive drive{on, 1, unsupervised};
    const command_status r = drive.run(disable{});
    CHECK(port.sends == 1);
    CHECK(r.error() == errc::clock_stopped);
    CHECK(r.outcome() == outcome::unknown);
}

TEST_CASE("G29: a command that ends because the clock has stopped does not sleep again") {
    struct stopped_clock {
        bool slept_last = false;
        transfer send(bytes b) { return static_cast<std::uint16_t>(b.size()); }
        bool sent() { return true; }
        transfer receive(byte_buffer) { return std::uint16_t{0}; }
        instant now() {
            slept_last = false;
            return {};
        }
        void wait(duration) { slept_last = true; } // a short sleep with a stopped clock
    } port;
    servobus::line on{port, modbus::timing_at(115200)};
    zlac8015d::drive drive{on, 1, unsupervised};
    CHECK(drive.run(disable{}).error() == errc::clock_stopped);
    CHECK_FALSE(port.slept_last);
}

TEST_CASE("G21: a restart is detected although the shafts are locked at power-on") {
    rig r;
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.write<shaft_at_power_on>(power_on_shaft::locked));
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(save{}));
    SUBCASE("by feedback, within half a second") {
        REQUIRE(r.drive.run(enable{}));
        r.model.power_cycle();
        for (int i = 0; i < 12 && r.drive.read(); ++i) r.wire.pass(milliseconds(50));
        CHECK(r.drive.state() == drive_state::needs_init);
    }
    SUBCASE("by a move, immediately") {
        REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
        r.model.power_cycle();
        CHECK(r.drive.run(move_by{100 * pulse, 100 * pulse}).error() == errc::needs_init);
        CHECK(r.drive.state() == drive_state::needs_init);
        CHECK(r.model.starts() == 0);
    }
}

TEST_CASE("S3: a watchdog time that one lost frame would exceed is refused; a stored 0 counts as the factory "
          "setting") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    // The response limit, the quarantine, and 50 ms until the next setpoint.
    const node<zlac8015d::device> by_default{1};
    const auto lost =
        static_cast<std::int32_t>((by_default.limits.response + by_default.gaps.quarantine).us / 1000);
    const zlac8015d::time shortest{lost + 50};
    CHECK(r.drive.run(watchdog{1 * millisecond}).error() == errc::out_of_range);
    CHECK(r.drive.run(watchdog{shortest - 1 * millisecond}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(watchdog{shortest}));
    client direct{r.line, node<device>{1}};
    CHECK(direct.write<host_timeout>(checked(0)).error() == errc::out_of_range);
    CHECK(r.drive.run(watchdog{0 * millisecond}).error() == errc::out_of_range);
    CHECK(r.model.writes_to(0x2000) == 1);
    REQUIRE(direct.write<host_timeout>(clamped(-5)));
    CHECK(r.model.peek(0x2000) == 1);
    REQUIRE(direct.write<host_timeout>(undocumented_zero{}));
    CHECK(r.model.peek(0x2000) == 0);
    CHECK(*direct.read<host_timeout>() == 0 * millisecond);
    REQUIRE(direct.write<host_timeout>(600));
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(watchdog{undocumented_zero{}}));
    CHECK(r.model.peek(0x2000) == 0);
    CHECK(r.drive.cached().host_timeout == 0);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    r.wire.pass(milliseconds(1100));
    CHECK(r.drive.run(velocity{10 * r_per_min, 10 * r_per_min}).error() == errc::needs_init);
}

TEST_CASE("a quick stop of a disabled drive ends without a wait") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    const std::uint64_t start = r.wire.time_us();
    REQUIRE(r.drive.run(quick_stop{}));
    CHECK(r.wire.time_us() - start < 100'000);
    CHECK(r.drive.state() == drive_state::disabled);
}

TEST_CASE("codes outside an enumeration are refused before anything is sent") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    const auto frames = r.log.frames.size();
    CHECK(r.drive.run(quick_stop_by{static_cast<quick_stop_option>(0)}).error() == errc::out_of_range);
    CHECK(r.drive.run(brakes{static_cast<brake>(7), brake::code_0}).error() == errc::out_of_range);
    CHECK(r.drive.run(brakes{brake::code_0, static_cast<brake>(2)}).error() == errc::out_of_range);
    CHECK(r.drive.run(park{static_cast<off_on>(3)}).error() == errc::out_of_range);
    CHECK(r.drive.run(on_input_stop{static_cast<input_stop_action>(2)}).error() == errc::out_of_range);
    CHECK(r.drive.run(clear_position{static_cast<wheels>(4)}).error() == errc::out_of_range);
    CHECK(r.drive.run(enable_in{checked(static_cast<operating_mode>(9))}).error() == errc::bad_argument);
    CHECK(r.log.frames.size() == frames);
}

TEST_CASE("S3: both speeds are slowed down together, also with a low limit") {
    cached_settings known{.state = drive_state::enabled, .mode = operating_mode::velocity};
    for (std::uint16_t limit = 1; limit <= 1000; limit = static_cast<std::uint16_t>(limit * 2)) {
        known.max_speed = limit;
        const wheel_velocities v = clamped_velocity{3000 * r_per_min, 3000 * r_per_min}.within(known);
        CHECK(v.left.count() == v.right.count());
        CHECK(v.left.count() <= limit * 2520);
        CHECK(v.left.count() >= (limit - 1) * 2520);
    }
}

TEST_CASE("G21: a stop whose response comes only after the watchdog time invalidates the cached state") {
    const node<zlac8015d::device> by_default{1};
    node<zlac8015d::device> slow = by_default;
    slow.limits.response = milliseconds(100);
    for (const node<zlac8015d::device>& at : {by_default, slow}) {
        unsigned stopped = 0;
        for (std::uint32_t ms = 800; ms < 940; ++ms) {
            CAPTURE(ms);
            rig r{{}, unsupervised, 1, at};
            be_enabled_in(r, operating_mode::velocity);
            REQUIRE(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}));
            r.wire.pass(milliseconds(ms));
            r.wire.faults().lost_request = 1000;
            REQUIRE(r.drive.begin(halt{}) == errc::ok);
            while (!r.model.in_watchdog_stop()) turn(r);
            CHECK(r.wire.struck() != 0);
            r.wire.faults() = {};
            while (!r.drive.is_idle()) turn(r);
            stopped += r.drive.last() ? 1u : 0u; // else none of its three frames came so late
            CHECK(r.drive.state() == drive_state::needs_init);
            CHECK(r.drive.begin(velocity{50 * r_per_min, 50 * r_per_min}) == errc::needs_init);
        }
        CHECK(stopped > 2);
    }
}

TEST_CASE("G25: a halt that pre-empts an init goes before all other traffic, also if the drive was silent") {
    for (const bool is_silent : {false, true}) {
        CAPTURE(is_silent);
        rig r;
        if (is_silent) r.wire.set_connected(0, false);
        REQUIRE(r.drive.begin(init{}) == errc::ok);
        while (r.wire.requests() < 2) turn(r);
        r.log.frames.clear();
        REQUIRE(r.drive.begin(halt{}) == errc::ok);
        const std::uint64_t begun = r.wire.time_us();
        while (r.sent(zero_targets) == 0 && !r.drive.is_idle()) turn(r);
        CHECK(r.sent(zero_targets) == 1);
        // After the frame in flight, without the quarantine that follows one without a response.
        const std::uint64_t in_flight = is_silent ? device::facts.limits.response.us : 5'000;
        CHECK(r.wire.time_us() - begun < in_flight + 10'000);
        r.wire.set_connected(0, true);
        while (!r.drive.is_idle()) turn(r);
        CHECK(r.drive.last());
        CHECK(r.model.stands_still());
    }
}

TEST_CASE("a fault of a drive that responds is answered by zero targets, then by a stop, in every mode") {
    for (const operating_mode mode : {operating_mode::velocity, operating_mode::torque}) {
        rig r;
        be_enabled_in(r, mode);
        r.model.raise(fault::overcurrent, {});
        r.log.frames.clear();
        CHECK(r.drive.read());
        std::vector<simulated::frame> writes;
        for (const simulated::frame& f : r.log.frames)
            if (modbus::is_write(f[1])) writes.push_back(f);
        REQUIRE(writes.size() == 3);
        CHECK(same_bytes(writes[0], zero_targets));
        CHECK(same_bytes(writes[1], modbus::write_frame(1, 0x200E, u16{0x07})));
        CHECK(load_word(writes[2], 2) == 0x2090);
    }
}

TEST_CASE(
    "G16: a start that gets no response ends as unknown at its register, though a read shows no motion") {
    rig r;
    be_enabled_in(r, operating_mode::relative_position);
    REQUIRE(r.drive.begin(move_by{1000 * pulse, 1000 * pulse}) == errc::ok);
    while (!r.drive.is_idle()) {
        const auto& last = r.log.frames.back();
        const bool is_start = load_word(last, 2) == 0x200E && last[5] == 0x10;
        if (is_start) r.wire.faults().lost_response = 1000; // and all after it
        turn(r);
    }
    CHECK(r.drive.last().error() == errc::timeout);
    CHECK(r.drive.last().outcome() == outcome::unknown);
    CHECK(r.drive.last().register_address() == 0x200E);
}

TEST_CASE(
    "S3: the first frame after a silence that the watchdog has ended is a stop that works in every mode") {
    for (const operating_mode mode : {operating_mode::velocity, operating_mode::torque}) {
        rig r{{}, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};
        be_enabled_in(r, mode);
        if (mode == operating_mode::velocity)
            REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        else
            REQUIRE(r.drive.run(torque{2 * ampere, 2 * ampere}));
        loop(r, 200);
        r.wire.pass(milliseconds(2500)); // the program does not step
        r.log.frames.clear();
        for (int i = 0; i < 100'000 && r.log.frames.empty(); ++i) turn(r);
        REQUIRE_FALSE(r.log.frames.empty());
        CHECK(same_bytes(r.log.frames[0], modbus::write_frame(1, 0x200E, u16{0x07})));
        loop(r, 1000);
        CHECK(r.model.stands_still());
    }
}

} // namespace drive_zlac8015d_faults_tests
