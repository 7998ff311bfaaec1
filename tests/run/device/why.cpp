// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// `why`: the states and settings in which a command is possible, on all drives; facades in operation; commands and
// drives of one's own. The values are judged by why_zlac8015d.cpp and its neighbours.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>
#include <string>

#include <servobus/device/c630s/arguments.hpp>
#include <servobus/device/yako/arguments.hpp>
#include <servobus/device/zlac8015d/arguments.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include <examples/own_device/own_drive.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace why_tests {

using namespace servobus;
using namespace servobus::units;
using enum drive_state;

namespace {

constexpr drive_states set_of(std::initializer_list<drive_state> all) {
    drive_states set;
    for (const drive_state s : all) set.add(s);
    return set;
}
static_assert(set_of({}) == drive_states{} && set_of({disabled}) == drive_states{disabled});
static_assert(set_of({enabled, disabled}) == drive_states{disabled, enabled});

/// `codes` of the setting at `address`, or -1 if it is none of the conditions.
constexpr long codes_of(const refusal& r, unsigned address) {
    for (std::size_t i = 0; i < r.size; ++i) {
        if (r.conditions[i].address == address) return r.conditions[i].codes;
    }
    return -1;
}

constexpr zlac8015d::cached_settings wheels_in(drive_state s, zlac8015d::operating_mode m) {
    return {.state = s, .mode = m, .resolution = 10, .max_speed = 100};
}
constexpr auto in_velocity = wheels_in(enabled, zlac8015d::operating_mode::velocity);

// The answer is a constant of the program if the settings are.
constexpr refusal too_fast = commands::refusal_of(velocity{0 * r_per_min, -101 * r_per_min}, in_velocity);
static_assert(too_fast.error == errc::out_of_range && too_fast.is_of_value() && !too_fast.is_of_state());
static_assert(too_fast.argument.address == zlac8015d::right_target_speed.address);
static_assert(too_fast.argument.limited_by == zlac8015d::max_motor_speed.address);
static_assert(too_fast.argument.count == -1010);
static_assert(too_fast.argument.limits.low == -1000 &&
              too_fast.argument.limits.high == 1000); // both of 2008h
static_assert(sizeof(refusal) <= 112);

// A command of the program's own, without a list of its arguments.
struct nudge {
    zlac8015d::speed by;
    constexpr zlac8015d::prepared_command prepare(const zlac8015d::cached_settings& known) const {
        return commands::prepared(velocity{by, by}, known);
    }
};

} // namespace

TEST_CASE("why: a ZLAC8015D's command names its states and its mode") {
    using namespace zlac8015d;
    const refusal off =
        commands::refusal_of(wheel_velocities{}, wheels_in(disabled, operating_mode::velocity));
    CHECK(off.error == errc::wrong_state);
    CHECK(off.is_of_state());
    CHECK_FALSE(off.is_of_value());
    CHECK(off.state == disabled);
    CHECK(off.states == set_of({enabled}));
    CHECK(off.unmet() == nullptr); // the mode is right, the state is not

    const refusal mode = commands::refusal_of(torque{}, in_velocity);
    CHECK(mode.states == set_of({enabled}));
    REQUIRE(mode.unmet() != nullptr);
    CHECK(mode.unmet()->address == 0x200D);
    CHECK(mode.unmet()->code == 3);
    CHECK(mode.unmet()->codes == 1u << 4);

    // The state and the mode are right, but the drive was enabled for starts of both wheels.
    auto together = wheels_in(enabled, operating_mode::relative_position);
    together.starts = synchronisation::synchronous;
    const refusal one = commands::refusal_of(move_left_by{10 * pulse}, together);
    REQUIRE(one.unmet() != nullptr);
    CHECK(one.unmet()->address == 0x200F);
    CHECK(one.unmet()->codes == 1u << 0);

    const refusal halted = commands::refusal_of(halt{}, together);
    CHECK(halted.error == errc::wrong_state);
    // In any other state; or in this one with another mode, velocity or torque.
    CHECK(halted.states == set_of({needs_init, needs_power_cycle, disabled, quick_stopped}));
    CHECK(halted.unmet()->address == 0x200D);
    CHECK(halted.unmet()->codes == (1u << 3 | 1u << 4));

    CHECK(commands::refusal_of(enable{}, cached_settings{}).error == errc::needs_init);
    CHECK(commands::refusal_of(enable{}, cached_settings{}).states ==
          set_of({disabled, enabled, quick_stopped}));
    const refusal no_mode = commands::refusal_of(enable_in{checked(operating_mode::undefined)}, in_velocity);
    CHECK(no_mode.is_of_value());
    CHECK(no_mode.argument.limits.low == 1);
    const refusal other = commands::refusal_of(enable_in{checked(operating_mode{9})}, in_velocity);
    CHECK(other.argument.limits == no_mode.argument.limits);
    CHECK(commands::refusal_of(save{}, in_velocity).states == set_of({disabled}));
    CHECK(commands::refusal_of(init{}, in_velocity).error == errc::ok);
}

