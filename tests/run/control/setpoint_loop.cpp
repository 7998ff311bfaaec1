// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A setpoint loop: the frames of a loop that was written by hand, consents that are used once, motion that never begins
// by itself, ends that are reported once. Judged by the simulated machines and by the frames on the wire.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/control/setpoint_loop.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace setpoint_loop_tests {

using namespace servobus;
using namespace servobus::units;
namespace z = servobus::zlac8015d;
namespace y = servobus::yako;
namespace c = servobus::c630s;
using part = take_over_part;

namespace {

constexpr auto wheel_settings = take_over{z::resolution{10}, z::watchdog{500 * millisecond},
                                          z::ramps{200 * millisecond, 200 * millisecond}};
constexpr supervision supervised{.feedback = milliseconds(20), .command_timeout = milliseconds(200)};
using wheels_drive = decltype(simulated::driven_zlac8015d::drive);

constexpr z::clamped_velocity at_speed(std::int32_t r_per_minute) {
    return {r_per_minute * r_per_min, -(r_per_minute * r_per_min)};
}

// The loop of a robot's program as it was written by hand, without its odometry and its messages.
class loop_by_hand {
  public:
    explicit loop_by_hand(wheels_drive& d) : wheels_{d} {}
    void want(const z::clamped_velocity& v) { wanted_ = v; }
    void operator_enables() { may_enable_ = true; }
    void operator_resets() { may_reset_ = true; }
    duration step() {
        const duration idle = wheels_.step();
        if (wheels_.is_idle()) command();
        return idle;
    }

  private:
    enum class what { nothing, init, setting, other };
    void command() {
        const instant now = wheels_.line().now();
        const auto state = wheels_.state();
        if (asked_ != what::nothing) {
            const auto& last = wheels_.last();
            if (last && asked_ == what::init) setting_ = 0;
            if (last && asked_ == what::setting) ++setting_;
            asked_ = what::nothing;
        }
        if (state == drive_state::needs_init) {
            if (since(tried_, now) < milliseconds(1000)) return;
            tried_ = now;
            return start(init{}, what::init);
        }
        if (state == drive_state::faulted) {
            if (may_reset_) {
                may_reset_ = false;
                start(fault_reset{}, what::other);
            }
            return;
        }
        if (state == drive_state::quick_stopped || state == drive_state::disabled) {
            const bool is_disabled = state == drive_state::disabled;
            if (is_disabled && setting_ == 0) return start(z::resolution{10}, what::setting);
            if (is_disabled && setting_ == 1) return start(z::watchdog{500 * millisecond}, what::setting);
            if (is_disabled && setting_ == 2)
                return start(z::ramps{200 * millisecond, 200 * millisecond}, what::setting);
            if (may_enable_) {
                may_enable_ = false;
                start(enable{}, what::other);
            }
            return;
        }
        if (since(commanded_, now) < milliseconds(20)) return;
        commanded_ = since(commanded_, now) < milliseconds(40) ? commanded_ + milliseconds(20) : now;
        start(wanted_, what::other);
    }
    template <class C> void start(const C& command, what w) {
        if (wheels_.begin(command) == errc::ok) asked_ = w;
    }

    wheels_drive& wheels_;
    z::clamped_velocity wanted_{};
    bool may_enable_ = false;
    bool may_reset_ = false;
    int setting_ = 0;
    what asked_ = what::nothing;
    instant tried_{};
    instant commanded_{};
};

// The same calls for the library's loop.
class loop_of_library {
  public:
    explicit loop_of_library(wheels_drive& d)
        : loop_{d, wheel_settings, enable{}, setpoints<z::clamped_velocity>{}} {}
    void want(const z::clamped_velocity& v) { loop_.set(v); }
    void operator_enables() { loop_.enable(); }
    void operator_resets() { (void)loop_.reset_faults(); }
    duration step() {
        const duration idle = loop_.step();
        (void)loop_.take_report();
        return idle;
    }

