// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives a C630S: its virtual terminals, two position segments, a speed, an emergency stop and what resets
// it.
//
//     servo PORT [--simulator PID]
//
// On a real machine it asks first, and stays at or below 30 r/min. It stops the drive when it is interrupted
// and on every error.
#include "machine.hpp"

using namespace servobus;
using namespace servobus::c630s;
using namespace servobus::units;

namespace {

using servo_bench = bench<servo_machine>;

// What was assigned works once the power has been off. The simulated drive does not mind a restart instead.
void cycle_power(servo_bench& b) {
    if (b.is_simulated()) {
        b.must(restart{});
        return b.take_over(milliseconds(5000));
    }
    b.say("switch the drive off and on again; this goes on by itself, or ends on Ctrl-C");
    do {
        b.rest(milliseconds(2000));
        b.take_over(milliseconds(120'000));
    } while (b.drive().needs_power_cycle());
}

void set_up_terminals(servo_bench& b) {
    if (b.drive().state() == drive_state::needs_set_up) {
        b.say("assigning the virtual terminals");
        b.must(set_up{});
    }
    if (b.drive().needs_power_cycle()) cycle_power(b);
}

void move_a_turn(servo_bench& b, std::int32_t units) {
    b.must(segment{1, units * reference_unit, 30 * r_per_min, 200 * millisecond});
    b.must_once(start_segment{1});
    b.watch_until_standstill();
}

void run_segments(servo_bench& b) {
    b.say("moving a turn forward and back by segments");
    b.must(position_segments{});
    b.must(enable_in{control_mode::position});
    move_a_turn(b, 10'000);
    move_a_turn(b, -10'000);
    b.must(disable{});
}

void run_at_speed(servo_bench& b) {
    b.say("turning at 30 r/min");
    b.must(ramps{200 * millisecond, 200 * millisecond});
    b.must(enable_in{control_mode::speed});
    b.must(velocity{30 * r_per_min});
    b.watch(milliseconds(2000));
    b.must(halt{});
}

void stop_in_emergency(servo_bench& b) {
    b.say("emergency stop at speed, and the reset of what it leaves");
    b.must(velocity{-30 * r_per_min});
    b.watch(milliseconds(1000));
    b.must(quick_stop{});
    b.watch(milliseconds(500));
    b.must(fault_reset{});
    b.watch(milliseconds(200));
}

} // namespace

int main(int argc, char** argv) {
    servo_bench b{argc, argv};
    b.say("taking the drive over");
    b.take_over(milliseconds(2000));
    set_up_terminals(b);

    run_segments(b);
    run_at_speed(b);
    stop_in_emergency(b);

    b.must(disable{});
    return b.is_at_rest() ? 0 : 1;
}
