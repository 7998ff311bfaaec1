// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D at address 1 for the measured programs: it checks each request and answers as its manual says,
// with a CRC, a parser and a state of its own, apart from the library. Nothing of it is in a figure.
#pragma once

#include <cstdint>

namespace simulated_drive {

/// A frame of the drive's; empty where it does not answer.
struct frame {
    const std::uint8_t* begin = nullptr;
    const std::uint8_t* end = nullptr;
};

/// Takes a whole request. The answer stays as it is until the next one.
frame answer(const std::uint8_t* request, std::uint32_t size);

/// Requests that it has answered; it wraps.
std::uint32_t answered();

/// True if the wheels have turned since the last call, and the drive is disabled and stands now.
bool has_run();

} // namespace simulated_drive