  private:
    setpoint_loop<wheels_drive, decltype(wheel_settings), enable, setpoints<z::clamped_velocity>> loop_;
};

// What happens, and how often it did.
struct events {
    unsigned faults = 0;
    unsigned restarts = 0;
    unsigned lost_frames = 0;
    unsigned lost_links = 0;
    unsigned lost_ports = 0;
    unsigned wired_stops = 0;
    unsigned setpoints = 0;
    unsigned enables = 0;
};

template <class Loop> struct robot {
    simulated::finer_zlac8015d r{{}, supervised};
    Loop loop{r.drive};
    std::vector<simulated::frame> frames; // all but the reads of the feedback and of the witness
    std::size_t seen = 0;
    unsigned lose_setpoint = 0; // this one gets no response
    bool loses_enable = false;
    bool is_absent = false; // which of its requests get no response depends on what was under way
    events played;

    void go(std::uint32_t ms, std::int32_t speed) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            loop.want(at_speed(speed));
            const duration idle = loop.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            note();
        }
    }
    void note() {
        for (; seen < r.log.frames.size(); ++seen) {
            const simulated::frame& f = r.log.frames[seen];
            const unsigned address = load_word(f, 2);
            r.wire.faults().lost_response = 0;
            if (f[1] == 0x03 && (address == 0x20A2 || address == 0x200D)) continue;
            if (!is_absent) frames.push_back(f);
            if (f[1] == 0x10 && address == 0x2088 && ++played.setpoints == lose_setpoint) lose();
            if (f[1] == 0x06 && address == 0x200E && f[5] == 0x08) {
                ++played.enables;
                if (loses_enable) lose();
                loses_enable = false;
            }
        }
    }
    void lose() {
        r.wire.faults().lost_response = 1000;
        ++played.lost_frames;
    }
    void play() {
        r.wire.pass(milliseconds(2000)); // the loop by hand waits a second after the clock's start
        loop.operator_enables();
        go(1500, 0);
        go(2000, 30);
        go(1000, 2000); // above what the drive can
        go(500, 0);
        go(500, 30);
        r.model.raise(z::fault::none, z::fault::overcurrent);
        ++played.faults;
        go(500, 30);
        r.model.end_faults();
        loop.operator_resets();
        go(500, 30);
        loop.operator_enables();
        go(1000, 30);
        r.wire.set_connected(0, false);
        is_absent = true;
        ++played.lost_links;
        go(3300, 30);
        r.wire.set_connected(0, true);
        go(5000, 30); // the loop's next attempt comes within 4 s
        is_absent = false;
        loop.operator_enables();
        go(1000, 30);
        r.model.set_input(true, false);
        ++played.wired_stops;
        go(500, 30);
        r.model.set_input(false, false);
        loop.operator_enables();
        go(1000, 30);
        r.model.power_cycle();
        ++played.restarts;
        go(2500, 30);
        loop.operator_enables();
        go(1000, 30);
        for (int i = 0; i < 3; ++i) {
            lose_setpoint = played.setpoints + 7;
            go(1000, 20 + i);
        }
        go(1500, 30);
        r.wire.unplug();
        ++played.lost_ports;
        go(1700, 30);
        r.wire.plug();
        r.log.open.clear(); // a request that the lost port has cut
        go(2000, 30);
        loses_enable = true;
        loop.operator_enables();
        go(3000, 30);
        loop.operator_enables();
        go(1000, 30);
    }
};

struct frame_run {
    simulated::frame frame;
    std::size_t count;
};
std::vector<frame_run> runs_of(const std::vector<simulated::frame>& frames) {
    std::vector<frame_run> runs;
    for (const simulated::frame& f : frames) {
        if (!runs.empty() && runs.back().frame == f)
            ++runs.back().count;
        else
            runs.push_back({f, 1});
    }
    return runs;
}
bool is_same(const frame_run& a, const frame_run& b) {
    return a.frame == b.frame && a.count <= b.count + 1 && b.count <= a.count + 1;
}

} // namespace

TEST_CASE("a setpoint loop sends the frames of the loop that a program wrote by hand") {
    robot<loop_by_hand> a;
    robot<loop_of_library> b;
    a.play();
    b.play();
    // A setpoint that lasts is sent every period: once more or less, as the periods fall.
    const auto by_hand = runs_of(a.frames);
    const auto by_loop = runs_of(b.frames);
    CHECK(a.frames.size() > 700);
    CHECK(by_hand.size() > 60);
    CHECK(by_hand.size() == by_loop.size());
    std::size_t same = 0;
    while (same < by_hand.size() && same < by_loop.size() && is_same(by_hand[same], by_loop[same])) ++same;
    CHECK(same == by_hand.size());
    for (const events& e : {a.played, b.played}) {
        CHECK(e.faults == 1);
        CHECK(e.restarts == 1);
        CHECK(e.lost_links == 1);
        CHECK(e.lost_ports == 1);
        CHECK(e.wired_stops == 1);
        CHECK(e.lost_frames == 4);
        CHECK(e.enables >= 6);
        CHECK(e.setpoints > 400);
    }
    CHECK(b.r.model.enabled());
}

namespace {

// Wheels in a loop, with all that was reported.
struct rig {
    simulated::finer_zlac8015d r{{}, supervised};
    setpoint_loop<wheels_drive, decltype(wheel_settings), enable, setpoints<z::wheel_velocities>> loop{
        r.drive, wheel_settings, enable{}, setpoints<z::wheel_velocities>{}};
    std::vector<loop_report> reports;

    void turn() {
        const duration idle = loop.step();
        if (const loop_report ended = loop.take_report()) reports.push_back(ended);
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void go(std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) turn();
    }
    void go(std::uint32_t ms, std::int32_t speed) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            set(speed);
            turn();
        }
    }
    void set(std::int32_t speed) { loop.set({speed * r_per_min, speed * r_per_min}); }
    bool is_moving() const { return !r.model.stands_still(); }
    std::size_t motions() const {
        std::size_t n = 0;
        for (const simulated::frame& f : r.log.frames) n += simulated::is_motion_or_enable(f) ? 1u : 0u;
        return n;
    }
    std::size_t count(loop_part what, errc why) const {
        std::size_t n = 0;
        for (const loop_report& e : reports) n += e.what == what && e.how.error() == why ? 1u : 0u;
        return n;
    }
    void enable_and_turn() {
        go(300);
        loop.enable();
        go(500, 30);
        REQUIRE(is_moving());
        REQUIRE(loop.is_motion_allowed());
    }
};

} // namespace

