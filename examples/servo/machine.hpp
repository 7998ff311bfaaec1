// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the servo program drives, for bench.hpp: a C630S with one motor.
#pragma once

#include <cstdio>

#include <servobus/device/c630s.hpp>

#include "../bench.hpp"

struct servo_machine {
    using device = servobus::c630s::device;
    using feedback = servobus::c630s::feedback;
    template <class Line> using drive = servobus::c630s::drive<Line>;
    using stop = servobus::disable;

    static constexpr const char* name = "servo";
    static constexpr const char* warning =
        "This moves a real machine at up to 30 r/min, a turn either way. Unload the shaft, keep a wired\n"
        "emergency stop at hand: this program is no safety function, and the drive goes on when the line\n"
        "is lost. Where they are not yet, it assigns the drive's virtual terminals in its EEPROM and takes\n"
        "servo-on, alarm reset and homing start away from the wired inputs.";
    static constexpr const char* at_rest = "the motor is at rest";
    static constexpr const char* not_at_rest = "the motor is not at rest";
    static constexpr unsigned lines = 1;

    static bool is_running(const feedback& f) { return !stands(f) || !f.state.is_completed(); }
    static bool is_at_rest(const feedback& f) { return stands(f); }

    static void print(const feedback& f) {
        const servobus::c630s::alarm* alarm = f.alarm();
        std::printf("   %6.1f r/min %9ld units %6ld behind  %-40s\n", f.fine_speed.count() / 10.0,
                    static_cast<long>(f.position.count()), static_cast<long>(f.following_error.count()),
                    alarm != nullptr ? alarm->name : "");
    }

  private:
    static bool stands(const feedback& f) { return f.speed.count() <= 2 && f.speed.count() >= -2; }
};
