// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a client grants a device and its line: time, silences, and what is forgiven.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus {

/// How long a device may take and what is forgiven on its line.
struct response_limits {
    duration response = milliseconds(100);  ///< from the request's last bit to the response's first byte
    duration turnaround = milliseconds(10); ///< after a broadcast, before anything else is sent
    std::uint8_t leading_bytes = 4;         ///< 0x00 and 0xFF bytes forgiven before a response; may be 0
    std::uint8_t corrupted_request = 0; ///< quirk: this exception says that the request came damaged; 0: none
    bool echoes_byte_count = false;     ///< quirk: the response to 10h carries the byte count as quantity
};

/// Silences that a node asks for before a request to it.
struct bus_gaps {
    duration gap{};         ///< always, if longer than t3.5
    duration quarantine{};  ///< after a transaction that did not end in exactly one valid response
    bool is_urgent = false; ///< a stop: waits for t3.5 or the gap only, whatever happened before
};

} // namespace servobus
