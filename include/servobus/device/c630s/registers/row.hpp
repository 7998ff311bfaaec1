// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the types and flags with which the register rows of the C630S are written. The headers of
// register groups include it. Source: manual V24.111, chapter 7.
//
//     namespace mine { // a row of your own: P08-40 is in no manual
//     using namespace c630s::literals;
//     inline constexpr c630s::rw<u16> damping{"P08-40"_p, {0, 1000}, percent / 10, 0, c630s::running_now};
//     }
//
// A row's comment has the printed name, range, unit and default; when the register may be set (while
// running, or only while stopped); when it takes effect (immediately, at the next stop, from the next
// power-on); and the control modes in which it has an effect (P, S, T). Registers that are "shown" or
// "read only" cannot be written.
#pragma once

#include <servobus/device/c630s/functions.hpp>
#include <servobus/device/c630s/registers/parameter_number.hpp>
#include <servobus/device/c630s/values.hpp>
#include <servobus/registers/reg.hpp>

namespace servobus::c630s {

template <class T> using ro = reg<T, access::ro, device>;
template <class T> using rw = reg<T, access::rw, device>;

using units::ampere, units::count, units::degree, units::degree_celsius, units::hertz, units::kilohertz,
    units::millisecond, units::millivolt, units::nanosecond, units::ohm, units::percent,
    units::pulse_per_revolution, units::r_per_min, units::reference_unit, units::revolution, units::second,
    units::times, units::volt, units::watt;

// While P0C-13 is 1, its factory setting, every write outside the groups P0B and P0D goes into the EEPROM.
inline constexpr flag running_now = saved_on_write | when_running | immediate;
inline constexpr flag running_from_stop = saved_on_write | when_running | at_stop;
inline constexpr flag running_from_power_on = saved_on_write | when_running | after_power_cycle;
inline constexpr flag stopped_now = saved_on_write | when_stopped | immediate;
inline constexpr flag stopped_from_power_on = saved_on_write | when_stopped | after_power_cycle;

// PS and PST in the manual's tables; ALL is `every_mode`.
inline constexpr flag ps_modes = position_mode | speed_mode;
inline constexpr flag pst_modes = position_mode | speed_mode | torque_mode;

} // namespace servobus::c630s
