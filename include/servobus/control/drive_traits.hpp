// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// In which respects drives differ that have the same commands. The model of each drive states them; a program reads
// them from the drive's facade, at compile time.
//
//     static_assert(zlac8015d::model::traits.stops_without_line && !c630s::model::traits.stops_without_line);
#pragma once

#include <servobus/core/cxx20.hpp>

namespace servobus {

/// Each is false where the manual does not state it.
struct drive_traits {
    bool stops_without_line;       ///< its own watchdog stops the motor when requests no longer arrive
    bool halts_in_position;        ///< `halt` also stops a move to a position
    bool changes_speed_on_the_run; ///< a velocity command is accepted while the motor turns
    bool has_homing;               ///< it looks for its home by itself
    bool keeps_single_parameters;  ///< one parameter can be kept over a power cycle without the others
};

} // namespace servobus
