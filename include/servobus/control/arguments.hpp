// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The arguments of a command, each with the register that takes it and the limits that it must keep. The
// `arguments.hpp` of each device lists them for its commands, and so does the author of a drive; `why` reads them.
//
//     constexpr auto arguments(const zlac8015d::ramps& c, const zlac8015d::cached_settings&) {
//         return argument_list{commands::argument<zlac8015d::left_acceleration_time>(c.acceleration),
//                              commands::argument<zlac8015d::left_deceleration_time>(c.deceleration)};
//     }
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/control/command.hpp>

namespace servobus {

/// An argument of a command in counts of its register, and the limits that the command keeps it in.
struct command_argument {
    std::uint16_t address = 0; ///< the register that takes it
    std::uint16_t limited_by =
        0;                    ///< the register whose row, or whose value in the drive, sets the broken limit
    bool has_register = true; ///< false for a number that is sent in no register, such as an index
    bool is_exact = true;     ///< false if it is no whole number of counts
    bool is_taken = true; ///< false if the command does not take this value, though it is within the limits
    errc outside = errc::out_of_range; ///< the error of a command with a value outside the limits
    std::int64_t count = 0;            ///< the whole number of counts, or the one below
    range limits{};                    ///< in counts

    /// True if the value, exact or not, lies outside the limits, or is not taken.
    constexpr bool is_refused() const { return !is_taken || is_below(limits.low) || is_above(limits.high); }
    /// True if a command with this argument is refused by `error`.
    constexpr bool explains(errc error) const {
        return error == errc::inexact ? !is_exact : error == outside && is_refused();
    }

    /// Narrows the limits: the command takes less than the register's row.
    constexpr command_argument within(std::int64_t low, std::int64_t high) const {
        return limited(limited_by, low, high);
    }
    /// Narrows the limits to those that the value of register `R` sets.
    template <const auto& R> constexpr command_argument within(std::int64_t low, std::int64_t high) const {
        return limited(R.address, low, high);
    }
    /// Excludes the value, whatever the limits are, unless `taken` is true.
    constexpr command_argument only_if(bool taken) const {
        command_argument a = *this;
        a.is_taken = a.is_taken && taken;
        return a;
    }
    /// Admits the value, whatever the limits are, if `taken` is true.
    constexpr command_argument or_if(bool taken) const {
        command_argument a = *this;
        if (taken) a.limits = {.low = count, .high = count};
        return a;
    }
    /// Sets the error outside the limits.
    constexpr command_argument refused_as(errc error) const {
        command_argument a = *this;
        a.outside = error;
        return a;
    }

  private:
    constexpr bool is_below(std::int64_t low) const { return count < low; }
    constexpr bool is_above(std::int64_t high) const { return count > high || (!is_exact && count == high); }
    // Narrows both ends; `limited_by` has the register of the narrowest limit that is broken.
    constexpr command_argument limited(std::uint16_t by, std::int64_t low, std::int64_t high) const {
        command_argument a = *this;
        const bool is_lower = high < limits.high;
        const bool is_higher = low > limits.low;
        if ((is_higher && is_below(low)) || (is_lower && is_above(high))) a.limited_by = by;
        if (is_higher) a.limits.low = low;
        if (is_lower) a.limits.high = high;
        return a;
    }
};

/// The arguments of a command, in the order in which it checks them.
template <std::size_t Count> struct argument_list {
    command_argument items[Count];

    constexpr const command_argument* begin() const { return items; }
    constexpr const command_argument* end() const { return items + Count; }
};
template <class... Arguments> argument_list(Arguments...) -> argument_list<sizeof...(Arguments)>;

namespace commands {

/// A number of counts of row `R`: the next one below for a value that is not exact.
template <const auto& R>
constexpr command_argument counted_argument(std::int64_t count, bool is_exact = true) {
    return {.address = R.address,
            .limited_by = R.address,
            .is_exact = is_exact,
            .count = count,
            .limits = register_value<R>::writable};
}

/// A quantity, a code or a plain number for row `R`.
template <const auto& R, class V>
requires is_register<R>
constexpr command_argument argument(V value) {
    if constexpr (std::is_integral_v<V> || std::is_enum_v<V>) {
        return counted_argument<R>(static_cast<std::int64_t>(value));
    } else {
        const counted c = count_of<R>(value);
        const bool is_exact = c.error == errc::ok;
        return counted_argument<R>(is_exact || value.count() >= 0 ? c.count : c.count - 1, is_exact);
    }
}

/// An argument for element `index`, counted from 0, of an array of rows of which `element_0` is the first.
template <const auto& Rows>
requires is_register_array<Rows>
constexpr command_argument for_element(std::size_t index, command_argument element_0) {
    element_0.address = element_0.limited_by = Rows[index].address;
    return element_0;
}
/// A quantity, a code or a plain number for element `index`, counted from 0, of an array of rows.
template <const auto& Rows, class V>
requires is_register_array<Rows>
constexpr command_argument argument(std::size_t index, V value) {
    return for_element<Rows>(index, argument<at<Rows, 0>>(value));
}

/// A value of register `R` that was checked already. Of one beyond 32 bits only the low 32 are known.
template <const auto& R> constexpr command_argument argument(const register_value<R>& value) {
    using type = typename row_type<R>::value_type;
    const std::int64_t signed_count = static_cast<std::int32_t>(value.bits());
    const std::int64_t count = std::is_same_v<type, u32> ? std::int64_t{value.bits()} : signed_count;
    return counted_argument<R>(count, value.error() != errc::inexact).only_if(value.error() == errc::ok);
}

/// A number that is sent in no register, such as a time that the program waits.
constexpr command_argument number(std::int64_t value, std::int64_t low, std::int64_t high) {
    return {.has_register = false, .count = value, .limits = {.low = low, .high = high}};
}
/// A number that chooses a segment, a terminal or the like: it is refused by `bad_argument`.
constexpr command_argument index(std::int64_t value, std::int64_t low, std::int64_t high) {
    return number(value, low, high).refused_as(errc::bad_argument);
}
/// An index that was checked already. A wrong one is not known any more: its count is 0.
template <class Checked>
constexpr command_argument checked_index(const Checked& n, std::int64_t low, std::int64_t high) {
    return index(n.error() == errc::ok ? std::int64_t{n.index()} + low : 0, low, high)
        .only_if(n.error() == errc::ok);
}

} // namespace commands
} // namespace servobus
