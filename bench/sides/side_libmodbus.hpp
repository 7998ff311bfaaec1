// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A function of libmodbus that is measured in addition to the operations of its side.
#pragma once

#include <cstddef>
#include <cstdint>

namespace bench {

/// Lets libmodbus make a frame of 2..254 bytes and send it into the wire in memory: the CRC, and a copy
/// before and after it. The CRC of libmodbus cannot be called alone.
bool libmodbus_sends(const std::uint8_t* bytes, std::size_t count);

} // namespace bench
