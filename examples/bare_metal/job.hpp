// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What both programs do with the drive, and the time limits they grant it: turn both wheels slowly, check
// that they turn, stop them, check that they are at rest.
#pragma once

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

namespace job {

namespace zlac = servobus::zlac8015d;
using namespace servobus::units;

inline constexpr std::uint32_t baud = zlac::device::facts.baud;

// The simulated drive is a process on a host that may be busy. For a real drive use the limits of its
// profile, node<device>{1} and timing_at(baud), and a watchdog time of half a second.
inline constexpr servobus::modbus::rtu_timing timing =
    servobus::modbus::timing_at(baud, servobus::modbus::timing_mode::host, servobus::milliseconds(250));
constexpr servobus::node<zlac::device> patient_node() {
    servobus::node<zlac::device> n{1};
    n.limits.response = servobus::milliseconds(1000);
    n.read_retries = 4;
    return n;
}
inline constexpr zlac::watchdog watchdog{20 * second};
// Nothing is read but by a command: so the drive's watchdog stops the wheels if this program dies.
inline constexpr servobus::supervision no_polling = servobus::unsupervised;
inline constexpr servobus::duration longest_ramp = servobus::milliseconds(60'000);

inline constexpr zlac::wheel_velocities opposite_ways{20 * r_per_min, -20 * r_per_min};

constexpr bool turns_as_commanded(const zlac::feedback& f) {
    return f.left_speed > 15 * r_per_min && f.right_speed < -15 * r_per_min;
}

/// True if both shafts are released and neither turns.
constexpr bool is_at_rest(const zlac::feedback& f) {
    return f.state == zlac::status_flags{} && f.left_speed == 0 * r_per_min && f.right_speed == 0 * r_per_min;
}

/// True if the drive has responded but its cached state is stale, since a response was lost or the program
/// was delayed, as on a busy host. Nothing is repeated then: the whole job starts again with `init`.
template <class Line> constexpr bool may_begin_anew(const zlac::drive<Line>& wheels, const Line& wire) {
    return wheels.state() == zlac::drive_state::needs_init && wire.observer().responses != 0;
}
inline constexpr int most_takeovers = 20;

} // namespace job
