// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An arrival is that of the last move that was begun, for each drive: none while the next one begins, none if that
// fails, and that of the move under way where another was refused as busy. A status and settings that a program keeps
// do not change.
#include <cstdint>
#include <type_traits>
#include <utility>

#include <doctest/doctest.h>

#include <servobus/control/axis_commands.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/control/wiring.hpp>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_c630s.hpp>
#include <tests/support/enabled_yako.hpp>
#include <tests/support/enabled_zlac8015d.hpp>

namespace last_arrival_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

// A subject is a drive that is enabled for moves, a move of it, one that is out of range, and what ends its motion.
struct wheels {
    simulated::driven_zlac8015d r{};
    wheels() { enabled_zlac8015d::be_enabled_in(r, zlac8015d::operating_mode::relative_position); }
    static auto move() { return move_by{4000 * zlac8015d::pulse, 4000 * zlac8015d::pulse}; }
    static auto too_far() { return move_by{distance{-0x7FFF'FFFF - 1}, distance{0}}; }
    using distance = zlac8015d::distance;
    void fail() { r.model.raise(zlac8015d::fault::overload, {}); }
    void mend() { r.model.end_faults(); }
    auto enabled() { return zlac8015d::enable_in{zlac8015d::operating_mode::relative_position}; }
    void turn() {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
};
struct stepper {
    simulated::closed_axis r{};
    stepper() { enabled_yako::take(r); }
    static auto move() { return move_by{4000 * yako::pulse}; }
    static auto too_far() { return move_by{4000 * yako::pulse, {{}, {}, {}, 30'000 * r_per_min}}; }
    void fail() { r.model.raise_alarm(4); }
    void mend() { r.model.end_alarm(); }
    auto enabled() { return enable{}; }
    void turn() { r.turn(); }
};
struct servo {
    simulated::driven_c630s r{};
    servo() {
        using namespace c630s;
        REQUIRE(r.make_ready());
        REQUIRE(r.drive.run(position_segments{.type = displacement_type::relative}));
        REQUIRE(r.drive.run(segment{1, 4000 * reference_unit, 600 * r_per_min, 20 * millisecond}));
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
    }
    static auto move() { return c630s::start_segment{1}; }
    void turn() { r.turn(); }
};

} // namespace

TEST_CASE_TEMPLATE("G34: while a move begins there is no arrival, and none stays if it fails", S, wheels,
                   stepper) {
    S s;
    auto& drive = s.r.drive;
    REQUIRE(drive.run(S::move(), wait_reached{}).how == arrival_state::reached);
    REQUIRE(drive.begin(S::move()) == errc::ok);
    unsigned begins = 0;
    for (; !drive.is_idle(); ++begins) {
        CHECK(drive.arrival().how == arrival_state::none);
        REQUIRE(begins < 100'000);
        s.turn();
    }
    CHECK(begins > 10);
    REQUIRE(drive.last());
    REQUIRE(drive.run(wait_reached{}));
    CHECK(drive.arrival().how == arrival_state::reached);
    SUBCASE("a fault before its start") {
        s.fail();
        REQUIRE(drive.read());
        CHECK(drive.run(S::move()).error() == errc::faulted);
        CHECK(drive.arrival().how == arrival_state::none);
        s.mend();
        REQUIRE(drive.run(fault_reset{}));
        REQUIRE(drive.run(s.enabled()));
    }
    SUBCASE("a value out of range") { CHECK(drive.run(S::too_far()).error() == errc::out_of_range); }
    SUBCASE("no consent to move: it is disabled") {
        REQUIRE(drive.run(disable{}));
        CHECK(drive.run(S::move()).error() == errc::wrong_state);
    }
    SUBCASE("a stop in its place") {
        REQUIRE(drive.begin(S::move()) == errc::ok);
        REQUIRE(drive.run(quick_stop{}));
    }
    CHECK(drive.arrival().how == arrival_state::none);
    CHECK(drive.run(wait_reached{}).error() == errc::wrong_state);
}

TEST_CASE_TEMPLATE("G34: a move that is refused as busy leaves the one under way its target", S, wheels,
                   stepper) {
    S s;
    auto& drive = s.r.drive;
    REQUIRE(drive.run(S::move()));
    CHECK(drive.run(S::move()).error() == errc::busy); // as the drive shows
    REQUIRE(drive.arrival().how == arrival_state::under_way);
    REQUIRE(drive.begin(wait_reached{}) == errc::ok);
    CHECK(drive.begin(S::move()) == errc::busy); // as the wait is under way
    for (unsigned i = 0; !drive.is_idle(); ++i) {
        REQUIRE(i < 100'000);
        s.turn();
    }
    CHECK(drive.last());
    CHECK(drive.arrival().how == arrival_state::reached);
}

TEST_CASE("G34: a move of one wheel that begins leaves the other its arrival") {
    using namespace zlac8015d;
    using which = zlac8015d::wheels;
    simulated::driven_zlac8015d r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::relative_position, synchronisation::asynchronous}));
    REQUIRE(r.drive.run(move_left_by{4096 * pulse}));
    REQUIRE(r.drive.run(wait_wheels_reached{which::left}));
    REQUIRE(r.drive.arrival(which::left).how == arrival_state::reached);
    REQUIRE(r.drive.begin(move_right_by{4096 * pulse}) == errc::ok);
    for (int i = 0; i < 100'000 && !r.drive.is_idle(); ++i) {
        CHECK(r.drive.arrival(which::left).how == arrival_state::reached);
        CHECK(r.drive.arrival(which::right).how == arrival_state::none);
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(r.drive.last());
}

TEST_CASE("G34: a C630S has no arrival while its next segment begins, nor if that is refused") {
    servo s;
    auto& drive = s.r.drive;
    REQUIRE(drive.run(servo::move(), wait_reached{}).how == arrival_state::reached);
    REQUIRE(drive.begin(servo::move()) == errc::ok);
    unsigned begins = 0;
    for (; !drive.is_idle(); ++begins) {
        CHECK(drive.arrival().how == arrival_state::none);
        REQUIRE(begins < 100'000);
        s.turn();
    }
    CHECK(begins > 10);
    REQUIRE(drive.last());
    CHECK(drive.arrival().how == arrival_state::under_way);
    REQUIRE(drive.run(wait_reached{}));
    CHECK(drive.arrival().how == arrival_state::reached);
    REQUIRE(drive.run(disable{}));
    CHECK(drive.run(servo::move()).error() == errc::wrong_state);
    CHECK(drive.arrival().how == arrival_state::none);
    CHECK(drive.run(wait_reached{}).error() == errc::wrong_state);
}

TEST_CASE("the status and the settings that a program keeps are those of when it asked") {
    simulated::driven_zlac8015d r;
    REQUIRE(r.drive.run(init{}));
    (void)r.drive.run(velocity{30 * r_per_min, 30 * r_per_min}); // refused: not enabled
    const auto& status = r.drive.last();
    const auto& settings = r.drive.cached();
    REQUIRE(status.error() == errc::wrong_state);
    REQUIRE(r.drive.read());
    REQUIRE(r.drive.run(zlac8015d::watchdog{700 * units::millisecond}));
    CHECK(r.drive.last());
    CHECK(r.drive.cached().host_timeout == 700);
    CHECK(status.error() == errc::wrong_state);
    CHECK(settings.host_timeout == 1000);
    static_assert(!std::is_reference_v<decltype(r.drive.last())> &&
                  !std::is_reference_v<decltype(r.drive.cached())>);
}

namespace {
template <class Arrival> constexpr bool is_true_where_reached() {
    Arrival a{};
    for (const arrival_state how : {arrival_state::none, arrival_state::under_way,
                                    arrival_state::stopped_short, arrival_state::reached}) {
        a.how = how;
        if (static_cast<bool>(a) != (how == arrival_state::reached)) return false;
    }
    return true;
}
static_assert(is_true_where_reached<zlac8015d::arrival>() && is_true_where_reached<c630s::arrival>() &&
              is_true_where_reached<yako::arrival>() && is_true_where_reached<axis_arrival>());
} // namespace

TEST_CASE_TEMPLATE("4.1: whether a motion was seen is asked anew by each move", S, wheels, stepper, servo) {
    S s;
    auto& drive = s.r.drive;
    REQUIRE(drive.run(S::move(), wait_reached{}).how == arrival_state::reached);
    const motion_check before = drive.motion();
    REQUIRE(drive.begin(S::move()) == errc::ok);
    CHECK(drive.motion() == motion_check::not_asked);
    for (unsigned i = 0; !drive.is_idle(); ++i) {
        REQUIRE(i < 100'000);
        s.turn();
    }
    REQUIRE(drive.last());
    REQUIRE(drive.run(wait_reached{}));
    CHECK(drive.motion() == before);
}

} // namespace last_arrival_tests