TEST_CASE(
    "G44: a loop takes the drive over by itself, and neither energises nor moves it without a consent") {
    rig t;
    t.go(3000, 30);
    CHECK(t.loop.is_taken_over());
    CHECK(t.r.drive.cached().resolution == 10);
    CHECK(t.motions() == 0);
    CHECK_FALSE(t.r.model.enabled());
    REQUIRE(t.reports.size() == 1);
    CHECK(t.reports[0].what == loop_part::take_over);
    CHECK(t.reports[0].how);
    CHECK(t.reports[0].how.part() == part::reading);
    // A setpoint that was given before the consent is not begun.
    t.set(30);
    t.loop.enable();
    t.go(180); // while it is not too old
    CHECK(t.r.model.enabled());
    CHECK(t.motions() == 1); // the enable
    t.go(800);
    CHECK_FALSE(t.is_moving());
    CHECK(t.count(loop_part::enable, errc::ok) == 1);
    t.go(300, 30);
    CHECK(t.is_moving());
    REQUIRE(t.reports.size() == 2); // setpoints that succeed are not reported
    CHECK(t.reports[1].what == loop_part::enable);
    CHECK(t.reports[1].how.setting() == 0);
}

TEST_CASE("a setpoint that is given between the consent and its enable is begun") {
    rig t;
    t.loop.enable();
    t.go(400, 30); // the take-over, then the enable
    CHECK(t.is_moving());
}

TEST_CASE("a consent is withdrawn by a fault that the take-over finds") {
    rig t;
    t.r.model.raise(z::fault::overcurrent, z::fault::none);
    t.loop.enable();
    t.go(1000, 30);
    CHECK(t.loop.is_taken_over());
    CHECK(t.r.drive.state() == drive_state::faulted);
    t.r.model.end_faults();
    REQUIRE(t.loop.reset_faults());
    t.go(1000, 30);
    CHECK(t.r.drive.state() == drive_state::disabled);
    CHECK(t.motions() == 0);
}

TEST_CASE("G44: a consent is used once: by an enable, whether it succeeds or not") {
    rig t;
    t.go(300);
    t.r.model.raise(z::fault::overcurrent, z::fault::none); // not seen yet
    t.loop.enable();
    bool was_allowed = false;
    while (t.r.drive.state() != drive_state::faulted || !t.r.drive.is_idle()) {
        t.set(30);
        t.turn();
        was_allowed = was_allowed || t.loop.is_motion_allowed();
    }
    CHECK_FALSE(was_allowed);
    t.go(1000, 30);
    CHECK(t.r.drive.state() == drive_state::faulted);
    CHECK_FALSE(t.r.model.enabled());
    t.r.model.end_faults();
    REQUIRE(t.loop.reset_faults());
    t.go(1000, 30);
    CHECK(t.r.drive.state() == drive_state::disabled);
    CHECK(t.count(loop_part::fault_reset, errc::ok) == 1);
    CHECK(t.motions() == 0);
    t.loop.enable();
    t.go(1000, 30);
    CHECK(t.is_moving());
}

TEST_CASE("after a fault motion needs a reset and an enable, each by a consent") {
    rig t;
    CHECK_FALSE(t.loop.reset_faults()); // no consent in advance
    t.enable_and_turn();
    CHECK_FALSE(t.loop.reset_faults());
    t.r.model.raise(z::fault::overcurrent, z::fault::none);
    t.go(500, 30);
    CHECK(t.r.drive.state() == drive_state::faulted);
    CHECK_FALSE(t.is_moving());
    t.r.model.end_faults();
    std::size_t motions = t.motions();
    t.go(2000, 30);
    CHECK(t.r.drive.state() == drive_state::faulted); // nobody has consented
    CHECK(t.loop.reset_faults());
    t.go(1000, 30);
    CHECK(t.r.drive.state() == drive_state::disabled);
    CHECK(t.motions() == motions);
    CHECK_FALSE(t.loop.is_motion_allowed());
    t.loop.enable();
    t.go(500, 30);
    CHECK(t.is_moving());
    // A consent that is given before the fault is seen is withdrawn by it.
    t.r.model.raise(z::fault::overcurrent, z::fault::none);
    t.loop.enable();
    t.go(500, 30);
    t.r.model.end_faults();
    CHECK(t.loop.reset_faults());
    motions = t.motions();
    t.go(1000, 30);
    CHECK(t.motions() == motions);
    CHECK_FALSE(t.r.model.enabled());
}

TEST_CASE("motion that the drive has ended is reported once, at whatever moment that comes") {
    for (std::uint32_t us = 0; us < 20'000; us += 1000) {
        rig t;
        t.enable_and_turn();
        const std::uint64_t pressed = t.r.wire.time_us() + us;
        while (t.r.wire.time_us() < pressed) t.turn();
        t.reports.clear();
        t.r.model.set_input(true, false);
        t.go(1000, 30);
        CHECK_FALSE(t.loop.is_motion_allowed());
        REQUIRE(t.reports.size() == 1);
        CHECK(t.reports[0].what == loop_part::permission);
        CHECK(t.reports[0].how.error() == errc::wrong_state);
        CHECK(t.r.drive.cause() == stop_cause::input);
        t.r.model.set_input(false, false);
        t.loop.enable();
        t.go(1000, 30);
        CHECK(t.is_moving());
        t.r.model.set_input(true, false);
        t.go(1000, 30);
        CHECK(t.count(loop_part::permission, errc::wrong_state) == 2);
        CHECK(t.loop.quick_stop() == errc::ok); // the program's own stop is a `stop`
        t.go(100);
        CHECK(t.count(loop_part::permission, errc::wrong_state) == 2);
        CHECK(t.count(loop_part::stop, errc::ok) == 1);
    }
    rig t;
    t.enable_and_turn();
    t.reports.clear();
    t.r.model.raise(z::fault::overcurrent, z::fault::none);
    t.go(1000, 30);
    CHECK(t.count(loop_part::permission, errc::faulted) + t.count(loop_part::setpoint, errc::faulted) == 1);
    CHECK(t.reports.size() == 1);
    rig u;
    u.enable_and_turn();
    u.reports.clear();
    u.r.model.power_cycle();
    u.go(300, 30);
    CHECK(u.count(loop_part::permission, errc::needs_init) + u.count(loop_part::setpoint, errc::needs_init) ==
          1);
}

