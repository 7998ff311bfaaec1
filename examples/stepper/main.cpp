// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives an axis with a closed loop YAKOTEC stepper: homes it, positions it, lets it creep, stops it quickly.
//
//     stepper PORT [--simulator PID]
//
// On a real machine it asks first, and stays at or below 30 r/min. It stops the drive when it is interrupted
// and on every error.
#include "machine.hpp"

using namespace servobus;
using namespace servobus::yako::closed_loop;
using namespace servobus::units;

namespace {

using axis_bench = bench<stepper_machine>;

constexpr motion_profile slow{5 * r_per_min, 200 * millisecond, 200 * millisecond, 30 * r_per_min};

// The index pulse needs no switch. A machine with switches has `home_24` or another method, and inputs set
// for them by `set_input`.
void find_home(axis_bench& b) {
    b.say("homing on the encoder's index pulse");
    b.must(set_homing_profile{30 * r_per_min, 20 * r_per_min, 200 * millisecond});
    b.must_once(home{homing::index_positive});
    b.watch(milliseconds(300));
}

void visit_stations(axis_bench& b) {
    b.say("positioning: three stations and back");
    for (const int place : {250, 750, -125, 0}) {
        b.must(move_to{place * pulse, slow});
        b.watch_until_standstill();
    }
}

// A jog without end would run on if the line were lost. A creep is ordered again as long as somebody holds
// the button.
void creep_along(axis_bench& b) {
    b.say("creeping: a way that ends by itself, ordered again and again");
    for (int i = 0; i < 5; ++i) {
        b.must_once(bounded_jog{250 * pulse, slow});
        b.watch(milliseconds(300));
    }
    b.watch_until_standstill();
}

// A new target may take the place of the one under way, by name.
void change_the_target(axis_bench& b) {
    b.say("a new target on the way");
    b.must(move_to{2000 * pulse, slow});
    b.watch(milliseconds(1000));
    b.must(move_to{0 * pulse, slow, while_moving::interrupt});
    b.watch_until_standstill();
}

// Steps may be lost: the axis is homed again before its next absolute move.
void stop_quickly(axis_bench& b) {
    b.say("quick stop");
    b.must(velocity{30 * r_per_min, 200 * millisecond, 200 * millisecond});
    b.watch(milliseconds(1000));
    b.must(quick_stop{});
    b.watch(milliseconds(300));
    find_home(b);
    b.must(move_to{0 * pulse, slow});
    b.watch_until_standstill();
}

} // namespace

int main(int argc, char** argv) {
    axis_bench b{argc, argv};
    b.say("taking the drive over");
    b.take_over(milliseconds(2000));
    b.must(enable{});

    find_home(b);
    visit_stations(b);
    creep_along(b);
    change_the_target(b);
    stop_quickly(b);

    b.must(disable{});
    return b.is_at_rest() ? 0 : 1;
}
