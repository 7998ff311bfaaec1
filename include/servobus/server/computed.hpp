// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row whose value a function computes each time that a client reads it. It takes flash for the function, and no RAM.
// server/row_values.hpp includes it.
//
//     constexpr u32 seconds() { return 42; }
//     static_assert(computed<tank::uptime, seconds>.bits() == 42); // row_values<tank::level, computed<..>>
#pragma once

#include <type_traits>

#include <servobus/registers/tables.hpp>
#include <servobus/server/stored_value.hpp>

namespace servobus {

namespace detail {
template <const auto& R> struct served_reading { using type = reading<R>; };
template <const auto& R>
requires is_bit<R>
struct served_reading<R> {
    using type = bool;
};
} // namespace detail

/// The type of row `R` in a server: bool for a coil or a discrete input, else `reading<R>`.
template <const auto& R> using served_reading = typename detail::served_reading<R>::type;

/// The type of `computed`.
template <const auto& R, auto Function> struct computed_row {
    using row = std::remove_cvref_t<decltype(R)>;

    static_assert(row::rights == access::ro, "a computed row is read-only");
    static_assert(std::is_same_v<decltype(Function()), served_reading<R>>,
                  "the function of a computed row returns what a read of the row returns");

    /// The value as a server sends it.
    static constexpr u32 bits() {
        if constexpr (is_bit<R>) {
            return Function() ? 1 : 0;
        } else {
            return stored_value<R>::bits_of_reading(Function());
        }
    }
};

/// Row `R` for `row_values`, with the function that computes its value: `served_reading<R> function()`. A read calls it
/// once, after all rows of the request have been checked. The function keeps the row's range.
template <const auto& R, auto Function> inline constexpr computed_row<R, Function> computed{};

} // namespace servobus
