// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device at an address: its profile's figures, which may be changed for this one node, and the word order
// that it uses as far as that is known.
#pragma once

#include <cstdint>

#include <servobus/line/line.hpp>
#include <servobus/registers/profile.hpp>

namespace servobus {

namespace detail {
/// Of a device that can switch its word order: what is known of it.
template <device_class Device, bool IsFixed = has_fixed_order<Device>> struct node_order {
    word_order order = Device::facts.order;
};
/// Of one that has one order only: nobody can set another.
template <device_class Device> struct node_order<Device, true> {
    static constexpr word_order order = Device::facts.order;
};
} // namespace detail

/// Node `unit` of a `Device`, with the `order` of its words. Time limits, quarantine and retries start as the
/// device's profile has them.
template <device_class Device> struct node : detail::node_order<Device> {
    std::uint8_t unit = Device::facts.lowest_unit;
    std::uint8_t read_retries = Device::facts.read_retries; ///< reads only; a write is never repeated
    response_limits limits = Device::facts.limits;
    bus_gaps gaps{Device::facts.gap, Device::facts.quarantine};

    constexpr node() = default;
    constexpr explicit node(std::uint8_t address) : unit{address} {}

    /// True if a device of this kind can have the address.
    constexpr bool is_valid() const {
        return unit >= Device::facts.lowest_unit && unit <= Device::facts.highest_unit;
    }
};

namespace detail {
template <device_class Device> struct fixed_patience {
    static constexpr duration response = Device::facts.limits.response;
    static constexpr duration turnaround = Device::facts.limits.turnaround;
    static constexpr std::uint8_t leading_bytes = Device::facts.limits.leading_bytes;
    static constexpr std::uint8_t corrupted_request = Device::facts.limits.corrupted_request;
    static constexpr bool echoes_byte_count = Device::facts.limits.echoes_byte_count;
};
template <device_class Device> struct fixed_silences {
    static constexpr duration gap = Device::facts.gap;
    static constexpr duration quarantine = Device::facts.quarantine;
    static constexpr bool is_urgent = false;
};
} // namespace detail

/// Node `Unit` of a `Device` whose figures never change: constants of the program, for a `blocking_line`. A
/// client of it takes no RAM for them, and its reads are frames in flash.
template <device_class Device, std::uint8_t Unit = Device::facts.lowest_unit> struct fixed_node {
    static_assert(Unit >= Device::facts.lowest_unit && Unit <= Device::facts.highest_unit,
                  "a device of this kind cannot have this address");

    static constexpr std::uint8_t unit = Unit;
    static constexpr word_order order = Device::facts.order;
    static constexpr std::uint8_t read_retries = Device::facts.read_retries;
    static constexpr detail::fixed_patience<Device> limits{};
    static constexpr detail::fixed_silences<Device> gaps{};

    static constexpr bool is_valid() { return true; }
};

/// Whether requests to the node are constants.
template <class Node> inline constexpr bool is_fixed = false;
template <device_class Device, std::uint8_t Unit>
inline constexpr bool is_fixed<fixed_node<Device, Unit>> = true;

} // namespace servobus
