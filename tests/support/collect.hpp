// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What arrives at a real port.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/line/port.hpp>

namespace tests {

/// Reads until `size` bytes are there or two seconds have passed.
template <servobus::waiting_port Port> std::vector<std::uint8_t> collect(Port& from, std::size_t size) {
    std::vector<std::uint8_t> all;
    const servobus::instant start = from.now();
    while (all.size() < size && since(start, from.now()) < servobus::milliseconds(2000)) {
        std::array<std::uint8_t, 700> chunk{};
        const servobus::transfer came = from.receive(chunk);
        if (!came) break;
        all.insert(all.end(), chunk.begin(), chunk.begin() + *came);
        if (*came == 0) from.wait(servobus::milliseconds(10));
    }
    return all;
}

} // namespace tests
