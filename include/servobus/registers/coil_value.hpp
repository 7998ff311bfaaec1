// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What is written to a coil: true or false, and nothing that converts to it. registers/tables.hpp includes it.
//
//     constexpr register_value<tank::valve> open{true}; // tank::valve: a coil
//     static_assert(open.bits() == 1);
#pragma once

#include <type_traits>

#include <servobus/registers/register_value.hpp>
#include <servobus/registers/table_rows.hpp>

namespace servobus {

/// Another word than on (FF00h) and off (0000h) that function 05 sends to a coil: 5500h toggles many relays.
struct coil_word {
    u16 value;
};

/// A value to be written to coil `R`. A number does not compile: a coil is FF00h or 0000h on the line, and neither 1
/// nor 2 says which.
template <const auto& R>
requires is_bit<R>
class register_value<R> {

  public:
    using value_type = bool;

    template <class Bool> constexpr register_value(Bool on) { // NOLINT: implicit
        static_assert(std::is_same_v<Bool, bool>, "a coil is written as true or false");
        if constexpr (std::is_same_v<Bool, bool>) on_ = on; // else the assertion is the only error
    }

    static constexpr errc error() { return errc::ok; }
    constexpr u32 bits() const { return on_ ? 1 : 0; }

  private:
    bool on_ = false;

    // Last: clang++ has no member that follows a failed assertion, and would print an error for each that is used.
    static_assert(table_of<R> == table::coils && row_type<R>::rights != access::ro, "this bit is read-only");
};

} // namespace servobus
