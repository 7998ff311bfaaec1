// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot changes its speed within its limits, whatever the drive's ramps do with a stream of setpoints. A joystick at
// 50 Hz drives it, its program dies at full speed, it is stopped, setpoints get no response. The simulated wheels are
// the judge.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/control/setpoint_loop.hpp>
#include <servobus/device/zlac8015d/parameters.hpp>
#include <tests/support/robot_world.hpp>

namespace robot_shaping_tests {

using namespace servobus;
using namespace servobus::literals;
using options = sim::zlac8015d_options;

namespace {

constexpr feed wheel = rolling(600_mm, counts_per_turn{4096}); // 100 r/min are 1 m/s
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 500_mm});
constexpr robots::machine machine{600, -600, 500, 1024};
constexpr axis_profile limits{.top = 1_m_per_s, .acceleration = 500_ms, .deceleration = 250_ms};
constexpr long double faster = 200, slower = 400; // r/min in a second, of `limits`
constexpr options::ramp readings[]{options::ramp::begins_anew, options::ramp::linear};

struct wheel_speeds_now {
    long double left, right; // r/min, forward
};

struct rig : robots::world {
    explicit rig(options::ramp reading, const axis_profile& by = limits)
        : world{machine, base, options_of(reading), {.feedback = 20_ms, .command_timeout = 400_ms}} {
        REQUIRE(robot.set_limits(by) == errc::ok);
        REQUIRE(robot.run(take_over{zlac8015d::watchdog{500 * units::millisecond}}));
        REQUIRE(robot.run(enable{}));
    }
    static options options_of(options::ramp reading) {
        options o;
        o.speed_ramp = reading;
        return o;
    }
    wheel_speeds_now speeds() const {
        return {static_cast<long double>(drive.left().speed) / 1e6L,
                static_cast<long double>(drive.right().speed) / -1e6L};
    }
    /// Begins a twist every 20 ms, as a joystick gives it, and looks at the wheels: `look(ms)`.
    template <class Stick, class Look> void drive_by(const Stick& stick, std::uint32_t ms, const Look& look) {
        const std::uint64_t start = wire.time_us();
        const auto now = [&] { return static_cast<std::uint32_t>((wire.time_us() - start) / 1000); };
        for (std::uint32_t next = 0; now() < ms;) {
            if (now() >= next) {
                CHECK(robot.begin(stick(now())) == errc::ok);
                next += 20;
            }
            const duration idle = robot.step();
            wait(idle.us == 0 ? microseconds(20) : idle.us > 500 ? microseconds(500) : idle);
            look(now());
        }
    }
    /// The greatest change of a wheel's speed in some 20 ms until both stand, r/min in a second.
    long double steepest_stop(const std::function<void()>& pass) {
        struct sample {
            wheel_speeds_now speeds;
            std::uint64_t us;
        };
        std::vector<sample> seen;
        long double steepest = 0;
        for (int i = 0; i < 20'000 && !drive.stands_still(); ++i) {
            seen.push_back({speeds(), wire.time_us()});
            pass();
            const auto is_old = [&](const sample& s) { return wire.time_us() - s.us >= 20'000; };
            while (seen.size() > 1 && is_old(seen[1])) seen.erase(seen.begin());
            const auto took = static_cast<long double>(wire.time_us() - seen.front().us) / 1e6L;
            if (!is_old(seen.front())) continue;
            const long double left = std::abs(seen.front().speeds.left - speeds().left);
            const long double right = std::abs(seen.front().speeds.right - speeds().right);
            steepest = std::max({steepest, left / took, right / took});
        }
        REQUIRE(drive.stands_still());
        return steepest;
    }
};

constexpr twist still{}, full{1_m_per_s, 0_rad_per_s};
twist twist_of(long double mm_per_s, long double mrad_per_s) {
    return {.speed = decltype(twist::speed){static_cast<std::int32_t>(std::lround(mm_per_s * 1000))},
            .turn = decltype(twist::turn){static_cast<std::int32_t>(std::lround(mrad_per_s * 1000))}};
}

/// Both wheels in each millisecond as the limits alone allow it, each change cut by one factor.
class ideal {
  public:
    template <class Stick> ideal(const Stick& stick, std::uint32_t ms) {
        for (std::uint32_t t = 0; t < ms; ++t) follow(stick(t / 20 * 20));
    }
    /// True if at `ms` the wheels have a speed that they were to have in the 60 ms before, or one between. Setpoints
    /// are a stair: each is for the 20 ms that follow.
    bool was_followed_by(const wheel_speeds_now& real, std::uint32_t ms) const {
        wheel_speeds_now low = at(ms), high = low;
        for (std::uint32_t t = ms < 60 ? 0 : ms - 60; t <= ms + 20; ++t) {
            const wheel_speeds_now then = ms < 60 && t == 0 ? wheel_speeds_now{} : at(t);
            low = {std::min(low.left, then.left), std::min(low.right, then.right)};
            high = {std::max(high.left, then.left), std::max(high.right, then.right)};
        }
        const auto is_in = [](long double v, long double l, long double h) {
            return v >= l - 1 && v <= h + 1; // r/min, of which a count is one
        };
        return is_in(real.left, low.left, high.left) && is_in(real.right, low.right, high.right);
    }

