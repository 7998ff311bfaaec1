// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device whose line is set at the factory, for the wrong programs that put it on a line with others.
#pragma once

#include <servobus/registers/profile.hpp>

struct gauge {
    static constexpr servobus::profile facts{
        .name = "gauge", .baud = 9600, .format = servobus::character_format::e81};
};
