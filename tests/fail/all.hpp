// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Whatever wrong programs include, to be precompiled.
#pragma once

#include <servobus/client/settings_on_one_line.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/control/arguments.hpp>
#include <servobus/control/setpoint_loop.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako/wiring.hpp>
#include <servobus/server/host_row_server.hpp>

#include "basin.hpp"
#include "belts.hpp"
#include "chassis.hpp"
#include "drives.hpp"
#include "gauge.hpp"
#include "meters.hpp"
#include "program.hpp"
#include "served.hpp"
#include "stepper.hpp"
#include "switched.hpp"
#include "travel.hpp"
