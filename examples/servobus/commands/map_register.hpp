// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One register of a map, for people.
#pragma once

#include "../devices/device.hpp"
#include "../registers/session.hpp"

namespace tool {

/// Prints what the catalogue has about a register: name and sentence, then a line for each property.
void print_register(const device& of, const chosen& what);

} // namespace tool
