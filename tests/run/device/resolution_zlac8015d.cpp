// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D whose 2022h a facade changes: no speed is sent before the drive has been powered off and on. The wheels
// of the simulated machine are the oracle.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <functional>

#include <servobus/control/setpoint_loop.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/device/zlac8015d/arguments.hpp>
#include <servobus/device/zlac8015d/axes.hpp>
#include <servobus/device/zlac8015d/robot.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/loop_bound.hpp>

namespace resolution_zlac8015d_tests {

using namespace servobus;
using namespace servobus::literals;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using rig = simulated::driven_zlac8015d;
using options = sim::zlac8015d_options;

namespace {

constexpr feed wheel = rolling(534_mm, counts_per_turn{4096});
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 400_mm});
constexpr auto belt = axis::of(wheel);
constexpr std::int64_t wanted = 50'000'000; // 50 r/min
constexpr auto set_up = take_over{resolution{10}, ramps{20 * millisecond, 20 * millisecond}};

std::int64_t magnitude(std::int64_t v) { return v < 0 ? -v : v; }

// Each combination of the switches that decide what is kept and when it counts.
template <class F> void under_each_reading(F f) {
    for (const bool is_immediate : {false, true}) {
        for (const auto kept : {options::kept::marked, options::kept::all}) {
            CAPTURE(is_immediate);
            CAPTURE(kept == options::kept::all);
            f(options{.save = kept, .rescales_immediately = is_immediate});
        }
    }
}

/// A program that has the drive taken over until it is, and then turns the wheels at 50 r/min. `before_each_step` is
/// the trouble.
struct program {
    rig r;
    std::function<void()> before_each_step = [] {};
    std::int64_t fastest = 0;

    explicit program(options chosen) : r{chosen} {}

    template <class Command> command_status run(const Command& command) {
        if (const command_status begun = r.drive.begin(command); !begun) return begun;
        for (tests::loop_bound left{"the end of a command"}; !r.drive.is_idle(); left.use()) {
            before_each_step();
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            watch();
        }
        return r.drive.last();
    }
    template <class... Settings> command_status run(const take_over<Settings...>& list) {
        return list.run_by(r.drive, [this](const auto& command) { return this->run(command); });
    }
    void watch() {
        for (const auto speed : {magnitude(r.model.left().speed), magnitude(r.model.right().speed)}) {
            if (speed > fastest) fastest = speed;
        }
    }
    // True if the wheels turn at 50 r/min at its end.
    bool turn() {
        if (!run(enable{}) || !run(velocity{50 * r_per_min, -50 * r_per_min})) return false;
        for (int i = 0; i < 30; ++i) { // a restart may have lost the ramps, not the scale
            if (!run(read_feedback{})) return false;
            r.wire.pass(milliseconds(20));
            watch();
        }
        const bool turns = r.drive.state() == drive_state::enabled;
        if (turns) {
            CHECK(r.model.left().speed == wanted);
            CHECK(r.model.right().speed == -wanted);
        }
        (void)run(disable{});
        return turns;
    }
    // Works until the wheels turn; who reads what the take-over says powers the drive off and on.
    void work() {
        int power_cycles = 0;
        bool turns = false;
        for (int i = 0; i < 12 && !turns; ++i) {
            const command_status how = run(set_up);
            CHECK(fastest <= wanted);
            if (how.part() == take_over_part::power_cycle) {
                CHECK(r.drive.state() == drive_state::needs_power_cycle);
                CHECK(run(enable{}).error() == errc::wrong_state);
                r.wire.pass(milliseconds(3000)); // of reading the message
                r.model.power_cycle();
                ++power_cycles;
            }
            if (how) turns = turn();
        }
        CHECK(turns);
        CHECK(fastest == wanted);
        CHECK(r.model.resolution() == 10);
        CHECK(power_cycles <= 3);
    }
};

} // namespace

TEST_CASE("a resolution that the drive has is taken: nothing is written and no power cycle is asked for") {
    rig r;
    r.have_resolution(10);
    const std::uint32_t worn = r.model.eeprom_writes();
    REQUIRE(r.drive.run(init{}));
    const std::uint32_t writes = r.model.writes();
    const std::size_t frames = r.log.frames.size();
    REQUIRE(r.drive.run(resolution{10}));
    CHECK(r.model.writes() == writes);
    CHECK(r.log.frames.size() == frames + 1);
    CHECK(r.model.eeprom_writes() == worn);
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable{}));
    REQUIRE(r.drive.run(velocity{125 * part<10>(r_per_min), 0 * r_per_min}));
    REQUIRE(r.live(milliseconds(1000)));
    CHECK(r.model.left().speed == 12'500'000);
}

