// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the registers and the drives of both variants. The catalogues for tools are
// headers of their own, yako/closed_loop_catalogue.hpp and yako/open_loop_catalogue.hpp.
#pragma once

#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/common.hpp>
#include <servobus/device/yako/drive.hpp>
#include <servobus/device/yako/feedback.hpp>
#include <servobus/device/yako/homing.hpp>
#include <servobus/device/yako/open_loop.hpp>
#include <servobus/device/yako/orders.hpp>
#include <servobus/device/yako/parameters.hpp>
#include <servobus/device/yako/values.hpp>
