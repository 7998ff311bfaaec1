// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D facade's promises of machine safety against its simulator: a program crashes, a frame is lost
// or the drive restarts at every possible step, the application stops commanding, or the line has faults.
#include <array>
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_zlac8015d.hpp>

namespace drive_zlac8015d_safety_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using enabled_zlac8015d::be_enabled_in;
using enabled_zlac8015d::fault_reset_frame;
using enabled_zlac8015d::quick_stop_frame;
using enabled_zlac8015d::stop_frame;
using simulated::is_motion_or_enable;
using rig = simulated::driven_zlac8015d;
using simulated::zero_targets;

namespace {

constexpr auto enable_frame = hex("01 06 20 0E 00 08 E2 0F");

void step_for(rig& r, std::uint32_t ms) {
    const std::uint64_t end = r.wire.time_us() + ms * 1000u;
    while (r.wire.time_us() < end) {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
}

} // namespace

TEST_CASE("S3: no mode is written to wheels that coast after a wired stop, whatever the running bits show") {
    using switches = sim::zlac8015d_options;
    for (const switches::running bit :
         {switches::running::turns, switches::running::driven, switches::running::enabled}) {
        CAPTURE(static_cast<int>(bit));
        rig r{{.bit = bit}};
        be_enabled_in(r, operating_mode::velocity);
        REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        step_for(r, 600);
        r.model.set_input(true, false);
        REQUIRE_FALSE(simulated::are_slow(r.model));
        const std::size_t before = r.log.frames.size();
        CHECK(r.drive.run(enable_in{checked(operating_mode::relative_position)}).error() == errc::busy);
        CHECK(r.drive.run(save{}).error() != errc::ok);
        CHECK(r.drive.run(factory_reset{sole_drive_on_the_line{}}).error() != errc::ok);
        for (std::size_t i = before; i < r.log.frames.size(); ++i)
            CHECK_FALSE(
                (r.log.frames[i][1] == 6 && load_word(r.log.frames[i], 2) == mode_of_operation.address));
        CHECK_FALSE(simulated::are_slow(r.model));
    }
}

TEST_CASE("S3: if a pair of speeds is too high, both wheels are slowed down together, never one alone") {
    cached_settings known{.state = drive_state::enabled, .mode = operating_mode::velocity, .max_speed = 200};
    for (std::uint16_t n = 1; n <= 10; ++n) {
        known.resolution = n;
        const wheel_velocities v = clamped_velocity{400 * r_per_min, -100 * r_per_min}.within(known);
        CHECK(zlac8015d::prepare(v, known).refusal == errc::ok);
        CHECK(v.left.count() <= 200 * 2520);
        CHECK(v.left.count() > 196 * 2520);
        const std::int32_t right = -v.right.count() * 4;
        CHECK(right >= v.left.count() - 6 * 2520);
        CHECK(right <= v.left.count() + 6 * 2520);
        const wheel_velocities slow = clamped_velocity{100 * r_per_min, 40 * r_per_min}.within(known);
        CHECK(slow.left == speed{100 * r_per_min});
        CHECK(slow.right == speed{40 * r_per_min});
        const wheel_velocities huge =
            clamped_velocity{2'000'000'000 * r_per_min, -2'000'000'000 * r_per_min}.within(known);
        CHECK(zlac8015d::prepare(huge, known).refusal == errc::ok);
        CHECK(huge.left.count() == -huge.right.count());
    }
}

TEST_CASE("S1: init stops the motion that a crashed program left, and neither moves nor enables the drive") {
    for (const operating_mode mode : {operating_mode::velocity, operating_mode::torque,
                                      operating_mode::relative_position, operating_mode::absolute_position}) {
        rig r;
        be_enabled_in(r, mode);
        if (mode == operating_mode::velocity)
            REQUIRE(r.drive.run(velocity{300 * r_per_min, -300 * r_per_min}));
        REQUIRE(r.drive.run(torque_slope{30'000 * milliampere_per_second}));
        if (mode == operating_mode::torque) REQUIRE(r.drive.run(torque{3 * ampere, 3 * ampere}));
        if (mode == operating_mode::relative_position)
            REQUIRE(r.drive.run(move_by{90000 * pulse, 90000 * pulse}));
        if (mode == operating_mode::absolute_position)
            REQUIRE(r.drive.run(move_to{90000 * pulse, 90000 * pulse}));
        r.wire.pass(milliseconds(700));
        REQUIRE_FALSE(r.model.stands_still());
        r.log.frames.clear();
        zlac8015d::drive<rig::line_type> successor{r.line, 1, unsupervised};
        REQUIRE(successor.run(init{}));
        CHECK(same_bytes(r.log.frames[0], zero_targets));
        CHECK(same_bytes(r.log.frames[1], stop_frame));
        for (const auto& f : r.log.frames) CHECK_FALSE(is_motion_or_enable(f));
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        CHECK(successor.state() == drive_state::disabled);
    }
}

TEST_CASE("S1: after a program has crashed at any frame of a routine, init of another program stops and "
          "initialises the drive") {
    for (std::size_t crash = 0; crash < 60; ++crash) {
        rig r;
        std::size_t steps = 0;
        bool is_over = false;
        // Steps the commands. At the crash the stepping just ends.
        const auto run_until_crash = [&](const auto& command) {
            if (is_over || r.drive.begin(command) != errc::ok) return;
            while (!r.drive.is_idle()) {
                const std::size_t before = r.log.frames.size();
                const duration idle = r.drive.step();
                r.wire.wait(idle);
                steps += r.log.frames.size() - before;
                if (steps > crash) {
                    is_over = true;
                    return;
                }
            }
        };
        run_until_crash(init{});
        run_until_crash(enable_in{operating_mode::velocity});
        run_until_crash(velocity{250 * r_per_min, 100 * r_per_min});
        run_until_crash(disable{});
        run_until_crash(enable_in{operating_mode::relative_position});
        run_until_crash(move_by{40000 * pulse, 40000 * pulse});
        r.wire.pass(milliseconds(crash % 2 == 0 ? 100 : 3000));
        r.log.frames.clear();
        r.log.open.clear();
        servobus::line restarted{r.wire, modbus::timing_at(115200)};
        zlac8015d::drive successor{restarted, 1, unsupervised};
        REQUIRE(successor.run(init{}));
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        CHECK(same_bytes(r.log.frames[0], zero_targets));
        for (const auto& f : r.log.frames) CHECK_FALSE(is_motion_or_enable(f));
    }
}

TEST_CASE("S2: targets are zeroed and read back before every enable, so old ones cannot move a wheel") {
    for (const operating_mode mode : {operating_mode::velocity, operating_mode::torque,
                                      operating_mode::relative_position, operating_mode::absolute_position}) {
        rig r;
        REQUIRE(r.drive.run(init{}));
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.write<left_target_speed>(raw(500)));
        REQUIRE(direct.write<right_target_torque>(2 * ampere));
        REQUIRE(direct.write<left_target_position>(10000));
        REQUIRE(r.drive.run(enable_in{checked(mode)}));
        REQUIRE(r.live(milliseconds(1500)));
        CHECK(r.model.stands_still());
        CHECK(r.model.left().position == 0);
        CHECK(r.model.right().position == 0);
        CHECK(r.sent(zero_targets) == 2);
        CHECK(r.sent(modbus::read_frame(1, 0x2088, 2)) == 1);
    }
}

TEST_CASE(
    "S3: the first frame after a gap is zero targets or stop, never a read, and motion does not resume") {
    for (const bool resumes : {true, false}) {
        rig r{{.resumes_after_watchdog = resumes}};
        be_enabled_in(r, operating_mode::velocity);
        REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        REQUIRE(r.live(milliseconds(1000)));
        r.wire.pass(milliseconds(2500)); // the program sleeps; the drive's watchdog stops it
        CHECK(r.model.stands_still());
        r.log.frames.clear();
        CHECK(r.drive.read().error() == errc::needs_init);
        CHECK(r.drive.run(velocity{10 * r_per_min, 10 * r_per_min}).error() == errc::needs_init);
        CHECK(r.drive.run(enable_in{operating_mode::velocity}).error() == errc::needs_init);
        CHECK(r.log.frames.empty());
        SUBCASE("init") { REQUIRE(r.drive.run(init{})); }
        SUBCASE("quick stop") { REQUIRE(r.drive.run(quick_stop{})); }
        SUBCASE("halt") { REQUIRE(r.drive.run(halt{})); }
        SUBCASE("disable") { REQUIRE(r.drive.run(disable{})); }
        REQUIRE_FALSE(r.log.frames.empty());
        CHECK((same_bytes(r.log.frames[0], zero_targets) || same_bytes(r.log.frames[0], stop_frame)));
        r.wire.pass(milliseconds(500));
        CHECK(r.model.stands_still());
    }
}

TEST_CASE("S3: the mode changes only at standstill") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    const auto before = r.sent(modbus::write_frame(1, 0x200D, 1));
    CHECK(r.drive.run(enable_in{operating_mode::relative_position}).error() == errc::busy);
    CHECK(r.sent(modbus::write_frame(1, 0x200D, 1)) == before);
    CHECK(r.drive.run(enable_in{checked(operating_mode::undefined)}).error() == errc::bad_argument);
}

TEST_CASE("S3, G15: a relative move is made at most once, whichever frame is lost; after a start of unknown "
          "outcome positions are compared") {
    unsigned seen = 0;
    unsigned not_seen = 0;
    for (std::uint32_t lost = 0; lost < 8; ++lost) {
        for (const bool lose_response : {false, true}) {
            rig r;
            be_enabled_in(r, operating_mode::relative_position);
            const std::uint32_t first = r.wire.requests();
            REQUIRE(r.drive.begin(move_by{4096 * pulse, 4096 * pulse}) == errc::ok);
            while (!r.drive.is_idle()) {
                // Request number `lost` of the move, or the response to it, is lost.
                const bool is_now = r.wire.requests() == first + lost;
                r.wire.faults().lost_request = is_now && !lose_response ? 1000 : 0;
                r.wire.faults().lost_response =
                    r.wire.requests() == first + lost + 1 && lose_response ? 1000 : 0;
                const duration idle = r.drive.step();
                r.wire.wait(idle.us < 100 ? microseconds(20) : microseconds(50));
            }
            r.wire.faults() = {};
            CHECK(r.sent(hex("01 06 20 0E 00 10 E2 05")) <= 1);
            r.wire.pass(milliseconds(900));
            CHECK(r.model.starts() <= 1);
            const command_status ended = r.drive.last();
            if (ended.outcome() == outcome::unknown && ended.step() == routines::start_step) {
                CHECK(r.drive.state() == drive_state::needs_init);
                if (r.drive.motion() == motion_check::seen) {
                    ++seen;
                    CHECK(r.model.starts() == 1);
                } else if (r.drive.motion() == motion_check::not_seen) {
                    ++not_seen;
                }
            }
        }
    }
    CHECK(seen == 1);
    CHECK(not_seen == 1);
}

TEST_CASE(
    "G15: whatever the line does, enable, starts, fault reset, save and factory reset are sent at most once "
    "per call") {
    unsigned struck = 0;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        rig r{{}, unsupervised, seed};
        be_enabled_in(r, operating_mode::relative_position);
        r.wire.faults() = {.lost_request = 50,
                           .corrupted_request = 50,
                           .lost_response = 100,
                           .late_response = 50,
                           .doubled_response = 50,
                           .corrupted_response = 50};
        r.log.frames.clear();
        (void)r.drive.run(move_by{100 * pulse, 100 * pulse});
        CHECK(r.sent(hex("01 06 20 0E 00 10 E2 05")) <= 1);
        (void)r.drive.run(disable{});
        (void)r.drive.run(fault_reset{});
        CHECK(r.sent(fault_reset_frame) <= 1);
        (void)r.drive.run(save{});
        CHECK(r.sent(modbus::write_frame(1, 0x2010, 1)) <= 1);
        (void)r.drive.run(enable_in{operating_mode::velocity});
        CHECK(r.sent(enable_frame) <= 1);
        (void)r.drive.run(disable{});
        (void)r.drive.run(factory_reset{sole_drive_on_the_line{}});
        CHECK(r.sent(modbus::write_frame(1, 0x2009, 1)) <= 1);
        struck += r.wire.struck();
    }
    REQUIRE(struck > 1000);
}

TEST_CASE("G16, G21: an unknown outcome invalidates the cached state; nothing moves before init") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    r.wire.faults().lost_response = 1000;
    const command_status lost = r.drive.run(velocity{50 * r_per_min, 50 * r_per_min});
    CHECK(lost.outcome() == outcome::unknown);
    CHECK(lost.error() == errc::timeout);
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK(r.wire.struck() != 0);
    r.wire.faults() = {};
    CHECK(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}).error() == errc::needs_init);
    CHECK(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}).outcome() == outcome::not_sent);
    REQUIRE(r.drive.run(init{}));
    CHECK(r.model.stands_still());
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    REQUIRE(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}));
}

