// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value that a device stores in one of its own registers. Unlike `register_value`, which a client writes, it is also
// of registers that clients only read. server/row_values.hpp includes it.
//
//     constexpr stored_value<tank::temperature> warm = 25; // 151 would not compile
//     static_assert(warm.bits() == 25);
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/registers/register_value.hpp>

namespace servobus {

namespace detail {
/// True if each value of the register's type lies in its range.
template <const auto& R>
concept holds_every_value = shape_of<typename row_type<R>::value_type>
.low == R.limits.low&& shape_of<typename row_type<R>::value_type>.high == R.limits.high;
} // namespace detail

/// A value inside the range of register `R`. A value that need not be inside enters by `clamped(v)`, or by
/// `row_values::set<R>(checked(v))`.
template <const auto& R> class stored_value {
  public:
    using value_type = typename row_type<R>::value_type;

    /// A constant. It does not compile if it is out of range, not a whole number of counts or of another kind than
    /// the register.
    template <class V> consteval stored_value(V constant) { // NOLINT: implicit, `set<r>(500)`
        const counted c = count_of<R>(constant);
        if (c.error != errc::ok) detail::this_quantity_is_no_whole_number_of_the_register_s_counts();
        if (!R.limits.contains(c.count))
            detail::this_constant_is_outside_the_range_of_the_register<R.limits.low, R.limits.high>();
        bits_ = bits_of(c.count);
    }

    /// A run-time value of a register whose range is that of its type, such as a position: it is always inside.
    constexpr stored_value(reading<R> v) // NOLINT: implicit, `set<r>(counter())`
        requires detail::holds_every_value<R> : bits_{bits_of_reading(v)} {}
    /// The same as a raw count.
    constexpr stored_value(raw_value<value_type> v) // NOLINT: implicit, `set<r>(raw(counter()))`
        requires detail::holds_every_value<R> : bits_{to_bits<value_type>(v.value)} {}

    /// A run-time value, limited to the range, and rounded towards zero to whole counts.
    template <class V>
    constexpr stored_value(clamped_value<V> v) // NOLINT: implicit, `set<r>(clamped(v))`
        : bits_{bits_of(limited(count_of<R>(v.value).count))} {}

    /// The raw bits in two's complement; a register of one word uses the low half.
    constexpr u32 bits() const { return bits_; }

    /// The raw bits of what a read of the register returns.
    static constexpr u32 bits_of_reading(reading<R> v) {
        if constexpr (std::is_same_v<reading<R>, value_type>) {
            return to_bits<value_type>(v);
        } else {
            return to_bits<value_type>(v.count());
        }
    }

  private:
    static constexpr std::int64_t limited(std::int64_t count) {
        if (count < R.limits.low) return R.limits.low;
        return count > R.limits.high ? R.limits.high : count;
    }
    static constexpr u32 bits_of(std::int64_t count) {
        return static_cast<u32>(static_cast<std::uint64_t>(count));
    }

    u32 bits_ = 0;

    // Last: clang++ has no member that follows a failed assertion, and would print an error for each that is used.
    static_assert(!detail::has_codec<value_type>,
                  "a server of floats, decimal digits, offsets or values that may be none: include "
                  "servobus/server/stored_number.hpp");
};

} // namespace servobus
