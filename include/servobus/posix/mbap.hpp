// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, POSIX: Modbus TCP over a connection, as a port. To a gateway in Modbus TCP mode, or to a device with a
// network connector.
//
//     servobus::posix::mbap port;
//     if (port.open("192.168.1.7", "502") != servobus::errc::ok) return 1;
//     servobus::line line{port, servobus::modbus::timing_at(115200)};
//
// `limits.response` of a node contains the network and the gateway, which may have requests of others to send first.
// Exceptions 0Ah and 0Bh are the gateway's: no way to the drive, no response of it.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/line/mbap_port.hpp>
#include <servobus/posix/tcp.hpp>

namespace servobus::posix {

using mbap = mbap_port<tcp>;

static_assert(waiting_port<mbap>);

} // namespace servobus::posix