TEST_CASE("G21: a restart is detected by a read, by an enable and by a move") {
    {
        rig r;
        be_enabled_in(r, operating_mode::velocity);
        r.model.power_cycle();
        REQUIRE(r.drive.read());
        CHECK(r.drive.state() == drive_state::needs_init);
    }
    {
        rig r;
        r.set_by_hand(0x2022, 10); // not saved
        REQUIRE(r.drive.run(init{}));
        r.model.power_cycle();
        CHECK(r.drive.run(enable_in{operating_mode::velocity}).error() == errc::needs_init);
        CHECK(r.drive.state() == drive_state::needs_init);
        CHECK(r.sent(enable_frame) == 0);
    }
    {
        rig r;
        be_enabled_in(r, operating_mode::relative_position);
        r.model.power_cycle();
        CHECK(r.drive.run(move_by{100 * pulse, 100 * pulse}).error() == errc::needs_init);
        CHECK(r.model.starts() == 0);
    }
}

TEST_CASE("G21: after a lost port has returned, init is required, and motion does not resume") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    r.wire.unplug();
    CHECK(r.drive.read().error() == errc::port_lost);
    CHECK(r.drive.run(init{}).error() == errc::port_lost);
    r.wire.pass(milliseconds(2000));
    CHECK(r.model.stands_still()); // by the drive's own watchdog
    r.wire.plug();
    CHECK(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}).error() == errc::needs_init);
    REQUIRE(r.drive.run(init{}));
    r.wire.pass(milliseconds(500));
    CHECK(r.model.stands_still());
}

