// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the argument of `on_init` (hardware_interface 4.46.0, Jazzy, and Rolling), without the executor.
#pragma once

#include "hardware_interface/hardware_info.hpp"

namespace hardware_interface {

struct HardwareComponentInterfaceParams {
    HardwareComponentInterfaceParams() = default;
    HardwareInfo hardware_info;
};

} // namespace hardware_interface
