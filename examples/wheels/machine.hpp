// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the wheel program drives, for bench.hpp: a ZLAC8015D with two wheels.
#pragma once

#include <cstdio>

#include <servobus/device/zlac8015d.hpp>

#include "../bench.hpp"

struct wheel_machine {
    using device = servobus::zlac8015d::device;
    using feedback = servobus::zlac8015d::feedback;
    /// Stops if no speed was commanded for a second.
    template <class Line> struct drive : servobus::zlac8015d::drive<Line> {
        drive(Line& on, std::uint8_t node_address)
            : servobus::zlac8015d::drive<Line>{
                  on, node_address, {.command_timeout = servobus::milliseconds(1000)}} {}
    };
    using stop = servobus::disable;

    static constexpr const char* name = "wheels";
    static constexpr const char* warning =
        "This moves a real machine at up to 30 r/min. Lift the wheels off the ground, keep a wired\n"
        "emergency stop at hand: this program is no safety function.";
    static constexpr const char* at_rest = "both wheels at rest";
    static constexpr const char* not_at_rest = "the wheels are not at rest";
    static constexpr unsigned lines = 2;

    static bool is_running(const feedback& f) { return f.state.is_running(); }
    static bool is_at_rest(const feedback& f) {
        return !is_running(f) && f.left_speed.count() == 0 && f.right_speed.count() == 0;
    }

    static void print(const feedback& f) {
        print_wheel("left", f.left_speed.count(), f.left_position.count(), f.left_faults.bits);
        print_wheel("right", f.right_speed.count(), f.right_position.count(), f.right_faults.bits);
    }

  private:
    static void print_wheel(const char* which, servobus::i32 tenths, servobus::i32 counts, unsigned faults) {
        std::printf("   %-5s %6.1f r/min %9ld counts  faults %04x\n", which, tenths / 10.0,
                    static_cast<long>(counts), faults);
    }
};
