// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device at an address: its limits, gaps, retries and word order. They start with the figures of the device's
// profile; a program changes them before it makes a client or a facade of the node. The headers of clients and
// facades include this one.
//
//     node<yako::closed_loop::device> lift_node{3};
//     lift_node.limits.response = milliseconds(250); // through a radio link
//     lift_node.gaps.quarantine = milliseconds(400); // longer than a response is ever late
//     yako::closed_loop::drive lift{wire, lift_node};
#pragma once

#include <cstdint>

#include <servobus/line/line.hpp>
#include <servobus/registers/profile.hpp>

namespace servobus {

namespace detail {
/// The word order of a device that can switch it, as far as it is known.
template <device_class Device, bool IsFixed = has_fixed_word_order<Device>> struct node_order {
    servobus::word_order word_order = Device::facts.word_order;
};
/// The word order of a device that has only one: a constant.
template <device_class Device> struct node_order<Device, true> {
    static constexpr servobus::word_order word_order = Device::facts.word_order;
};
} // namespace detail

/// Node `address` of a `Device`, with its word order. Limits, gaps and retries start with the profile's figures.
template <device_class Device> struct node : detail::node_order<Device> {
    std::uint8_t address = Device::facts.lowest_address;
    std::uint8_t read_retries = Device::facts.read_retries; ///< reads only; a write is never repeated
    response_limits limits = Device::facts.limits;
    bus_gaps gaps{Device::facts.gap, Device::facts.quarantine};
    servobus::priority priority = servobus::priority::ordinary; ///< of all requests of its client

    constexpr node() = default;
    constexpr explicit node(std::uint8_t at) : address{at} {}

    /// True if a device of this kind can have the address.
    constexpr bool is_valid() const {
        return address >= Device::facts.lowest_address && address <= Device::facts.highest_address;
    }
};

namespace detail {
/// The quarantine of a node that responds within a time: a response may be 10 ms late.
constexpr duration quarantine_of(duration within, const bus_gaps& gaps) {
    return longer_of(within + milliseconds(10), gaps.gap);
}
} // namespace detail

/// A node that responds `within` a shorter time than its profile grants, so that on a line that it shares others wait
/// less when it does not respond. Only for a device that was seen to: a response that comes later is dropped in the
/// quarantine, which is 10 ms longer, and the request counts as one without a response.
template <device_class Device> constexpr node<Device> responds_within(node<Device> at, duration within) {
    at.limits.response = within;
    at.gaps.quarantine = detail::quarantine_of(within, at.gaps);
    return at;
}

namespace detail {
template <device_class Device> struct fixed_response_limits {
    static constexpr duration response = Device::facts.limits.response;
    static constexpr duration turnaround = Device::facts.limits.turnaround;
    static constexpr std::uint8_t leading_bytes = Device::facts.limits.leading_bytes;
    static constexpr std::uint8_t corrupted_request = Device::facts.limits.corrupted_request;
    static constexpr std::uint8_t acknowledge = Device::facts.limits.acknowledge;
    static constexpr bool echoes_byte_count = Device::facts.limits.echoes_byte_count;
    static constexpr bool has_gateway = Device::facts.limits.has_gateway;
};
template <device_class Device> struct fixed_bus_gaps {
    static constexpr duration gap = Device::facts.gap;
    static constexpr duration quarantine = Device::facts.quarantine;
};
struct fixed_priority {}; // ordinary
} // namespace detail

/// Node `Address` of a `Device` whose figures never change: constants of the program, for a `blocking_line`.
/// A client of it takes no RAM for them, and its reads are frames in flash.
template <device_class Device, std::uint8_t Address = Device::facts.lowest_address> struct fixed_node {
    static_assert(Address >= Device::facts.lowest_address && Address <= Device::facts.highest_address,
                  "a device of this kind cannot have this address");

    static constexpr std::uint8_t address = Address;
    static constexpr servobus::word_order word_order = Device::facts.word_order;
    static constexpr std::uint8_t read_retries = Device::facts.read_retries;
    static constexpr detail::fixed_response_limits<Device> limits{};
    static constexpr detail::fixed_bus_gaps<Device> gaps{};
    static constexpr detail::fixed_priority priority{};

    static constexpr bool is_valid() { return true; }
};

/// True if requests to the node are constants.
template <class Node> inline constexpr bool is_fixed = false;
template <device_class Device, std::uint8_t Address>
inline constexpr bool is_fixed<fixed_node<Device, Address>> = true;

} // namespace servobus
