// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The text of a quantity with its unit: exact, without floating point, heap and catalogue. Programs include it to print
// what they have read.
//
//     static_assert(text(4820 * part<100>(units::volt)) == "48.20 V");
//     constexpr auto speed = text(-125 * part<10>(units::r_per_min)); // speed.c_str() is "-12.5 r/min"
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/text.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
/// A unit as `factor / 10^decimals`; `is_decimal` is false if that takes more than 6 decimals.
struct decimal_scale {
    std::int64_t factor = 1;
    unsigned decimals = 0;
    bool is_decimal = true;
};

constexpr decimal_scale decimal_of(unit u) {
    const std::int64_t common = common_divisor(u.numerator, u.denominator);
    std::int64_t numerator = u.numerator / common;
    const std::int64_t denominator = u.denominator / common;
    for (unsigned decimals = 0; decimals <= 6; ++decimals) {
        if (numerator % denominator == 0) return {numerator / denominator, decimals, true};
        numerator *= 10;
    }
    return {1, 0, false};
}

} // namespace detail

/// Writes `count` counts of `u` without the unit's symbol: `12.5`, or `1/3` if the unit is no decimal
/// fraction.
constexpr void put_count(text_writer& out, std::int64_t count, unit u) {
    const detail::decimal_scale scale = detail::decimal_of(u);
    constexpr std::int64_t most = detail::highest<std::int64_t>;
    if (scale.is_decimal && count <= most / scale.factor && count >= -(most / scale.factor)) {
        out.scaled(count * scale.factor, scale.decimals);
    } else if (scale.is_decimal) { // 64 bits do not hold the product
        out.number(count) << " * ";
        out.scaled(scale.factor, scale.decimals);
    } else {
        out.number(count * u.numerator) << '/';
        out.number(u.denominator);
    }
}

namespace detail {
constexpr void put_symbol(text_writer& out, unit u) {
    if (u.of != measure::none && u.of != measure::device_unit) out << ' ' << symbol(u.of);
}
} // namespace detail

/// A text of up to 39 characters by value, ended by a zero. It lives as long as the expression that it is printed in.
class short_text {
  public:
    constexpr const char* c_str() const { return letters_; }
    constexpr std::size_t size() const { return size_; }

    /// `put` writes it. Text that does not fit is cut, and ends in "...".
    template <class Put> static constexpr short_text of(Put&& put) {
        short_text t{};
        text_writer out{std::span<char>{t.letters_, sizeof t.letters_ - 1}};
        put(out);
        t.size_ = static_cast<std::uint8_t>(out.size());
        return t;
    }

    friend constexpr bool operator==(const short_text& a, const char* b) {
        std::size_t i = 0;
        while (i < a.size_ && a.letters_[i] == b[i]) ++i;
        return i == a.size_ && b[i] == '\0';
    }

  private:
    char letters_[40]{};
    std::uint8_t size_ = 0;
};

/// `48.20 V`, `-12.5 r/min`; `1/3 mm` if the unit is no decimal fraction.
template <unit U, std::integral Rep> constexpr short_text text(quantity<U, Rep> q) {
    return short_text::of([&](text_writer& out) {
        put_count(out, static_cast<std::int64_t>(q.count()), U);
        detail::put_symbol(out, U);
    });
}

} // namespace servobus