  private:
    const wheel_speeds_now& at(std::uint32_t ms) const {
        return past_[std::min<std::size_t>(ms, past_.size() - 1)];
    }
    void follow(const twist& by) {
        const long double speed = by.speed.count() / 1e6L * 100; // r/min
        const long double side = by.turn.count() / 1e6L * 0.25L * 100;
        const long double left = speed - side - now_.left, right = speed + side - now_.right;
        const long double part = std::min({1.0L, allowed(now_.left, left), allowed(now_.right, right)});
        now_.left += part * left;
        now_.right += part * right;
        past_.push_back(now_);
    }
    static long double allowed(long double now, long double change) {
        if (change == 0) return 1;
        const bool slows = now * change < 0;
        return (slows ? slower : faster) / 1000 / std::abs(change);
    }

    wheel_speeds_now now_{};
    std::vector<wheel_speeds_now> past_{};
};

} // namespace

TEST_CASE(
    "a robot follows a joystick within 60 ms of what its limits allow, whatever its drive's ramps are") {
    using stick = std::function<twist(std::uint32_t)>;
    const long double turn = 2 * std::acos(-1.0L);
    const stick sticks[]{
        [](std::uint32_t t) { return t < 1500 ? full : still; },
        [](std::uint32_t t) { return t < 900 ? twist_of(800, 600) : twist_of(-600, 1000); },
        [](std::uint32_t t) { return t / 700 % 2 == 0 ? twist_of(0, 2000) : twist_of(0, -2000); },
        [=](std::uint32_t t) { return twist_of(600 * std::sin(turn * t / 4000), 0); },
        [=](std::uint32_t t) { return twist_of(500, 1500 * std::sin(turn * t / 1500)); },
        [=](std::uint32_t t) {
            return twist_of(900 * std::sin(turn * t / 1000), 800);
        }, // more than they allow
    };
    for (const options::ramp reading : readings)
        for (const std::uint16_t resolution : {std::uint16_t{1}, std::uint16_t{10}})
            for (std::size_t k = 0; k < std::size(sticks); ++k) {
                CAPTURE(static_cast<int>(reading));
                CAPTURE(k);
                rig r{reading};
                if (resolution != 1) {
                    r.drive.store(zlac8015d::speed_resolution.address, resolution);
                    r.drive.power_cycle();
                    REQUIRE(r.robot.run(init{}));
                    REQUIRE(r.robot.run(enable{}));
                }
                const ideal wanted{sticks[k], 4000};
                unsigned behind = 0;
                r.drive_by(sticks[k], 4000, [&](std::uint32_t t) {
                    if (!wanted.was_followed_by(r.speeds(), t)) ++behind;
                });
                CHECK(behind == 0);
            }
}

