// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The device at the other end of a Modbus TCP connection itself: a gateway's own registers, or a device that is on the
// network. It has no address on a serial line. Programs include it that talk to such a device.
//
//     posix::mbap port;
//     port.set_peer_unit(0); // if the device demands it; else 255
//     line wire{port, modbus::timing_at(115200)};
//     client meter{wire, peer_node<tank::device>{}};
#pragma once

#include <servobus/client/client.hpp>
#include <servobus/client/node.hpp>

namespace servobus {

/// A node whose requests go to the peer, and whose responses are awaited. For a line on Modbus TCP; not for a plan.
template <device_class Device> struct peer_node : node<Device> {
    static constexpr bool is_peer = true;
    constexpr peer_node() { this->address = modbus::peer_address; }
    constexpr bool is_valid() const { return this->address == modbus::peer_address; }
};

template <class Line, device_class Device>
client(Line&, peer_node<Device>) -> client<Line, Device, peer_node<Device>>;

} // namespace servobus
