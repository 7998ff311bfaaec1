// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot with two hub motors: twists at 50 Hz, and where it has come to. It prints nothing and waits for nothing, so
// that it runs on a small core too.
#pragma once

#include <servobus/control/setpoint_loop.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/zlac8015d/robot.hpp>
#include <servobus/servobus.hpp>

namespace robot {
using namespace servobus;
using namespace servobus::literals;
namespace z = servobus::zlac8015d;

inline constexpr feed wheel =
    rolling(534_mm, counts_per_turn{4096}); // measured over ten turns; 4 x the encoder's lines
inline constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 400_mm});
// A new drive is reported once as `power_cycle`: it keeps the resolution, and counts so from the next power-on.
inline constexpr take_over set_up{z::resolution{10}, z::watchdog{500_ms}};
// A wheel over the ground keeps to them: the robot shapes its setpoints.
inline constexpr axis_profile limits{.top = 1200_mm_per_s, .acceleration = 600_ms, .deceleration = 400_ms};

template <class Line> class robot {
  public:
    // Presumes a drive that responds within 30 ms, and is never late by more than 70 ms: `servobus doctor` measures it.
    explicit robot(Line& wire)
        : wheels_{wire,
                  responds_within(node<z::device>{1}, 30_ms),
                  base,
                  {.feedback = 20_ms, .command_timeout = 300_ms}} {
        (void)wheels_.set_limits(limits); // within what a drive can count
    }

    // In each iteration of the program's loop. A twist that is older than 200 ms counts no more.
    duration step() { return loop_.step(); }
    void drive(const twist& by) { loop_.set(by); }

    // Nothing turns before an operator has enabled the robot, and again after each fault, stop or loss.
    void enable() { loop_.enable(); }
    bool reset_faults() { return loop_.reset_faults(); }
    command_status stop() { return loop_.halt(); }
    // Waits until the wheels stand, and frees them.
    bool shut_down() { return (void)wheels_.run(halt{}), static_cast<bool>(wheels_.run(disable{})); }

    // The pose says itself whether it is continuous. Where the robot is known to be, `is_at` says so.
    plane_pose pose() const { return wheels_.pose(); }
    void is_at(const plane_pose& here) { wheels_.set_pose(here); }

    // What has ended, once; and what the wheels say.
    loop_report take_report() { return loop_.take_report(); }
    drive_state state() const { return wheels_.state(); }
    stop_cause cause() const { return wheels_.cause(); }
    z::faults faults() const {
        const z::feedback seen = wheels_.feedback(200_ms).value_or({});
        return seen.left_faults.any() ? seen.left_faults : seen.right_faults;
    }

  private:
    z::robot<Line> wheels_;
    setpoint_loop<z::robot<Line>, decltype(set_up), servobus::enable, setpoints<twist>> loop_{wheels_,
                                                                                              set_up};
};
} // namespace robot
