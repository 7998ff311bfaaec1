// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The arithmetic of 128 bits that computes scales and axles, against the compiler's own where there is one; products by
// parts, as small cores compute them.
#include <cstdint>
#include <random>

#include <doctest/doctest.h>

#include <servobus/axis/detail/exact.hpp>
#include <servobus/axis/detail/high_word.hpp>
#include <servobus/axis/detail/is_beyond.hpp>

namespace exact_tests {

using servobus::detail::floor_of;
using servobus::detail::greatest_divisor;
using servobus::detail::nearest_of;
using std::uint64_t;

constexpr uint64_t ones = ~uint64_t{0};

static_assert(greatest_divisor(16384, 652'300) == 4 && greatest_divisor(0, 7) == 7 &&
              greatest_divisor(7, 0) == 7);
static_assert(greatest_divisor(ones, ones - 1) == 1 && greatest_divisor(ones, ones) == ones);
static_assert(floor_of(ones, 1, 1) == ones && floor_of(0, ones, 1) == 0);
static_assert(floor_of(ones, uint64_t{1} << 62, uint64_t{1} << 63) == ones / 2);
static_assert(floor_of(ones, uint64_t{1} << 63, uint64_t{1} << 63) == ones);
static_assert(floor_of(ones, ones, 1) == 1, "modulo 2^64: (2^64 - 1)^2 is 1");
static_assert(floor_of(7, 5, 9) == 3 && nearest_of(7, 5, 9) == 4);
static_assert(nearest_of(1, 1, 2) == 1 && nearest_of(1, 3, 2) == 2, "halves are rounded up");
static_assert(nearest_of(1'000'000'007, 1'000'000'009, 1'000'000'011) == 1'000'000'005);

TEST_CASE("a * b / c by parts: c times the quotient and a rest below c are a * b, modulo 2^64") {
    std::mt19937_64 random{42};
    bool are_equal = true;
    for (int i = 0; i < 20'000; ++i) {
        const uint64_t a = random() >> random() % 64;
        const uint64_t b = random() >> random() % 64;
        const uint64_t c = (random() >> (1 + random() % 63)) | 1;
        const uint64_t quotient = floor_of(a, b, c);
        const uint64_t common = greatest_divisor(a, c);
        are_equal &= a % common == 0 && c % common == 0 && greatest_divisor(a / common, c / common) == 1;
        // Below 2^32 each, a 64-bit division says the same.
        const uint64_t x = a >> 32, y = b >> 33, z = (c >> 33) + 1;
        are_equal &= nearest_of(x, y, z) == (2 * x * y / z + 1) / 2;
        are_equal &= a * b - quotient * c < c;
#ifdef __SIZEOF_INT128__
        __extension__ using wide = unsigned __int128;
        are_equal &= quotient == static_cast<uint64_t>(static_cast<wide>(a) * b / c);
#endif
    }
    CHECK(are_equal);
}

TEST_CASE("the upper half of a product, whole and by parts") {
    using servobus::detail::high_word;
    using servobus::detail::high_word_by_parts;
    std::mt19937 random{43};
    bool are_equal = high_word_by_parts(0xFFFF'FFFF, 0xFFFF'FFFF) == 0xFFFF'FFFE &&
                     high_word_by_parts(0x1'0000, 0x1'0000) == 1;
    for (int i = 0; i < 20'000; ++i) {
        const auto a = static_cast<std::uint32_t>(random() >> random() % 32);
        const auto b = static_cast<std::uint32_t>(random() >> random() % 32);
        const auto expected = static_cast<std::uint32_t>(uint64_t{a} * b >> 32);
        are_equal &= high_word(a, b) == expected && high_word_by_parts(a, b) == expected;
    }
    CHECK(are_equal);
}

using servobus::detail::is_beyond;
static_assert(!is_beyond(0, 0) && is_beyond(1, 0) && is_beyond(-1, 0));
static_assert(!is_beyond(0x7FFF'FFFF, 0x7FFF'FFFF) && !is_beyond(-0x7FFF'FFFF, 0x7FFF'FFFF));
static_assert(is_beyond(-0x7FFF'FFFF - 1, 0x7FFF'FFFF) && is_beyond(0x7FFF'FFFF, 0x7FFF'FFFE));

} // namespace exact_tests
