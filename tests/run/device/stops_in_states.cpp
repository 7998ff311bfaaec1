// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Each stop in each state of each drive; and any two of the things that end a motion, one after the other. Compared are
// the state, the cause, and what the drive takes after them. Judged by the simulated motor and by rules, which are
// those of the manuals.
#include <cstdint>
#include <type_traits>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace stops_in_states_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

enum class place { unknown, disabled, enabled, moving, quick_stopped, faulted };
enum class event { halt, quick_stop, disable, fault, restart, lost_port, foreign_setting };
constexpr event events[] = {event::halt,    event::quick_stop, event::disable,        event::fault,
                            event::restart, event::lost_port,  event::foreign_setting};

struct wheels {
    simulated::driven_zlac8015d r{};
    static constexpr bool has_watchdog = true;
    /// A quick stop ends that the drive is enabled.
    static constexpr drive_state after_quick_stop = drive_state::quick_stopped;
    void prepare() { REQUIRE(r.drive.run(init{})); }
    static auto on() { return zlac8015d::enable_in{zlac8015d::operating_mode::velocity}; }
    static auto motion() { return velocity{60 * r_per_min, -90 * r_per_min}; }
    void fail() { r.model.raise(zlac8015d::fault::overload, {}); }
    bool stands_still() const { return r.model.stands_still(); }
};
template <class A> struct stepper {
    A r{};
    static constexpr bool has_watchdog = false;
    static constexpr drive_state after_quick_stop = drive_state::enabled;
    void prepare() {
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(disable{}));
    }
    static auto on() { return enable{}; }
    static auto motion() { return velocity{60 * r_per_min}; }
    void fail() { r.model.raise_alarm(4); }
    bool stands_still() const { return !r.is_moving(); }
};
using closed = stepper<simulated::closed_axis>;
using open = stepper<simulated::open_axis>;
struct servo {
    simulated::driven_c630s r{};
    static constexpr bool has_watchdog = false;
    static constexpr drive_state after_quick_stop = drive_state::quick_stopped;
    void prepare() { REQUIRE(r.make_ready()); }
    static auto on() { return c630s::enable_in{c630s::control_mode::speed}; }
    static auto motion() { return velocity{100 * r_per_min}; }
    void fail() { r.model.raise(0x620); }
    bool stands_still() const { return r.model.stands_still(); }
};

/// Lets time pass while the program reads feedback.
template <class S> void live(S& s, std::uint32_t ms) {
    const std::uint64_t end = s.r.wire.time_us() + std::uint64_t{ms} * 1000u;
    while (s.r.wire.time_us() < end) {
        (void)s.r.drive.read();
        s.r.wire.pass(milliseconds(50));
    }
}
template <class S> void reach(S& s, place there) {
    if (there == place::unknown) return;
    s.prepare();
    if (there == place::disabled) return;
    REQUIRE(s.r.drive.run(S::on()));
    if (there == place::enabled) return;
    REQUIRE(s.r.drive.run(S::motion()));
    live(s, 200);
    REQUIRE_FALSE(s.stands_still());
    if (there == place::quick_stopped) REQUIRE(s.r.drive.run(quick_stop{}));
    if (there != place::faulted) return;
    s.fail();
    (void)s.r.drive.read();
}
template <class S> command_status stop(S& s, event how) {
    if (how == event::halt) return s.r.drive.run(halt{});
    if (how == event::quick_stop) return s.r.drive.run(quick_stop{});
    return s.r.drive.run(disable{});
}
template <class S> void happen(S& s, event what) {
    switch (what) {
    case event::halt:
    case event::quick_stop:
    case event::disable: (void)stop(s, what); break;
    case event::fault: s.fail(); break;
    case event::restart: s.r.model.power_cycle(); break;
    case event::lost_port:
        s.r.wire.unplug();
        (void)s.r.drive.read();
        s.r.wire.plug();
        break;
    case event::foreign_setting: s.r.line.note_change(1); break;
    }
    live(s, what == event::restart || what == event::fault ? 700 : 100);
}
constexpr bool is_stop(event e) { return e <= event::disable; }
constexpr bool makes_unknown(event e) { return e >= event::restart; }
/// The state after a stop in `before`.
template <class S> constexpr drive_state state_after(event how, drive_state before) {
    if (before == drive_state::needs_init || before == drive_state::faulted) return before;
    if (how == event::disable) return drive_state::disabled;
    return how == event::quick_stop && before == drive_state::enabled ? S::after_quick_stop : before;
}
/// The same after any event.
template <class S> constexpr drive_state next(event what, drive_state before) {
    if (makes_unknown(what) || before == drive_state::needs_init) return drive_state::needs_init;
    return what == event::fault ? drive_state::faulted : state_after<S>(what, before);
}

} // namespace

