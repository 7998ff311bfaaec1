// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the orders of every drive's facade need to be checked before anything is sent: the first of several
// errors, and values as counts of a row.
#pragma once

#include <cstdint>

#include <servobus/registers/register_value.hpp>

/// What a drive's author makes of a command's arguments: counts of a row, words of a frame, the first error.
namespace servobus::commands {

constexpr errc first_error(errc a, errc b) { return a != errc::ok ? a : b; }
template <class... More> constexpr errc first_error(errc a, errc b, More... more) {
    return first_error(first_error(a, b), more...);
}

/// A code or a plain number against its row's limits: an enumeration may have been made of any number.
template <const auto& R, class V> constexpr errc in_range(V value) {
    return register_value<R>::writable.contains(static_cast<std::int64_t>(value)) ? errc::ok
                                                                                  : errc::out_of_range;
}

/// A quantity in counts of a row; `inexact` or `out_of_range` if it is none.
template <const auto& R, unit U> constexpr counted count_in(quantity<U, std::int32_t> q) {
    counted c = count_of<R>(q);
    if (c.error == errc::ok && !register_value<R>::writable.contains(c.count)) c.error = errc::out_of_range;
    return c;
}

/// The word that carries a count, or a code.
constexpr std::uint16_t as_word(std::int64_t count) { return static_cast<std::uint16_t>(count & 0xFFFF); }
template <class E>
requires wire_enum<E>
constexpr std::uint16_t as_word(E value) { return static_cast<std::uint16_t>(value); }

} // namespace servobus::commands
