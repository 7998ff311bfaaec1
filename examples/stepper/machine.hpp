// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the stepper program drives, for bench.hpp: a closed loop YAKOTEC stepper on an axis.
#pragma once

#include <cstdio>

#include <servobus/device/yako.hpp>

#include "../bench.hpp"

struct stepper_machine {
    using device = servobus::yako::closed_loop::device;
    using feedback = servobus::yako::closed_loop::feedback;
    template <class Line> using drive = servobus::yako::closed_loop::drive<Line>;
    using stop = servobus::halt; // a load that hangs on the axis is held

    static constexpr const char* name = "stepper";
    static constexpr const char* warning =
        "This moves a real machine at up to 30 r/min, two turns either way. Clear the axis, keep a wired\n"
        "emergency stop at hand: this program is no safety function.";
    static constexpr const char* at_rest = "the axis is at rest";
    static constexpr const char* not_at_rest = "the axis is not at rest";
    static constexpr unsigned lines = 1;

    static bool is_running(const feedback& f) { return f.state.is_moving(); }
    static bool is_at_rest(const feedback& f) { return !is_running(f) && f.speed.count() == 0; }

    static void print(const feedback& f) {
        std::printf("   %7.1f r/min %9ld pulses  %-8s %s\n", f.speed.count() / 10.0,
                    static_cast<long>(f.position.count()), f.state.is_homed() ? "homed" : "",
                    f.state.has_alarm() ? "ALARM" : "");
    }
};
