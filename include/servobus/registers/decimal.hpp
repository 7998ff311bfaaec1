// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A count of a unit times a power of ten that the device keeps in another register, see `ten_to`.
//
//     constexpr decimal<unit{measure::watt}> power{1234, -2};
//     static_assert(power.rounded(units::watt) == 12);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/registers/detail/rounded_ratio.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

/// `count * 10^exponent` of `U`.
template <unit U> class decimal {
  public:
    static constexpr unit unit_of_count = U;
    static constexpr int longest_exponent = 10;

    constexpr decimal() = default;
    /// `exponent` is from -10 to 10.
    constexpr decimal(std::int64_t count, int exponent)
        : magnitude_{count < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(count)
                               : static_cast<std::uint64_t>(count)},
          is_negative_{count < 0}, exponent_{static_cast<std::int16_t>(exponent)} {}
    /// The same for a count of 64 bits without a sign.
    static constexpr decimal of_unsigned(std::uint64_t count, int exponent) {
        decimal d{0, exponent};
        d.magnitude_ = count;
        return d;
    }

    constexpr bool is_negative() const { return is_negative_; }
    /// The count without its sign.
    constexpr std::uint64_t magnitude() const { return magnitude_; }
    constexpr int exponent() const { return exponent_; }

    /// The number as a count of `Unit`: rounded to the nearest, halves away from zero, and limited to 32 bits.
    template <class Unit> constexpr std::int32_t rounded(Unit) const {
        static_assert(detail::same_kind(U, Unit::value), "the number is of another kind than this unit");
        constexpr detail::ratio r = detail::conversion(U, Unit::value);
        static_assert(r.numerator < (std::int64_t{1} << 32) && r.denominator < (std::int64_t{1} << 26),
                      "this unit is too fine or too coarse for a number of 32 bits");
        std::uint64_t value = magnitude_;
        auto divisor = static_cast<std::uint64_t>(r.denominator);
        for (int e = exponent_; e < 0; ++e) divisor *= 10;
        for (int e = exponent_; e > 0; --e) {
            if (value >
                0x1999'9999'9999'9999u) // ten times as much does not fit, and the result is beyond 32 bits
                return detail::signed_ratio(is_negative_, detail::most_of_ratio);
            value *= 10;
        }
        return detail::signed_ratio(
            is_negative_, detail::rounded_ratio(value, static_cast<std::uint32_t>(r.numerator), divisor));
    }
    friend constexpr bool operator==(decimal, decimal) = default;

  private:
    std::uint64_t magnitude_ = 0;
    bool is_negative_ = false;
    std::int16_t exponent_ = 0;
};

} // namespace servobus