TEST_CASE("a consent to a fault reset is used once, though the fault lasts") {
    rig t;
    t.go(300);
    t.r.model.raise(z::fault::overcurrent, z::fault::none);
    t.go(500);
    REQUIRE(t.loop.reset_faults());
    t.go(3000);
    CHECK(t.r.drive.state() == drive_state::faulted);
    t.r.model.end_faults();
    t.go(1000);
    CHECK(t.r.drive.state() == drive_state::faulted);
    CHECK(t.reports.back().what == loop_part::fault_reset);
    CHECK_FALSE(t.reports.back().how);
}

TEST_CASE("what a drive refuses, or is busy for, is said at once, and changes nothing") {
    rig t;
    t.enable_and_turn();
    while (!t.r.drive.is_idle()) t.turn();
    CHECK(t.loop.begin(z::watchdog{33 * second}) == errc::out_of_range);
    t.go(300, 30);
    CHECK(t.is_moving());
    // The setpoints end, and the command timeout begins a stop.
    const std::uint64_t end = t.r.wire.time_us() + 1'000'000;
    bool was_busy = false;
    while (t.r.wire.time_us() < end && !was_busy) {
        t.turn();
        was_busy = !t.r.drive.is_idle() && t.r.drive.cause() == stop_cause::unknown &&
                   t.r.wire.time_us() > end - 780'000;
        if (was_busy) CHECK(t.loop.begin(z::watchdog{600 * millisecond}) == errc::busy);
    }
    CHECK(was_busy);
    t.go(1000);
    CHECK_FALSE(t.is_moving());
    CHECK(t.loop.begin(z::watchdog{600 * millisecond}) == errc::ok);
}

