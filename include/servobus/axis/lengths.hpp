// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Lengths of a machine as whole numbers of 64 bits, and the direction in which an axis counts. Lengths in coarser units
// convert to them exactly: `125.5_mm` is 125'500 um.
//
//     using namespace servobus::literals;
//     constexpr micrometres stroke = 125.5_mm;
//     static_assert(stroke.count() == 125'500 && nanometres{stroke}.count() == 125'500'000);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/registers/literals.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

/// A length in um, +-9.2e12 m.
using micrometres = quantity<unit{measure::micrometre}, std::int64_t>;
/// A length in nm, +-9.2e9 m, for what is divided by many counts.
using nanometres = quantity<unit{measure::micrometre, 1, 1000}, std::int64_t>;

/// The direction in which the drive of an axis counts.
enum class count_direction : std::uint8_t {
    forward,  ///< up when the axis moves forward
    mirrored, ///< down when the axis moves forward, as of a second motor that is mounted mirrored
};

} // namespace servobus