TEST_CASE("G20: after the command timeout one halt is sent and confirmed; motion does not resume") {
    rig r{{}, {.command_timeout = milliseconds(400)}};
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    r.log.frames.clear();
    const auto loop = [&](std::uint32_t ms) { step_for(r, ms); };
    loop(300);
    CHECK(r.sent(zero_targets) == 0);
    CHECK_FALSE(r.model.stands_still());
    loop(2000);
    CHECK(r.sent(zero_targets) == 1);
    CHECK(r.model.stands_still());
    loop(10'000); // keep-alive requests continue, nothing moves
    CHECK(r.sent(zero_targets) == 1);
    CHECK(r.drive.state() == drive_state::enabled);
    CHECK_FALSE(r.model.in_watchdog_stop());
    REQUIRE(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}));
    loop(300);
    CHECK_FALSE(r.model.stands_still());
    loop(3000);
    CHECK(r.sent(zero_targets) == 2);
    CHECK(r.model.stands_still());
}

TEST_CASE("S3, G20: the stop of a supervisor that a drive receives first after its watchdog's stops it in "
          "every mode") {
    rig r{{}, {.command_timeout = milliseconds(400)}};
    be_enabled_in(r, operating_mode::torque);
    REQUIRE(r.drive.run(torque{500 * milliampere, 500 * milliampere}));
    const auto loop = [&](std::uint32_t ms) { step_for(r, ms); };
    loop(300);
    r.wire.set_connected(0, false); // and the program commands no more
    loop(3000);
    REQUIRE(r.drive.state() == drive_state::needs_init);
    r.log.frames.clear();
    r.wire.set_connected(0, true);
    loop(3000);
    REQUIRE_FALSE(r.log.frames.empty());
    CHECK(same_bytes(r.log.frames.front(), stop_frame));
    CHECK(r.model.stands_still());
}

