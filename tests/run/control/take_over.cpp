// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A take-over on each simulated drive: its parts in their order, where it ends and how, and that nothing is energised
// or moved by it. Judged by the simulated machine and by the frames on the wire.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/control/take_over.hpp>
#include <servobus/registers/literals.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace take_over_tests {

using namespace servobus;
using namespace servobus::units;
using part = take_over_part;
namespace z = servobus::zlac8015d;
namespace y = servobus::yako;
namespace c = servobus::c630s;

// What moves or energises.
template <class Model, class... Commands> constexpr bool all_move = (may_move<Model, Commands> && ...);
template <class Model, class... Commands> constexpr bool none_moves = (!may_move<Model, Commands> && ...);
static_assert(
    all_move<z::model, enable, z::enable_in, z::wheel_velocities, z::left_velocity, z::right_velocity,
             z::clamped_velocity, z::torque, z::left_torque, z::right_torque, z::wheel_ways, z::move_left_by,
             z::move_right_by, z::wheel_places, z::move_left_to, z::move_right_to>);
static_assert(none_moves<z::model, init, disable, halt, quick_stop, fault_reset, read_feedback,
                         wait_standstill, wait_reached, z::resolution, z::watchdog, z::ramps, z::save,
                         z::park, z::clear_position, z::factory_reset, z::brakes, z::quick_stop_by>);
using stepper = y::model<y::closed_loop::device>;
static_assert(all_move<stepper, enable, y::relative_move, y::absolute_move, y::jog_velocity, y::bounded_jog,
                       y::closed_loop::home>);
static_assert(
    none_moves<stepper, disable, y::position_declaration, y::accept_position, y::clear_position, y::set_input,
               y::set_output, y::set_profile, y::set_homing_profile, y::travel_bounds, y::save>);
static_assert(all_move<c::model, enable, c::enable_in, c::motor_velocity, c::torque, c::jog,
                       c::run_speed_segments, c::start_segment, c::start_segments, c::make_step, c::home,
                       c::home_electrically, c::select_speed_segment>);
static_assert(none_moves<c::model, disable, c::set_up, c::ramps, c::torque_limits, c::segment,
                         c::position_segments, c::homing_by, c::set_home, c::step_size, c::read_status>);

static_assert(sizeof(take_over<>) == 1);
static_assert(sizeof(take_over<with_fault_reset, disable, z::resolution>) <= 4); // empty ones take no room
static_assert(sizeof(command_status) <= 12);

namespace {
constexpr auto for_wheels = take_over{z::resolution{10}, z::watchdog{500 * millisecond},
                                      z::ramps{200 * millisecond, 300 * millisecond}};
constexpr auto for_wheels_with_reset =
    take_over{with_fault_reset{}, z::resolution{10}, z::watchdog{500 * millisecond}};
} // namespace

TEST_CASE("a take-over runs init, the settings in their order, and a reading") {
    simulated::finer_zlac8015d r;
    const command_status done = r.drive.run(for_wheels);
    REQUIRE(done);
    CHECK(done.part() == part::reading);
    CHECK(done.setting() == 0);
    CHECK(done.error() == errc::ok);
    CHECK(r.drive.last());
    CHECK(r.drive.state() == drive_state::disabled);
    CHECK(r.drive.cached().resolution == 10);
    CHECK(r.drive.cached().host_timeout == 500);
    CHECK(r.model.peek(z::left_acceleration_time.address) == 200);
    CHECK(r.model.peek(z::right_deceleration_time.address) == 300);
    CHECK(r.drive.feedback(milliseconds(10)));
    CHECK(r.model.enables() == 0);
    CHECK_FALSE(r.model.enabled());
    for (const simulated::frame& f : r.log.frames) CHECK_FALSE(simulated::is_motion_or_enable(f));
    // The last frame reads the feedback.
    CHECK(r.log.frames.back()[1] == 0x03);
    CHECK(load_word(r.log.frames.back(), 2) == 0x20A2);
}

TEST_CASE("a take-over without settings is init and a reading") {
    simulated::finer_zlac8015d r;
    REQUIRE(r.drive.run(take_over{}));
    CHECK(r.drive.feedback(milliseconds(10)));
}

TEST_CASE("a take-over sends the frames of its commands, run one by one") {
    simulated::finer_zlac8015d a;
    simulated::finer_zlac8015d b;
    REQUIRE(a.drive.run(for_wheels));
    REQUIRE(b.drive.run(init{}));
    REQUIRE(b.drive.run(z::resolution{10}));
    REQUIRE(b.drive.run(z::watchdog{500 * millisecond}));
    REQUIRE(b.drive.run(z::ramps{200 * millisecond, 300 * millisecond}));
    REQUIRE(b.drive.read());
    CHECK(a.log.frames == b.log.frames);
}

