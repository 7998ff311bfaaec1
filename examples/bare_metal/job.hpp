// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What both programs do with the drive, and the patience that they have: turn both wheels slowly, see them
// turn, stop them, see them stand.
#pragma once

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

namespace job {

namespace zlac = servobus::zlac8015d;
using namespace servobus::units;

inline constexpr std::uint32_t baud = zlac::device::facts.baud;

// The peer is a process of a host that may be busy with other things. A drive on a wire is granted what its
// profile says, node<device>{1} and timing_at(baud), and its watchdog half a second.
inline constexpr servobus::modbus::rtu_timing timing =
    servobus::modbus::timing_at(baud, servobus::modbus::timing_mode::host, servobus::milliseconds(250));
constexpr servobus::node<zlac::device> patient_node() {
    servobus::node<zlac::device> n{1};
    n.limits.response = servobus::milliseconds(1000);
    n.read_retries = 4;
    return n;
}
inline constexpr zlac::watchdog watchdog{20 * second};
inline constexpr servobus::duration longest_ramp = servobus::milliseconds(60'000);

inline constexpr zlac::velocity opposite_ways{20 * r_per_min, -20 * r_per_min};

constexpr bool turns_as_ordered(const zlac::feedback& f) {
    return f.left_speed > 15 * r_per_min && f.right_speed < -15 * r_per_min;
}

/// Both shafts free, nothing turns.
constexpr bool is_at_rest(const zlac::feedback& f) {
    return f.state == zlac::status{} && f.left_speed == 0 * r_per_min && f.right_speed == 0 * r_per_min;
}

/// A drive that has answered and is not believed any more, since a response was lost or the program was kept
/// waiting: nothing is repeated then, the whole job begins anew with `init`. A busy host does that.
template <class Line> constexpr bool may_begin_anew(const zlac::drive<Line>& wheels, const Line& wire) {
    return wheels.state() == zlac::drive_state::needs_init && wire.observer().responses != 0;
}
inline constexpr int most_takeovers = 20;

} // namespace job
