// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands of a setpoint loop after its enable: begun by a consent alone, before any other motion, and anew after
// all but a halt. Judged by the simulated machines and by the frames on the wire.
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/control/setpoint_loop.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_yako.hpp>

namespace after_enable_tests {

using namespace servobus;
using namespace servobus::units;
namespace z = servobus::zlac8015d;
namespace y = servobus::yako;
namespace c = servobus::c630s;
using simulated::transaction_fault;

using stepper = y::model<y::closed_loop::device>;
template <class Model, class... Commands>
constexpr bool all_change_power = (detail::changes_power<Model, Commands>() && ...);
template <class Model, class... Commands>
constexpr bool none_changes_power = (!detail::changes_power<Model, Commands>() && ...);
static_assert(all_change_power<stepper, init, enable, disable, quick_stop, fault_reset>);
static_assert(
    none_changes_power<stepper, halt, y::closed_loop::home, y::travel_bounds, y::relative_move,
                       y::jog_velocity, wait_reached, wait_standstill, read_feedback, y::set_output>);
static_assert(all_change_power<z::model, enable, disable, fault_reset>);
static_assert(none_changes_power<z::model, z::wheel_velocities, z::ramps, z::wheel_ways>);
static_assert(all_change_power<c::model, enable, c::enable_in, c::run_speed_segments, fault_reset>);
static_assert(none_changes_power<c::model, c::home, c::ramps, c::start_segment>);
static_assert(std::is_empty_v<after_enable<>> && std::is_empty_v<after_enable<read_feedback, halt>>);

namespace {

constexpr take_over set_up{disable{},
                           y::set_input{y::input_terminal::x0, y::input_function::home},
                           y::set_input{y::input_terminal::x1, y::input_function::positive_limit},
                           y::set_input{y::input_terminal::x2, y::input_function::negative_limit},
                           y::set_input{y::input_terminal::x3, y::input_function::stop},
                           y::set_homing_profile{300 * r_per_min, 150 * r_per_min, 30 * millisecond}};
constexpr y::closed_loop::home home{y::homing::home_24};
constexpr limit_travel limit{-3000 * pulse, 3000 * pulse};
constexpr after_enable homed{home, limit};
constexpr y::motion_profile brisk{10 * r_per_min, 50 * millisecond, 50 * millisecond, 300 * r_per_min};
constexpr y::motion_profile gentle{10 * r_per_min, 50 * millisecond, 50 * millisecond, 60 * r_per_min};

// Ends a loop that waits for the library in vain, after 30 s of simulated time.
class bound {
  public:
    explicit bound(const sim::virtual_line& on) : wire_{on}, end_{on.time_us() + 30'000'000} {}
    void use() const { REQUIRE(wire_.time_us() < end_); }

  private:
    const sim::virtual_line& wire_;
    std::uint64_t end_;
};

sim::yako_machine rails() {
    sim::yako_machine m = simulated::yako_slide();
    m.home_from = 300;
    m.home_to = 400;
    return m;
}

struct axis_on_rails : simulated::simulated_closed_loop {
    y::closed_loop::drive<line_type> drive;