TEST_CASE("a take-over that fails says which part and how, and sends nothing more") {
    SUBCASE("init: the drive does not respond") {
        simulated::finer_zlac8015d r;
        r.wire.set_connected(0, false);
        const auto done = r.drive.run(for_wheels);
        CHECK_FALSE(done);
        CHECK(done.part() == part::init);
        CHECK(done.setting() == 0);
        CHECK(done.error() == errc::timeout);
    }
    SUBCASE("a setting that is refused") {
        simulated::finer_zlac8015d r;
        const auto done = r.drive.run(take_over{z::watchdog{500 * millisecond}, z::resolution{11},
                                                z::ramps{200 * millisecond, 300 * millisecond}});
        CHECK_FALSE(done);
        CHECK(done.part() == part::setting);
        CHECK(done.setting() == 2);
        CHECK(done.error() == errc::out_of_range);
        CHECK(done.outcome() == outcome::not_sent);
        CHECK(r.drive.last().error() == errc::out_of_range);
        CHECK(r.model.peek(z::left_acceleration_time.address) == 500);
        CHECK(r.drive.cached().host_timeout == 500);
    }
    SUBCASE("the number counts without the reset") {
        simulated::finer_zlac8015d r;
        const auto done = r.drive.run(take_over{with_fault_reset{}, z::resolution{11}});
        CHECK(done.part() == part::setting);
        CHECK(done.setting() == 1);
    }
    SUBCASE("a lost port") {
        simulated::finer_zlac8015d r;
        r.wire.unplug();
        const auto done = r.drive.run(for_wheels);
        CHECK(done.part() == part::init);
        CHECK(done.error() == errc::port_lost);
        r.wire.plug();
        CHECK(r.drive.run(for_wheels));
    }
    SUBCASE("responses that are lost from each of its frames on") {
        std::size_t frames = 0;
        unsigned part_before = 0;
        bool is_done = false;
        for (std::uint32_t good = 0; !is_done && good < 200; ++good) {
            CAPTURE(good);
            simulated::finer_zlac8015d r;
            const command_status done = for_wheels.run_by(r.drive, [&](const auto& command) {
                if (const command_status begun = r.drive.begin(command); !begun) return begun;
                while (!r.drive.is_idle()) {
                    if (r.wire.requests() > good) r.wire.faults().lost_response = 1000;
                    r.line.sleep(r.drive.step());
                }
                return r.drive.last();
            });
            is_done = static_cast<bool>(done);
            // The later the loss, the later the part.
            const unsigned number = (done.part() == part::init      ? 0u
                                     : done.part() == part::setting ? done.setting()
                                                                    : 9u);
            CHECK(number >= part_before);
            part_before = number;
            ++frames;
            CHECK(r.model.enables() == 0);
        }
        CHECK(is_done);
        CHECK(frames > 12);
    }
}

TEST_CASE("a fault is reset by a take-over that asks for it, and else reported by the state") {
    simulated::finer_zlac8015d r;
    REQUIRE(r.drive.run(init{}));
    r.model.raise(z::fault::overcurrent, z::fault::none);
    REQUIRE(r.drive.run(for_wheels));
    CHECK(r.drive.state() == drive_state::faulted);
    SUBCASE("its cause lasts") {
        const auto done = r.drive.run(for_wheels_with_reset);
        CHECK(done.part() == part::fault_reset);
        CHECK(done.error() == errc::faulted);
    }
    SUBCASE("its cause has ended") {
        r.model.end_faults();
        REQUIRE(r.drive.run(for_wheels));
        CHECK(r.drive.state() == drive_state::faulted);
        REQUIRE(r.drive.run(for_wheels_with_reset));
        CHECK(r.drive.state() == drive_state::disabled);
        CHECK(r.drive.cached().resolution == 10);
        // Nothing to reset: no reset is sent.
        const std::uint32_t resets = r.model.commands(z::control_code::fault_reset);
        REQUIRE(r.drive.run(for_wheels_with_reset));
        CHECK(r.model.commands(z::control_code::fault_reset) == resets);
    }
    CHECK(r.model.enables() == 0);
}

