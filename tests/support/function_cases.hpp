// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Tables of PDUs in hex with what a check must say about each, judged by the compiler and again at run time.
#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/status.hpp>
#include <servobus/modbus/functions.hpp>
#include <servobus/modbus/growing_response.hpp>

namespace tests {

/// A short PDU in hex, such as "01 00 13 00 13".
struct printed_pdu {
    std::uint8_t data[36]{};
    std::size_t size = 0;

    template <std::size_t Chars>
    constexpr printed_pdu(const char (&text)[Chars]) { // NOLINT: implicit, in tables
        // Not consteval: clang 14 fails on one as an argument.
        for (std::size_t i = 0; i + 2 < Chars; i += 3) {
            const unsigned high = servobus::hex_digit(text[i]);
            const unsigned low = servobus::hex_digit(text[i + 1]);
            if (high > 15 || low > 15) __builtin_trap(); // no hex: no constant either
            data[size++] = static_cast<std::uint8_t>(high << 4 | low);
        }
    }
    constexpr operator servobus::bytes() const { return {data, size}; } // NOLINT: a PDU is its bytes
};

/// A PDU that is built in place, for a `static_assert`.
template <std::size_t Capacity> struct built_pdu {
    std::uint8_t data[Capacity]{};
    std::size_t size = 0;

    constexpr operator servobus::bytes() const { return {data, size}; } // NOLINT: a PDU is its bytes
};

/// True if the compiler can run `Call`. A builder names the rule that a constant request breaks by a call that it
/// cannot.
template <class Call, std::size_t = Call{}()> constexpr bool is_constant(Call) { return true; }
constexpr bool is_constant(...) { return false; }

struct request_case {
    const char* what;
    printed_pdu request;
    servobus::errc error = servobus::errc::ok;

    constexpr servobus::errc found() const { return servobus::modbus::check_request(request).error(); }
};

struct response_case {
    const char* what;
    printed_pdu request;
    printed_pdu response;
    servobus::errc error = servobus::errc::ok;

    constexpr servobus::errc found() const {
        return servobus::modbus::check_response(request, response).error();
    }
};

template <class Case, std::size_t N> constexpr bool all_hold(const Case (&all)[N]) {
    for (const Case& each : all) {
        if (each.found() != each.error) return false;
    }
    return true;
}
template <class Case, std::size_t N> void check_all(const Case (&all)[N]) {
    for (const Case& each : all) {
        CAPTURE(each.what);
        CHECK(text(each.found()) == doctest::String{text(each.error)});
    }
}

/// Feeds the response as its length rule asks. True if it ends with the last byte.
constexpr bool ends_where_it_should(servobus::bytes request, servobus::bytes response) {
    servobus::modbus::growing_response growing{request};
    std::size_t have = 0;
    while (true) {
        const std::size_t least = growing.least_length(response.first(have));
        if (least == have || least > response.size()) return least == response.size();
        have = least;
    }
}

} // namespace tests
