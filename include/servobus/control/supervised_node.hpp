// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plan states the limits, gaps and supervision of each drive that it controls. The plan's bus gives them to the
// drive's machine; programs do not include this.
//
//     constexpr supervised_node wheels{.address = 1,
//                                      .by = {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};
#pragma once

#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/supervision.hpp>

namespace servobus {

/// A drive with a facade, as a plan has it.
struct supervised_node {
    std::uint8_t address = 0;
    response_limits limits{};
    bus_gaps gaps{};
    supervision by = unsupervised;
};

} // namespace servobus
