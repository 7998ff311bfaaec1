// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Sine and cosine by a table: the error against the standard library, over the whole turn.
#include <array>
#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/axis/detail/sine.hpp>

namespace sine_tests {

using servobus::detail::high_product;
using servobus::detail::unit_vector;
using servobus::detail::unit_vector_at;
using std::int32_t;
using std::uint32_t;

constexpr int32_t one = 1 << 30;

// The axes are exact, and the octants mirror each other.
static_assert(high_product(1, 0x7FFF'FFFF) == 0 && high_product(2, 0x4000'0000) == 1, "to the nearest");
static_assert(unit_vector_at(0).cosine == one && unit_vector_at(0).sine == 0);
static_assert(unit_vector_at(0x4000'0000).cosine == 0 && unit_vector_at(0x4000'0000).sine == one);
static_assert(unit_vector_at(0x8000'0000).cosine == -one && unit_vector_at(0x8000'0000).sine == 0);
static_assert(unit_vector_at(0xC000'0000).cosine == 0 && unit_vector_at(0xC000'0000).sine == -one);
static_assert(unit_vector_at(0x2000'0000).cosine == unit_vector_at(0x2000'0000).sine);

TEST_CASE("the error of sine and cosine is at most 3.7e-9") {
    constexpr double turn = 6.283185307179586476925286766559;
    double worst = 0;
    // 2^22 angles, of which each of the 256 entries has 16384, with low bits that differ.
    for (uint32_t i = 0; i < 1u << 22; ++i) {
        const uint32_t angle = (i << 10) + i % 1021;
        const unit_vector at = unit_vector_at(angle);
        const double exact = angle / 4294967296.0 * turn;
        worst = std::fmax(worst, std::fabs(at.cosine - std::cos(exact) * one));
        worst = std::fmax(worst, std::fabs(at.sine - std::sin(exact) * one));
    }
    MESSAGE("error of sine and cosine: ", worst / one);
    CHECK(worst / one <= 3.7e-9);
}

static_assert(sizeof(servobus::detail::quarter_sine) == 65 * sizeof(int32_t));

TEST_CASE("each entry of the table is the nearest integer") {
    constexpr double turn = 6.283185307179586476925286766559;
    for (int32_t n = 0; n <= 64; ++n)
        CHECK(servobus::detail::quarter_sine[n] == std::lround(std::sin(n * turn / 256) * one));
}

TEST_CASE("the ends of the table's intervals") {
    constexpr double turn = 6.283185307179586476925286766559;
    for (uint32_t entry = 0; entry < 256; ++entry) {
        for (const uint32_t beyond :
             std::array{0x007F'FFFFu, 0x0080'0000u, 0x0080'0001u, 0u, 1u, 0x00FF'FFFFu}) {
            const uint32_t angle = (entry << 24) + beyond;
            const unit_vector at = unit_vector_at(angle);
            const double exact = angle / 4294967296.0 * turn;
            CHECK(std::fabs(at.cosine - std::cos(exact) * one) <= 4);
            CHECK(std::fabs(at.sine - std::sin(exact) * one) <= 4);
        }
    }
}

} // namespace sine_tests
