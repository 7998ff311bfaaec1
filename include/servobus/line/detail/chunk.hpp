// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The bytes that a port gives in one call of `receive`.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/small_core.hpp>

namespace servobus::detail {

// Made with zeros, since this memory may hold the last response: a port that claims bytes which it did not write
// would deliver that again, with its CRC.
struct chunk {
    std::uint8_t all[is_small_core ? 4 : 32]; // 4 bytes are one store of a small core

    // No more than there are, whatever a port claims.
    constexpr bytes first(std::uint16_t count) const {
        return {all, count < sizeof all ? count : sizeof all};
    }
};

} // namespace servobus::detail
