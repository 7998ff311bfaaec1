// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: its register map, 463 parameters, in one header for each subject, in registers/.
// servobus/device/c630s.hpp includes it, and so do the catalogue and the drive's own headers. Source: manual
// V24.111, chapter 7; [errata Cn] are in device/errata_c630s.md.
//
//     auto look(auto& servo) { // a client; in the fewest requests
//         return read<c630s::actual_speed, c630s::phase_current, c630s::bus_voltage>(servo);
//     }
#pragma once

#include <servobus/device/c630s/registers/auxiliary.hpp>
#include <servobus/device/c630s/registers/bus_signals.hpp>
#include <servobus/device/c630s/registers/communication.hpp>
#include <servobus/device/c630s/registers/control.hpp>
#include <servobus/device/c630s/registers/gains.hpp>
#include <servobus/device/c630s/registers/inputs.hpp>
#include <servobus/device/c630s/registers/monitoring.hpp>
#include <servobus/device/c630s/registers/outputs.hpp>
#include <servobus/device/c630s/registers/position.hpp>
#include <servobus/device/c630s/registers/position_segments.hpp>
#include <servobus/device/c630s/registers/protection.hpp>
#include <servobus/device/c630s/registers/speed.hpp>
#include <servobus/device/c630s/registers/speed_segments.hpp>
#include <servobus/device/c630s/registers/torque.hpp>
#include <servobus/device/c630s/registers/tuning.hpp>
#include <servobus/device/c630s/registers/virtual_terminals.hpp>
