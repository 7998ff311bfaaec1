// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated C630S on a virtual line with factory settings: node 1, 57600 Bd. It delays its response by
// P0C-25.
#pragma once

#include <servobus/sim/c630s.hpp>

#include "simulated_model.hpp"

namespace simulated {

using simulated_c630s = simulated_model<servobus::sim::c630s, servobus::sim::c630s_options, 57600>;

} // namespace simulated
