// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A floating-point number of a unit, as a device sent it. It is kept as bits, so that a core without a floating-point
// unit links no library for it: `rounded` calculates with integers. A NaN or an infinity is no value.
//
//     constexpr real<unit{measure::volt}, float> voltage{230.1f};
//     static_assert(*voltage.rounded(units::millivolt) == 230'100);
//     static_assert(voltage.in(units::millivolt) > 230'000.0f); // the program asks for floating point
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>
#include <type_traits>

#include <servobus/registers/detail/rounded_ratio.hpp>
#include <servobus/registers/maybe.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

/// A number of `U`; `F` is float or double.
template <unit U, class F> class real {
    static_assert(std::is_same_v<F, float> || std::is_same_v<F, double>);
    static_assert((std::is_same_v<F, float> && sizeof(F) == 4) || sizeof(F) == 8,
                  "this compiler's floating-point numbers are not those of IEEE 754");

  public:
    using bits_type = std::conditional_t<sizeof(F) == 4, std::uint32_t, std::uint64_t>;
    static constexpr unit unit_of_count = U;

    constexpr real() = default;
    constexpr explicit real(F value) : bits_{__builtin_bit_cast(bits_type, value)} {}
    static constexpr real from_bits(bits_type bits) {
        real r;
        r.bits_ = bits;
        return r;
    }

    /// False for a NaN and for an infinity.
    constexpr bool has_value() const { return (bits_ & ~sign) < infinity; }
    /// The bits of IEEE 754, the sign on top.
    constexpr bits_type bits() const { return bits_; }
    /// The number in the row's unit, NaN and infinities as they are.
    constexpr F value() const { return __builtin_bit_cast(F, bits_); }
    /// The number in another unit of the same kind, by one floating-point multiplication.
    template <class Unit> constexpr F in(Unit) const {
        constexpr detail::ratio r = ratio_to<Unit>();
        if constexpr (r.numerator == r.denominator)
            return value();
        else
            return value() * (static_cast<F>(r.numerator) / static_cast<F>(r.denominator));
    }
    /// The number as a count of `Unit`, calculated with integers: rounded to the nearest, halves away from zero, and
    /// limited to 32 bits. None for a NaN and for an infinity.
    template <class Unit> constexpr maybe<std::int32_t> rounded(Unit) const {
        constexpr detail::ratio r = ratio_to<Unit>();
        static_assert(r.numerator < (std::int64_t{1} << 32) && r.denominator < (std::int64_t{1} << 30),
                      "this unit is too fine or too coarse for a number of 32 bits");
        if (!has_value()) return {};
        const auto shift = static_cast<unsigned>(bits_ >> mantissa_bits) & exponent_mask;
        const bits_type fraction = bits_ & ((one << mantissa_bits) - 1);
        const std::uint64_t mantissa = shift == 0 ? fraction : fraction | one << mantissa_bits;
        const int exponent = static_cast<int>(shift == 0 ? 1 : shift) - bias;
        return maybe{detail::signed_ratio(
            (bits_ & sign) != 0, detail::rounded_ratio(mantissa, static_cast<std::uint32_t>(r.numerator),
                                                       static_cast<std::uint64_t>(r.denominator), exponent))};
    }
    /// The same in the row's unit.
    constexpr maybe<std::int32_t> rounded() const { return rounded(unit_constant<U>{}); }
    /// Compares the bits: a NaN equals itself, and 0 does not equal -0.
    friend constexpr bool operator==(real, real) = default;

  private:
    static constexpr bits_type one = 1;
    static constexpr unsigned mantissa_bits = sizeof(F) == 4 ? 23 : 52;
    static constexpr unsigned exponent_mask = sizeof(F) == 4 ? 0xFF : 0x7FF;
    static constexpr int bias = (sizeof(F) == 4 ? 127 : 1023) + static_cast<int>(mantissa_bits);
    static constexpr bits_type sign = one << (8 * sizeof(F) - 1);
    static constexpr bits_type infinity = bits_type{exponent_mask} << mantissa_bits;

    template <class Unit> static constexpr detail::ratio ratio_to() {
        static_assert(detail::same_kind(U, Unit::value), "the number is of another kind than this unit");
        return detail::conversion(U, Unit::value);
    }

    bits_type bits_ = 0;
};

} // namespace servobus