TEST_CASE("why: a C630S's command names its states, mode, source and segments") {
    using namespace c630s;
    const cached_settings in_speed{.state = enabled, .mode = control_mode::speed, .max_speed = 6000};
    const refusal move = commands::refusal_of(start_segment{3}, in_speed);
    CHECK(move.states == set_of({enabled}));
    CHECK(codes_of(move, 0x0200) == 1 << 1); // position
    CHECK(codes_of(move, 0x0500) == 1 << 2); // segments
    CHECK(codes_of(move, 0x1100) == 1 << 2); // by input
    CHECK(move.unmet()->address == 0x0200);
    // A speed is refused while a jog is under way, also where there is none now.
    auto with_segments = in_speed;
    with_segments.runs_speed_segments = true;
    CHECK(codes_of(commands::refusal_of(motor_velocity{}, with_segments), 0x3100) == 1 << 0);

    auto by_steps = in_speed;
    by_steps.mode = control_mode::position;
    by_steps.source = position_source::step;
    CHECK(commands::refusal_of(start_segment{3}, by_steps).unmet()->address == 0x0500);
    CHECK(commands::refusal_of(make_step{}, by_steps).error == errc::ok);

    CHECK(commands::refusal_of(step_size{9 * reference_unit}, in_speed).states ==
          set_of({needs_set_up, needs_power_cycle, disabled}));
    CHECK(commands::refusal_of(enable{}, in_speed).states == set_of({disabled}));

    auto jogging = in_speed;
    jogging.inputs = terminal::jog_forward;
    const refusal running = commands::refusal_of(motor_velocity{}, jogging);
    REQUIRE(running.unmet() != nullptr);
    CHECK(running.unmet()->is_flag);
    CHECK(running.unmet()->address == virtual_input_levels.address);
    CHECK(running.unmet()->codes == 1u << 0);

    auto by_itself = in_speed;
    by_itself.runs_speed_segments = true;
    CHECK(commands::refusal_of(motor_velocity{}, by_itself).unmet()->address == 0x0602);
    auto slow = in_speed;
    slow.max_forward = 3000;
    slow.max_reverse = 2000;
    const range both = commands::refusal_of(velocity{3001 * r_per_min}, slow).argument.limits;
    CHECK(both.low == -2000);
    CHECK(both.high == 3000);
    by_itself.run = segment_mode::cyclic;
    CHECK(commands::refusal_of(select_speed_segment{2}, by_itself).unmet()->address == 0x1200);
    // Before `init` the settings are not known, so any of them count.
    CHECK(commands::refusal_of(start_segment{3}, cached_settings{}).states == set_of({enabled}));
}

