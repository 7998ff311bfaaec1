// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a client must know of a node to time its requests and to judge its responses: the response timeout, the
// gaps before a request, and known deviations from the standard. registers/profile.hpp includes it for a
// device's defaults; programs include it to change those of a node.
//
//     constexpr response_limits slow_node{.response = milliseconds(250), .leading_bytes = 0};
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus {

/// Time limits for a node's responses, and deviations that are accepted in them.
struct response_limits {
    duration response = milliseconds(100);  ///< from the request's last bit to the response's first byte
    duration turnaround = milliseconds(10); ///< time after a broadcast in which nothing is sent
    std::uint8_t leading_bytes = 4; ///< number of bytes 00h or FFh ignored before a response; may be 0
    /// Deviation: the exception number with which the device answers a request with a bad CRC; 0: none.
    std::uint8_t corrupted_request = 0;
    /// The exception number by which the device has accepted a request that takes it longer; 0: none.
    std::uint8_t acknowledge = 5;
    /// Deviation: the response to 10h may carry the byte count in place of the quantity.
    bool echoes_byte_count = false;
    /// A gateway of RTU frames is between line and node: exceptions 0Ah and 0Bh are its own, not the node's. On
    /// Modbus TCP the port says so.
    bool has_gateway = false;
};

/// Minimum gaps on the line before a request to a node.
struct bus_gaps {
    duration gap{};        ///< before every request, if longer than t3.5
    duration quarantine{}; ///< if the last transaction did not end in exactly one valid response
};

/// How urgent a request is on its line.
enum class priority : std::uint8_t {
    ordinary,
    planned, ///< the plan of a bus has it
    stop,    ///< goes before all others, and waits for t3.5 or `bus_gaps::gap`, never for a quarantine
};

} // namespace servobus