TEST_CASE("an enable that a wired stop has overtaken does not allow motion") {
    rig t;
    t.go(300);
    t.loop.enable();
    while (t.r.drive.is_idle()) t.turn(); // the enable is under way
    for (const std::uint64_t end = t.r.wire.time_us() + 1'000'000; t.r.wire.time_us() < end;) {
        if (t.r.drive.is_idle()) t.r.model.set_input(true, false);
        const duration idle = t.r.drive.step(); // a bus steps it, and the loop commands seldom
        t.r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(t.r.drive.state() == drive_state::quick_stopped);
    t.go(500, 30);
    CHECK_FALSE(t.loop.is_motion_allowed());
    CHECK_FALSE(t.is_moving());
    CHECK(t.count(loop_part::enable, errc::ok) == 1);
}

TEST_CASE("a take-over that fails otherwise than before is reported again") {
    rig t;
    t.r.wire.set_connected(0, false);
    t.go(5000);
    CHECK(t.count(loop_part::take_over, errc::timeout) == 1);
    t.r.wire.unplug();
    t.go(3000);
    CHECK(t.count(loop_part::take_over, errc::port_lost) >= 1); // sent in part, and then not sent
    CHECK(t.count(loop_part::take_over, errc::port_lost) <= 2);
    t.r.wire.plug();
    t.go(5000);
    CHECK(t.count(loop_part::take_over, errc::timeout) == 2);
    t.r.wire.set_connected(0, true);
    t.go(2000);
    CHECK(t.loop.is_taken_over());
}

TEST_CASE("G44: after a loss the drive is taken over again, and stays at rest until a consent") {
    rig t;
    t.enable_and_turn();
    SUBCASE("a restart") {
        t.r.model.power_cycle();
        t.go(40, 30); // the next feedback shows it
    }
    SUBCASE("a lost port") {
        t.r.wire.unplug();
        t.go(2500, 30);
        CHECK(t.count(loop_part::take_over, errc::port_lost) == 1); // of several attempts
        CHECK_FALSE(t.loop.is_taken_over());
        t.r.wire.plug();
    }
    SUBCASE("a lost link") {
        t.r.wire.set_connected(0, false);
        t.go(5500, 30);
        CHECK(t.count(loop_part::take_over, errc::timeout) == 1);
        t.r.wire.set_connected(0, true);
    }
    const std::size_t motions = t.motions();
    const std::size_t done = t.count(loop_part::take_over, errc::ok);
    t.go(2500, 30);
    CHECK(t.loop.is_taken_over());
    CHECK(t.count(loop_part::take_over, errc::ok) == done + 1);
    CHECK(t.motions() == motions);
    CHECK_FALSE(t.is_moving());
    CHECK_FALSE(t.r.model.enabled());
    t.loop.enable();
    t.go(500, 30);
    CHECK(t.is_moving());
}

TEST_CASE("a consent that is given before a loss is seen is withdrawn by it") {
    rig t;
    t.go(300);
    REQUIRE(t.loop.is_taken_over());
    t.r.wire.set_connected(0, false);
    for (int ms = 0; ms < 10'000 && t.r.drive.state() != drive_state::needs_init; ++ms) {
        (void)t.r.drive.step(); // as a bus steps it: the loop does not look yet
        t.r.wire.pass(milliseconds(1));
    }
    REQUIRE(t.r.drive.state() == drive_state::needs_init);
    t.r.wire.set_connected(0, true);
    t.loop.enable();
    t.go(3000, 30);
    CHECK(t.loop.is_taken_over());
    CHECK(t.motions() == 0);
}

TEST_CASE("a consent is withdrawn by a take-over that fails") {
    rig t;
    t.r.wire.set_connected(0, false);
    t.loop.enable(); // the operator believes that the drive is there
    t.go(3000, 30);
    t.r.wire.set_connected(0, true);
    t.go(5000, 30); // the attempts are 1, 2 and 4 s apart
    CHECK(t.loop.is_taken_over());
    CHECK(t.motions() == 0);
}

TEST_CASE("take-overs are tried once in a period, and a failure that is repeated is reported once") {
    rig t;
    t.r.wire.set_connected(0, false);
    t.go(10'300);
    REQUIRE(t.reports.size() == 1);
    CHECK(t.reports[0].what == loop_part::take_over);
    CHECK(t.reports[0].how.part() == part::init);
    CHECK(t.reports[0].how.error() == errc::timeout);
    CHECK(t.r.log.frames.size() >= 10); // an attempt a second
    CHECK(t.r.log.frames.size() <= 60);
}

TEST_CASE("a failure at another part of a take-over is another one") {
    detail::loop_reports reports;
    const auto failed = [](part at, std::uint8_t setting) {
        return loop_report{loop_part::take_over, command_status{errc::timeout}.in_part(at, setting)};
    };
    CHECK(reports.note(failed(part::setting, 1)));
    CHECK_FALSE(reports.note(failed(part::setting, 1)));
    CHECK(reports.note(failed(part::setting, 2)));
    CHECK(reports.note(failed(part::reading, 2)));
    CHECK(reports.take().how.part() == part::reading);
}

TEST_CASE("a setting that fails is reported with its number, and tried again") {
    simulated::finer_zlac8015d r{{}, supervised};
    setpoint_loop loop{r.drive, take_over{z::watchdog{500 * millisecond}, z::resolution{11}}};
    std::vector<loop_report> reports;
    const std::uint64_t end = r.wire.time_us() + 3'500'000;
    while (r.wire.time_us() < end) {
        r.wire.wait(loop.step());
        if (const loop_report ended = loop.take_report()) reports.push_back(ended);
    }
    REQUIRE(reports.size() == 1);
    CHECK(reports[0].how.part() == part::setting);
    CHECK(reports[0].how.setting() == 2);
    CHECK(reports[0].how.error() == errc::out_of_range);
    CHECK_FALSE(loop.is_taken_over());
    CHECK(loop.begin(read_feedback{}) == errc::needs_init);
}

TEST_CASE("a command is begun once the end of the one before was seen") {
    rig t;
    t.go(300);
    REQUIRE(t.loop.begin(read_feedback{}) == errc::ok);
    while (!t.r.drive.is_idle()) t.r.wire.wait(t.r.drive.step()); // as a bus steps it
    CHECK(t.loop.begin(z::ramps{300 * millisecond, 300 * millisecond}) == errc::busy);
    t.loop.command();
    CHECK(t.loop.take_report().what == loop_part::command);
    REQUIRE(t.loop.begin(z::ramps{300 * millisecond, 300 * millisecond}) == errc::ok);
    t.go(100);
    CHECK(t.r.model.peek(z::left_acceleration_time.address) == 300);
}

TEST_CASE("a stop goes before everything else, and motion needs a consent after it") {
    rig t;
    t.enable_and_turn();
    SUBCASE("halt") {
        CHECK(t.loop.halt() == errc::ok);
        t.go(1000, 30);
        CHECK(t.r.drive.state() == drive_state::enabled);
        CHECK(t.count(loop_part::stop, errc::ok) == 1);
        CHECK_FALSE(t.is_moving());
        CHECK(t.loop.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::wrong_state);
        constexpr auto energises = modbus::write_frame(1, 0x200E, 0x0008);
        const std::size_t enables = t.r.sent(energises);
        CHECK(enables == 1);
        t.loop.enable(); // it is energised: motion is allowed again
        t.go(500, 30);
        CHECK(t.r.sent(energises) == enables);
    }
    SUBCASE("quick stop") {
        CHECK(t.loop.quick_stop() == errc::ok);
        t.go(1000, 30);
        CHECK(t.r.drive.state() == drive_state::quick_stopped);
        CHECK_FALSE(t.is_moving());
        t.loop.enable();
        t.go(500, 30);
    }
    SUBCASE("disable") {
        CHECK(t.loop.disable() == errc::ok);
        t.go(1000, 30);
        CHECK(t.r.drive.state() == drive_state::disabled);
        CHECK_FALSE(t.r.model.enabled());
        t.loop.enable();
        t.go(500, 30);
    }
    CHECK(t.is_moving());
}

TEST_CASE("a stop withdraws a consent that waits, and ends a take-over") {
    rig t;
    t.loop.enable();
    for (int i = 0; i < 30; ++i) t.turn();
    CHECK(t.loop.disable() == errc::ok);
    t.go(3000, 30);
    CHECK(t.count(loop_part::stop, errc::ok) == 1);
    CHECK(t.loop.is_taken_over()); // by the next attempt
    CHECK(t.motions() == 0);
}

TEST_CASE(
    "a program that gives no setpoint any more is stopped by the command timeout, and goes on by a new one") {
    rig t;
    t.enable_and_turn();
    t.go(1000); // no set
    CHECK_FALSE(t.is_moving());
    CHECK(t.r.drive.state() == drive_state::enabled);
    t.go(500, 30);
    CHECK(t.is_moving());
}

TEST_CASE("the latest setpoint is begun every period") {
    rig t;
    t.enable_and_turn();
    const auto velocities = [&] {
        std::vector<unsigned> sent;
        for (const simulated::frame& f : t.r.log.frames) {
            if (f[1] == 0x10 && load_word(f, 2) == 0x2088) sent.push_back(load_word(f, 7));
        }
        return sent;
    };
    const std::size_t before = velocities().size();
    const std::uint64_t begun = t.r.wire.time_us();
    for (std::int32_t n = 0; t.r.wire.time_us() < begun + 1'000'000; ++n) {
        t.set(20 + n % 3);
        t.turn();
    }
    const std::size_t after = velocities().size();
    CHECK(after - before >= 49);
    CHECK(after - before <= 51);
    // One that the drive refuses is reported once; the next good one is sent.
    t.go(500, 30'000);
    CHECK(t.count(loop_part::setpoint, errc::out_of_range) == 1);
    CHECK(velocities().size() <= after + 2);
    t.go(300, 30);
    t.go(300, 30'000);
    CHECK(t.count(loop_part::setpoint, errc::out_of_range) == 2);
}

TEST_CASE("G44: on a bad line motion is only what was consented") {
    unsigned consents = 0;
    unsigned losses = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        CAPTURE(seed);
        rig t;
        t.r.wire.faults().lost_response = 60;
        t.r.wire.faults().lost_request = 20;
        bool was_allowed = false;
        std::size_t motions = 0;
        const std::uint64_t end = t.r.wire.time_us() + 20'000'000;
        sim::dice dice{seed};
        while (t.r.wire.time_us() < end) {
            t.set(30);
            if (dice.below(2000) == 0 && !t.loop.is_motion_allowed()) {
                t.loop.enable();
                ++consents;
                was_allowed = true; // until the consent has been used or withdrawn
            }
            t.turn();
            if (was_allowed && t.loop.is_motion_allowed()) was_allowed = false;
            if (!was_allowed && !t.loop.is_motion_allowed() && t.motions() > motions) {
                // A frame of a setpoint that was begun while motion was allowed may still leave.
                CHECK(t.motions() == motions + 1);
                ++losses;
            }
            motions = t.motions();
        }
    }
    CHECK(consents > 10);
    CHECK(losses < consents * 2);
}

TEST_CASE("a lift is moved through its loop") {
    simulated::closed_axis r;
    setpoint_loop loop{r.drive,
                       take_over{disable{}, y::set_input{y::input_terminal::x0, y::input_function::home},
                                 y::set_homing_profile{120 * r_per_min, 30 * r_per_min}}};
    std::vector<loop_report> reports;
    const auto go = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            const duration idle = loop.step();
            if (const loop_report ended = loop.take_report()) reports.push_back(ended);
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    constexpr y::motion_profile slow{5 * r_per_min, 100 * millisecond, 100 * millisecond, 120 * r_per_min};
    CHECK(loop.begin(move_by{1000 * pulse, slow}) == errc::needs_init);
    go(3000);
    REQUIRE(loop.is_taken_over());
    CHECK(r.drive.state() == drive_state::disabled);
    CHECK(loop.begin(move_by{1000 * pulse, slow}) == errc::wrong_state);
    CHECK(loop.begin(y::set_output{}) != errc::wrong_state);
    go(500);
    loop.enable();
    go(500);
    REQUIRE(loop.is_motion_allowed());
    const std::int64_t before = r.place();
    REQUIRE(loop.begin(move_by{500 * pulse, slow}) == errc::ok);
    CHECK(loop.begin(move_by{500 * pulse, slow}) == errc::busy);
    go(300);
    CHECK(loop.begin(wait_reached{}) == errc::ok);
    go(4000);
    CHECK(r.place() == before + 500);
    REQUIRE_FALSE(reports.empty());
    CHECK(reports.back().what == loop_part::command);
    CHECK(reports.back().how);
    // A wired stop ends that motion is allowed although the stepper stays energised.
    REQUIRE(loop.begin(move_by{2000 * pulse, slow}) == errc::ok);
    go(300);
    CHECK(loop.halt() == errc::ok);
    go(1000);
    CHECK(r.drive.state() == drive_state::enabled);
    CHECK_FALSE(r.is_moving());
    CHECK(loop.begin(move_by{500 * pulse, slow}) == errc::wrong_state);
}

TEST_CASE("a stepper that a wired stop has stopped stays at rest once that is released") {
    simulated::closed_axis r;
    setpoint_loop loop{r.drive,
                       take_over{disable{}, y::set_input{y::input_terminal::x3, y::input_function::stop}},
                       enable{}, setpoints<y::bounded_jog>{}};
    constexpr y::motion_profile slow{5 * r_per_min, 100 * millisecond, 100 * millisecond, 60 * r_per_min};
    unsigned refused = 0;
    const auto go = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            loop.set({200 * pulse, slow});
            const duration idle = loop.step();
            if (const loop_report ended = loop.take_report(); ended.how.error() == errc::not_executed)
                ++refused;
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    go(1000);
    loop.enable();
    go(1000);
    CHECK(r.place() > 300);
    r.model.set_input(3, true);
    go(1000);
    CHECK(refused == 1);
    CHECK(r.drive.state() == drive_state::enabled);
    CHECK_FALSE(loop.is_motion_allowed());
    const std::int64_t stopped_at = r.place();
    r.model.set_input(3, false);
    go(2000);
    CHECK(r.place() == stopped_at);
    loop.enable();
    go(1000);
    CHECK(r.place() > stopped_at + 300);
}

TEST_CASE(
    "a setpoint that says that the motor is elsewhere, or not there in time, ends that motion is allowed") {
    constexpr y::motion_profile slow{5 * r_per_min, 100 * millisecond, 100 * millisecond, 60 * r_per_min};
    const auto play = [&](std::int32_t way, wait_reached wait, bool is_stopped) {
        simulated::closed_axis r;
        setpoint_loop loop{r.drive,
                           take_over{disable{}, y::set_input{y::input_terminal::x3, y::input_function::stop}},
                           enable{}, setpoints<wait_reached>{}};
        errc seen = errc::ok;
        const auto go = [&](std::uint32_t ms) {
            const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
            while (r.wire.time_us() < end) {
                const duration idle = loop.step();
                if (const loop_report ended = loop.take_report(); ended.what == loop_part::setpoint)
                    seen = ended.how.error();
                r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            }
        };
        go(1000);
        loop.enable();
        go(500);
        REQUIRE(loop.is_motion_allowed());
        REQUIRE(loop.begin(move_by{way * pulse, slow}) == errc::ok);
        go(300);
        r.model.set_input(3, is_stopped);
        loop.set(wait);
        go(1500);
        CHECK(loop.is_motion_allowed() == (seen == errc::ok));
        CHECK(r.drive.state() == drive_state::enabled);
        return seen;
    };
    CHECK(play(20, {}, false) == errc::ok);
    CHECK(play(5000, {milliseconds(200)}, false) == errc::not_reached);
    CHECK(play(5000, {}, true) == errc::stopped_short);
}

namespace {
// A drive of a program's own that stays energised, and says that an input holds it.
struct held_stepper : y::model<y::closed_loop::device> {
    static inline bool is_held = false;
    static verdict judge(const std::uint16_t* words, y::cached_settings& known) {
        const verdict found = y::model<y::closed_loop::device>::judge(words, known);
        return found == verdict::as_expected && is_held ? verdict::held : found;
    }
};
} // namespace

TEST_CASE("a wired stop ends that motion is allowed although the drive stays energised") {
    simulated::simulated_closed_loop r;
    y::basic_drive<y::closed_loop::device, decltype(r.line), held_stepper> drive{
        r.line, 1, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
    setpoint_loop loop{drive, take_over{}};
    const auto go = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            const duration idle = loop.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    go(1000);
    loop.enable();
    go(500);
    REQUIRE(loop.is_motion_allowed());
    held_stepper::is_held = true;
    go(100);
    CHECK(drive.state() == drive_state::enabled);
    CHECK_FALSE(loop.is_motion_allowed());
    held_stepper::is_held = false;
    go(500);
    CHECK_FALSE(loop.is_motion_allowed());
    loop.enable();
    go(500);
    CHECK(loop.is_motion_allowed());
}

TEST_CASE("a C630S waits in its loop for its power cycle, and is enabled in its mode") {
    simulated::driven_c630s r;
    setpoint_loop loop{r.drive, take_over{c::set_up{}, c::torque_limits{40 * percent, 40 * percent}},
                       c::enable_in{c::control_mode::torque}, setpoints<c::torque>{}};
    std::vector<loop_report> reports;
    const auto go = [&](std::uint32_t ms, std::int32_t share) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            loop.set({share * percent});
            const duration idle = loop.step();
            if (const loop_report ended = loop.take_report()) reports.push_back(ended);
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    go(20'000, 5);
    REQUIRE(reports.size() == 1); // of several attempts
    CHECK(reports[0].how.part() == part::power_cycle);
    CHECK(reports[0].how.error() == errc::wrong_state);
    CHECK(r.drive.needs_power_cycle());
    r.model.power_cycle();
    go(20'000, 5);
    CHECK(loop.is_taken_over());
    CHECK_FALSE(r.model.enabled());
    loop.enable();
    go(3000, 5);
    CHECK(r.model.enabled());
    CHECK(r.r_per_min() != 0);
    CHECK(r.drive.cached().mode == c::control_mode::torque);
    CHECK(loop.disable() == errc::ok);
    go(20'000, 5);
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("a stop that the drive refuses ends that motion is allowed all the same") {
    simulated::driven_c630s r;
    setpoint_loop loop{r.drive, take_over{c::set_up{}}, c::enable_in{c::control_mode::position}};
    const auto go = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            const duration idle = loop.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    go(20'000);
    r.model.power_cycle();
    go(20'000);
    loop.enable();
    go(3000);
    REQUIRE(loop.is_motion_allowed());
    CHECK(loop.halt() == errc::wrong_state); // in position mode it has none
    go(100);
    CHECK(r.drive.state() == drive_state::enabled);
    CHECK_FALSE(loop.is_motion_allowed());
}

namespace {
// A drive of a program's own that has no halt.
template <class Drive> struct without_halt : Drive {
    using Drive::Drive;
    template <class Wanted> constexpr command_status begin(const Wanted& wanted) {
        if constexpr (std::same_as<Wanted, servobus::halt>)
            return command_status{errc::wrong_state};
        else
            return Drive::begin(wanted);
    }
};
} // namespace

TEST_CASE("G44: a stop that the drive refuses during an enable withdraws the consent to that") {
    for (const bool is_again : {false, true}) {
        simulated::simulated_closed_loop r;
        without_halt<y::basic_drive<y::closed_loop::device, decltype(r.line)>> drive{
            r.line, 1, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
        setpoint_loop loop{drive, take_over{}};
        const auto turn = [&] {
            const duration idle = loop.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        };
        const auto go = [&](std::uint32_t ms) {
            const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
            while (r.wire.time_us() < end) turn();
        };
        go(1000);
        CHECK(loop.disable() == errc::ok); // a stepper is energised from its power-on
        go(500);
        REQUIRE(drive.state() == drive_state::disabled);
        loop.enable();
        for (tests::loop_bound left{"an enable"}; drive.is_idle(); left.use()) turn();
        CHECK(loop.halt() == errc::wrong_state);
        if (is_again) loop.enable();
        go(500);
        CHECK(drive.state() == drive_state::enabled); // the enable has gone on
        CHECK(loop.is_motion_allowed() == is_again);
    }
}

TEST_CASE("a bus steps the drives, and their loops command them") {
    tests::wheels_and_lift m;
    tests::wheels_and_lift_program p{m.wire};
    m.wheels_model.store(0x2022, 10);
    m.wheels_model.power_cycle();
    setpoint_loop wheels{p.wheels, wheel_settings, enable{}, setpoints<z::wheel_velocities>{}};
    setpoint_loop lift{p.lift, take_over{disable{}}};
    const auto go = [&](std::uint32_t ms, std::int32_t speed) {
        const std::uint64_t end = m.wire.time_us() + std::uint64_t{ms} * 1000;
        while (m.wire.time_us() < end) {
            wheels.set({speed * r_per_min, speed * r_per_min});
            p.turn(); // all.step()
            wheels.command();
            lift.command();
        }
    };
    go(3000, 30);
    CHECK(wheels.is_taken_over());
    CHECK(lift.is_taken_over());
    CHECK(m.wheels_model.enables() == 0);
    wheels.enable();
    go(1000, 30);
    CHECK(m.wheels_model.left().speed > 25'000'000);
    CHECK_FALSE(m.lift_model.enabled());
    m.lift_model.power_cycle();
    go(3000, 30);
    CHECK(lift.is_taken_over());
    CHECK(m.wheels_model.left().speed > 25'000'000); // the other drive's loss is none of its own
}

namespace {
constexpr loop_report ended(loop_part what, errc why) { return {.what = what, .how = command_status{why}}; }
constexpr bool is_told_after(loop_part other, errc how) {
    detail::loop_reports r;
    (void)r.note(ended(loop_part::command, errc::timeout));
    (void)r.note(ended(other, how));
    return r.note(ended(loop_part::command, errc::timeout));
}
} // namespace
static_assert(is_told_after(loop_part::stop, errc::ok) && is_told_after(loop_part::command, errc::ok));
static_assert(is_told_after(loop_part::command, errc::busy) && is_told_after(loop_part::stop, errc::timeout));
static_assert(!is_told_after(loop_part::command, errc::timeout), "the same failure again");

TEST_CASE("each part of a loop has a text") {
    CHECK(text(loop_part::none) == doctest::String("nothing"));
    CHECK(text(loop_part::take_over) == doctest::String("take-over"));
    CHECK(text(loop_part::fault_reset) == doctest::String("fault reset"));
    CHECK(text(loop_part::enable) == doctest::String("enable"));
    CHECK(text(loop_part::setpoint) == doctest::String("setpoint"));
    CHECK(text(loop_part::command) == doctest::String("command"));
    CHECK(text(loop_part::permission) == doctest::String("permission to move"));
    CHECK(text(loop_part::stop) == doctest::String("stop"));
    CHECK(text(static_cast<loop_part>(99)) == doctest::String("unknown"));
}

TEST_CASE(
    "a take-over without a response is tried again later and later, and after 1 s once a response came") {
    rig t;
    t.r.wire.set_connected(0, false);
    // When the drive was idle last before each attempt, in seconds from now.
    const auto attempts = [&](std::uint32_t ms) {
        std::vector<std::uint32_t> begun;
        const std::uint64_t start = t.r.wire.time_us(), end = start + std::uint64_t{ms} * 1000;
        while (t.r.wire.time_us() < end) {
            const bool was_idle = t.r.drive.is_idle();
            const std::uint64_t now = t.r.wire.time_us();
            t.turn();
            if (was_idle && !t.r.drive.is_idle())
                begun.push_back(static_cast<std::uint32_t>((now - start + 500'000) / 1'000'000));
        }
        return begun;
    };
    CHECK(attempts(15'000) == std::vector<std::uint32_t>{0, 2, 6, 14});
    t.r.model.refuses = true; // with an exception
    t.r.wire.set_connected(0, true);
    t.go(9'000);
    CHECK(attempts(3'000).size() == 3);
}

} // namespace setpoint_loop_tests