    axis_on_rails(const supervision& by, const sim::yako_machine& machine) : drive{line, 1, by} {
        model.attach(machine);
    }
    std::int64_t place() const { return model.view().position; }
    bool is_moving() const { return model.view().is_moving; }
};

// A lift in a loop, with all that was reported.
template <class List, class Setpoints = no_setpoints> struct lift_of {
    axis_on_rails r;
    setpoint_loop<decltype(r.drive), std::remove_const_t<decltype(set_up)>, enable, Setpoints, List> loop;
    std::vector<loop_report> reports;

    explicit lift_of(const List& list, const sim::yako_machine& machine = rails(),
                     const supervision& by = without_watchdog)
        : r{by, machine}, loop{r.drive, set_up, enable{}, list, Setpoints{}} {}
    void turn() {
        const duration idle = loop.step();
        if (const loop_report ended = loop.take_report()) reports.push_back(ended);
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void go(std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) turn();
    }
    // Until the end of this part is reported.
    loop_report until(loop_part what) {
        const std::size_t before = reports.size();
        for (const bound left{r.wire}; reports.size() == before || reports.back().what != what; left.use())
            turn();
        return reports.back();
    }
    std::size_t homings() const { return r.sent(enabled_yako::start_homing_frame); }
    std::size_t enables() const { return r.sent(enabled_yako::enable_frame); }
    std::size_t count(loop_part what) const {
        std::size_t n = 0;
        for (const loop_report& e : reports) n += e.what == what ? 1u : 0u;
        return n;
    }
    std::size_t failures(loop_part what) const {
        std::size_t n = 0;
        for (const loop_report& e : reports) n += e.what == what && !e.how ? 1u : 0u;
        return n;
    }
    // The switch's edge is home, and the software limits of the list are in force.
    bool is_ready() {
        return r.model.view().is_homed && r.model.peek(0x0038) == 3000 &&
               r.model.peek(y::software_limits.address) == 1;
    }
    bool moves() {
        const std::int64_t before = r.place();
        if (!loop.begin(move_by{100 * pulse, brisk})) return false;
        (void)until(loop_part::command);
        if (!loop.begin(wait_reached{})) return false;
        return until(loop_part::command).how && r.place() == before + 100;
    }
    // Consents, and is homed by that.
    void make_ready() {
        if (!loop.is_taken_over()) (void)until(loop_part::take_over);
        loop.enable();
        REQUIRE(until(loop_part::after_enable).how);
        REQUIRE(loop.is_motion_allowed());
        REQUIRE(is_ready());
        REQUIRE(moves());
        reports.clear();
    }
    // The list is under way, `ms` after the enable.
    void be_homing(std::uint32_t ms) {
        (void)until(loop_part::take_over);
        loop.enable();
        (void)until(loop_part::enable);
        go(ms);
        REQUIRE_FALSE(loop.is_motion_allowed());
        REQUIRE(count(loop_part::after_enable) == 0);
    }
    // Nothing moves by itself, and nothing can be moved.
    void check_stopped() {
        CHECK_FALSE(loop.is_motion_allowed());
        go(1500);
        const std::int64_t place = r.model.view().shaft;
        const std::uint32_t starts = r.model.starts();
        const std::size_t reported = reports.size();
        go(1500);
        CHECK(r.model.view().shaft == place);
        CHECK(r.model.starts() == starts);
        CHECK(reports.size() == reported);
        CHECK_FALSE(loop.is_motion_allowed());
        if (loop.is_taken_over()) CHECK(loop.begin(move_by{100 * pulse, brisk}) == errc::wrong_state);
    }
};
using lift = lift_of<std::remove_const_t<decltype(homed)>>;

// A mistake at one of these times, in ms, leaves a machine without its list after the next consent.
constexpr std::uint32_t moments[] = {0, 1, 5, 20, 60, 120};

} // namespace

TEST_CASE(
    "G44: the commands after an enable are begun by a consent, and motion is allowed after the last one") {
    lift t{homed};
    t.go(3000);
    CHECK(t.loop.is_taken_over());
    CHECK(t.r.model.starts() == 0);
    CHECK(t.homings() == 0);
    t.reports.clear();
    t.loop.enable();
    bool was_moving = false;
    std::size_t busy = 0;
    for (const bound left{t.r.wire}; !t.loop.is_motion_allowed(); left.use()) {
        const bool is_energised = t.r.drive.state() == drive_state::enabled && t.r.drive.is_idle();
        if (t.homings() == 1) {
            busy += t.loop.begin(move_by{100 * pulse, brisk}) == errc::busy ? 1u : 0u;
            CHECK(t.loop.begin(read_feedback{}) == errc::busy);
            t.loop.enable(); // it is covered by the consent already
        } else if (is_energised) {
            CHECK(t.loop.begin(move_by{100 * pulse, brisk}) != errc::ok);
        }
        was_moving = was_moving || t.r.is_moving();
        t.turn();
    }
    CHECK(busy > 10);
    CHECK(was_moving);
    CHECK(t.is_ready());
    CHECK(t.homings() == 1);
    CHECK(t.enables() == 1);
    REQUIRE(t.reports.size() == 2);
    CHECK(t.reports[0].what == loop_part::enable);
    CHECK(t.reports[0].how);
    CHECK(t.reports[1].what == loop_part::after_enable);
    CHECK(t.reports[1].how);
    CHECK(t.reports[1].how.setting() == 0);
    CHECK(t.moves());
    t.go(3000);
    CHECK(t.count(loop_part::enable) == 1);
    CHECK(t.count(loop_part::after_enable) == 1);
    CHECK(t.homings() == 1);
    CHECK(t.r.model.starts() == 2);
}

TEST_CASE("a halt keeps what the commands after an enable have done; all else makes them due again") {
    const auto homes_again = [](auto&& event) {
        lift t{homed};
        t.make_ready();
        event(t);
        t.go(2000);
        CHECK_FALSE(t.loop.is_motion_allowed());
        const std::size_t before = t.homings();
        t.reports.clear();
        if (t.r.drive.state() == drive_state::faulted) {
            t.r.model.end_alarm();
            REQUIRE(t.loop.reset_faults());
            REQUIRE(t.until(loop_part::fault_reset).how);
            CHECK(t.homings() == before);
        }
        t.loop.enable();
        t.go(3000);
        CHECK(t.loop.is_motion_allowed());
        CHECK(t.is_ready());
        CHECK(t.moves());
        CHECK(t.count(loop_part::enable) == 1);
        CHECK(t.count(loop_part::after_enable) == t.homings() - before);
        return t.homings() != before;
    };
    const auto move = [](lift& t) {
        REQUIRE(t.loop.begin(move_by{-2000 * pulse, gentle}));
        REQUIRE(t.until(loop_part::command).how);
        t.go(200);
        REQUIRE(t.r.is_moving());
    };
    const auto halt = [](lift& t) {
        CHECK(t.loop.halt());
        CHECK(t.until(loop_part::stop).how);
        CHECK_FALSE(t.r.is_moving());
        CHECK(t.r.model.enabled());
    };
    SUBCASE("a halt at rest") { CHECK_FALSE(homes_again(halt)); }
    SUBCASE("a halt of a move") {
        CHECK_FALSE(homes_again([&](lift& t) {
            move(t);
            halt(t);
        }));
    }
    SUBCASE("a halt of a wait") {
        CHECK_FALSE(homes_again([&](lift& t) {
            move(t);
            REQUIRE(t.loop.begin(wait_reached{}));
            t.go(100);
            halt(t);
        }));
    }
    SUBCASE("two halts") {
        CHECK_FALSE(homes_again([&](lift& t) {
            halt(t);
            t.loop.enable();
            t.go(300);
            REQUIRE(t.loop.is_motion_allowed());
            halt(t);
        }));
    }
    SUBCASE("a quick stop") {
        CHECK(homes_again([](lift& t) { CHECK(t.loop.quick_stop()); }));
    }
    SUBCASE("a quick stop, and a halt after it") {
        CHECK(homes_again([&](lift& t) {
            CHECK(t.loop.quick_stop());
            (void)t.until(loop_part::stop);
            halt(t);
        }));
    }
    SUBCASE("a quick stop that is begun as a command, and a halt") {
        CHECK(homes_again([&](lift& t) {
            REQUIRE(t.loop.begin(quick_stop{}));
            (void)t.until(loop_part::command);
            halt(t);
        }));
    }
    SUBCASE("a disable") {
        CHECK(homes_again([](lift& t) { CHECK(t.loop.disable()); }));
    }
    SUBCASE("a halt, then a disable") {
        CHECK(homes_again([&](lift& t) {
            halt(t);
            CHECK(t.loop.disable());
        }));
    }
    SUBCASE("a halt whose response is lost") {
        CHECK(homes_again([&](lift& t) {
            t.r.wire.faults().lost_response = 1000;
            CHECK(t.loop.halt());
            CHECK_FALSE(t.until(loop_part::stop).how);
            t.r.wire.faults() = {};
            t.go(3000);
        }));
    }
    SUBCASE("a halt that the drive refuses by an exception") {
        CHECK(homes_again([&](lift& t) {
            t.r.model.refuses = true;
            CHECK(t.loop.halt());
            CHECK_FALSE(t.until(loop_part::stop).how);
            t.r.model.refuses = false;
            t.go(3000);
        }));
    }
    SUBCASE("a halt, then a fault") {
        CHECK(homes_again([&](lift& t) {
            halt(t);
            t.r.model.raise_alarm(2);
        }));
    }
    SUBCASE("a fault in a move") {
        CHECK(homes_again([&](lift& t) {
            move(t);
            t.r.model.raise_alarm(2);
        }));
    }
    SUBCASE("a restart") {
        CHECK(homes_again([](lift& t) {
            t.r.model.power_cycle();
            t.go(6000);
        }));
    }
    SUBCASE("a halt, then a restart") {
        CHECK(homes_again([&](lift& t) {
            halt(t);
            t.r.model.power_cycle();
            t.go(6000);
        }));
    }
    SUBCASE("a halt, then a lost port") {
        CHECK(homes_again([&](lift& t) {
            halt(t);
            t.r.wire.unplug();
            t.go(1500);
            t.r.wire.plug();
            t.r.forget_open_request();
            t.go(3000);
        }));
    }
    SUBCASE("a wired stop of a move, and a halt") {
        CHECK(homes_again([&](lift& t) {
            move(t);
            t.r.model.set_input(3, true);
            REQUIRE(t.loop.begin(wait_reached{}));
            CHECK(t.until(loop_part::command).how.error() == errc::stopped_short);
            t.r.model.set_input(3, false);
            halt(t);
        }));
    }
    SUBCASE("a homing of the program that a halt has ended") {
        CHECK(homes_again([&](lift& t) {
            REQUIRE(t.loop.begin(home));
            t.go(60);
            REQUIRE(t.r.is_moving());
            halt(t);
        }));
    }
    SUBCASE("a homing of the program that has failed") {
        CHECK(homes_again([&](lift& t) {
            REQUIRE(t.loop.begin(y::closed_loop::home{y::homing::home_24, {}, {}, milliseconds(50)}));
            CHECK_FALSE(t.until(loop_part::command).how);
            halt(t);
        }));
    }
    SUBCASE("a homing of the program that gets an exception") {
        CHECK(homes_again([&](lift& t) {
            REQUIRE(t.loop.begin(home));
            t.r.model.refuses = true;
            const command_status how = t.until(loop_part::command).how;
            t.r.model.refuses = false;
            CHECK(how.outcome() == outcome::refused);
            CHECK(t.r.drive.state() == drive_state::enabled);
            halt(t);
        }));
    }
    SUBCASE("a homing of the program that was refused before anything was sent") {
        CHECK_FALSE(homes_again([&](lift& t) {
            REQUIRE(t.loop.begin(move_by{500 * pulse, gentle}));
            REQUIRE(t.until(loop_part::command).how);
            REQUIRE(t.loop.begin(home));
            CHECK(t.until(loop_part::command).how.outcome() == outcome::not_sent); // it moves
            halt(t);
        }));
    }
    SUBCASE("a homing of the program that is done") {
        CHECK_FALSE(homes_again([&](lift& t) {
            REQUIRE(t.loop.begin(home));
            CHECK(t.until(loop_part::command).how);
            halt(t);
        }));
    }
}

TEST_CASE("before the list is left out a reading shows that a drive that nobody polls is as it was") {
    enum class event { none, fault, restart, no_power, lost_response };
    const auto play = [](event what) {
        lift t{homed, rails(), unsupervised};
        t.make_ready();
        CHECK(t.loop.halt()); // one reading is good for one consent
        CHECK(t.until(loop_part::stop).how);
        t.loop.enable();
        CHECK(t.until(loop_part::enable).how);
        CHECK(t.loop.is_motion_allowed());
        CHECK(t.loop.halt());
        CHECK(t.until(loop_part::stop).how);
        if (what == event::fault) t.r.model.raise_alarm(2);
        if (what == event::restart) t.r.model.power_cycle();
        constexpr std::array<std::uint8_t, 2> release{0x00, 0x11};
        if (what == event::no_power) CHECK(t.r.model.write(0x002D, words_view{release}) == 0);
        if (what == event::lost_response) t.r.wire.faults().lost_response = 1000;
        t.go(1000);
        CHECK(t.r.drive.state() == drive_state::enabled); // as far as the program knows
        t.reports.clear();
        t.loop.enable();
        t.go(3000);
        t.r.wire.faults() = {};
        t.go(3000);
        const bool is_as_before = what == event::none || what == event::no_power;
        CHECK(t.failures(loop_part::enable) == (is_as_before ? 0 : 1));
        CHECK(t.count(loop_part::enable) == 1);
        CHECK(t.loop.is_motion_allowed() == is_as_before);
        if (!is_as_before) {
            t.r.model.end_alarm();
            (void)t.loop.reset_faults();
            t.go(1000);
            CHECK(t.homings() == 1);
            t.loop.enable();
            t.go(3000);
        }
        CHECK(t.loop.is_motion_allowed());
        CHECK(t.is_ready());
        CHECK(t.moves());
        return t.homings();
    };
    CHECK(play(event::none) == 1);
    CHECK(play(event::lost_response) == 2); // the state of the drive is not known any more
    CHECK(play(event::fault) == 2);
    CHECK(play(event::restart) == 2);
    CHECK(play(event::no_power) == 2); // and it was enabled again
}

namespace {
// The transactions from the enable on.
struct counted_lift {
    lift& t;
    std::uint32_t first = t.r.wire.requests();
    std::size_t seen = t.r.requests.size();
    decltype(lift::r.wire)& wire = t.r.wire;
    decltype(lift::r.model)& model = t.r.model;

