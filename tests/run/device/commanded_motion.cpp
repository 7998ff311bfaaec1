// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Each command of a ZLAC8015D leaves the speeds of its wheels, or changes them. It is played after rest and after a
// motion, done and failed.
#include <string>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/zlac8015d/commanded_motion.hpp>
#include <servobus/device/zlac8015d/single_parameters.hpp>
#include <tests/support/endings.hpp>

namespace commanded_motion_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;

namespace {

constexpr cached_settings in(operating_mode mode, drive_state state = drive_state::enabled) {
    return {.state = state, .mode = mode, .resolution = 1, .max_speed = 1000, .host_timeout = 800};
}
constexpr cached_settings turning = in(operating_mode::velocity);
constexpr cached_settings off = in(operating_mode::undefined, drive_state::disabled);

const prepared_command turn = commands::prepared(velocity{60 * r_per_min, 90 * r_per_min}, turning);

/// The commands since the last feedback, as a robot's model is told of them.
struct commands_since : commanded_motion {
    void play(const prepared_command& c, bool is_done) {
        REQUIRE(c.refusal == errc::ok);
        begin(c);
        conclude(c, is_done);
    }
    void conclude(const prepared_command& c, bool is_done) {
        endings e;
        ending how = is_done ? e.done() : e.failed(command_status{status::sent(errc::timeout)});
        how.steps = c.steps;
        prepared_command over = c;
        over.steps = no_steps; // as a machine has it
        end(over, how);
    }
};

} // namespace

TEST_CASE("G43: what each command leaves of the speeds, and whether it is a new one") {
    struct row {
        std::string name;
        prepared_command command;
        bool moves;  ///< the wheels may have a target that is not zero after it
        bool stops;  ///< they have none after it
        bool is_new; ///< the speeds may be others after it
        bool keeps;  ///< a shaped setpoint leads on after it
    };
    const row rows[] = {
        {"both wheels", turn, true, false, true, false},
        {"both wheels, the right one at zero",
         commands::prepared(velocity{60 * r_per_min, 0 * r_per_min}, turning), true, false, true, false},
        {"both wheels, the left one at zero",
         commands::prepared(velocity{0 * r_per_min, 60 * r_per_min}, turning), true, false, true, false},
        {"both wheels at zero", commands::prepared(velocity{0 * r_per_min, 0 * r_per_min}, turning), false,
         true, true, false},
        {"the left wheel", left_velocity{60 * r_per_min}.prepare(turning), true, false, true, false},
        {"the left wheel at zero", left_velocity{0 * r_per_min}.prepare(turning), true, false, true, false},
        {"torque", torque{1000 * milliampere, 0 * milliampere}.prepare(in(operating_mode::torque)), true,
         false, true, false},
        {"a move", commands::prepared(move_by{40 * pulse, 0 * pulse}, in(operating_mode::relative_position)),
         true, false, true, false},
        {"halt", prepare(halt{}, turning), false, true, true, false},
        {"quick stop", prepare(quick_stop{}, turning), false, true, true, false},
        {"disable", prepare(disable{}, turning), false, true, true, false},
        {"enable", prepare(enable{}, off), false, true, true, false},
        {"init", prepare(init{}, turning), false, true, true, false},
        {"a read", prepare(read_feedback{}, turning), false, false, false, true},
        {"a wait", prepare(wait_reached{}, turning), false, false, false, true},
        {"the watchdog", watchdog{500 * millisecond}.prepare(turning), false, false, true, true},
        {"ramps", ramps{100 * millisecond, 100 * millisecond}.prepare(turning), false, false, true, true},
        {"a top speed", prepare(set<max_motor_speed>{300}, off), false, false, true, true},
        {"currents", current_limits{3000 * milliampere, 4000 * milliampere}.prepare(off), false, false, true,
         true},
        {"cleared positions", clear_position{}.prepare(off), false, false, true, true},
        {"another resolution", resolution{10}.prepare(off), false, false, true, false},
    };
    for (const row& r : rows) {
        CAPTURE(r.name);
        CHECK(commanded_motion::keeps_speeds(r.command) == r.keeps);
        for (const bool was_moving : {false, true}) {
            CAPTURE(was_moving);
            for (const bool is_done : {false, true}) {
                CAPTURE(is_done);
                commands_since m;
                if (was_moving) m.play(turn, true);
                m.note_feedback();
                CHECK_FALSE(m.is_new());
                CHECK(m.could_move() == was_moving);
                prepared_command c = r.command;
                if (was_moving && r.command.steps.data() == turn.steps.data() &&
                    r.command.arguments[0] == turn.arguments[0] &&
                    r.command.arguments[1] == turn.arguments[1])
                    continue; // the same twist again
                m.begin(c);
                CHECK(m.is_new() == r.is_new);
                CHECK(m.could_move() == (was_moving || r.moves));
                m.note_feedback(); // a feedback while it is under way
                CHECK_FALSE(m.is_new());
                CHECK(m.could_move() == (was_moving || r.moves));
                m.conclude(c, is_done);
                CHECK(m.is_new() == r.is_new);
                m.play(prepare(read_feedback{}, turning), true); // forgets nothing of what came before it
                CHECK(m.is_new() == r.is_new);
                CHECK(m.could_move() == (was_moving || r.moves)); // since that feedback
                m.note_feedback();
                CHECK(m.could_move() == (r.moves || (was_moving && !(r.stops && is_done))));
            }
        }
    }
}

TEST_CASE("G43: a twist is repeated only where the drive has acknowledged both speeds together") {
    const prepared_command both = commands::prepared(velocity{60 * r_per_min, 0 * r_per_min}, turning);
    struct row {
        std::string name;
        prepared_command last;
        bool is_done;
        bool is_repeated;
    };
    const row rows[] = {{"the same", both, true, true},
                        {"the same, which has failed", both, false, false},
                        {"another", turn, true, false},
                        {"another of the left wheel",
                         commands::prepared(velocity{30 * r_per_min, 0 * r_per_min}, turning), true, false},
                        {"the left wheel alone", left_velocity{60 * r_per_min}.prepare(turning), true, false},
                        {"a halt", prepare(halt{}, turning), true, false},
                        {"a read", prepare(read_feedback{}, turning), true, true},
                        {"a wait", prepare(wait_reached{}, turning), true, true},
                        {"a read that has failed", prepare(read_feedback{}, turning), false, true}};
    for (const row& r : rows) {
        CAPTURE(r.name);
        commands_since m;
        m.play(both, true);
        m.play(r.last, r.is_done);
        m.note_feedback();
        m.begin(both);
        CHECK(m.is_new() == !r.is_repeated);
        m.conclude(both, true);
        CHECK(m.is_new() == !r.is_repeated);
    }
    commands_since m; // the same words are another command in another register
    m.play(both, true);
    m.note_feedback();
    m.begin(torque{60 * milliampere, 0 * milliampere}.prepare(in(operating_mode::torque)));
    CHECK(m.is_new());
}

} // namespace commanded_motion_tests
