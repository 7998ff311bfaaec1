// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The decimal text of a float that a device sends: the shortest one that reads back to the same bits, by integer
// arithmetic alone. The text of values (registers/value_text.hpp) includes it. The text is that of `std::to_chars`.
//
//     constexpr auto power = [] {
//         std::array<char, 16> room{};
//         text_writer out{room};
//         return put_float(out, float_bits::of_single(0xC32C'9822)), room; // "-172.59427"
//     }();
//
// Source: Burger, Dybvig: Printing Floating-Point Numbers Quickly and Accurately, 1996.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/text.hpp>
#include <servobus/registers/detail/big_integer.hpp>

namespace servobus {

/// A float of IEEE 754 by its parts. Its value is `mantissa * 2^exponent`.
struct float_bits {
    bool is_negative = false;
    bool is_finite = true;
    bool is_nan = false;
    bool is_lowest_of_exponent =
        false; ///< the next float towards 0 is only half as far away as the next above
    std::uint64_t mantissa = 0;
    int exponent = 0;

    static constexpr float_bits of_single(std::uint32_t bits) { return of(bits, 23, 8); }
    static constexpr float_bits of_double(std::uint64_t bits) { return of(bits, 52, 11); }

  private:
    static constexpr float_bits of(std::uint64_t bits, unsigned fraction_size, unsigned exponent_size) {
        const std::uint64_t fraction = bits & ((std::uint64_t{1} << fraction_size) - 1);
        const auto most = static_cast<int>((1u << exponent_size) - 1);
        const int field = static_cast<int>(bits >> fraction_size) & most;
        const int unit =
            -(most >> 1) - static_cast<int>(fraction_size); // the exponent of a fraction's lowest bit, less 1
        float_bits f{.is_negative = (bits >> (fraction_size + exponent_size) & 1) != 0};
        f.is_finite = field != most;
        f.is_nan = !f.is_finite && fraction != 0;
        f.is_lowest_of_exponent = fraction == 0 && field > 1;
        f.mantissa = field == 0 ? fraction : fraction | std::uint64_t{1} << fraction_size;
        f.exponent = unit + (field == 0 ? 1 : field);
        return f;
    }
};

/// Decimal digits. Their value is `d.ddd * 10^exponent` with the first digit before the point.
struct decimal_digits {
    std::uint64_t digits = 0; ///< without zeros at the end
    unsigned count = 1;
    int exponent = 0;
};

namespace detail {

// 2^1024 and 10^308 need 1024 bits, the smallest f64 a denominator of 1076, and the steps below four bits more.
using float_integer = big_integer<36>;

constexpr int bit_count(std::uint64_t n) {
    int count = 0;
    for (; n != 0; n >>= 1) ++count;
    return count;
}

/// A positive float as `value / whole`, with half the distances to the next floats in the same measure.
struct float_ratio {
    float_integer value, whole, above, below;

