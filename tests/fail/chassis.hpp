// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A machine with two wheels, for the wrong programs with a geometry.
#pragma once

#include <servobus/axis/axle.hpp>

using namespace servobus::literals;
using servobus::axle, servobus::counts_per_turn, servobus::gear_ratio, servobus::rolling;

inline constexpr servobus::feed tyre = rolling(652.3_mm, counts_per_turn{16384});
inline constexpr axle base = axle::of({.left = tyre, .right = mirrored(tyre), .track = 500_mm});
