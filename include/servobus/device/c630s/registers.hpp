// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: its register map, 463 parameters, in one header for each subject.
// servobus/device/c630s.hpp includes it, and so do the catalogue and the drive's own headers. Source: manual
// V24.111, chapter 7; [errata Cn] are in device/errata_c630s.md.
//
//     auto look(auto& servo) { // a client; in the fewest requests
//         return read<c630s::actual_speed, c630s::phase_current, c630s::bus_voltage>(servo);
//     }
#pragma once

#include <servobus/device/c630s/auxiliary.hpp>
#include <servobus/device/c630s/bus_signals.hpp>
#include <servobus/device/c630s/communication.hpp>
#include <servobus/device/c630s/control.hpp>
#include <servobus/device/c630s/gains.hpp>
#include <servobus/device/c630s/inputs.hpp>
#include <servobus/device/c630s/monitoring.hpp>
#include <servobus/device/c630s/outputs.hpp>
#include <servobus/device/c630s/position.hpp>
#include <servobus/device/c630s/position_segments.hpp>
#include <servobus/device/c630s/protection.hpp>
#include <servobus/device/c630s/speed.hpp>
#include <servobus/device/c630s/speed_segments.hpp>
#include <servobus/device/c630s/torque.hpp>
#include <servobus/device/c630s/tuning.hpp>
#include <servobus/device/c630s/virtual_terminals.hpp>
