// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Counts of floating-point numbers and of decimal exponents, compared with arithmetic of 128 bits. Compilers for i386
// have none, and the numbers that are no values alone.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include <servobus/registers/decimal.hpp>
#include <servobus/registers/meter_units.hpp>
#include <servobus/registers/real.hpp>

namespace real_tests {

using namespace servobus;

TEST_CASE_TEMPLATE("a NaN and an infinity are no values", F, float, double) {
    using limits = std::numeric_limits<F>;
    for (const F none :
         {limits::quiet_NaN(), limits::signaling_NaN(), limits::infinity(), -limits::infinity()}) {
        const real<unit{measure::volt}, F> v{none};
        CHECK(!v.has_value());
        CHECK(!v.rounded(units::volt));
        CHECK(!v.rounded());
    }
    CHECK(real<unit{measure::volt}, F>{limits::max()}.has_value());
    CHECK(*real<unit{}, F>{F{-2.5}}.rounded() == -3);
}

#ifdef __SIZEOF_INT128__
namespace {
__extension__ using wide = __int128;

std::int32_t limited(wide n) {
    constexpr wide low = std::numeric_limits<std::int32_t>::min(),
                   high = std::numeric_limits<std::int32_t>::max();
    return static_cast<std::int32_t>(n < low ? low : n > high ? high : n);
}
// Halves are rounded away from zero.
wide divided(wide n, wide d) {
    const wide magnitude = n < 0 ? -n : n;
    const wide whole = (2 * magnitude + d) / (2 * d);
    return n < 0 ? -whole : whole;
}
// What `rounded` is to be, for numbers whose product has 120 bits at most.
template <class F> std::int32_t counted(F value, std::int64_t numerator, std::int64_t denominator) {
    int exponent = 0;
    const F fraction = std::frexp(value, &exponent); // below 1
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(fraction, 53));
    exponent -= 53;
    if (exponent > 10) return value > 0 ? limited(wide{1} << 100) : limited(-(wide{1} << 100));
    wide n = wide{mantissa} * numerator;
    wide d = denominator;
    if (exponent > 0) return limited(divided(n << exponent, d));
    if (exponent < -90) return 0;
    // Bits that are dropped here lie far below half a count.
    while (exponent < -60) {
        n /= 2;
        ++exponent;
    }
    d <<= -exponent;
    return limited(divided(n, d));
}

template <unit From, class Unit, class F> void compare(F value, Unit to) {
    constexpr detail::ratio r = detail::conversion(From, Unit::value);
    const auto found = real<From, F>{value}.rounded(to);
    REQUIRE(found.has_value());
    CAPTURE(static_cast<double>(value));
    CHECK(*found == counted(value, r.numerator, r.denominator));
}
template <class F> void compare_units(F value) {
    using namespace units;
    compare<unit{measure::volt}>(value, volt);
    compare<unit{measure::volt}>(value, millivolt);
    compare<unit{measure::millivolt}>(value, volt);
    compare<unit{measure::watt}>(value, kilowatt);
    compare<unit{measure::kilowatt_hour}>(value, watt_hour);
    compare<unit{measure::degree_celsius}>(value, part<10>(degree_celsius));
    compare<unit{measure::minute}>(value, hour);
}
} // namespace

TEST_CASE_TEMPLATE("a float is counted as arithmetic of 128 bits counts it", F, float, double) {
    std::mt19937_64 random{60};
    for (int i = 0; i < 40'000; ++i) {
        const auto exponent = static_cast<int>(random() % 80) - 40;
        const F value = std::ldexp(static_cast<F>(static_cast<std::int64_t>(random())), exponent - 63);
        compare_units(value);
    }
    // Halves, and what lies beside them.
    for (int n = -300; n <= 300; ++n) {
        const F half = static_cast<F>(n) + F{0.5};
        compare_units(half);
        compare_units(std::nextafter(half, F{1000}));
        compare_units(std::nextafter(half, F{-1000}));
    }
    for (const F edge : {F{0}, -F{0}, std::numeric_limits<F>::min(), std::numeric_limits<F>::denorm_min(),
                         std::numeric_limits<F>::max(), std::numeric_limits<F>::lowest(), F{2147483520},
                         F{2147483648}, F{-2147483648}, F{2147483392}})
        compare_units(edge);
}

TEST_CASE("all exponents of a float have counts") {
    for (std::uint32_t bits = 0; bits < 0x7F80'0000u; bits += 0x0012'3457u) {
        float value = 0;
        std::memcpy(&value, &bits, sizeof value);
        compare<unit{measure::volt}>(value, units::millivolt);
        compare<unit{measure::volt}>(-value, units::millivolt);
    }
}

TEST_CASE("a decimal is counted as arithmetic of 128 bits counts it") {
    using namespace units;
    std::mt19937_64 random{61};
    for (int i = 0; i < 100'000; ++i) {
        const auto count = static_cast<std::int64_t>(random()) >> random() % 64;
        const auto exponent = static_cast<int>(random() % 21) - 10;
        wide ten = 1;
        for (int e = 0; e < std::abs(exponent); ++e) ten *= 10;
        const wide n = exponent > 0 ? wide{count} * ten : wide{count};
        const wide d = exponent < 0 ? ten : 1;
        CAPTURE(count);
        CAPTURE(exponent);
        const decimal<unit{measure::watt}> v{count, exponent};
        CHECK(v.rounded(watt) == limited(divided(n, d)));
        CHECK(v.rounded(kilowatt) == limited(divided(n, d * 1000)));
        CHECK(v.rounded(part<1000>(watt)) == limited(divided(n * 1000, d)));
    }
    CHECK(decimal<unit{measure::watt}>::of_unsigned(~0ull, -10).rounded(watt) == 1'844'674'407);
    CHECK(decimal<unit{measure::watt}>{std::numeric_limits<std::int64_t>::min(), -10}.rounded(watt) ==
          -922'337'204);
}
#endif

} // namespace real_tests
