// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Unsigned integers of a fixed number of 32-bit digits, for exact decimal text of floats and of scaled numbers.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

namespace servobus::detail {

/// An unsigned integer of `32 * Size` bits. A result that needs more bits loses the highest ones.
template <std::size_t Size> class big_integer {
  public:
    constexpr big_integer() = default;
    constexpr explicit big_integer(std::uint64_t value)
        : digits_{static_cast<std::uint32_t>(value), static_cast<std::uint32_t>(value >> 32)},
          used_{value >> 32 != 0 ? 2u : 1u} {}

    constexpr bool is_zero() const { return compare(*this, big_integer{0}) == 0; }

    constexpr void multiply(std::uint32_t by) {
        std::uint64_t carry = 0;
        for (std::size_t i = 0; i < used_; ++i) {
            carry += std::uint64_t{digits_[i]} * by;
            digits_[i] = static_cast<std::uint32_t>(carry);
            carry >>= 32;
        }
        if (carry != 0 && used_ < Size) digits_[used_++] = static_cast<std::uint32_t>(carry);
    }
    constexpr void multiply_by_power_of_ten(unsigned exponent) {
        for (; exponent >= 9; exponent -= 9) multiply(1'000'000'000);
        for (; exponent != 0; --exponent) multiply(10);
    }
    constexpr void shift_left(unsigned bits) {
        for (; bits >= 31; bits -= 31) multiply(0x8000'0000u);
        multiply(1u << bits);
    }
    /// Divides, and returns the remainder.
    constexpr std::uint32_t divide(std::uint32_t by) {
        std::uint64_t rest = 0;
        for (std::size_t i = used_; i-- != 0;) {
            rest = rest << 32 | digits_[i];
            digits_[i] = static_cast<std::uint32_t>(rest / by);
            rest %= by;
        }
        trim();
        return static_cast<std::uint32_t>(rest);
    }
    constexpr void add(const big_integer& other) {
        std::uint64_t carry = 0;
        const std::size_t most = used_ > other.used_ ? used_ : other.used_;
        for (std::size_t i = 0; i < most; ++i) {
            carry += std::uint64_t{digits_[i]} + other.digits_[i];
            digits_[i] = static_cast<std::uint32_t>(carry);
            carry >>= 32;
        }
        used_ = most;
        if (carry != 0 && used_ < Size) digits_[used_++] = static_cast<std::uint32_t>(carry);
    }
    /// `other` must not be larger.
    constexpr void subtract(const big_integer& other) {
        std::uint64_t borrow = 0;
        for (std::size_t i = 0; i < used_; ++i) {
            const std::uint64_t taken = other.digits_[i] + borrow;
            borrow = digits_[i] < taken ? 1 : 0;
            digits_[i] = static_cast<std::uint32_t>((borrow << 32) + digits_[i] - taken);
        }
        trim();
    }

    /// Negative, 0 or positive, as `a` is below, equal to or above `b`.
    static constexpr int compare(const big_integer& a, const big_integer& b) {
        if (a.used_ != b.used_) return a.used_ < b.used_ ? -1 : 1;
        for (std::size_t i = a.used_; i-- != 0;) {
            if (a.digits_[i] != b.digits_[i]) return a.digits_[i] < b.digits_[i] ? -1 : 1;
        }
        return 0;
    }

  private:
    constexpr void trim() {
        while (used_ > 1 && digits_[used_ - 1] == 0) --used_;
    }

    std::uint32_t digits_[Size]{}; // from the lowest on
    std::size_t used_ = 1;         // digits without zeros above them, but for the lowest
};

} // namespace servobus::detail
