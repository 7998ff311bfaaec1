// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The named units of meters and sensors, which maps of drives do not have. A program without such a device does not
// include them, since each costs the compiler time.
//
//     static_assert((15 * part<10>(units::kilowatt_hour)).in(units::watt_hour) == 1500);
//     static_assert((90 * units::minute).in(units::second) == 5400);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/registers/unit.hpp>

namespace servobus::units {
inline constexpr unit_constant<unit{measure::minute}> minute{};
inline constexpr unit_constant<unit{measure::hour}> hour{};
inline constexpr unit_constant<unit{measure::kilowatt}> kilowatt{};
inline constexpr unit_constant<unit{measure::volt_ampere}> volt_ampere{};
inline constexpr unit_constant<unit{measure::var}> var{};
inline constexpr unit_constant<unit{measure::watt_hour}> watt_hour{};
inline constexpr unit_constant<unit{measure::kilowatt_hour}> kilowatt_hour{};
inline constexpr unit_constant<unit{measure::var_hour}> var_hour{};
inline constexpr unit_constant<unit{measure::kilogram}> kilogram{};
inline constexpr unit_constant<unit{measure::newton}> newton{};
inline constexpr unit_constant<unit{measure::newton_metre}> newton_metre{};
inline constexpr unit_constant<unit{measure::pascals}> pascals{};
inline constexpr unit_constant<unit{measure::bar}> bar{};
inline constexpr unit_constant<unit{measure::litre}> litre{};
inline constexpr unit_constant<unit{measure::cubic_metre}> cubic_metre{};
inline constexpr unit_constant<unit{measure::litre_per_minute}> litre_per_minute{};
inline constexpr unit_constant<unit{measure::cubic_metre_per_hour}> cubic_metre_per_hour{};
/// A unit of the device's own: `ppm`, `lux`. A catalogue has its symbol.
inline constexpr unit_constant<unit{measure::device_unit}> device_unit{};
} // namespace servobus::units
