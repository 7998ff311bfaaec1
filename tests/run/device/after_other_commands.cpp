// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A command sends the same frames after each other command as alone, from the same state of the drive. Nothing that a
// command leaves behind in the facade concerns the next one.
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/frames_of_commands.hpp>
#include <tests/support/simulated_c630s.hpp>
#include <tests/support/simulated_yako.hpp>

namespace after_other_commands_tests {

using namespace servobus;
using namespace servobus::units;
using frames_of_commands::frame;
using frames_of_commands::hex_of;
using frames_of_commands::watched;

namespace {

/// A drive, what is done to it, and how it ends.
template <class Rig> struct named {
    std::string name;
    std::function<bool(Rig&)> play;
};

/// Equal frames one after another, as in a wait, count once.
std::string text_of(const std::vector<frame>& log) {
    std::string all, before;
    for (const frame& f : log) {
        std::string one = hex_of(f.address);
        for (std::size_t i = 0; f.is_write && i < f.words.size(); ++i)
            one += (i == 0 ? "=" : ".") + hex_of(f.words[i]);
        if (one != before) all += " " + one;
        before = one;
    }
    return all;
}

template <class Rig>
void check_all(const std::function<bool(Rig&)>& be_ready, const std::vector<named<Rig>>& before,
               const std::vector<named<Rig>>& wanted) {
    for (const named<Rig>& w : wanted) {
        CAPTURE(w.name);
        std::string alone;
        for (std::size_t i = 0; i <= before.size(); ++i) {
            const std::string name = i == 0 ? "" : before[i - 1].name;
            CAPTURE(name);
            Rig r;
            REQUIRE(be_ready(r));
            if (i != 0) REQUIRE(before[i - 1].play(r));
            r.model.log.clear();
            CHECK(w.play(r));
            if (i == 0)
                REQUIRE_FALSE((alone = text_of(r.model.log)).empty());
            else
                CHECK(text_of(r.model.log) == alone);
        }
    }
}

struct axis : simulated::simulated_yako<watched<sim::yako_closed_loop>> {
    yako::closed_loop::drive<line_type> drive{line, 1, unsupervised};
};
struct servo : simulated::simulated_model<watched<sim::c630s>, sim::c630s_options, 57600> {
    c630s::drive<line_type> drive{line, 1, unsupervised};
};
struct dual_servo : simulated::simulated_model<watched<sim::zlac8015d>, sim::zlac8015d_options, 115200> {
    zlac8015d::drive<line_type> drive{line, 1, unsupervised};
};

/// Plays commands one after another, of which each must succeed.
template <class Rig, class... Commands> named<Rig> doing(std::string name, const Commands&... all) {
    return {std::move(name), [=](Rig& r) { return (bool{r.drive.run(all)} && ...); }};
}
/// Plays a command that the facade refuses, or that fails.
template <class Rig, class Command> named<Rig> failing(std::string name, const Command& c) {
    return {std::move(name), [=](Rig& r) { return !r.drive.run(c); }};
}

} // namespace

TEST_CASE("a YAKO's commands send the same after each other command as alone") {
    using namespace servobus::yako;
    const motion_profile slow{10 * r_per_min, 90 * millisecond, 80 * millisecond, 60 * r_per_min};
    const auto be_ready = [](axis& a) {
        return a.drive.run(init{}) && a.drive.run(enable{}) && a.drive.run(declare_position{0 * pulse});
    };
    const auto play = [](std::string name, const auto&... all) {
        return doing<axis>(std::move(name), all...);
    };
    check_all<axis>(
        be_ready,
        {play("a move", move_by{20 * pulse, slow}, wait_reached{}),
         play("a move to a place", move_to{-20 * pulse, slow}, wait_reached{}),
         play("a jog", velocity{60 * r_per_min}, halt{}),
         play("a bounded jog", bounded_jog{30 * pulse, slow}, wait_standstill{}),
         play("a hold", hold{60 * r_per_min, milliseconds(50)}, halt{}),
         play("a position", declare_position{70'000 * pulse}), play("a disable", disable{}, enable{}),
         play("a quick stop", quick_stop{}, declare_position{0 * pulse}),
         play("segments", set_position_segment{2, 70'000 * pulse, 90 * r_per_min},
              set_speed_segment{2, 90 * r_per_min}),
         play("a reset", fault_reset{}),
         play("limits", limit_travel{-70'000 * pulse, 70'000 * pulse}, unlimit_travel{}),
         play("a read", read_feedback{}), play("another init", init{}, declare_position{0 * pulse}),
         failing<axis>(
             "a refused move",
             move_by{20 * pulse, {10 * r_per_min, 90 * millisecond, 80 * millisecond, 3001 * r_per_min}}),
         failing<axis>("a refused wait", wait_reached{})},
        {play("a move", move_by{20 * pulse, slow}), play("a move to a place", move_to{200'000 * pulse, slow}),
         play("a jog", velocity{-60 * r_per_min}), play("a bounded jog", bounded_jog{-30 * pulse, slow}),
         play("a position", declare_position{80'000 * pulse}), play("halt", halt{}),
         play("quick stop", quick_stop{}), play("disable", disable{}),
         play("a segment", set_position_segment{3, 80'000 * pulse, 80 * r_per_min}),
         play("limits", limit_travel{-60'000 * pulse, 60'000 * pulse}), play("a read", read_feedback{}),
         play("a wait", wait_standstill{}), play("an input's move", set_input_move{300 * pulse, slow})});
}

TEST_CASE("a C630S's commands send the same after each other command as alone") {
    using namespace servobus::c630s;
    servo made;
    REQUIRE(made.drive.run(init{}));
    REQUIRE(made.drive.run(set_up{}));
    made.model.power_cycle();
    const auto be_ready = [&](servo& r) {
        r.model = made.model;
        return bool{r.drive.run(init{})};
    };
    const auto play = [](std::string name, const auto&... all) {
        return doing<servo>(std::move(name), all...);
    };
    const enable_in position{control_mode::position}, torque{control_mode::torque};
    const segment way{1, 3000 * reference_unit, 600 * r_per_min};
    check_all<servo>(
        be_ready,
        {play("speed", enable{}, velocity{30 * r_per_min}, halt{}, disable{}),
         play("a jog", enable{}, jog{-30 * r_per_min}, halt{}, disable{}),
         play("a jog that is disabled", enable{}, jog{30 * r_per_min}, disable{}),
         play("torque", torque, c630s::torque{2 * percent}, disable{}),
         play("a move", position, way, start_segment{1}, wait_reached{}, disable{}),
         play("a move that is cut", position, way, start_segment{1}, disable{}),
         play("a run", enable_in{control_mode::position, position_source::segments, segment_mode::single},
              start_segments{}, disable{}),
         play("speed segments", run_speed_segments{}, select_speed_segment{3}, disable{}),
         play("speed segments that are stopped", run_speed_segments{}, quick_stop{}),
         play("a quick stop", enable{}, quick_stop{}, disable{}), play("a reset", fault_reset{}),
         play("a homing", position, home_electrically{10 * second}, disable{}),
         play("settings", ramps{1 * millisecond, 2 * millisecond}, torque_limits{90 * percent, 80 * percent}),
         play("a read", read_feedback{}), play("a fault's record", read_fault{1}),
         play("another init", init{}), failing<servo>("a refused move", start_segment{1}),
         failing<servo>("a refused wait", wait_reached{})},
        {play("enable", enable{}), play("in torque", torque), play("in position", position),
         play("speed segments", run_speed_segments{.from = 2}), play("disable", disable{}),
         play("quick stop", quick_stop{}), play("a reset", fault_reset{}),
         play("a segment", segment{2, 70'000 * reference_unit, 60 * r_per_min}),
         play("limits", torque_limits{70 * percent, 60 * percent}), play("a read", read_feedback{}),
         play("set home", set_home{}),
         play("enabled and moved", enable_in{control_mode::position}, start_segment{2}),
         play("enabled and turned", enable{}, velocity{20 * r_per_min}, halt{})});
}

TEST_CASE("a ZLAC8015D's commands send the same after each other command as alone") {
    using namespace servobus::zlac8015d;
    const auto be_ready = [](dual_servo& r) { return bool{r.drive.run(init{})}; };
    const auto play = [](std::string name, const auto&... all) {
        return doing<dual_servo>(std::move(name), all...);
    };
    const enable_in relative{operating_mode::relative_position}, absolute{operating_mode::absolute_position},
        torque{operating_mode::torque};
    check_all<dual_servo>(
        be_ready,
        {play("speeds", enable{}, velocity{30 * r_per_min, -40 * r_per_min}, halt{}, disable{}),
         play("speeds that are disabled", enable{}, left_velocity{30 * r_per_min}, disable{}),
         play("currents", torque, zlac8015d::torque{1000 * milliampere, -2000 * milliampere}, disable{}),
         play("a move", relative, move_by{40 * pulse, -50 * pulse}, wait_reached{}, disable{}),
         play("a move that is cut", absolute, move_to{4000 * pulse, -5000 * pulse}, disable{}),
         play("a move of one wheel",
              enable_in{operating_mode::relative_position, synchronisation::asynchronous},
              move_right_by{40 * pulse}, wait_reached{}, disable{}),
         play("a quick stop", enable{}, quick_stop{}, disable{}), play("a reset", fault_reset{}),
         play("a save", save{}), play("ramps", ramps{100 * millisecond, 200 * millisecond}),
         play("cleared positions", clear_position{}), play("a read", read_feedback{}),
         play("another init", init{}), failing<dual_servo>("a refused wait", wait_reached{}),
         failing<dual_servo>("a refused speed", velocity{30 * r_per_min, 30 * r_per_min})},
        {play("enable", enable{}), play("in torque", torque), play("in relative positions", relative),
         play("in absolute positions", absolute), play("disable", disable{}), play("a reset", fault_reset{}),
         play("a save", save{}), play("cleared positions", clear_position{}),
         play("the watchdog", zlac8015d::watchdog{800 * millisecond}), play("a read", read_feedback{}),
         play("init", init{}),
         play("enabled and turned", enable{}, velocity{10 * r_per_min, 10 * r_per_min}, halt{}, quick_stop{}),
         play("enabled and moved", enable_in{operating_mode::relative_position},
              move_by{10 * pulse, 10 * pulse}, wait_reached{})});
}

} // namespace after_other_commands_tests
