// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A block of the feedback by its rows: adjacent registers that one frame reads, and the place of each among its words.
//
//     using image = servobus::image_of<zlac8015d::status_word, zlac8015d::hall_state>;
//     static_assert(image::block.words == 2 && image::place_of<zlac8015d::hall_state> == 1);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>
#include <type_traits>

#include <servobus/control/image.hpp>
#include <servobus/control/steps.hpp>

namespace servobus {

namespace detail {
template <const auto& Row> struct row_name {};
} // namespace detail

/// Rows in address order, without a gap, of at most 11 registers.
template <const auto&... Rows> class image_of {
    static constexpr step read = steps::fetch<Rows...>();

  public:
    static constexpr register_block block{read.address, read.count};
    /// The word at which the row begins.
    template <const auto& Row>
    static constexpr std::uint8_t place_of = [] {
        static_assert((std::is_same_v<detail::row_name<Row>, detail::row_name<Rows>> || ...),
                      "the row is not one of this block");
        return static_cast<std::uint8_t>(Row.address - block.address);
    }();
};

} // namespace servobus
