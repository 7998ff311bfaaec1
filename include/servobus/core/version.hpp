// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The library's version, for a program that prints it or needs a least one.
//
//     static_assert(servobus::version >= servobus::version_number{0, 1, 0});
#pragma once

#include <servobus/core/cxx20.hpp>

#include <compare>

namespace servobus {

/// MAJOR.MINOR.PATCH. Before 1.0.0 a new MINOR may change names.
struct version_number {
    int major_number = 0; // not `major`: a macro of some C libraries
    int minor_number = 0;
    int patch_number = 0;

    constexpr auto operator<=>(const version_number&) const = default;
};

/// This one; CMakeLists.txt, meson.build and the pkg-config file say the same.
inline constexpr version_number version{0, 1, 0};

} // namespace servobus
