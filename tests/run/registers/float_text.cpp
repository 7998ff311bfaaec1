// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The decimal text of floats, compared with that of std::to_chars.
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>

#include <servobus/registers/float_text.hpp>

namespace float_text_tests {

using namespace servobus;

namespace {

struct constant_text {
    std::array<char, 32> room{};
    std::size_t size = 0;
    constexpr operator std::string_view() const {
        return {room.data(), size};
    } // NOLINT: implicit, it is a text
};
constexpr constant_text constant(float_bits f, int shift = 0) {
    constant_text t;
    text_writer out{t.room};
    put_float(out, f, shift);
    t.size = out.size();
    return t;
}
constexpr std::string_view view(const constant_text& t) { return t; }

static_assert(view(constant(float_bits::of_single(0x4366'199A))) == "230.1");
static_assert(view(constant(float_bits::of_single(0xC32C'9822))) == "-172.59427");
static_assert(view(constant(float_bits::of_double(0x7FEF'FFFF'FFFF'FFFF))) == "1.7976931348623157e+308");
static_assert(view(constant(float_bits::of_double(1))) == "5e-324");
static_assert(view(constant(float_bits::of_single(0x8000'0000))) == "-0");

std::string text_of(const float_bits& f, int shift = 0) { return std::string{view(constant(f, shift))}; }

template <class Float> std::string usual_text(Float f) {
    char room[64];
    const std::to_chars_result end = std::to_chars(room, room + sizeof room, f);
    return {room, end.ptr};
}

// The first bits whose text differs, or 0.
std::uint64_t differing_single(std::uint32_t bits) {
    const float f = std::bit_cast<float>(bits);
    return std::isfinite(f) && text_of(float_bits::of_single(bits)) != usual_text(f) ? bits | 1ull << 63 : 0;
}
std::uint64_t differing_double(std::uint64_t bits) {
    const double f = std::bit_cast<double>(bits);
    return std::isfinite(f) && text_of(float_bits::of_double(bits)) != usual_text(f) ? bits | 1 : 0;
}

TEST_CASE("a float's text is the shortest that reads back to the same bits: at both ends of each exponent") {
    std::uint64_t wrong = 0;
    for (std::uint32_t exponent = 0; exponent < 0xFF; ++exponent) {
        for (const std::uint32_t fraction : {0u, 1u, 2u, 0x40'0000u, 0x7F'FFFEu, 0x7F'FFFFu})
            wrong |= differing_single(exponent << 23 | fraction);
    }
    CHECK(wrong == 0);
    for (std::uint64_t exponent = 0; exponent < 0x7FF; exponent += 3) {
        for (const std::uint64_t fraction : {0ull, 1ull, 0xF'FFFF'FFFF'FFFEull, 0xF'FFFF'FFFF'FFFFull})
            wrong |= differing_double(exponent << 52 | fraction);
    }
    CHECK(wrong == 0);
}

TEST_CASE("a float's text: any bits, the smallest floats, whole numbers, hundredths") {
    std::mt19937_64 random{17};
    std::uint64_t wrong = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::uint64_t bits = random();
        wrong |= differing_single(static_cast<std::uint32_t>(bits));
        wrong |= differing_double(bits);
        wrong |= differing_single(static_cast<std::uint32_t>(bits) & 0x7F'FFFF);
        wrong |= differing_double(bits >> 12);
        wrong |= differing_double(std::bit_cast<std::uint64_t>(static_cast<double>(bits >> (bits & 63))));
        wrong |= differing_single(std::bit_cast<std::uint32_t>(static_cast<float>(bits >> 45) / 100));
    }
    CHECK(wrong == 0);
}

TEST_CASE("a float may be written with another power of ten") {
    const float_bits volts = float_bits::of_single(std::bit_cast<std::uint32_t>(1234.5f));
    CHECK(text_of(volts, -3) == "1.2345");
    CHECK(text_of(volts, 3) == "1234500");
    CHECK(text_of(float_bits::of_single(0), 5) == "0");
}

TEST_CASE("what is no number has a word") {
    CHECK(text_of(float_bits::of_single(0x7FC0'0000)) == "nan");
    CHECK(text_of(float_bits::of_single(0xFF80'0000)) == "-inf");
    CHECK(text_of(float_bits::of_double(0x7FF0'0000'0000'0000)) == "inf");
}

} // namespace

} // namespace float_text_tests
