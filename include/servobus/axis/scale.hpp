// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A scale: the exact ratio between the counts of a drive and a length of the machine. A conversion rounds to the
// nearest and keeps the rest, so that many conversions do not drift. It neither divides nor uses floating point.
//
//     constexpr scale um_of_count = scale::of(163'075, 4096); // 39.8 um
//     static_assert(um_of_count.nearest(16384).value() == 652'300);
//     static_assert(um_of_count.is_exact(4096) && !um_of_count.is_exact(1));
//     static_assert(um_of_count.nearest(60'000'000).error() == errc::out_of_range); // 2389 m
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/detail/exact.hpp>
#include <servobus/axis/detail/high_word.hpp>
#include <servobus/axis/detail/is_beyond.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/status.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a constant scale that calls one does not compile, and the error names the rule.
inline void a_scale_is_a_ratio_above_0() {}
inline void a_scale_in_lowest_terms_is_below_2_32_over_at_most_2_29() {}
} // namespace detail

/// A positive ratio in lowest terms: a numerator below 2^32 over a denominator of at most 2^29. It is a constant.
class scale {
  public:
    /// The ratio 1.
    constexpr scale() = default;

    /// The ratio `numerator / denominator`. A ratio of 0, or one that is too fine, does not compile.
    static consteval scale of(std::uint64_t numerator, std::uint64_t denominator) {
        return as_constant(numerator, denominator, checked(numerator, denominator));
    }
    /// The same of numbers that are known at run time only. It divides.
    /// Errors: out_of_range (a ratio of 0, or one that is too fine).
    static constexpr result<scale> checked(std::uint64_t numerator, std::uint64_t denominator) {
        const std::uint64_t common = detail::greatest_divisor(numerator, denominator);
        if (numerator == 0 || denominator == 0 || !fits(numerator / common, denominator / common))
            return errc::out_of_range;
        return scale{numerator / common, denominator / common};
    }

    /// The ratio `numerator / denominator`, or if that is too fine one that differs from it by at most 2^-30, or 2^-32
    /// of itself. For speeds, which are not added up. A ratio below 2^-30 does not compile.
    static consteval scale close_to(std::uint64_t numerator, std::uint64_t denominator) {
        return as_constant(numerator, denominator, checked_close_to(numerator, denominator));
    }
    /// The same of numbers that are known at run time only. It divides.
    /// Errors: out_of_range (a ratio below 2^-30).
    static constexpr result<scale> checked_close_to(std::uint64_t numerator, std::uint64_t denominator) {
        const result<scale> exact = checked(numerator, denominator);
        if (exact || numerator == 0 || denominator == 0) return exact;
        // Long division takes 62 bits of the denominator.
        for (; denominator > std::uint64_t{1} << 62; denominator /= 2) numerator /= 2;
        std::uint64_t parts = std::uint64_t{1} << 29;
        while (parts > 1 && numerator / denominator >= (std::uint64_t{1} << 32) / parts) parts /= 2;
        return checked(detail::nearest_of(numerator, parts, denominator), parts);
    }
    /// The ratio 0, to which every number converts: of an axis that was refused.
    static constexpr scale zero() {
        scale none;
        none.whole_ = 0;
        return none;
    }
    /// A scale that nothing but 0 converts by: likewise.
    static constexpr scale refusing() {
        scale none = zero();
        none.most_ = 0;
        return none;
    }

    /// Converts `x`: the whole number nearest to `x * numerator / denominator` and the rest of earlier conversions.
    /// Halves are rounded up. `carry` is that rest in parts of the denominator, 0 at first, and is replaced by the new
    /// one, -denominator/2 .. denominator/2.
    /// Errors: out_of_range (`x` is beyond +-`most()`; `carry` is kept).
    constexpr result<std::int32_t> convert(std::int32_t x, std::int32_t& carry) const {
        if (detail::is_beyond(x, static_cast<std::uint32_t>(most_))) return errc::out_of_range;
        return converted(x, carry);
    }

