// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, closed loop and open loop: the registers and their values, the commands and the
// drives of both variants. Programs include it together with servobus/servobus.hpp. Tools also include
// yako/closed_loop_catalogue.hpp or yako/open_loop_catalogue.hpp, which have the registers by name.
//
//     auto advance(auto& wire) { // on a line
//         yako::closed_loop::drive axis{wire, 1};
//         return axis.run(init{}) && axis.run(enable{}) &&
//                axis.run(move_by{5000 * units::pulse}) && axis.run(wait_standstill{});
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/commands.hpp>
#include <servobus/device/yako/common.hpp>
#include <servobus/device/yako/drive.hpp>
#include <servobus/device/yako/feedback.hpp>
#include <servobus/device/yako/hold.hpp>
#include <servobus/device/yako/homing.hpp>
#include <servobus/device/yako/open_loop.hpp>
#include <servobus/device/yako/parameters.hpp>
#include <servobus/device/yako/single_parameters.hpp>
#include <servobus/device/yako/values.hpp>