TEST_CASE("why: a YAKO's command names the register that the program must set first") {
    using namespace yako;
    cached_settings known{.state = enabled, .resolution = speed_count::tenth_r_per_min};
    const refusal fast = commands::refusal_of(velocity{10 * r_per_min}, known);
    CHECK(fast.error == errc::wrong_state);
    CHECK(fast.states == set_of({enabled}));
    REQUIRE(fast.unmet() != nullptr);
    CHECK(fast.unmet()->is_flag);
    CHECK(fast.unmet()->address == 0x001A);
    known.has_scale = true;
    CHECK(commands::refusal_of(move_by{10 * pulse}, known).unmet()->address == 0x0020);
    CHECK(commands::refusal_of(closed_loop::home{homing::home_24}, known).unmet()->address == 0x0032);
    const refusal lost = commands::refusal_of(
        move_to{10 * pulse, {0 * r_per_min, 90 * millisecond, 90 * millisecond, 60 * r_per_min}}, known);
    CHECK(lost.error == errc::needs_homing);
    CHECK_FALSE(lost.is_of_state());
    CHECK_FALSE(lost.is_of_value());

    // The drive is asked for its state before anything else is sent; the program knows it from the last time.
    cached_settings off{.state = disabled, .has_scale = true, .has_profile = true};
    CHECK(commands::prepared(move_by{10 * pulse}, off).refusal == errc::ok);
    CHECK(commands::refusal_of(move_by{10 * pulse}, off).error == errc::wrong_state);
    CHECK(commands::refusal_of(move_by{10 * pulse}, off).states == set_of({enabled}));
    off.state = enabled;
    const refusal free_first = commands::refusal_of(set_input{input_terminal::x0, input_function::home}, off);
    CHECK(free_first.error == errc::wrong_state);
    CHECK(free_first.states == set_of({disabled}));

    // A drive that is not enabled refuses these two also once their values are right, or the homing is done.
    const refusal wrong_too =
        commands::refusal_of(velocity{9999 * r_per_min}, cached_settings{.has_scale = true});
    CHECK(wrong_too.error == errc::needs_init);
    CHECK(wrong_too.states == set_of({enabled}));
    CHECK(commands::refusal_of(move_to{10 * pulse}, known).error == errc::wrong_state);
    CHECK(commands::refusal_of(move_to{10 * pulse}, known).states == set_of({enabled}));

    const refusal standing = commands::refusal_of(velocity{0 * r_per_min}, known);
    CHECK(standing.argument.count == 0);
    CHECK_FALSE(standing.argument.is_taken); // 0 lies within 001Dh's range
    const refusal crossed = commands::refusal_of(limit_travel{5 * pulse, 5 * pulse}, known);
    CHECK(crossed.error == errc::bad_argument);
    CHECK(crossed.argument.address == 0x0037);
    CHECK(crossed.argument.limited_by == 0x0039);
    CHECK(crossed.argument.limits == range{.low = 6, .high = 0x7FFF'FFFE});
    const refusal number = commands::refusal_of(set_speed_segment{checked(17), {}}, known);
    CHECK(number.error == errc::bad_argument);
    CHECK_FALSE(number.argument.has_register);
    CHECK(number.argument.limits.high == 16);
}

TEST_CASE(
    "why: a command without a list of its arguments has its error and its states, and names no register") {
    const refusal r = commands::refusal_of(nudge{1000 * r_per_min}, in_velocity);
    CHECK(r.error == errc::out_of_range);
    CHECK_FALSE(r.is_of_value());
    const refusal s = commands::refusal_of(nudge{}, wheels_in(disabled, zlac8015d::operating_mode::torque));
    CHECK(s.error == errc::wrong_state);
    CHECK(s.states == set_of({enabled}));
}

TEST_CASE("why: a drive of one's own, whose settings are a state alone") {
    const winch::cached_settings known{drive_state::enabled};
    const refusal r = commands::refusal_of(winch::turn{601 * winch::r_per_min}, known);
    CHECK(r.argument.address == winch::speed.address);
    CHECK(r.argument.limits == winch::speed.limits);
    CHECK(commands::refusal_of(servobus::move_to{2'000'000 * winch::pulse}, known).argument.count ==
          2'000'000);
    const refusal s = commands::refusal_of(enable{}, known);
    CHECK(s.states == set_of({disabled}));
    CHECK(s.size == 0);
    CHECK(s.unmet() == nullptr);
}

TEST_CASE("why: asked of a facade after it has refused, in words of the catalogue") {
    using namespace zlac8015d;
    simulated::driven_zlac8015d r{};
    CHECK(why(r.drive, wheel_velocities{}).error == errc::needs_init);
    REQUIRE(r.drive.run(init{}));
    const velocity fast{1 * r_per_min, 2000 * r_per_min};
    CHECK(r.drive.begin(fast) == errc::wrong_state);
    CHECK(why(r.drive, fast).state == disabled);
    REQUIRE(r.drive.run(enable{}));
    CHECK(r.drive.begin(fast) == errc::out_of_range);
    const refusal said = why(r.drive, fast);
    REQUIRE(said.is_of_value());
    const entry* const row = zlac8015d::catalogue.find(said.argument.address);
    const entry* const by = zlac8015d::catalogue.find(said.argument.limited_by);
    const std::string words = std::string{row->name} + ' ' + std::to_string(said.argument.count) + ": " +
                              static_cast<const char*>(by->name) + " allows " +
                              std::to_string(said.argument.limits.high);
    CHECK(words == "right_target_speed 2000: max_motor_speed allows 1000");
    // The same command within the limits has no refusal, and it is not sent by the question.
    CHECK(why(r.drive, velocity{1 * r_per_min, 2 * r_per_min}).error == errc::ok);
    CHECK(r.drive.is_idle());
    // Another command is under way: the facade's own reason.
    REQUIRE(r.drive.begin(ramps{10 * millisecond, 10 * millisecond}) == errc::ok);
    CHECK(r.drive.begin(wheel_velocities{}) == errc::busy);
    CHECK(why(r.drive, wheel_velocities{}).error == errc::ok);
}

TEST_CASE("why: a YAKO that is not enabled refuses a motion after it was asked, and why has the state") {
    using namespace yako;
    simulated::closed_axis a{};
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.state() == disabled);
    const velocity slow{10 * r_per_min};
    CHECK(a.drive.run(slow).error() == errc::wrong_state);
    const refusal said = why(a.drive, slow);
    CHECK(said.error == errc::wrong_state);
    CHECK(said.state == disabled);
    CHECK(said.states == set_of({enabled}));
    REQUIRE(a.drive.run(enable{}));
    CHECK(why(a.drive, slow).error == errc::ok);
    CHECK(a.drive.run(slow));
}

TEST_CASE("why: after a fault the state is faulted") {
    using namespace zlac8015d;
    simulated::driven_zlac8015d r{};
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    r.model.raise(fault::overload, fault::none);
    (void)r.drive.read();
    (void)r.drive.run(disable{});
    REQUIRE(r.drive.state() == faulted);
    CHECK(r.drive.begin(wheel_velocities{}) == errc::faulted);
    const refusal said = why(r.drive, wheel_velocities{});
    CHECK(said.error == errc::faulted);
    CHECK(said.is_of_state());
    CHECK(said.state == faulted);
    CHECK(said.states == set_of({enabled}));
    const refusal other = why(r.drive, watchdog{70'000 * millisecond}); // the error is the command's own
    CHECK(other.error == errc::out_of_range);
    CHECK(other.state == faulted);
}

TEST_CASE("why: a number above 15 is no code of a setting, and six settings of a drive are told") {
    const condition all{.address = 0x200D, .code = 16, .codes = 0xFFFF};
    CHECK(all.has(15));
    CHECK_FALSE(all.has(16));
    CHECK_FALSE(all.is_met());
    each_condition each{0};
    bool flags[7]{};
    for (bool& flag : flags) each.flag<winch::speed>(flag);
    CHECK(each.size() == each_condition::most);
    CHECK(each.is_valid());
}

} // namespace why_tests