TEST_CASE("G17, G46: another resolution is saved once, and refuses to enable until the power was off") {
    under_each_reading([](const options& of) {
        rig r{of};
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(resolution{10}));
        CHECK(r.model.peek(0x2022) == 10);
        CHECK(r.model.peek(0x2010) == 0);
        CHECK(r.sent(modbus::write_frame(1, 0x2010, 1)) == 1);
        CHECK(r.sent(modbus::write_frame(1, 0x2010, 0)) == 1); // 1 may be a mode
        CHECK(r.model.saves() == 1);
        for (int i = 0; i < 3; ++i) {
            CHECK(r.drive.state() == drive_state::needs_power_cycle);
            CHECK(r.drive.run(enable{}).error() == errc::wrong_state);
            CHECK(r.drive.run(enable_in{operating_mode::torque}).error() == errc::wrong_state);
            CHECK(r.drive.run(velocity{1 * r_per_min, 0 * r_per_min}).error() == errc::wrong_state);
            CHECK(r.drive.run(save{}).error() == errc::wrong_state);
            CHECK(r.drive.run(resolution{5}).error() == errc::wrong_state);
            CHECK(r.drive.read());
            // Neither a stop nor a silence ends it.
            CHECK(r.drive.run(disable{}));
            CHECK(r.drive.run(quick_stop{}));
            CHECK(r.drive.run(halt{}));
            CHECK(r.drive.run(fault_reset{}));
            CHECK(r.drive.state() == drive_state::needs_power_cycle);
            if (i == 1) r.wire.pass(milliseconds(5000));
            REQUIRE(r.drive.run(init{}));
        }
        CHECK(r.model.saves() == 1);
        CHECK(r.model.enables() == 0);
        const refusal why_not = why(r.drive, enable{});
        CHECK(why_not.is_of_state());
        CHECK(why_not.state == drive_state::needs_power_cycle);
        CHECK(why_not.states.has(drive_state::disabled));
        r.model.power_cycle();
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.state() == drive_state::disabled);
        REQUIRE(r.drive.run(resolution{10}));
        REQUIRE(r.drive.run(enable{}));
        REQUIRE(r.drive.run(velocity{125 * part<10>(r_per_min), 0 * r_per_min}));
        REQUIRE(r.live(milliseconds(1000)));
        CHECK(r.model.left().speed == 12'500'000);
        CHECK(r.model.saves() == 1);
        // The next init has the frames of a drive that needs nothing.
        REQUIRE(r.drive.run(disable{}));
        r.log.frames.clear();
        REQUIRE(r.drive.run(init{}));
        CHECK(r.sent(modbus::read_frame(1, 0x200D, 1)) == 0);
    });
}

TEST_CASE("G46: no wheel turns faster than it was told, wherever in a resolution the drive restarts") {
    under_each_reading([](const options& of) {
        std::uint32_t at = 0;
        for (bool is_over = false; !is_over; ++at) {
            for (const std::uint32_t restarts : {1u, 2u}) {
                CAPTURE(at);
                CAPTURE(restarts);
                program p{of};
                std::uint32_t done = 0;
                p.before_each_step = [&] { // before that frame, and once more before the next
                    if (done == restarts || p.r.wire.requests() < at + done) return;
                    ++done;
                    p.r.model.power_cycle();
                };
                p.work();
                is_over = done == 0;
            }
        }
        CHECK(at > 20);
    });
}

TEST_CASE("G46: no wheel turns faster than it was told, wherever in a resolution a frame is lost") {
    under_each_reading([](const options& of) {
        std::uint32_t at = 0;
        for (bool is_over = false; !is_over; ++at) {
            for (const bool loses_request : {false, true}) {
                for (const std::uint32_t frames : {1u, 4u}) {
                    CAPTURE(at);
                    CAPTURE(loses_request);
                    CAPTURE(frames);
                    program p{of};
                    is_over = true;
                    p.before_each_step = [&] {
                        const std::uint32_t n = p.r.wire.requests();
                        const bool is_lost = n >= at && n < at + frames;
                        if (is_lost) is_over = false;
                        auto& faults = p.r.wire.faults();
                        (loses_request ? faults.lost_request : faults.lost_response) = is_lost ? 1000 : 0;
                    };
                    p.work();
                    CHECK(p.r.model.saves() <= 2);
                }
            }
        }
        CHECK(at > 20);
    });
}

