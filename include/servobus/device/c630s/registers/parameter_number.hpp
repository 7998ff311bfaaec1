// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: parameter numbers of the C630S as its manual writes them. row.hpp includes it. The high
// byte of a register's address has the two characters of the group, read as hexadecimal digits; the low
// byte has the decimal index: "P0B-17" is 0x0B11. Source: manual V24.111, section 9.1.3; [errata C9].
//
//     using namespace c630s::literals;
//     static_assert("P0B-17"_p == 0x0B11);
//     const bool is_di7 = servo.conflicting_terminal() == "P03-14"_p; // after `already_assigned`
#pragma once

#include <cstddef>

#include <servobus/registers/wire.hpp>

namespace servobus::c630s {

namespace detail {
// Not constexpr on purpose: a number that calls it does not compile.
inline void a_parameter_number_looks_like_P0B_17() {}

constexpr int hex_digit(char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}
constexpr int decimal_digit(char c) { return c >= '0' && c <= '9' ? c - '0' : -1; }

/// The address of a parameter number; negative if the text is not a parameter number.
constexpr int parameter_address(const char* text, std::size_t size) {
    if (size != 6 || text[0] != 'P' || text[3] != '-') return -1;
    const int high = hex_digit(text[1]);
    const int low = hex_digit(text[2]);
    const int tens = decimal_digit(text[4]);
    const int ones = decimal_digit(text[5]);
    if (high < 0 || low < 0 || tens < 0 || ones < 0) return -1;
    return (high * 16 + low) * 256 + tens * 10 + ones;
}
} // namespace detail

inline namespace literals {
/// The address of a parameter: `"P0B-17"_p == 0x0B11`. Any text but P, two hexadecimal digits in capitals, a
/// hyphen and two decimal digits does not compile.
consteval u16 operator""_p(const char* text, std::size_t size) {
    const int address = detail::parameter_address(text, size);
    if (address < 0) detail::a_parameter_number_looks_like_P0B_17();
    return static_cast<u16>(address);
}
} // namespace literals

} // namespace servobus::c630s
