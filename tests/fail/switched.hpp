// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device that can switch the word order of its 32-bit values, for the wrong programs with a pair.
#pragma once

#include <servobus/registers/reg.hpp>

namespace switched {
struct device {
    static constexpr servobus::profile facts{.name = "switched", .word_order = servobus::word_order::unknown};
};
inline constexpr servobus::reg<servobus::i32, servobus::access::rw, device> place{
    0x0100, servobus::full<servobus::i32>, servobus::no_unit, 0};
} // namespace switched
