// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: its registers and their values, its alarms, its commands and its drive. Programs
// include it together with servobus/servobus.hpp. Tools also include c630s/catalogue.hpp, which has the
// registers by name.
//
//     auto turn(auto& wire) { // on a line
//         c630s::drive servo{wire, 1};
//         return servo.run(init{}) && servo.run(enable{}) &&
//                servo.run(velocity{300 * units::r_per_min});
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/device/c630s/alarms.hpp>
#include <servobus/device/c630s/commands.hpp>
#include <servobus/device/c630s/drive.hpp>
#include <servobus/device/c630s/feedback.hpp>
#include <servobus/device/c630s/functions.hpp>
#include <servobus/device/c630s/moves.hpp>
#include <servobus/device/c630s/parameters.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/c630s/single_parameters.hpp>
#include <servobus/device/c630s/terminals.hpp>
#include <servobus/device/c630s/values.hpp>