TEST_CASE_TEMPLATE("each stop in each state: the motor stands, and the state is what the drive will take", S,
                   wheels, closed, open, servo) {
    for (const place there : {place::unknown, place::disabled, place::enabled, place::moving,
                              place::quick_stopped, place::faulted}) {
        for (const event how : {event::halt, event::quick_stop, event::disable}) {
            CAPTURE(static_cast<int>(there));
            CAPTURE(static_cast<int>(how));
            S s;
            reach(s, there);
            auto& drive = s.r.drive;
            const drive_state before = drive.state();
            const bool was_enabled = s.r.model.enabled();
            const command_status ended = stop(s, how);
            if (there != place::unknown) CHECK(ended);
            CHECK(s.stands_still());
            CHECK(drive.state() == state_after<S>(how, before));
            CHECK(drive.cause() == (there == place::faulted ? stop_cause::fault : stop_cause::command));
            CHECK(drive.last().error() == ended.error());
            if (how == event::disable) CHECK_FALSE(s.r.model.enabled());
            if (how == event::halt) CHECK(s.r.model.enabled() == was_enabled);
            // A C630S is switched off before it is enabled again, everywhere.
            const bool is_on = drive.state() == drive_state::enabled ||
                               (drive.state() == drive_state::quick_stopped && s.r.model.enabled());
            const errc refusal = there == place::unknown             ? errc::needs_init
                                 : there == place::faulted           ? errc::faulted
                                 : std::is_same_v<S, servo> && is_on ? errc::wrong_state
                                                                     : errc::ok;
            CHECK(drive.run(S::on()).error() == refusal);
            if (refusal == errc::wrong_state) continue;
            CHECK(drive.run(S::motion()).error() == refusal);
            if (refusal != errc::ok) continue;
            CHECK(drive.cause() == stop_cause::unknown); // of the motion before
            live(s, 200);
            CHECK_FALSE(s.stands_still());
        }
    }
}

TEST_CASE_TEMPLATE(
    "two things end a motion, one after the other: the state is of both, the cause of the first", S, wheels,
    closed, servo) {
    for (const event first : events) {
        for (const event second : events) {
            CAPTURE(static_cast<int>(first));
            CAPTURE(static_cast<int>(second));
            S s;
            reach(s, place::moving);
            auto& drive = s.r.drive;
            happen(s, first);
            const drive_state between = next<S>(first, drive_state::enabled);
            CHECK(drive.state() == between);
            happen(s, second);
            // The witness of a ZLAC8015D is its mode, which counts while it is enabled.
            const bool is_hidden =
                S::has_watchdog && second == event::restart && between != drive_state::enabled;
            if (!is_hidden) CHECK(drive.state() == next<S>(second, between));
            const auto leaves_moving = [](event e) { return makes_unknown(e) && e != event::restart; };
            if (is_stop(first) || is_stop(second)) CHECK(s.stands_still());
            if (!S::has_watchdog && leaves_moving(first) && leaves_moving(second))
                CHECK_FALSE(s.stands_still());
            if (first == event::disable || second == event::disable) {
                const bool restarts = first == event::restart || second == event::restart;
                CHECK((restarts || !s.r.model.enabled()));
            }
            // What stopped the motor is the cause. A fault of a drive that is energised may replace a stop.
            const bool is_open = is_stop(first) && second == event::fault;
            const stop_cause cause = first == event::fault     ? stop_cause::fault
                                     : first == event::restart ? stop_cause::restart
                                     : is_stop(first)          ? stop_cause::command
                                     : is_stop(second)         ? stop_cause::command
                                                               : stop_cause::unknown;
            if (!is_open) CHECK(drive.cause() == cause);
            if (drive.state() == drive_state::needs_init) {
                CHECK(drive.begin(S::motion()) == errc::needs_init);
                CHECK(drive.feedback(milliseconds(10'000)).error() != errc::ok);
            }
        }
    }
}

} // namespace stops_in_states_tests