    constexpr explicit float_ratio(const float_bits& f) : value{f.mantissa}, whole{1}, above{1}, below{1} {
        const unsigned doubled = f.is_lowest_of_exponent ? 2 : 1;
        value.shift_left(doubled);
        whole.shift_left(doubled);
        above.shift_left(doubled - 1);
        if (f.exponent >= 0) {
            for (float_integer* one : {&value, &above, &below})
                one->shift_left(static_cast<unsigned>(f.exponent));
        } else {
            whole.shift_left(static_cast<unsigned>(-f.exponent));
        }
    }
    constexpr void multiply(unsigned by) {
        for (float_integer* one : {&value, &above, &below}) one->multiply(by);
    }
    constexpr void scale(int exponent) {
        if (exponent >= 0) return whole.multiply_by_power_of_ten(static_cast<unsigned>(exponent));
        for (float_integer* one : {&value, &above, &below})
            one->multiply_by_power_of_ten(static_cast<unsigned>(-exponent));
    }
    /// True if the float above rounds to no less than `whole`. `is_even`: a float at the middle is rounded to this one.
    constexpr bool reaches_whole(bool is_even) const {
        float_integer high = value;
        high.add(above);
        return float_integer::compare(high, whole) >= (is_even ? 0 : 1);
    }
    constexpr bool reaches_zero(bool is_even) const {
        return float_integer::compare(value, below) <= (is_even ? 0 : -1);
    }
    constexpr unsigned take_digit() {
        unsigned digit = 0;
        for (; float_integer::compare(value, whole) >= 0; ++digit) value.subtract(whole);
        return digit;
    }
    /// True if `value` is above the half of `whole`, or is the half and `digit` is odd.
    constexpr bool rounds_up(unsigned digit) const {
        float_integer twice = value;
        twice.multiply(2);
        return float_integer::compare(twice, whole) >= (digit % 2 == 0 ? 1 : 0);
    }
};

} // namespace detail

/// The fewest digits that read back to the same float, and of these the nearest. The float must be finite.
constexpr decimal_digits shortest_digits(const float_bits& f) {
    if (f.mantissa == 0) return {};
    const bool is_even = f.mantissa % 2 == 0;
    detail::float_ratio ratio{f};
    // log10(2) is 0.30103; the estimate is at most one too low.
    const int binary = detail::bit_count(f.mantissa) + f.exponent - 1;
    int exponent = static_cast<int>((std::int64_t{binary} * 78'913) >> 18);
    ratio.scale(exponent);
    for (; ratio.reaches_whole(is_even); ++exponent) ratio.whole.multiply(10);
    decimal_digits found{.count = 0, .exponent = exponent - 1};
    while (true) {
        ratio.multiply(10);
        const unsigned digit = ratio.take_digit();
        const bool may_end_below = ratio.reaches_zero(is_even);
        const bool may_end_above = ratio.reaches_whole(is_even);
        found.digits = found.digits * 10 + digit;
        ++found.count;
        if (!may_end_below && !may_end_above) continue;
        if (may_end_above && (!may_end_below || ratio.rounds_up(digit))) ++found.digits;
        return found;
    }
}

namespace detail {

/// The digits of a number, in the order in which they are written.
struct written_digits {
    char text[24]{};
    unsigned count = 0;

    constexpr void prepend(std::uint32_t digit) {
        for (unsigned i = count; i != 0; --i) text[i] = text[i - 1];
        text[0] = static_cast<char>('0' + static_cast<char>(digit));
        ++count;
    }
    constexpr char at(unsigned i) const { return i < count ? text[i] : '0'; }
};

constexpr written_digits written(std::uint64_t n, unsigned count) {
    written_digits all;
    for (; all.count < count; n /= 10) all.prepend(static_cast<std::uint32_t>(n % 10));
    return all;
}
/// All digits of a float that is a whole number.
constexpr written_digits written_whole(const float_bits& f) {
    float_integer rest{f.mantissa};
    if (f.exponent >= 0) {
        rest.shift_left(static_cast<unsigned>(f.exponent));
    } else {
        for (int i = f.exponent; i != 0; ++i) (void)rest.divide(2);
    }
    written_digits all;
    while (!rest.is_zero() && all.count < sizeof all.text) all.prepend(rest.divide(10));
    return all;
}

constexpr void put_scientific(text_writer& out, const decimal_digits& d) {
    const written_digits all = written(d.digits, d.count);
    out << all.at(0);
    if (d.count > 1) out << '.';
    for (unsigned i = 1; i < d.count; ++i) out << all.at(i);
    const int size = d.exponent < 0 ? -d.exponent : d.exponent;
    out << 'e' << (d.exponent < 0 ? '-' : '+');
    if (size < 10) out << '0';
    out.number(size);
}

constexpr void put_fixed(text_writer& out, const written_digits& all, int exponent) {
    if (exponent < 0) out << "0.";
    for (int i = -1; i > exponent; --i) out << '0';
    const int before_point = exponent < 0 ? 0 : exponent + 1;
    for (int i = 0; i < before_point; ++i) out << all.at(static_cast<unsigned>(i));
    const auto rest = static_cast<unsigned>(before_point);
    if (exponent >= 0 && rest < all.count) out << '.';
    for (unsigned i = rest; i < all.count; ++i) out << all.at(i);
}

} // namespace detail

/// Writes `230.1`, `-172.59427`, `1e+20`, the shorter of both notations; `nan` or `inf` for what is not finite.
/// The value is multiplied by ten to the power of `shift`.
constexpr void put_float(text_writer& out, const float_bits& f, int shift = 0) {
    if (f.is_nan) {
        out << "nan";
        return;
    }
    if (f.is_negative) out << '-';
    if (!f.is_finite) {
        out << "inf";
        return;
    }
    decimal_digits d = shortest_digits(f);
    if (f.mantissa != 0) d.exponent += shift;
    const auto count = static_cast<int>(d.count);
    const int size = d.exponent < 0 ? -d.exponent : d.exponent;
    const int scientific = count + (count > 1 ? 1 : 0) + (size < 100 ? 4 : 5);
    const int fixed = d.exponent < 0           ? count + 1 - d.exponent
                      : d.exponent + 1 < count ? count + 1
                                               : d.exponent + 1;
    if (fixed > scientific) return detail::put_scientific(out, d);
    // A whole number that needs fewer digits than it has is written with its own ones, not with zeros.
    const bool is_cut = count < d.exponent + 1 && shift == 0;
    detail::put_fixed(out, is_cut ? detail::written_whole(f) : detail::written(d.digits, d.count),
                      d.exponent);
}

} // namespace servobus