TEST_CASE("G46: no wheel turns faster than it was told, wherever a stop replaces a resolution") {
    under_each_reading([](const options& of) {
        std::uint32_t at = 0;
        for (bool is_over = false; !is_over; ++at) {
            for (const bool restarts : {false, true}) {
                CAPTURE(at);
                CAPTURE(restarts);
                program p{of};
                is_over = true;
                REQUIRE(p.run(init{}));
                const std::uint32_t first = p.r.wire.requests();
                p.before_each_step = [&] {
                    if (!is_over || p.r.wire.requests() < first + at) return;
                    is_over = false;
                    if (restarts) p.r.model.power_cycle();
                    REQUIRE(p.r.drive.begin(disable{}) == errc::ok);
                };
                (void)p.run(resolution{10});
                p.before_each_step = [] {};
                // Without a take-over the enable finds out.
                for (const auto& mode :
                     {enable_mode{operating_mode::velocity}, enable_mode{operating_mode::torque}})
                    (void)p.run(enable_in{mode}), (void)p.run(velocity{50 * r_per_min, -50 * r_per_min});
                p.r.wire.pass(milliseconds(100));
                p.watch();
                CHECK(p.fastest <= wanted);
                p.work();
            }
        }
        CHECK(at > 8);
    });
}

TEST_CASE("a resolution that was not written asks for no power cycle") {
    program p{{}};
    REQUIRE(p.run(init{}));
    p.r.wire.faults().lost_request = 1000;
    CHECK(p.run(resolution{10}).outcome() == outcome::not_sent);
    p.r.wire.faults().lost_request = 0;
    REQUIRE(p.run(init{}));
    CHECK(p.r.drive.state() == drive_state::disabled);
    const std::uint32_t first = p.r.wire.requests();
    p.before_each_step = [&] { p.r.model.refuses = p.r.wire.requests() == first + 2; }; // the write
    CHECK(p.run(resolution{10}).outcome() == outcome::refused);
    p.before_each_step = [] {};
    p.r.model.refuses = false;
    CHECK(p.r.model.writes_to(0x2022) == 0);
    REQUIRE(p.run(init{}));
    CHECK(p.r.drive.state() == drive_state::disabled);
}

TEST_CASE("a drive that did not keep the value is told again") {
    rig r;
    for (int i = 0; i < 3; ++i) {
        const command_status how = r.drive.run(set_up);
        CHECK(how.part() == take_over_part::power_cycle);
        CHECK(how.error() == errc::wrong_state);
        CHECK(r.model.saves() == static_cast<std::uint32_t>(i + 1)); // once for each power cycle
        r.model.store(0x2022, 1);
        r.model.power_cycle();
    }
    CHECK(r.model.enables() == 0);
}

TEST_CASE("a value that another program wrote is taken as it is found") {
    rig r;
    r.have_resolution(5);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    REQUIRE(r.drive.run(velocity{30 * r_per_min, 0 * r_per_min}));
    REQUIRE(r.live(milliseconds(1000)));
    CHECK(r.model.left().speed == 30'000'000);
}

