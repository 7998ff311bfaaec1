// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives both wheels of a ZLAC8015D: ramps, opposite speeds, a relative move, a quick stop, and a lost line. Signs are
// the drive's: on a robot whose motors are mounted mirrored, equal signs turn it on the spot.
//
//     wheels PORT [--simulator PID]
//
// On a real machine it asks first, and stays at or below 30 r/min. It stops the drive when it is interrupted
// and on every error.
#include "machine.hpp"

using namespace servobus;
using namespace servobus::zlac8015d;
using namespace servobus::units;

namespace {

using wheel_bench = bench<wheel_machine>;

void ramp_both(wheel_bench& b) {
    b.say("ramping to different speeds");
    b.must(velocity{30 * r_per_min, 20 * r_per_min});
    b.watch(milliseconds(3000));
}

void run_opposite(wheel_bench& b) {
    b.say("turning the wheels with opposite signs");
    b.must(velocity{20 * r_per_min, -20 * r_per_min});
    b.watch(milliseconds(3000));
    b.must(halt{});
}

// A turn is 4 counts for each encoder line: 2048 counts are half a turn of an encoder with 1024 lines, the register's
// default, and an eighth with 4096.
void move_by_counts(wheel_bench& b) {
    b.say("moving both wheels by 2048 counts");
    b.must(disable{});
    b.must(position_speed{30 * r_per_min, 30 * r_per_min});
    b.must(enable_in{operating_mode::relative_position});
    b.must_once(move_by{2048 * pulse, 2048 * pulse});
    b.watch_until_standstill();
    b.must(disable{});
}

void stop_quickly(wheel_bench& b) {
    b.say("quick stop at speed");
    b.must(enable_in{operating_mode::velocity});
    b.must(velocity{30 * r_per_min, 30 * r_per_min});
    b.watch(milliseconds(1500));
    b.must(quick_stop{});
    b.watch(milliseconds(500));
}

// The drive's own watchdog stops the wheels; nothing moves again before it has been initialised.
void lose_the_line(wheel_bench& b) {
    b.must(enable_in{operating_mode::velocity});
    b.must(velocity{20 * r_per_min, 20 * r_per_min});
    b.watch(milliseconds(1000));
    b.pull_the_plug();
    b.say("taking the drive over again");
    b.take_over(milliseconds(10000));
    b.must(enable_in{operating_mode::velocity});
    b.must(velocity{20 * r_per_min, 20 * r_per_min});
    b.watch(milliseconds(1000));
}

} // namespace

int main(int argc, char** argv) {
    wheel_bench b{argc, argv};
    b.say("taking the drive over");
    b.take_over(milliseconds(2000));
    b.must(watchdog{1 * second});
    b.must(ramps{500 * millisecond, 500 * millisecond});
    b.must(enable_in{operating_mode::velocity});

    ramp_both(b);
    run_opposite(b);
    move_by_counts(b);
    stop_quickly(b);
    lose_the_line(b);

    b.must(halt{});
    b.must(disable{});
    return b.is_at_rest() ? 0 : 1;
}
