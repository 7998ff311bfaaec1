// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device at an address: its profile's figures, which may be changed for this one node, and the word order
// that it uses as far as that is known.
#pragma once

#include <cstdint>

#include <servobus/line.hpp>
#include <servobus/registers/profile.hpp>

namespace servobus {

/// Node `unit` of a `Device`. Time limits, quarantine and retries start as the device's profile has them.
template <device_class Device> struct node {
    std::uint8_t unit = Device::facts.lowest_unit;
    word_order order = Device::facts.order;
    std::uint8_t read_retries = Device::facts.read_retries; ///< reads only; a write is never repeated
    patience limits = Device::facts.limits;
    silences quiet{Device::facts.gap, Device::facts.quarantine};

    constexpr node() = default;
    constexpr explicit node(std::uint8_t address) : unit{address} {}

    /// True if a device of this kind can have the address.
    constexpr bool is_valid() const {
        return unit >= Device::facts.lowest_unit && unit <= Device::facts.highest_unit;
    }
};

} // namespace servobus