TEST_CASE("G17: a setpoint loop that waits for the power cycle writes and saves once") {
    under_each_reading([](const options& of) {
        rig r{of, {.feedback = milliseconds(20), .command_timeout = milliseconds(200)}};
        setpoint_loop loop{r.drive, set_up, enable{}, setpoints<clamped_velocity>{}};
        std::size_t power_cycles = 0;
        const auto go = [&](std::uint32_t ms) {
            for (std::uint32_t t = 0; t < 10 * ms; ++t) {
                loop.set({50 * r_per_min, -50 * r_per_min});
                (void)loop.step();
                if (const loop_report ended = loop.take_report();
                    ended.what == loop_part::take_over && ended.how.part() == take_over_part::power_cycle)
                    ++power_cycles;
                r.wire.pass(microseconds(100));
                CHECK(magnitude(r.model.left().speed) <= wanted);
            }
        };
        loop.enable();
        go(2000);
        const std::uint32_t saves = r.model.saves();
        const std::uint32_t worn = r.model.eeprom_writes();
        CHECK(saves == 1);
        loop.enable();
        go(30'000);
        CHECK(power_cycles == 1); // it is reported once
        CHECK_FALSE(loop.is_taken_over());
        CHECK(r.model.eeprom_writes() == worn);
        CHECK(r.model.writes_to(0x2022) == 1);
        CHECK(r.model.enables() == 0);
        r.model.power_cycle();
        go(3000);
        CHECK(loop.is_taken_over());
        loop.enable();
        go(3000);
        CHECK(r.model.left().speed == wanted);
        CHECK(r.model.eeprom_writes() == worn);
    });
}

TEST_CASE("G46: a factory reset of a finer resolution counts from the next power-on too") {
    under_each_reading([](const options& of) {
        program p{of};
        p.r.have_resolution(10);
        REQUIRE(p.run(init{}));
        REQUIRE(p.run(factory_reset{sole_drive_on_the_line{}}));
        CHECK(p.r.model.peek(0x2022) == 1);
        CHECK(p.r.drive.state() == drive_state::needs_power_cycle);
        REQUIRE(p.run(init{}));
        CHECK(p.run(enable{}).error() == errc::wrong_state);
        p.r.model.power_cycle();
        REQUIRE(p.run(init{}));
        REQUIRE(p.run(ramps{20 * millisecond, 20 * millisecond}));
        CHECK(p.turn());
    });
}

TEST_CASE("G46: the facades of a robot and of two axes wait for the power cycle too") {
    const auto waits = [](auto& r, auto& facade) {
        const auto how = facade.run(take_over{resolution{10}});
        CHECK(how.part() == take_over_part::power_cycle);
        for (int i = 0; i < 3; ++i) {
            REQUIRE(facade.run(init{}));
            CHECK(facade.state() == drive_state::needs_power_cycle);
            CHECK(facade.run(enable{}).error() == errc::wrong_state);
        }
        r.model.power_cycle();
        REQUIRE(facade.run(take_over{resolution{10}}));
        CHECK(facade.state() == drive_state::disabled);
        REQUIRE(facade.run(enable{}));
        CHECK(facade.cached().resolution == 10);
    };
    SUBCASE("robot") {
        rig r;
        zlac8015d::robot robot{r.line, node<device>{1}, base, unsupervised};
        waits(r, robot);
    }
    SUBCASE("axes") {
        rig r;
        zlac8015d::axes belts{r.line, node<device>{1}, belt, belt, unsupervised};
        waits(r, belts);
    }
}

TEST_CASE("G46: a resolution of a robot ends as that of its drive, whichever response is lost") {
    struct end {
        errc how;
        drive_state state;
        bool is_saved;
    };
    // `has_lost`: there was a frame to lose.
    const auto end_of = [](auto& r, auto& facade, std::uint32_t lost, bool& has_lost) {
        REQUIRE(facade.run(init{}));
        REQUIRE(facade.run(enable{})); // from then on its mode is known
        REQUIRE(facade.run(disable{}));
        const std::uint32_t first = r.wire.requests();
        REQUIRE(facade.begin(resolution{10}) == errc::ok);
        for (tests::loop_bound left{"the end of a resolution"}; !facade.is_idle(); left.use()) {
            const bool is_now = r.wire.requests() == first + lost;
            r.wire.faults().lost_response = is_now ? 1000 : 0;
            has_lost = has_lost || is_now;
            const duration idle = facade.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
        r.wire.faults() = {};
        return end{facade.last().error(), facade.state(), r.model.saves() != 0};
    };
    constexpr supervision polled{.feedback = milliseconds(20), .command_timeout = milliseconds(400)};
    unsigned played = 0;
    for (std::uint32_t lost = 1; lost < 30; ++lost) {
        CAPTURE(lost);
        bool has_lost = false;
        bool has_lost_too = false;
        rig one;
        zlac8015d::drive plain{one.line, node<device>{1}, polled};
        const end of_drive = end_of(one, plain, lost, has_lost);
        rig other;
        zlac8015d::robot robot{other.line, node<device>{1}, base, polled};
        const end of_robot = end_of(other, robot, lost, has_lost_too);
        CHECK(of_robot.how == of_drive.how);
        CHECK(of_robot.state == of_drive.state);
        CHECK(of_robot.is_saved == of_drive.is_saved);
        played += has_lost && has_lost_too ? 1u : 0u;
    }
    CHECK(played >= 6);
}

} // namespace resolution_zlac8015d_tests