TEST_CASE("both wheels arrive together: the robot keeps to its arc while it changes its speed") {
    for (const options::ramp reading : readings) {
        rig r{reading};
        unsigned seen = 0;
        r.drive_by([](std::uint32_t) { return twist_of(600, 1600); }, 1000,
                   [&](std::uint32_t) { // 20 and 100 r/min
                       const wheel_speeds_now now = r.speeds();
                       CHECK(std::abs(now.right - 5 * now.left) <=
                             6); // a count of the left one is five of the right one
                       seen += now.right > 10 && now.right < 90;
                   });
        CHECK(seen > 300);
    }
}

TEST_CASE("a program that dies at full speed: the drive stops the robot no harder than the limits") {
    struct ending {
        std::string name;
        std::function<void(rig&)> begin;
        bool lives; ///< the program goes on
    };
    const ending endings[]{
        {"the program dies", [](rig&) {}, false},
        {"the line is cut", [](rig& r) { r.wire.unplug(); }, true},
        {"a wired stop", [](rig& r) { r.drive.set_input(true, false); }, true},
        {"quick stop", [](rig& r) { CHECK(r.robot.begin(quick_stop{}) == errc::ok); }, true},
    };
    for (const options::ramp reading : readings)
        for (const ending& e : endings) {
            CAPTURE(e.name);
            rig r{reading};
            r.drive_by([](std::uint32_t) { return full; }, 1500, [](std::uint32_t) {});
            CHECK(r.speeds().left == doctest::Approx(100).epsilon(0.01));
            e.begin(r);
            const long double steepest = r.steepest_stop([&] { e.lives ? r.live(1_ms) : r.wait(1_ms); });
            MESSAGE(e.name, ": ", static_cast<double>(steepest), " r/min in a second");
            CHECK(steepest <= slower * 1.01L); // the drive's ticks
            CHECK(steepest > slower / 4);
        }
}

TEST_CASE("no stop waits for the limits: zero speeds, 07h and the command timeout leave at once") {
    for (const options::ramp reading : readings)
        for (const int how : {0, 1, 2}) {
            CAPTURE(how);
            rig r{reading};
            r.drive_by([](std::uint32_t) { return full; }, 1000, [](std::uint32_t) {});
            if (how == 0) CHECK(r.robot.begin(halt{}) == errc::ok);
            if (how == 1) CHECK(r.robot.begin(disable{}) == errc::ok);
            if (how == 2) r.live(400_ms); // no twist any more
            r.live(60_ms);
            CHECK(r.drive.stands_still());
        }
}

TEST_CASE("after a stop, and where a setpoint has had no response, the way begins at the measured speeds") {
    for (const options::ramp reading : readings) {
        rig r{reading};
        const auto ordered = [&] { return static_cast<std::int16_t>(r.drive.peek(0x2088)); };
        r.drive_by([](std::uint32_t) { return full; }, 300, [](std::uint32_t) {});
        REQUIRE(r.robot.run(halt{}));
        CHECK(r.robot.begin(full) == errc::ok);
        r.live(10_ms);
        CHECK(ordered() == 4); // 20 ms of 200 r/min in a second
        r.drive_by([](std::uint32_t) { return full; }, 200, [](std::uint32_t) {});
        const int before = ordered();
        CHECK(before > 35);
        // The setpoint is lost, and its read-back says so.
        r.wire.faults().lost_request = 1000;
        CHECK(r.robot.begin(full) == errc::ok);
        r.live(8_ms);
        r.wire.faults() = {};
        for (int ms = 0; ms < 600 && !r.robot.is_idle(); ++ms) r.live(1_ms);
        CHECK_FALSE(r.robot.last());
        REQUIRE(r.robot.state() == drive_state::enabled);
        CHECK_FALSE(r.robot.is_changing_speed());
        CHECK(r.robot.begin(full) == errc::ok);
        r.live(10_ms);
        CHECK(ordered() <= static_cast<int>(r.speeds().left) + 5);
    }
}

