// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D facade against drives with responses that the simulated one never gives: an invalid
// resolution, one shaft alone in another state, a start that is refused; and speeds in tenths of a r/min.
#include <array>

#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/frame_port.hpp>
#include <tests/support/loop_bound.hpp>

namespace drive_zlac8015d_states_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using rig = simulated::driven_zlac8015d;

namespace {

/// A drive of which one register may read as another value, and which may refuse a control word.
struct odd_drive : sim::zlac8015d {
    u16 odd_address = 0; // 0: all registers read normally
    u16 odd_word = 0;
    u16 refused = 0;

    static constexpr modbus::server_rules rules() { return {}; }
    constexpr std::uint8_t read(u16 address, std::span<u16> to) {
        const std::uint8_t exception = sim::zlac8015d::read(address, to);
        if (odd_address >= address && odd_address < address + to.size()) to[odd_address - address] = odd_word;
        return exception;
    }
    constexpr std::uint8_t write(u16 address, words_view from) {
        if (refused != 0 && address == control_word.address && from[0] == refused) return 4;
        return sim::zlac8015d::write(address, from);
    }
};

struct odd_rig {
    simulated::frame_port<odd_drive> port{odd_drive{}};
    using line_type = servobus::line<simulated::frame_port<odd_drive>>;
    line_type line{port, modbus::timing_at(port.baud)};
    zlac8015d::drive<line_type> drive;

    explicit odd_rig(const node<device>& at = node<device>{1}) : drive{line, at, unsupervised} {}
    odd_drive& model() { return port.model; }
};

} // namespace

TEST_CASE("init refuses a drive whose resolution reads as an invalid value") {
    for (const u16 n : {u16{0}, u16{11}}) {
        CAPTURE(n);
        odd_rig r;
        r.model().odd_address = speed_resolution.address;
        r.model().odd_word = n;
        const command_status got = r.drive.run(init{});
        CHECK(got.error() == errc::unexpected_value);
        CHECK(r.drive.state() == drive_state::needs_init);
        CHECK(r.drive.run(enable{}).error() == errc::needs_init);
    }
}

TEST_CASE("S3: the state that one shaft reports holds for both, also without a fault bit") {
    for (const bool is_left : {false, true}) {
        CAPTURE(is_left);
        const auto word = [&](shaft_state s) {
            const axis_status odd{s, false};
            const axis_status locked{shaft_state::locked, false};
            return status_flags{is_left ? odd : locked, is_left ? locked : odd}.to_word();
        };
        odd_rig r;
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
        REQUIRE(r.drive.read());
        REQUIRE(r.drive.state() == drive_state::enabled);
        r.model().odd_address = status_word.address;
        SUBCASE("alarm") {
            r.model().odd_word = word(shaft_state::alarm);
            REQUIRE(r.drive.read());
            CHECK_FALSE(r.drive.feedback(milliseconds(2000))->has_fault());
            CHECK(r.drive.state() == drive_state::faulted);
            CHECK_FALSE(r.model().enabled());
        }
        SUBCASE("emergency stop") {
            r.model().odd_word = word(shaft_state::emergency_stop);
            REQUIRE(r.drive.read());
            CHECK(r.drive.state() == drive_state::quick_stopped);
        }
        SUBCASE("released") {
            r.model().odd_word = word(shaft_state::released);
            REQUIRE(r.drive.read());
            CHECK(r.drive.state() == drive_state::needs_init);
        }
    }
}

TEST_CASE("G16: a start that the drive refuses was not executed, and no positions are compared") {
    odd_rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
    r.model().refused = static_cast<u16>(control_code::start_both);
    const command_status got = r.drive.run(move_by{1000 * pulse, 1000 * pulse});
    CHECK(got.error() == errc::exception);
    CHECK(got.exception() == 4);
    CHECK(r.drive.motion() == motion_check::not_asked);
    CHECK(r.model().starts() == 0);
    CHECK(r.drive.state() == drive_state::needs_init); // the targets were written
}

