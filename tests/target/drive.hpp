// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated ZLAC8015D at address 1 for the measured programs. It checks each request and responds as its
// manual states, with its own CRC, parser and state, independent of the library. No figure includes it.
#pragma once

#include <cstdint>

namespace simulated_drive {

/// A response of the drive; empty if it does not respond.
struct frame {
    const std::uint8_t* begin = nullptr;
    const std::uint8_t* end = nullptr;
};

/// Takes a whole request. The response stays valid until the next request.
frame answer(const std::uint8_t* request, std::uint32_t size);

/// The number of requests to which it has responded; it wraps.
std::uint32_t answered();

/// True if the wheels have turned since the last call, and the drive is now disabled and at standstill.
bool has_run();

/// Sets the fault code of the left wheel, 20A5h. Other than 0 it ends the operation of both.
void set_fault(std::uint32_t code);

/// True if, since the last call, moves have driven the wheels by so many counts to their targets, a quick stop
/// has held the shafts and a fault was reset, and the drive is now without a fault.
bool has_done_all(std::int32_t left, std::int32_t right);

} // namespace simulated_drive