TEST_CASE(
    "a setpoint steps by the time since the one before, 100 ms at most, however often the program commands") {
    rig r{options::ramp::begins_anew, {.top = 2_m_per_s, .acceleration = 1_s, .deceleration = 1_s}};
    const auto ordered = [&] { return static_cast<std::int16_t>(r.drive.peek(0x2088)); };
    const auto order = [&] {
        const std::uint64_t begun = r.wire.time_us();
        CHECK(r.robot.begin(twist_of(2000, 0)) == errc::ok);
        while (!r.robot.is_idle()) r.live(1_ms);
        return begun;
    };
    const auto step_after = [&](duration pause) {
        const std::uint64_t before = order();
        const int first = ordered();
        while (r.wire.time_us() - before < pause.us) r.live(1_ms);
        const std::uint64_t took = std::min<std::uint64_t>(order() - before, 100'000);
        const long double by_time = static_cast<long double>(took) / 1e6L * 200; // r/min
        CHECK(std::abs(ordered() - first - by_time) <= 1);
        return ordered() - first;
    };
    CHECK(step_after(20_ms) >= 4);
    CHECK(step_after(50_ms) >= 10);
    CHECK(step_after(100_ms) == 20);
    CHECK(step_after(300_ms) == 20);
}

TEST_CASE("`run` brings the robot to its twist within the limits; `begin` orders one setpoint") {
    for (const options::ramp reading : readings) {
        rig r{reading};
        const std::uint64_t start = r.wire.time_us();
        REQUIRE(r.robot.run(full));
        const std::uint64_t took = r.wire.time_us() - start;
        CHECK(took > 450'000);
        CHECK(took < 560'000);
        CHECK_FALSE(r.robot.is_changing_speed());
        r.live(20_ms);
        CHECK(r.speeds().left == doctest::Approx(100).epsilon(0.01));
        CHECK(r.robot.begin(still) == errc::ok);
        CHECK(r.robot.is_changing_speed());
        r.live(20_ms);
        REQUIRE(r.robot.run(still));
        CHECK_FALSE(r.robot.is_changing_speed());
        REQUIRE(r.robot.run(disable{}));
        CHECK(r.robot.run(full).error() == errc::wrong_state);
    }
}

TEST_CASE("`init` writes short ramps and the time of a stop without the program, again after each restart") {
    const auto words = [](rig& r) {
        std::vector<int> all;
        for (std::uint16_t at = 0x2080; at <= 0x2085; ++at) all.push_back(r.drive.peek(at));
        all.push_back(r.drive.peek(0x2011));
        return all;
    };
    rig r{options::ramp::begins_anew};
    const std::vector<int> written{10, 10, 10, 10, 469, 469, 6}; // 250 ms and a S-shaped ramp's 15/8
    CHECK(words(r) == written);
    r.drive.power_cycle();
    CHECK(words(r) == std::vector<int>{500, 500, 500, 500, 10, 10, 5});
    r.live(600_ms);
    REQUIRE(r.robot.state() == drive_state::needs_init);
    REQUIRE(r.robot.run(init{}));
    CHECK(words(r) == written);
    robots::world unlimited{machine, base};
    REQUIRE(unlimited.robot.run(init{}));
    CHECK(unlimited.drive.peek(0x2084) == 500); // as from the factory by 2082h
    CHECK(unlimited.drive.peek(0x2085) == 500);
}

TEST_CASE("limits that are none are refused, and change nothing") {
    rig r{options::ramp::begins_anew};
    CHECK(r.robot.set_limits(limits) == errc::wrong_state); // it is enabled
    REQUIRE(r.robot.run(disable{}));
    const auto refusal = [&](const axis_profile& by) { return r.robot.set_limits(by); };
    CHECK(refusal({}) == errc::bad_argument);
    CHECK(refusal({.top = 1_m_per_s, .acceleration = 500_ms}) == errc::bad_argument);
    CHECK(refusal({.top = 1_m_per_s, .acceleration = 500_ms, .deceleration = 1_s, .start = 1_mm_per_s}) ==
          errc::bad_argument);
    CHECK(refusal({.top = 33_m_per_s, .acceleration = 10_s, .deceleration = 10_s}) == errc::out_of_range);
    CHECK(refusal({.top = 32_m_per_s, .acceleration = 480_ms, .deceleration = 10_s}) == errc::out_of_range);
    CHECK(refusal({.top = 32_m_per_s, .acceleration = 10_s, .deceleration = 480_ms}) == errc::out_of_range);
    CHECK(refusal({.top = 1_mm_per_s, .acceleration = 17_s, .deceleration = 500_ms}) == errc::out_of_range);
    CHECK(refusal({.top = 1_m_per_s, .acceleration = 17'001_ms, .deceleration = 500_ms}) ==
          errc::out_of_range);
    CHECK(refusal({.top = 1_m_per_s, .acceleration = 500_ms, .deceleration = 17'001_ms}) ==
          errc::out_of_range);
    REQUIRE(r.robot.run(enable{}));
    REQUIRE(r.robot.run(full));
    CHECK(r.drive.peek(0x2088) == 100);
    REQUIRE(r.robot.run(halt{}));
    REQUIRE(r.robot.run(disable{}));
    CHECK(refusal({.top = 32_m_per_s, .acceleration = 17_s, .deceleration = 17_s}) == errc::ok);
}

TEST_CASE("no wheel is faster than the top speed: both slow down by one factor") {
    for (const std::uint16_t resolution : {std::uint16_t{1}, std::uint16_t{10}}) {
        rig r{options::ramp::linear};
        r.drive.store(zlac8015d::speed_resolution.address, resolution);
        r.drive.power_cycle();
        REQUIRE(r.robot.run(init{}));
        REQUIRE(r.robot.run(enable{}));
        REQUIRE(r.robot.run(twist_of(1500, 2000))); // 100 and 200 r/min
        r.live(100_ms);
        CHECK(r.speeds().left == doctest::Approx(50).epsilon(0.02));
        CHECK(r.speeds().right == doctest::Approx(100).epsilon(0.01));
    }
}

TEST_CASE("speeds of the drive's own are a setpoint too; a setting leaves the one before") {
    for (const options::ramp reading : readings)
        for (std::uint32_t phase = 20; phase <= 50; phase += 5) {
            rig r{reading};
            const auto ordered_by = [&](const twist& by) {
                CHECK(r.robot.begin(by) == errc::ok);
                while (!r.robot.is_idle()) r.live(microseconds(100));
                return static_cast<std::int16_t>(r.drive.peek(0x2088));
            };
            REQUIRE(r.robot.run(full));
            r.live(milliseconds(phase));
            REQUIRE(r.robot.run(zlac8015d::wheel_velocities{}));
            r.live(10_ms);
            CHECK(ordered_by(twist_of(100, 0)) == 4); // it stands
            REQUIRE(r.robot.run(halt{}));
            REQUIRE(r.robot.run(velocity{100 * units::r_per_min, -100 * units::r_per_min}));
            r.live(10_ms);
            CHECK(ordered_by(full) == 100);
            REQUIRE(r.robot.run(zlac8015d::watchdog{600 * units::millisecond}));
            CHECK(ordered_by(full) == 100);
        }
    robots::world slow{machine, base, {}, unsupervised};
    REQUIRE(slow.robot.set_limits(limits) == errc::ok);
    REQUIRE(slow.robot.run(init{}));
    REQUIRE(slow.robot.run(enable{}));
    REQUIRE(slow.robot.run(full));
    REQUIRE(slow.robot.read());
    REQUIRE(slow.robot.run(still));
    REQUIRE(slow.robot.run(zlac8015d::watchdog{600 * units::millisecond}));
    CHECK(slow.robot.begin(full) == errc::ok);
    while (!slow.robot.is_idle()) slow.live(1_ms);
    CHECK(slow.drive.peek(0x2088) <= 20); // 100 ms at most
}

TEST_CASE("low limits move the wheels too; a top speed below a count is refused") {
    rig r{options::ramp::linear,
          {.top = 17_mm_per_s, .acceleration = 17_s, .deceleration = 17_s}}; // 0.1 r/min in a second
    for (std::uint32_t ms = 0; ms < 17'500; ms += 20) {
        (void)r.robot.begin(full);
        r.live(20_ms);
    }
    CHECK(r.drive.peek(0x2088) == 1);
    rig none{options::ramp::linear, {.top = 9_mm_per_s, .acceleration = 1_s, .deceleration = 1_s}};
    CHECK(none.robot.begin(full) == errc::out_of_range);
}

TEST_CASE("what `init` has written is not undone: ramps and the stop without the program") {
    rig r{options::ramp::begins_anew};
    REQUIRE(r.robot.run(disable{}));
    using zlac8015d::time;
    CHECK(r.robot.begin(zlac8015d::ramps{time{500}, time{500}}) == errc::bad_argument);
    CHECK(r.robot.begin(zlac8015d::quick_stop_ramp{time{10}}) == errc::bad_argument);
    CHECK(r.robot.begin(zlac8015d::quick_stop_by{zlac8015d::quick_stop_option::immediate}) ==
          errc::bad_argument);
    CHECK(r.drive.peek(0x2080) == 10);
    CHECK(r.drive.peek(0x2084) == 469);
}

TEST_CASE("a restart ends that the robot changes its speed") {
    rig r{options::ramp::begins_anew};
    CHECK(r.robot.begin(full) == errc::ok);
    r.live(20_ms);
    CHECK(r.robot.is_changing_speed());
    r.drive.power_cycle();
    r.live(600_ms);
    REQUIRE(r.robot.state() == drive_state::needs_init);
    CHECK_FALSE(r.robot.is_changing_speed());
}

namespace {
constexpr node<zlac8015d::device> at{1};
constexpr poll_plan plan{modbus::timing_at(115200),
                         controlled(at, {.feedback = milliseconds(25), .command_timeout = milliseconds(500)})
                             .commands(milliseconds(50))};

/// A line whose clock stops when it is told to.
struct frozen_wire : sim::virtual_line {
    using sim::virtual_line::virtual_line;
    std::function<bool()> is_time{};
    bool is_frozen = false;
    instant stopped{};
    unsigned looks = 0;

    instant now() {
        if (!is_frozen) return sim::virtual_line::now();
        REQUIRE(++looks < 1'000'000);
        return stopped;
    }
    void wait(duration d) {
        if (is_frozen) return;
        sim::virtual_line::wait(d);
        if (!is_time || !is_time()) return;
        stopped = sim::virtual_line::now();
        is_frozen = true;
    }
};
} // namespace

TEST_CASE("a bus runs a twist until it is reached") {
    robots::observed_drive drive{machine, {}};
    sim::station<robots::observed_drive> station{drive};
    sim::virtual_line wire{115200};
    wire.attach(station);
    scheduled_line on{wire, modbus::timing_at(115200)};
    zlac8015d::robot robot{on, 1, base, unsupervised};
    REQUIRE(robot.set_limits(limits) == errc::ok);
    auto all = make_bus<plan>(on, robot);
    REQUIRE(all.run(robot, init{}));
    REQUIRE(all.run(robot, enable{}));
    REQUIRE(all.run(robot, full));
    CHECK(drive.peek(0x2088) == 100);
    CHECK_FALSE(robot.is_changing_speed());
    REQUIRE(all.blocking(robot).run(still));
    CHECK(drive.peek(0x2088) == 0);
}

TEST_CASE("a clock that stops between two setpoints ends a blocking call") {
    robots::observed_drive drive{machine, {}};
    sim::station<robots::observed_drive> station{drive};
    frozen_wire wire{115200};
    wire.attach(station);
    line<frozen_wire> on{wire, modbus::timing_at(115200)};
    zlac8015d::robot robot{on, 1, base, {.feedback = 20_ms, .command_timeout = 400_ms}};
    REQUIRE(robot.set_limits(limits) == errc::ok);
    REQUIRE(robot.run(init{}));
    REQUIRE(robot.run(enable{}));
    wire.is_time = [&] { return robot.is_idle() && robot.is_changing_speed(); };
    CHECK(robot.run(full).error() == errc::clock_stopped);
}

} // namespace robot_shaping_tests
