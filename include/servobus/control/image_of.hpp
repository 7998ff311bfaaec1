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

#include <servobus/control/image.hpp>
#include <servobus/control/steps.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a place that calls it does not compile, and the error names the rule.
inline void the_row_is_not_one_of_this_block() {}
} // namespace detail

/// Rows in address order, without a gap, of at most 11 registers.
template <const auto&... Rows> class image_of {
    static constexpr bool are_adjacent() {
        const extent rows[]{{Rows.address, static_cast<std::uint16_t>(row_type<Rows>::words)}...};
        return detail::are_adjacent(rows, sizeof...(Rows));
    }
    static constexpr step step_of() {
        if constexpr (are_adjacent()) {
            return steps::fetch<Rows...>();
        } else { // the assertion is the only error
            step one{};
            one.count = 1;
            return one;
        }
    }
    static constexpr step read = step_of();

    static constexpr std::uint8_t place_at(std::uint16_t address) {
        if (((Rows.address != address) && ...)) detail::the_row_is_not_one_of_this_block();
        return static_cast<std::uint8_t>(address - read.address);
    }

  public:
    static constexpr register_block block{read.address, read.count};
    /// The word at which the row begins.
    template <const auto& Row> static constexpr std::uint8_t place_of = place_at(Row.address);

  private:
    // Last: clang++ has no member that follows a failed assertion, and would print an error for each that is used.
    static_assert(are_adjacent(), "a_step_is_of_adjacent_registers");
};

} // namespace servobus