TEST_CASE("S3: after a start that got no response for longer than the watchdog time no read is sent") {
    node<device> patient{1};
    patient.limits.response = milliseconds(1200);
    odd_rig r{patient};
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
    constexpr std::size_t start_frame = 3; // after the mode, the feedback and the positions
    r.port.plan(simulated::mishap::no_more_responses, start_frame);
    const command_status got = r.drive.run(move_by{100'000 * pulse, 100'000 * pulse});
    REQUIRE(r.model().starts() == 1);
    CHECK(got.outcome() == outcome::unknown);
    CHECK(r.drive.motion() == motion_check::unknown);
    CHECK(
        same_bytes(r.port.requests.back(),
                   modbus::write_frame(1, control_word.address, static_cast<u16>(control_code::start_both))));
    CHECK(r.drive.state() == drive_state::needs_init);
}

// After a watchdog stop, the first frame that the drive receives may let its wheels go on.
TEST_CASE("S3: whichever frame of an init a returning drive receives first, its wheels stay at standstill") {
    for (std::uint32_t ms = 0; ms < 600; ms += 7) {
        CAPTURE(ms);
        rig r;
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
        REQUIRE(r.drive.run(velocity{30 * r_per_min, 30 * r_per_min}));
        r.wire.pass(milliseconds(500));
        r.wire.set_connected(0, false);
        r.wire.pass(milliseconds(3000));
        REQUIRE(r.model.in_watchdog_stop());
        const auto place = r.model.left().position;
        const std::uint64_t back = r.wire.time_us() + ms * 1000u;
        while (r.drive.state() != drive_state::disabled) {
            if (r.wire.time_us() >= back && r.line.is_free()) r.wire.set_connected(0, true);
            if (r.drive.is_idle()) REQUIRE(r.drive.begin(init{}) == errc::ok);
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
        CHECK(r.model.left().position == place);
        CHECK(r.model.stands_still());
    }
}

TEST_CASE("S4: after a start without a response, motion is seen also if the wheel is already at standstill "
          "again, more than 20 counts away") {
    for (const std::int32_t pulses : {60, -60, 20, -20}) {
        for (const bool is_left : {false, true}) {
            CAPTURE(is_left);
            CAPTURE(pulses);
            rig r;
            REQUIRE(r.drive.run(init{}));
            REQUIRE(r.drive.run(ramps{10 * millisecond, 10 * millisecond}));
            REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
            const distance way = pulses * pulse;
            REQUIRE(r.drive.begin(move_by{is_left ? way : 0 * pulse, is_left ? 0 * pulse : way}) == errc::ok);
            const auto start_frame =
                modbus::write_frame(1, control_word.address, static_cast<u16>(control_code::start_both));
            while (!r.drive.is_idle()) {
                r.wire.faults().lost_response =
                    r.sent(start_frame) == 1 && r.drive.motion() == motion_check::not_asked ? 1000 : 0;
                const duration idle = r.drive.step();
                r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            }
            CHECK(r.drive.last().outcome() == outcome::unknown);
            CHECK(r.model.stands_still());
            const bool is_far = pulses > 20 || pulses < -20;
            CHECK(r.drive.motion() == (is_far ? motion_check::seen : motion_check::not_seen));
            CHECK(r.model.starts() == 1);
            REQUIRE(r.drive.run(init{}));
            CHECK(r.drive.motion() == motion_check::not_asked);
        }
    }
}

TEST_CASE("speeds in tenths of a r/min are limited to a word of 3000, and a clamped pair keeps its ratio") {
    rig r;
    r.have_resolution(10);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    REQUIRE(r.drive.cached().max_speed > 300);
    const std::size_t frames = r.log.frames.size();
    CHECK(r.drive.run(velocity{301 * r_per_min, 0 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{0 * r_per_min, -301 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.log.frames.size() == frames);
    REQUIRE(r.drive.run(velocity{300 * r_per_min, -300 * r_per_min}));
    CHECK(r.model.peek(left_target_speed.address) == 3000);
    CHECK(r.model.peek(right_target_speed.address) == static_cast<u16>(-3000));
    REQUIRE(r.drive.run(clamped_velocity{600 * r_per_min, -150 * r_per_min}));
    CHECK(r.model.peek(left_target_speed.address) <= 3000);
    CHECK(r.model.peek(left_target_speed.address) >= 2990);
    CHECK(static_cast<i16>(r.model.peek(right_target_speed.address)) >= -750);
    CHECK(static_cast<i16>(r.model.peek(right_target_speed.address)) <= -747);
}

TEST_CASE("targets and distances beyond the drive's range are refused in either direction") {
    constexpr std::int32_t lowest = -0x7FFF'FFFF - 1;
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
    CHECK(r.drive.run(move_by{distance{lowest}, 0 * pulse}).error() == errc::out_of_range);
    CHECK(r.drive.run(move_by{0 * pulse, distance{lowest}}).error() == errc::out_of_range);
    // A count of 64 bits that was limited to 32, such as a difference of unsigned numbers.
    CHECK(r.drive.run(move_by{3'000'000'000 * pulse, 0 * pulse}).error() == errc::out_of_range);
    CHECK(r.drive.run(move_by{0 * pulse, (1000u - 1200u) * pulse}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::absolute_position}));
    CHECK(r.drive.run(move_to{0 * pulse, -0x4000'0000 * pulse}).error() == errc::out_of_range);
    CHECK(r.drive.run(move_to{0x4000'0000 * pulse, 0 * pulse}).error() == errc::out_of_range);
    CHECK(r.model.starts() == 0);
}

TEST_CASE("a halt is refused in the position modes, where the drive has none, and nothing is sent") {
    for (const operating_mode mode : {operating_mode::relative_position, operating_mode::absolute_position}) {
        rig r;
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable_in{checked(mode)}));
        const std::size_t frames = r.log.frames.size();
        CHECK(r.drive.run(halt{}).error() == errc::wrong_state);
        CHECK(r.log.frames.size() == frames);
        CHECK(r.model.enabled());
    }
}

namespace {
/// A command of a program's own: a move that counts as a motion without an end.
struct endless_move {
    distance way;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = commands::prepared(move_by{way, way}, cached);
        o.then = effect::motion;
        return o;
    }
};
} // namespace

TEST_CASE("G20: in a position mode the command timeout stops the wheels by a quick stop") {
    rig r{{}, {.command_timeout = milliseconds(300)}};
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
    REQUIRE(r.drive.run(endless_move{100'000 * pulse}));
    const std::uint64_t end = r.wire.time_us() + 2'000'000;
    while (r.wire.time_us() < end) {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(r.sent(modbus::write_frame(1, control_word.address, static_cast<u16>(control_code::quick_stop))) ==
          1);
    CHECK(r.model.stands_still());
    CHECK(r.model.left().position < 50'000);
    CHECK(r.drive.state() == drive_state::quick_stopped);
}

TEST_CASE("a fault of either wheel is a fault of the drive") {
    for (const fault left : {fault::none, fault::overcurrent}) {
        for (const fault right : {fault::none, fault::encoder}) {
            rig r;
            REQUIRE(r.drive.run(init{}));
            r.model.raise(left, right);
            const result<feedback> seen = r.drive.read();
            REQUIRE(seen);
            const bool is_any = left != fault::none || right != fault::none;
            CHECK(seen->has_fault() == is_any);
            CHECK((r.drive.state() == drive_state::faulted) == is_any);
        }
    }
}

TEST_CASE("before init a command that needs a disabled drive says that init is missing") {
    rig r;
    CHECK(r.drive.run(save{}).error() == errc::needs_init);
    CHECK(r.drive.run(resolution{10}).error() == errc::needs_init);
    CHECK(r.log.frames.empty());
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    CHECK(r.drive.run(save{}).error() == errc::wrong_state);
    CHECK(r.drive.run(resolution{10}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.drive.run(resolution{10}));
}

TEST_CASE("a wheel counts as stopped at 2 r/min and below, either way") {
    for (const int tenths : {20, -20, 21, -21}) {
        for (const u16 wheel : {left_actual_speed.address, right_actual_speed.address}) {
            CAPTURE(tenths);
            odd_rig r;
            REQUIRE(r.drive.run(init{}));
            r.model().odd_address = wheel;
            r.model().odd_word = static_cast<u16>(tenths);
            const command_status got = r.drive.run(disable{});
            CHECK(got.error() == (tenths == 20 || tenths == -20 ? errc::ok : errc::not_reached));
        }
    }
}

TEST_CASE(
    "B30: an enable after which the shafts do not read as locked stops the drive, and init must follow") {
    odd_rig r;
    REQUIRE(r.drive.run(init{}));
    const axis_status released{shaft_state::released, false};
    r.model().odd_address = status_word.address;
    r.model().odd_word = status_flags{released, released}.to_word();
    CHECK(r.drive.run(enable_in{operating_mode::velocity}).error() == errc::not_reached);
    CHECK_FALSE(r.model().enabled());
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK(r.drive.run(velocity{1 * r_per_min, 1 * r_per_min}).error() == errc::needs_init);
}

namespace {

/// A write of the watchdog's time of which nothing is known. With this response limit an `init` sends two reads before
/// the shorter of both times has passed.
struct unknown_watchdog {
    std::uint16_t wanted_ms;
    std::uint32_t limit_ms;
    simulated::mishap lost;
};

} // namespace

TEST_CASE(
    "S3: a watchdog time whose write got no response may be in force or not: no read is the first frame "
    "after the shorter one") {
    constexpr std::uint16_t before_ms = 1000; // of the factory
    for (const unknown_watchdog& s : {unknown_watchdog{300, 150, simulated::mishap::response_lost},
                                      unknown_watchdog{300, 150, simulated::mishap::request_lost},
                                      unknown_watchdog{3000, 450, simulated::mishap::response_lost},
                                      unknown_watchdog{3000, 450, simulated::mishap::request_lost}}) {
        CAPTURE(s.wanted_ms);
        CAPTURE(static_cast<int>(s.lost));
        const std::uint16_t shorter_ms = s.wanted_ms < before_ms ? s.wanted_ms : before_ms;
        node<device> patient{1};
        patient.limits.response = milliseconds(s.limit_ms);
        odd_rig r{patient};
        REQUIRE(r.drive.run(init{}));
        r.port.plan(s.lost, 0);
        REQUIRE(r.drive.run(watchdog{s.wanted_ms * millisecond}).outcome() == outcome::unknown);
        const bool is_in_force = s.lost == simulated::mishap::response_lost;
        REQUIRE(r.model().peek(host_timeout.address) == (is_in_force ? s.wanted_ms : before_ms));
        constexpr std::size_t stops = 3; // of an init, before its first read
        r.port.plan(simulated::mishap::no_more_responses, stops);
        const std::size_t first = r.port.requests.size();
        REQUIRE(r.drive.begin(init{}) == errc::ok);
        std::uint64_t received = 0; // when the last request with a response was sent
        std::size_t reads = 0;
        for (tests::loop_bound left{"the end of a command"}; !r.drive.is_idle(); left.use()) {
            const std::size_t before = r.port.requests.size();
            const duration idle = r.drive.step();
            if (r.port.requests.size() > before) {
                if (before < first + stops) received = r.port.time_us();
                if (r.port.requests.back()[1] == 0x03) {
                    ++reads;
                    CHECK(r.port.time_us() - received < shorter_ms * 1000u);
                }
            }
            r.port.wait(idle.us == 0 ? microseconds(10) : idle);
        }
        CHECK(reads == 2);
        CHECK_FALSE(r.drive.last());
    }
}

TEST_CASE("20A2h to 20ACh: the feedback has each word in its place") {
    const std::array<u16, 11> words{
        0x4000, 0x0003, 0x1A1B, 0x0004, 0x0200, 0x0001, 0x0002, 0xFFFF, 0xFFFE, 305, static_cast<u16>(-12)};
    const auto f = feedback::from_words(slice<const u16>{words.data(), words.size()});
    CHECK(f.state.to_word() == 0x4000);
    CHECK(f.hall.to_word() == 0x0003);
    CHECK(f.temperature.to_word() == 0x1A1B);
    CHECK(f.left_faults.bits == static_cast<u16>(fault::overcurrent));
    CHECK(f.right_faults.bits == static_cast<u16>(fault::hall));
    CHECK(f.left_position.count() == 0x1'0002);
    CHECK(f.right_position.count() == -2);
    CHECK(f.left_speed.count() == 305); // 0.1 r/min
    CHECK(f.right_speed.count() == -12);
}

TEST_CASE("a read that finds a fault has succeeded, whatever the command before it") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    CHECK(r.drive.run(move_by{1 * pulse, 1 * pulse}).error() == errc::wrong_state);
    r.model.raise(fault::overcurrent, fault{});
    CHECK(r.drive.read());
    CHECK(r.drive.last());
    CHECK(r.drive.state() == drive_state::faulted);
}

} // namespace drive_zlac8015d_states_tests