TEST_CASE(
    "S3, G21: a stop of which a part got no response reads nothing once the watchdog's time has passed") {
    unsigned waited = 0;
    for (std::int32_t ms = 300; ms <= 1500; ms += 20) {
        CAPTURE(ms);
        rig r;
        be_enabled_in(r, operating_mode::torque);
        REQUIRE(r.drive.run(watchdog{ms * millisecond}));
        REQUIRE(r.drive.run(torque{500 * milliampere, 500 * milliampere}));
        r.wire.pass(milliseconds(2500)); // the program sleeps
        r.log.frames.clear();
        REQUIRE(r.drive.begin(halt{}) == errc::ok);
        const auto turn = [&r] {
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : shorter_of(idle, milliseconds(1)));
        };
        const auto is_stopped = [&r] {
            r.model.advance(r.wire.clock());
            return r.model.in_watchdog_stop();
        };
        REQUIRE(is_stopped());
        while (r.log.frames.empty() || r.log.open.empty()) turn(); // the second one begins to leave
        CHECK(same_bytes(r.log.frames[0], zero_targets)); // confirmed, but it does not stop this mode
        REQUIRE_FALSE(is_stopped());
        r.wire.set_connected(0, false);
        while (!r.drive.is_idle() && !is_stopped()) turn();
        if (!is_stopped()) continue;
        r.wire.set_connected(0, true);
        r.log.frames.clear();
        while (!r.drive.is_idle() && r.log.frames.empty()) turn();
        if (r.log.frames.empty()) {
            ++waited;
            CHECK_FALSE(r.drive.last());
            CHECK(is_stopped());
        } else {
            CHECK(modbus::is_write(r.log.frames.front()[1]));
        }
    }
    CHECK(waited != 0);
}

