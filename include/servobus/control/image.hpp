// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The process image of a drive: its feedback registers as the last frame read them, with the time at which
// they were read. control/facade.hpp includes it.
//
//     static_assert(zlac8015d::model::image.contains(zlac8015d::left_actual_speed.address, 2));
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// Adjacent registers that one frame reads.
struct register_block {
    std::uint16_t address;
    std::uint8_t words;

    constexpr bool contains(std::uint16_t first, std::uint8_t count) const {
        return first >= address && first + count <= address + words;
    }
};

/// The words of a block, as a frame read them.
template <std::size_t Words> struct process_image {
    std::uint16_t words[Words]{};
    bool has_words = false; // here it takes no room of its own
    instant taken{};        ///< when the request began to leave: the drive's values are no older
};

/// Of a model that has further blocks: control/slower_blocks.hpp.
template <class Model> class slower_blocks {};

} // namespace servobus