    /// The whole number nearest to `x * numerator / denominator`; halves are rounded up.
    /// Errors: out_of_range (`x` is beyond +-`most()`).
    constexpr result<std::int32_t> nearest(std::int32_t x) const {
        std::int32_t carry = 0;
        return convert(x, carry);
    }

    /// True if `x` converts to a whole number, without a rest.
    constexpr bool is_exact(std::int32_t x) const {
        std::int32_t carry = 0;
        return convert(x, carry) && carry == 0;
    }

    /// The largest size of a number that converts to 32 bits: `x` is in -most .. most.
    constexpr std::int32_t most() const { return most_; }
    constexpr std::uint32_t numerator() const {
        return whole_ * static_cast<std::uint32_t>(denominator_) + numerator_;
    }
    constexpr std::int32_t denominator() const { return denominator_; }

    /// As `convert`, of an `x` that is in -most .. most, which is not checked.
    constexpr std::int32_t converted(std::int32_t x, std::int32_t& carry) const {
        // The estimate is at most 2 too small. What is left is exact in 32 bits and corrects it.
        const std::uint32_t size = x < 0 ? 0u - static_cast<std::uint32_t>(x) : static_cast<std::uint32_t>(x);
        const std::uint32_t estimate = detail::high_word(size, reciprocal_) >> shift_;
        std::uint32_t part = x < 0 ? 0u - estimate : estimate;
        auto rest = static_cast<std::int32_t>(static_cast<std::uint32_t>(x) * numerator_ -
                                              part * static_cast<std::uint32_t>(denominator_) +
                                              static_cast<std::uint32_t>(carry));
        const std::int32_t half = denominator_ / 2;
        while (rest >= denominator_ - half) {
            rest -= denominator_;
            ++part;
        }
        while (rest < -half) {
            rest += denominator_;
            --part;
        }
        carry = rest;
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(x) * whole_ + part);
    }

  private:
    static consteval scale as_constant(std::uint64_t numerator, std::uint64_t denominator,
                                       const result<scale>& found) {
        if (numerator == 0 || denominator == 0)
            detail::a_scale_is_a_ratio_above_0();
        else if (!found)
            detail::a_scale_in_lowest_terms_is_below_2_32_over_at_most_2_29();
        return *found;
    }
    static constexpr bool fits(std::uint64_t numerator, std::uint64_t denominator) {
        return numerator <= 0xFFFF'FFFFu && denominator <= std::uint64_t{1} << 29;
    }

    constexpr scale(std::uint64_t numerator, std::uint64_t denominator) {
        whole_ = static_cast<std::uint32_t>(numerator / denominator);
        numerator_ = static_cast<std::uint32_t>(numerator % denominator);
        denominator_ = static_cast<std::int32_t>(denominator);
        std::uint64_t power = std::uint64_t{1} << 32;
        if (numerator_ != 0) {
            for (; power * numerator_ / denominator < 0x8000'0000u; ++shift_) power *= 2;
        }
        reciprocal_ = static_cast<std::uint32_t>(power * numerator_ / denominator);
        const std::uint64_t most = detail::floor_of(0x7FFF'FFFF, denominator, numerator);
        most_ = most < 0x7FFF'FFFF ? static_cast<std::int32_t>(most) : 0x7FFF'FFFF;
    }

    // The ratio is whole + numerator / denominator, numerator < denominator.
    std::uint32_t whole_ = 1;
    std::uint32_t numerator_ = 0;
    std::int32_t denominator_ = 1;
    std::uint32_t reciprocal_ = 0; // floor(numerator * 2^(32 + shift) / denominator), 2^31 .. 2^32, or 0
    std::int32_t most_ = 0x7FFF'FFFF;
    std::uint8_t shift_ = 0;
};

} // namespace servobus
