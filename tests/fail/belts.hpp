// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D with two belts, for the wrong programs with axes.
#pragma once

#include <servobus/axis/axis.hpp>
#include <servobus/device/zlac8015d/axes.hpp>

#include "chassis.hpp"
#include "program.hpp"

using servobus::axis;

inline constexpr axis belt = axis::of(tyre);

inline some_port port_of_belts;
inline servobus::line<some_port> line_of_belts{port_of_belts, servobus::modbus::timing_at(115200)};