TEST_CASE("without a command timeout the facade sends nothing by itself, and the drive's watchdog stops the "
          "wheels") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    const auto frames = r.log.frames.size();
    for (int i = 0; i < 3000; ++i) {
        (void)r.drive.step();
        r.wire.pass(milliseconds(1));
    }
    CHECK(r.log.frames.size() == frames);
    CHECK(r.model.stands_still());
}

TEST_CASE("a superloop that never waits controls the wheels; a stop pre-empts another command") {
    rig r;
    const auto turn = [&] {
        const std::uint64_t before = r.wire.time_us();
        (void)r.drive.step();
        CHECK(r.wire.time_us() - before < 100); // no step waits
        r.wire.pass(microseconds(50));
    };
    REQUIRE(r.drive.begin(init{}) == errc::ok);
    while (!r.drive.is_idle()) turn();
    REQUIRE(r.drive.last());
    REQUIRE(r.drive.begin(enable{}) == errc::ok);
    CHECK(r.drive.begin(enable{}) == errc::busy);
    while (!r.drive.is_idle()) turn();
    REQUIRE(r.drive.begin(velocity{300 * r_per_min, 300 * r_per_min}) == errc::ok);
    while (!r.drive.is_idle()) turn();
    for (int i = 0; i < 10000; ++i) turn();
    REQUIRE(r.drive.begin(disable{}) == errc::ok);
    for (int i = 0; i < 100; ++i) turn();
    REQUIRE_FALSE(r.drive.is_idle()); // the wheels are still slowing down
    r.log.frames.clear();
    REQUIRE(r.drive.begin(quick_stop{}) == errc::ok);
    CHECK(r.drive.begin(quick_stop{}) == errc::busy);
    while (!r.drive.is_idle()) turn();
    REQUIRE(r.log.frames.size() >= 2);
    // At most the frame in progress comes before it.
    CHECK((same_bytes(r.log.frames[0], quick_stop_frame) || same_bytes(r.log.frames[1], quick_stop_frame)));
    CHECK(r.model.stands_still());
}

TEST_CASE("on a line with random faults init stops the drive and makes it usable again") {
    // A response that begins after limit and quarantine may be taken for the one to the next request (G2).
    const node<zlac8015d::device> by_default{1};
    const duration past_limit = by_default.gaps.quarantine - milliseconds(2);
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        CAPTURE(seed);
        sim::zlac8015d model;
        sim::station at{model};
        sim::virtual_line wire{115200, seed};
        wire.attach(at);
        servobus::line on{wire, modbus::timing_at(115200)};
        zlac8015d::drive drive{on, 1, unsupervised};
        sim::fault_plan plan;
        REQUIRE(sim::parse_faults("late,lossy,noisy,doubled", plan));
        plan.late_by =
            by_default.limits.response + duration{past_limit.us / 40 * static_cast<std::uint32_t>(seed)};
        wire.faults() = plan;
        unsigned rounds = 0;
        for (int i = 0; i < 40; ++i) {
            if (!drive.run(init{})) continue;
            CHECK(model.stands_still());
            if (!drive.run(enable_in{operating_mode::velocity})) continue;
            if (!drive.run(velocity{100 * r_per_min, -100 * r_per_min})) continue;
            for (int k = 0; k < 5; ++k) {
                const auto f = drive.read();
                if (!f) break;
                CHECK(f->left_speed <= 101 * r_per_min);
            }
            ++rounds;
        }
        CHECK(rounds > 10);
        CHECK(wire.struck() != 0);
        wire.faults() = {};
        REQUIRE(drive.run(init{}));
        CHECK(model.stands_still());
    }
}

} // namespace drive_zlac8015d_safety_tests