    std::size_t begun() const { return wire.requests() - first; }
    std::size_t frames() const { return t.r.requests.size() - seen; }
};
} // namespace

TEST_CASE("G44: whichever frame after an enable is lost, motion is allowed only after the whole list") {
    std::size_t done = 0;
    std::size_t failed = 0;
    for (const transaction_fault what : simulated::transaction_faults) {
        CAPTURE(static_cast<int>(what));
        for (std::size_t n = 0;; ++n) {
            CAPTURE(n);
            lift t{homed};
            (void)t.until(loop_part::take_over);
            t.loop.enable();
            (void)t.until(loop_part::enable);
            counted_lift s{t};
            simulated::fault_injection fault{s, what, n};
            bool is_over = false;
            for (const bound left{t.r.wire}; !is_over; left.use()) {
                if (what == transaction_fault::request_damaged) t.r.forget_open_request();
                fault();
                t.turn();
                is_over = t.count(loop_part::after_enable) != 0;
                CHECK((!t.loop.is_motion_allowed() || is_over));
            }
            const bool has_struck = fault.has_struck();
            fault.end();
            t.r.forget_open_request();
            const loop_report ended = t.reports.back();
            if (ended.how) {
                ++done;
                CHECK(t.loop.is_motion_allowed());
                CHECK(t.is_ready());
            } else {
                ++failed;
                CHECK((ended.how.setting() == 1 || ended.how.setting() == 2));
                t.check_stopped();
                CHECK(t.count(loop_part::after_enable) == 1);
                t.go(4000); // perhaps taken over
                t.make_ready();
            }
            if (!has_struck) break;
        }
    }
    CHECK(done > 30);
    CHECK(failed > 30);
}

TEST_CASE(
    "G44: a restart, a fault, a wired stop or a lost port during the list ends it, and is reported once") {
    enum class event { restart, fault, wired_stop, lost_port };
    const auto play = [](event what, std::uint32_t ms) {
        lift t{homed};
        t.be_homing(ms);
        switch (what) {
        case event::restart: t.r.model.power_cycle(); break;
        case event::fault: t.r.model.raise_alarm(2); break;
        case event::wired_stop: t.r.model.set_input(3, true); break;
        case event::lost_port:
            t.r.wire.unplug();
            t.go(500);
            t.r.wire.plug();
            t.r.forget_open_request();
            break;
        }
        t.go(5000);
        CHECK(t.count(loop_part::after_enable) == 1);
        CHECK(t.failures(loop_part::after_enable) == 1);
        for (const loop_report& e : t.reports) {
            if (e.what == loop_part::after_enable) CHECK(e.how.setting() == 1);
        }
        t.check_stopped();
        t.r.model.set_input(3, false);
        t.check_stopped(); // also once it is released
        const std::size_t before = t.homings();
        if (t.r.drive.state() == drive_state::faulted) {
            t.r.model.end_alarm();
            REQUIRE(t.loop.reset_faults());
            t.go(1000);
            CHECK(t.homings() == before);
        }
        t.make_ready();
        CHECK(t.homings() == before + 1);
    };
    for (const event what : {event::restart, event::fault, event::wired_stop, event::lost_port}) {
        CAPTURE(static_cast<int>(what));
        for (const std::uint32_t ms : moments) {
            CAPTURE(ms);
            play(what, ms);
        }
    }
}

TEST_CASE("G44: a stop during the list ends it, and the next consent begins it anew") {
    for (const stop_priority by : {stop_priority::halt, stop_priority::quick_stop, stop_priority::disable}) {
        CAPTURE(text(by));
        for (const std::uint32_t ms : moments) {
            CAPTURE(ms);
            lift t{homed};
            t.be_homing(ms);
            CHECK((by == stop_priority::halt      ? t.loop.halt()
                   : by == stop_priority::disable ? t.loop.disable()
                                                  : t.loop.quick_stop()));
            CHECK(t.until(loop_part::stop).how);
            CHECK_FALSE(t.r.is_moving());
            t.check_stopped();
            CHECK(t.count(loop_part::after_enable) == 0); // it is the program's own stop
            const std::size_t before = t.homings();
            t.make_ready();
            CHECK(t.homings() == before + 1);
        }
    }
}

TEST_CASE("a command of the list that fails is reported once with its number, and ends the list") {
    SUBCASE("the first one: there is no switch") {
        lift t{homed, sim::yako_machine::none()};
        t.go(3000);
        t.loop.enable();
        t.go(500);
        t.r.model.set_input(3, true); // it would turn for a minute
        const loop_report ended = t.until(loop_part::after_enable);
        CHECK_FALSE(ended.how);
        CHECK(ended.how.part() == take_over_part::setting);
        CHECK(ended.how.setting() == 1);
        t.r.model.set_input(3, false);
        t.check_stopped();
        CHECK(t.homings() == 1);
        CHECK(t.r.model.enabled());
        t.loop.enable(); // the same failure is another one
        t.go(500);
        t.r.model.set_input(3, true);
        CHECK_FALSE(t.until(loop_part::after_enable).how);
        CHECK(t.homings() == 2);
        CHECK(t.enables() == 1); // it was energised
    }
    SUBCASE("the second one is refused") {
        const after_enable wrong{home, limit_travel{3000 * pulse, -3000 * pulse}, read_feedback{}};
        lift_of<std::remove_const_t<decltype(wrong)>> t{wrong};
        for (std::size_t n = 1; n <= 2; ++n) {
            t.go(3000);
            t.loop.enable();
            const loop_report ended = t.until(loop_part::after_enable);
            CHECK(ended.how.error() == errc::bad_argument);
            CHECK(ended.how.setting() == 2);
            t.check_stopped();
            CHECK(t.count(loop_part::after_enable) == n);
            CHECK(t.homings() == n);
        }
    }
}

TEST_CASE("a consent whose list has failed is not used by what it was given for") {
    lift t{homed};
    t.be_homing(20);
    t.r.model.raise_alarm(2);
    const auto is_stopped = [&] { return t.r.drive.state() == drive_state::faulted && t.r.drive.is_idle(); };
    for (const bound left{t.r.wire}; !is_stopped(); left.use()) {
        (void)t.r.drive.step(); // as a bus steps it: the loop has not seen it yet
        t.r.wire.wait(microseconds(100));
    }
    t.loop.enable();
    t.go(1000);
    t.r.model.end_alarm();
    REQUIRE(t.loop.reset_faults());
    t.check_stopped();
    CHECK(t.homings() == 1);
}

TEST_CASE("G44: setpoints that were given before the end of the list are not begun") {
    lift_of<std::remove_const_t<decltype(homed)>, setpoints<y::bounded_jog>> t{homed};
    constexpr y::bounded_jog up{200 * pulse, gentle};
    (void)t.until(loop_part::take_over);
    t.loop.set(up);
    t.loop.enable();
    for (const bound left{t.r.wire}; !t.loop.is_motion_allowed(); left.use()) {
        t.loop.set(up);
        t.turn();
    }
    CHECK(t.is_ready());
    CHECK(t.r.model.starts() == 1); // the homing
    t.go(150);                      // while the last one is not too old
    CHECK(t.r.model.starts() == 1);
    t.loop.set(up);
    t.go(300);
    CHECK(t.r.model.starts() >= 2);
    // After a halt the list is left out, and a setpoint after the consent is begun.
    CHECK(t.loop.halt());
    t.go(500);
    const std::uint32_t starts = t.r.model.starts();
    t.loop.set(up);
    t.loop.enable();
    t.go(150);
    CHECK(t.r.model.starts() == starts);
    t.loop.set(up);
    t.go(150);
    CHECK(t.r.model.starts() > starts);
    // A setpoint that is not carried out may be all that shows a wired stop.
    t.r.model.set_input(3, true);
    for (int i = 0; i < 500; ++i) {
        t.loop.set(up);
        t.turn();
        t.go(1);
    }
    CHECK(t.failures(loop_part::setpoint) == 1);
    t.r.model.set_input(3, false);
    const std::size_t homings = t.homings();
    CHECK(t.loop.halt());
    t.go(500);
    t.loop.enable();
    CHECK(t.until(loop_part::after_enable).how);
    CHECK(t.homings() == homings + 1);
}

namespace {
// A drive of a program's own: it has no halt, and stays energised while an input holds it.
struct held_stepper : y::model<y::closed_loop::device> {
    static inline bool is_held = false;
    static verdict judge(const std::uint16_t* words, y::cached_settings& known) {
        const verdict found = y::model<y::closed_loop::device>::judge(words, known);
        return found == verdict::as_expected && is_held ? verdict::held : found;
    }
};
template <class Line> struct without_halt : y::basic_drive<y::closed_loop::device, Line, held_stepper> {
    using base = y::basic_drive<y::closed_loop::device, Line, held_stepper>;
    using base::base;
    static inline bool has_halt = false;
    template <class Wanted> constexpr command_status begin(const Wanted& wanted) {
        if constexpr (std::same_as<Wanted, servobus::halt>) {
            if (!has_halt) return command_status{errc::wrong_state};
        }
        return base::begin(wanted);
    }
};
struct odd_lift {
    simulated::simulated_closed_loop r;
    without_halt<decltype(r.line)> drive{
        r.line, 1, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
    setpoint_loop<decltype(drive), std::remove_const_t<decltype(set_up)>, enable, no_setpoints,
                  std::remove_const_t<decltype(homed)>>
        loop{drive, set_up, enable{}, homed};
    std::vector<loop_report> reports;

    odd_lift() {
        r.model.attach(rails());
        held_stepper::is_held = false;
        drive.has_halt = false;
        go(3000);
        reports.clear();
    }
    void turn() {
        const duration idle = loop.step();
        if (const loop_report ended = loop.take_report()) reports.push_back(ended);
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void go(std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) turn();
    }
    std::size_t homings() const { return r.sent(enabled_yako::start_homing_frame); }
    void begin_homing() {
        loop.enable();
        for (const bound left{r.wire}; homings() == 0; left.use()) turn();
    }
};
} // namespace

TEST_CASE("G44: a stop that the drive refuses during the list withdraws the consent to the rest of it") {
    for (const bool is_again : {false, true}) {
        odd_lift t;
        t.begin_homing();
        CHECK(t.loop.halt() == errc::wrong_state);
        if (is_again) t.loop.enable();
        t.go(3000);
        CHECK(t.r.model.view().is_homed); // the homing has gone on
        REQUIRE(t.reports.size() == (is_again ? 4 : 2));
        CHECK(t.reports[1].what == loop_part::after_enable);
        CHECK(t.reports[1].how.error() == errc::wrong_state);
        CHECK(t.reports[1].how.setting() == 1);
        CHECK(t.homings() == (is_again ? 2 : 1)); // from the beginning
        CHECK(t.loop.is_motion_allowed() == is_again);
    }
}

TEST_CASE("a halt that the drive refuses makes the list due again") {
    odd_lift t;
    t.begin_homing();
    t.go(3000);
    REQUIRE(t.loop.is_motion_allowed());
    CHECK(t.loop.halt() == errc::wrong_state);
    t.go(300);
    t.loop.enable();
    t.go(3000);
    CHECK(t.homings() == 2);
    CHECK(t.loop.is_motion_allowed());
}

TEST_CASE("a wired stop between two calls of a loop ends its list, though the drive stays energised") {
    SUBCASE("in the list") {
        odd_lift t;
        t.begin_homing();
        held_stepper::is_held = true;
        t.go(3000);
        CHECK_FALSE(t.loop.is_motion_allowed());
        REQUIRE(t.reports.size() == 2);
        CHECK(t.reports[1].what == loop_part::after_enable);
        CHECK_FALSE(t.reports[1].how);
        held_stepper::is_held = false;
        t.go(1000);
        CHECK_FALSE(t.loop.is_motion_allowed());
        t.loop.enable();
        t.go(3000);
        CHECK(t.loop.is_motion_allowed());
        CHECK(t.homings() == 2);
    }
    SUBCASE("between the enable and the list") {
        odd_lift t;
        t.loop.enable();
        for (const bound left{t.r.wire}; t.reports.empty(); left.use()) t.turn(); // the enable
        REQUIRE(t.homings() == 0);
        held_stepper::is_held = true;
        for (const bound left{t.r.wire}; t.drive.cause() != stop_cause::input; left.use()) {
            const duration idle = t.drive.step(); // a bus steps it
            t.r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
        t.go(3000);
        CHECK(t.homings() == 0);
        REQUIRE(t.reports.size() == 2);
        CHECK(t.reports[1].what == loop_part::after_enable);
        CHECK(t.reports[1].how.error() == errc::wrong_state);
        CHECK(t.reports[1].how.setting() == 1);
    }
    SUBCASE("before a halt that comes first") {
        odd_lift t;
        t.drive.has_halt = true;
        t.begin_homing();
        t.go(3000);
        REQUIRE(t.loop.is_motion_allowed());
        held_stepper::is_held = true;
        for (const bound left{t.r.wire}; t.drive.cause() != stop_cause::input; left.use()) {
            const duration idle = t.drive.step();
            t.r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
        held_stepper::is_held = false;
        CHECK(t.loop.halt());
        t.go(500);
        t.loop.enable();
        t.go(3000);
        CHECK(t.homings() == 2);
    }
}

TEST_CASE("G44: wheels move before a program may move them, and a wired stop ends that") {
    constexpr auto settings = take_over{z::resolution{10}};
    constexpr after_enable test_run{z::ramps{200 * millisecond, 200 * millisecond},
                                    velocity{10 * r_per_min, 10 * r_per_min}, halt{}};
    for (std::uint32_t ms = 0; ms < 400; ms += 20) {
        CAPTURE(ms);
        simulated::finer_zlac8015d r{{},
                                     {.feedback = milliseconds(20), .command_timeout = milliseconds(200)}};
        setpoint_loop loop{r.drive, settings, enable{}, test_run, setpoints<z::wheel_velocities>{}};
        std::vector<loop_report> reports;
        const auto go = [&](std::uint32_t time, std::int32_t speed) {
            const std::uint64_t end = r.wire.time_us() + std::uint64_t{time} * 1000;
            while (r.wire.time_us() < end) {
                loop.set({speed * r_per_min, speed * r_per_min});
                const duration idle = loop.step();
                if (const loop_report ended = loop.take_report()) reports.push_back(ended);
                r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            }
        };
        go(1000, 30);
        reports.clear();
        loop.enable();
        go(ms, 30);
        const bool was_allowed = loop.is_motion_allowed();
        if (!was_allowed) CHECK(r.model.left().speed < 11'000'000);
        r.model.set_input(true, false);
        go(1500, 30);
        CHECK_FALSE(loop.is_motion_allowed());
        CHECK(r.model.stands_still());
        std::size_t ends = 0;
        for (const loop_report& e : reports) ends += e.how ? 0u : 1u;
        CHECK(ends == 1);
        r.model.set_input(false, false);
        go(1500, 30);
        CHECK(r.model.stands_still());
        reports.clear();
        loop.enable();
        go(3000, 30);
        CHECK(loop.is_motion_allowed());
        CHECK(r.model.left().speed > 25'000'000);
        REQUIRE(reports.size() == 2);
        CHECK(reports[1].what == loop_part::after_enable);
        CHECK(reports[1].how);
    }
}

TEST_CASE("a C630S is homed in its position mode before its loop allows motion") {
    simulated::driven_c630s r;
    r.model.attach({.home_from = 600'000,
                    .home_to = 660'000,
                    .negative_limit = -90'000'000,
                    .positive_limit = 90'000'000});
    setpoint_loop loop{
        r.drive,
        take_over{c::set_up{}, c::homing_by{c::homing_mode::forward_home_switch, 300 * r_per_min,
                                            60 * r_per_min, 100 * millisecond, 30'000}},
        c::enable_in{c::control_mode::position}, after_enable{c::home{30 * second}}};
    std::vector<loop_report> reports;
    const auto go = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end) {
            const duration idle = loop.step();
            if (const loop_report ended = loop.take_report()) reports.push_back(ended);
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    go(20'000);
    r.model.power_cycle();
    go(20'000);
    REQUIRE(loop.is_taken_over());
    const std::int64_t before = r.model.position();
    reports.clear();
    loop.enable();
    for (const bound left{r.wire}; !r.model.enabled(); left.use()) go(1);
    go(100);
    CHECK_FALSE(loop.is_motion_allowed());
    go(30'000);
    CHECK(loop.is_motion_allowed());
    CHECK(r.model.position() > before + 400'000); // at the switch
    REQUIRE(reports.size() == 2);
    CHECK(reports[1].what == loop_part::after_enable);
    CHECK(reports[1].how);
}

TEST_CASE("G44: on a bus a lift is homed while the wheels turn, and a loss of the one leaves the other") {
    tests::wheels_and_lift m;
    tests::wheels_and_lift_program p{m.wire};
    m.lift_model.attach(rails());
    m.wheels_model.store(0x2022, 10);
    m.wheels_model.power_cycle();
    setpoint_loop wheels{p.wheels, take_over{z::resolution{10}}, enable{}, setpoints<z::wheel_velocities>{}};
    setpoint_loop lift_loop{p.lift, set_up, enable{}, homed};
    std::size_t done = 0;
    std::size_t failed = 0;
    const auto go = [&](std::uint32_t ms) {
        const std::uint64_t end = m.wire.time_us() + std::uint64_t{ms} * 1000;
        while (m.wire.time_us() < end) {
            wheels.set({30 * r_per_min, 30 * r_per_min});
            p.turn(); // all.step()
            wheels.command();
            lift_loop.command();
            (void)wheels.take_report();
            if (const loop_report ended = lift_loop.take_report(); ended.what == loop_part::after_enable)
                ++(ended.how ? done : failed);
        }
    };
    const auto are_wheels_turning = [&] { return m.wheels_model.left().speed > 25'000'000; };
    go(3000);
    CHECK(m.lift_model.starts() == 0);
    wheels.enable();
    lift_loop.enable();
    go(100);
    CHECK_FALSE(lift_loop.is_motion_allowed());
    go(3000);
    CHECK(done == 1);
    CHECK(lift_loop.is_motion_allowed());
    CHECK(m.lift_model.view().is_homed);
    CHECK(are_wheels_turning());
    CHECK(lift_loop.halt());
    go(500);
    lift_loop.enable();
    go(3000);
    CHECK(done == 1);
    CHECK(m.lift_model.starts() == 1);
    CHECK(lift_loop.is_motion_allowed());
    m.lift_model.power_cycle();
    go(4000);
    CHECK(lift_loop.is_taken_over());
    CHECK_FALSE(lift_loop.is_motion_allowed());
    CHECK(m.lift_model.starts() == 1);
    CHECK(are_wheels_turning());
    lift_loop.enable();
    for (const bound left{m.wire}; m.lift_model.starts() == 1; left.use()) go(1);
    m.lift_model.power_cycle(); // during it
    go(4000);
    CHECK(failed == 1);
    CHECK_FALSE(lift_loop.is_motion_allowed());
    lift_loop.enable();
    go(3000);
    CHECK(done == 2);
    CHECK(failed == 1);
    CHECK(m.lift_model.view().is_homed);
    CHECK(lift_loop.is_motion_allowed());
    CHECK(are_wheels_turning());
}

namespace {
constexpr bool is_done_after(loop_part ended, const command_status& how, bool may_move) {
    detail::after_enable_progress p;
    p.begin();
    if (!p.advance(1)) return false;
    p.note_command(may_move, false);
    p.note_end(ended, how, false);
    return p.is_done();
}
const command_status lost{status::sent(errc::timeout)};
} // namespace

TEST_CASE(
    "a stop that fails otherwise, and a moving command, make the list due again, and a setting does not") {
    CHECK(is_done_after(loop_part::stop, {}, true));
    CHECK_FALSE(is_done_after(loop_part::stop, errc::timeout, false));
    CHECK_FALSE(is_done_after(loop_part::command, lost, true));
    CHECK(is_done_after(loop_part::command, lost, false));
    CHECK(is_done_after(loop_part::command, errc::timeout, true)); // nothing was sent
    CHECK(is_done_after(loop_part::command, {}, true));
    CHECK(is_done_after(loop_part::setpoint, lost, true));
}

TEST_CASE("a list of no commands is none") {
    simulated::closed_axis r;
    setpoint_loop loop{r.drive, take_over{}, enable{}, after_enable{}};
    static_assert(std::same_as<decltype(loop), setpoint_loop<decltype(r.drive), take_over<>>>);
    setpoint_loop slow{r.drive, take_over{}, enable{}, after_enable{}, no_setpoints{}, milliseconds(2000)};
    static_assert(std::same_as<decltype(slow), decltype(loop)>);
    for (int i = 0; i < 20'000; ++i) r.wire.wait(loop.step());
    loop.enable();
    for (int i = 0; i < 2'000; ++i) r.wire.wait(loop.step());
    CHECK(loop.is_motion_allowed());
}

TEST_CASE("the commands after an enable have a text") {
    CHECK(text(loop_part::after_enable) == doctest::String("after enable"));
}

} // namespace after_enable_tests
