// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats what read and write return (hardware_interface 2.54.0, Humble).
#pragma once

#include <cstdint>

namespace hardware_interface {

enum class return_type : std::uint8_t { OK = 0, ERROR = 1 };

} // namespace hardware_interface
