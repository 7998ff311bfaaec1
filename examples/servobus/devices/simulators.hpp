// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated drives of `servobus sim`. Each returns the exit status.
#pragma once

#include "../tool.hpp"

namespace tool {

int simulate_zlac8015d(const simulation& wanted);
int simulate_yako_closed_loop(const simulation& wanted);
int simulate_yako_open_loop(const simulation& wanted);
int simulate_c630s(const simulation& wanted);
/// A device of a file, which holds what is written to it.
int simulate_file(const device& of, const simulation& wanted);

} // namespace tool
