// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The one thing beside its side that is measured of libmodbus.
#pragma once

#include <cstddef>
#include <cstdint>

namespace bench {

/// Has libmodbus make a frame of these bytes, 2..254, and send it into the wire in memory: the CRC, and a
/// copy before and behind it. Its CRC alone cannot be called.
bool libmodbus_sends(const std::uint8_t* bytes, std::size_t count);

} // namespace bench