TEST_CASE("a drive that restarts at the end of a take-over is not taken over") {
    detail::take_over_progress parts{false, 0};
    parts.conclude({}, drive_state::disabled);
    CHECK(parts.due() == part::reading);
    parts.conclude({}, drive_state::needs_init);
    CHECK(parts.is_over());
    CHECK(parts.status().part() == part::reading);
    CHECK(parts.status().error() == errc::needs_init);
    // A fault that has come since the reset.
    detail::take_over_progress resets{true, 0};
    resets.conclude({}, drive_state::disabled);
    resets.conclude({}, drive_state::faulted);
    CHECK(resets.due() == part::fault_reset);
    resets.conclude({}, drive_state::disabled);
    resets.conclude({}, drive_state::faulted);
    CHECK(resets.is_over());
    CHECK(resets.status().part() == part::reading);
    CHECK(resets.status().error() == errc::faulted);
}

TEST_CASE("a take-over of a stepper: settings that need it without power follow a disable") {
    simulated::closed_axis r;
    const auto inputs = take_over{with_fault_reset{},
                                  disable{},
                                  y::set_input{y::input_terminal::x0, y::input_function::home},
                                  y::set_input{y::input_terminal::x1, y::input_function::positive_limit},
                                  y::set_over_travel_stop{y::over_travel_stop::emergency_stop},
                                  y::set_homing_profile{120 * r_per_min, 30 * r_per_min, 100 * millisecond}};
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.state() == drive_state::enabled); // by its power-on
    const auto refused = r.drive.run(take_over{y::set_input{y::input_terminal::x0, y::input_function::home}});
    CHECK(refused.part() == part::setting);
    CHECK(refused.error() == errc::wrong_state);
    REQUIRE(r.drive.run(inputs));
    CHECK(r.drive.state() == drive_state::disabled);
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.feedback(milliseconds(10)));
    r.model.raise_alarm(1);
    REQUIRE(r.drive.read());
    r.model.end_alarm();
    REQUIRE(r.drive.run(inputs));
    CHECK(r.drive.state() == drive_state::disabled);
    CHECK_FALSE(r.is_moving());
}

TEST_CASE("a C630S is taken over in two goes: before and after its power cycle") {
    simulated::driven_c630s r;
    const auto list = take_over{c::set_up{}, c::torque_limits{40 * percent, 60 * percent}};
    const auto first = r.drive.run(list);
    CHECK_FALSE(first);
    CHECK(first.part() == part::power_cycle);
    CHECK(first.error() == errc::wrong_state);
    CHECK(r.drive.needs_power_cycle());
    CHECK(r.written_to(c::positive_internal_torque_limit.address).empty());
    // Again before the power was off: the same, and no register is written again.
    const auto again = r.drive.run(list);
    CHECK(again.part() == part::power_cycle);
    CHECK(r.written_to(c::positive_internal_torque_limit.address).empty());
    r.model.power_cycle();
    const auto last = r.drive.run(list);
    CHECK(last);
    CHECK(r.drive.state() == drive_state::disabled);
    CHECK(r.written_to(c::positive_internal_torque_limit.address).size() == 1);
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.feedback(milliseconds(50)));
    REQUIRE(r.drive.run(enable{}));
}

TEST_CASE("a C630S that is not set up is not taken over without its set-up") {
    simulated::driven_c630s r;
    const auto done = r.drive.run(take_over{});
    CHECK(done.part() == part::set_up);
    CHECK(done.error() == errc::wrong_state);
    CHECK(r.drive.state() == drive_state::needs_set_up);
}

TEST_CASE("a bus takes its drives over while the others go on") {
    tests::wheels_and_lift m;
    tests::wheels_and_lift_program p{m.wire};
    m.wheels_model.store(0x2022, 10);
    m.wheels_model.power_cycle();
    REQUIRE(p.all.run(p.wheels, for_wheels));
    REQUIRE(p.wheels.run(enable{}));
    const auto done =
        p.all.run(p.lift, take_over{disable{}, y::set_input{y::input_terminal::x0, y::input_function::home}});
    CHECK(done);
    CHECK(p.lift.state() == drive_state::disabled);
    CHECK(p.wheels.state() == drive_state::enabled); // was read meanwhile
    m.wire.set_connected(1, false);
    const auto failed = p.all.run(p.lift, take_over{disable{}});
    CHECK(failed.part() == part::init);
    CHECK(failed.error() == errc::timeout);
}

TEST_CASE("each part of a take-over has a text") {
    for (int i = 0; i < 6; ++i) CHECK(text(static_cast<part>(i)) != text(static_cast<part>(9)));
    CHECK(text(part::power_cycle) == doctest::String("power cycle"));
}

} // namespace take_over_tests
