// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A scale: each conversion against a division of 64 bits, and the sum of many against one product.
#include <array>
#include <cstdint>
#include <random>

#include <doctest/doctest.h>

#include <servobus/axis/scale.hpp>

namespace scale_tests {

using namespace servobus;
using std::int32_t;
using std::int64_t;

constexpr int32_t largest = 0x7FFF'FFFF;
constexpr int32_t smallest = -largest - 1;

// Constants
static_assert(scale{}.nearest(largest).value() == largest && scale{}.most() == largest);
static_assert(scale::of(652'300, 16'384).numerator() == 163'075 &&
              scale::of(652'300, 16'384).denominator() == 4096);
static_assert(scale::of(0xFFFF'FFFF, 1).most() == 0, "nothing but 0 converts");
static_assert(scale::of(0xFFFF'FFFF, 1).nearest(0).value() == 0 && !scale::of(0xFFFF'FFFF, 1).nearest(1));
static_assert(scale::of(1, 1 << 29).nearest(largest).value() == 4);
static_assert(scale::of(1, 2).nearest(1).value() == 1 && scale::of(1, 2).nearest(-1).value() == 0,
              "halves are rounded up");
static_assert(scale::of(1, 3).nearest(-2).value() == -1 && scale::of(1, 3).nearest(-1).value() == 0);
static_assert(scale::of(2, 1).most() == largest / 2 && !scale::of(2, 1).nearest(largest / 2 + 1));
static_assert(scale{}.nearest(smallest).error() == errc::out_of_range, "it has no opposite");
static_assert(scale::of(5, 4).is_exact(-8) && !scale::of(5, 4).is_exact(3));
static_assert(!scale::of(2, 1).is_exact(largest), "what does not convert is not exact");

// A ratio that is too fine has one close to it.
static_assert(scale::close_to(3, 4).numerator() == 3 && scale::close_to(3, 4).denominator() == 4);
constexpr scale close = scale::close_to(600'000, 652'194'637);
static_assert(close.nearest(largest).value() == 1'975'624); // 1'975'622.1, at most 2 off

// 7 / 2^31 is 1.75 / 2^29
static_assert(scale::close_to(7, 0x8000'0000).numerator() == 1 &&
              scale::close_to(7, 0x8000'0000).denominator() == 1 << 28);
static_assert(scale::close_to(1, 1 << 29).denominator() == 1 << 29);
static_assert(scale::close_to(1'000'001, 536'870'913).numerator() == 1'000'001 &&
              scale::close_to(1'000'001, 536'870'913).denominator() == 1 << 29);
static_assert(scale::close_to(0x1'FFFF'FFFF, 0x2000'0001).nearest(1'000'000).value() == 16'000'000);
static_assert(scale::close_to(0x1'0000'0001, 3).nearest(1).value() == 0x5555'5556);
static_assert(scale::close_to(0xFFFF'FFFF'FFFF'FFFF, 0x1'0000'0001).most() == 0, "4294967295 to 1");
static_assert(scale::close_to(0x4000'0000'0000'0001, 0x8000'0000'0000'0003).nearest(1'000'000).value() ==
              500'000);

// The same by a division. |x * numerator| < 2^63.
struct division {
    int64_t whole = 0;
    int64_t rest = 0;
};
division divided(const scale& s, int32_t x, int64_t carry) {
    const int64_t d = s.denominator();
    const int64_t n = int64_t{x} * s.numerator() + carry;
    int64_t whole = n / d;
    int64_t rest = n % d;
    if (rest < 0) {
        rest += d;
        --whole;
    }
    if (2 * rest >= d) {
        rest -= d;
        ++whole;
    }
    return {whole, rest};
}

constexpr std::array scales{
    scale{},
    scale::of(163'075, 4096),
    scale::of(4096, 163'075),
    scale::of(1, 1 << 29),
    scale::of(0xFFFF'FFFF, 1 << 29),
    scale::of(0xFFFF'FFFF, (1 << 29) - 2),
    scale::of(0xFFFF'FFFE, 536'870'911),
    scale::of(536'870'909, 536'870'911),
    scale::of(536'870'911, 536'870'909),
    scale::of(1, 3),
    scale::of(2, 3),
    scale::of(3, 2),
    scale::of(7'000'001, 3),
    scale::of(0x7FFF'FFFF, 1),
    scale::of(0x8000'0001, 1),
    scale::of(130'438'927, 3'276'800),
    scale::of(3'276'800, 130'438'927),
    scale::close_to(600'000, 652'194'637),
    scale::close_to(0xFFFF'FFFF'FFFF'FFFF, 0xFFFF'FFFF'FFFF'FFFD),
    scale::close_to(0xFFFF'FFFF'FFFF'FFFF, 1ull << 33),
};

TEST_CASE("a conversion is the division, rounded to the nearest") {
    std::mt19937 random{40};
    for (const scale& s : scales) {
        const auto half = static_cast<int32_t>(s.denominator() / 2);
        bool are_equal = true;
        for (int i = 0; i < 20'000; ++i) {
            // All sizes alike, and the ends of the range.
            auto x = static_cast<int32_t>(static_cast<std::uint32_t>(random()) >> (1 + random() % 31));
            if (i % 16 == 0) x = s.most() - static_cast<int32_t>(random() % 3);
            if (x < 0) x = 0;
            if (random() % 2 == 0) x = -x;
            int32_t carry =
                i % 3 == 0
                    ? 0
                    : static_cast<int32_t>(random() % static_cast<std::uint32_t>(s.denominator())) - half;
            if (i % 16 == 1) carry = -half;
            if (i % 16 == 2) carry = s.denominator() - half - 1;
            const int32_t before = carry;
            const result<int32_t> whole = s.convert(x, carry);
            if (x > s.most() || x < -s.most()) {
                are_equal &= whole.error() == errc::out_of_range && carry == before;
                continue;
            }
            const division expected = divided(s, x, before);
            are_equal &= whole && *whole == expected.whole && carry == expected.rest;
        }
        CHECK_MESSAGE(are_equal, s.numerator(), "/", s.denominator());
        // `most` is the last one that fits.
        CHECK(divided(s, s.most(), 0).whole <= largest);
        if (s.most() != largest)
            CHECK((int64_t{s.most()} + 1) * s.numerator() > int64_t{largest} * s.denominator());
    }
}

TEST_CASE("what is exact leaves no rest") {
    constexpr scale s = scale::of(5, 4);
    int exact = 0;
    for (int32_t x = -10; x <= 10; ++x) exact += s.is_exact(x);
    CHECK(exact == 5);
    CHECK(s.nearest(3).value() == 4);
    CHECK(!s.is_exact(largest));
}

TEST_CASE("conversions add up to one product") {
    constexpr scale s = scale::of(163'075, 4096);
    std::mt19937 random{41};
    int64_t counts = 0;
    int64_t sum = 0;
    int32_t carry = 0;
    for (int i = 0; i < 200'000; ++i) {
        const auto x = static_cast<int32_t>(random() % 200'001) - 100'000;
        counts += x;
        sum += s.convert(x, carry).value();
    }
    CHECK(sum * s.denominator() + carry == counts * s.numerator());
}

} // namespace scale_tests
