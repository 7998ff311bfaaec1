// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D dual hub servo: its registers and their values, its commands and its drive. Programs
// include it together with servobus/servobus.hpp. Tools also include zlac8015d/catalogue.hpp, which has the
// registers by name.
//
//     auto roll(auto& wire) { // on a line
//         zlac8015d::drive wheels{wire, 1, {.command_timeout = milliseconds(500)}};
//         return wheels.run(init{}) && wheels.run(enable{}) &&
//                wheels.run(velocity{30 * units::r_per_min, -30 * units::r_per_min});
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/device/zlac8015d/commands.hpp>
#include <servobus/device/zlac8015d/drive.hpp>
#include <servobus/device/zlac8015d/parameters.hpp>
#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/device/zlac8015d/single_parameters.hpp>
#include <servobus/device/zlac8015d/values.hpp>
