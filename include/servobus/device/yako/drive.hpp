// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the drives as their programs see them, `closed_loop::drive` and
// `open_loop::drive`.
#pragma once

#include <cstdint>

#include <servobus/device/yako/basic_drive.hpp>

namespace servobus::yako {

namespace closed_loop {
/// One closed loop drive (ESS242-, ESS257-, ESS286-Rx1) on a line.
template <class Line> class drive : public basic_drive<device, Line> {
  public:
    constexpr explicit drive(Line& on, std::uint8_t at = 1) : drive{on, servobus::node<device>{at}} {}
    /// With limits and silences of its own.
    constexpr drive(Line& on, const servobus::node<device>& at) : basic_drive<device, Line>{on, at} {}
};
} // namespace closed_loop

namespace open_loop {
/// One open loop drive (ESD2205PR, ESD2505PR, YKE2405PR, YKE2608PR) on a line.
template <class Line> class drive : public basic_drive<device, Line> {
  public:
    constexpr explicit drive(Line& on, std::uint8_t at = 1) : drive{on, servobus::node<device>{at}} {}
    /// With limits and silences of its own.
    constexpr drive(Line& on, const servobus::node<device>& at) : basic_drive<device, Line>{on, at} {}
};
} // namespace open_loop

} // namespace servobus::yako
