// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: its registers, its alarms and its drive. The catalogue for tools is a header of its
// own, c630s/catalogue.hpp.
#pragma once

#include <servobus/device/c630s/alarms.hpp>
#include <servobus/device/c630s/drive.hpp>
#include <servobus/device/c630s/feedback.hpp>
#include <servobus/device/c630s/functions.hpp>
#include <servobus/device/c630s/moves.hpp>
#include <servobus/device/c630s/orders.hpp>
#include <servobus/device/c630s/parameters.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/c630s/terminals.hpp>
#include <servobus/device/c630s/values.hpp>
