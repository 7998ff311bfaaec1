// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A prepared command of a drive that moves an axis: the drive's own, and what a relative move of the axis leaves when
// its length is rounded to counts. The model of such a drive has it as its `prepared_command`.
//
//     using command = axis_command<yako::prepared_command>;
//     constexpr command stop = yako::prepare(halt{}, {}); // every command of the drive is one
//     static_assert(!stop.carries);
#pragma once

#include <cstdint>

#include <servobus/control/step.hpp>

namespace servobus {

/// A prepared command of a drive that moves an axis.
template <class Command> struct axis_command : Command {
    constexpr axis_command(const Command& c) : Command{c} {} // NOLINT: implicit, as every other command
    constexpr explicit axis_command(const routine& table) : Command{.steps = table} {}

    std::int32_t rest = 0; ///< what the move leaves for the next one
    bool carries = false;  ///< it is a relative move of the axis
};

} // namespace servobus
