// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Values of every form: what words mean, which words mean a number, and the text of both.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <servobus/registers/value_text.hpp>

namespace value_text_tests {

using namespace servobus;

namespace {

constexpr unit volt{measure::volt}, celsius{measure::degree_celsius, 1, 10};

constexpr entry row(value_kind kind, const value_form* form = nullptr, unit worth = {},
                    range limits = {0, 0, false}) {
    return {0x10,       "row",          kind, access::rw,          limits, no_default, worth,
            flag::none, naming::number, {},   word_order::unknown, form};
}

std::string text_of(const entry& e, const std::vector<u16>& words, const row_scale& scale = {}) {
    char room[200];
    text_writer out{room};
    put_row(out, e, words, value_format::words, scale, "exponent");
    return {room, out.size()};
}
std::int64_t count_of(const entry& e, std::uint64_t bits) { return value_of(e, bits).count(); }

TEST_CASE("floats") {
    CHECK(text_of(row(value_kind::float_pair, nullptr, volt), {0x4366, 0x199A}) == "230.1 V");
    CHECK(text_of(row(value_kind::float_quad, nullptr, volt), {0x406C, 0xC333, 0x3333, 0x3333}) == "230.1 V");
    CHECK(text_of(row(value_kind::float_pair, nullptr, {measure::volt, 1, 1000}), {0x4366, 0x199A}) ==
          "0.2301 V");
    CHECK(text_of(row(value_kind::float_pair, nullptr, {measure::volt, 1, 3}), {0x3F80, 0}) == "1 * 1/3 V");
    for (const u16 high : {u16{0x7FC0}, u16{0x7F80}, u16{0xFF80}, u16{0xFFFF}})
        CHECK(text_of(row(value_kind::float_pair, nullptr, volt), {high, 0}) == "no value");
    static constexpr std::int64_t none[] = {0xC61C'3C00};
    constexpr value_form form{.none = none};
    CHECK(text_of(row(value_kind::float_pair, &form, volt), {0xC61C, 0x3C00}) == "no value"); // -9999
}

TEST_CASE("a float's range is in whole units") {
    const entry e = row(value_kind::float_pair, nullptr, volt, {-2, 100});
    const auto takes_bits = [&](std::uint32_t bits) { return takes(e, value_of(e, bits)); };
    CHECK(takes_bits(0x42C8'0000));       // 100
    CHECK_FALSE(takes_bits(0x42C8'0001)); // a bit more
    CHECK(takes_bits(0xC000'0000));       // -2
    CHECK_FALSE(takes_bits(0xC000'0001));
    CHECK(takes_bits(0x0000'0001)); // the smallest of all
    CHECK(takes_bits(0x8000'0000)); // -0
    CHECK_FALSE(takes_bits(0x7F7F'FFFF));
    CHECK_FALSE(takes_bits(0xFF7F'FFFF));
    CHECK_FALSE(takes_bits(0x7FC0'0000)); // no number
    const entry all = row(value_kind::float_pair);
    CHECK(takes(all, value_of(all, 0x7F7F'FFFF)));
    CHECK_FALSE(takes(all, value_of(all, 0x7F80'0000)));
}

TEST_CASE("64 bits, at both ends") {
    const entry u = row(value_kind::unsigned_quad), i = row(value_kind::signed_quad, nullptr, celsius);
    CHECK(text_of(u, {0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF}) == "18446744073709551615");
    CHECK(text_of(u, {0, 1, 0, 2}) == "4294967298");
    CHECK(text_of(i, {0x8000, 0, 0, 0}) == "-922337203685477580.8 degC");
    CHECK(text_of(i, {0x7FFF, 0xFFFF, 0xFFFF, 0xFFFF}) == "922337203685477580.7 degC");
    constexpr value_form form{.offset = -5};
    CHECK(text_of(row(value_kind::unsigned_quad, &form), {0, 0, 0, 2}) == "-3");
    CHECK(text_of(row(value_kind::signed_quad, &form), {0x8000, 0, 0, 0}) == "-9223372036854775813");
    constexpr value_form up{.offset = 1};
    CHECK(text_of(row(value_kind::unsigned_quad, &up), {0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF}) ==
          "no number (0xFFFFFFFFFFFFFFFF)");
}

TEST_CASE("decimal digits; a digit above 9 is no number") {
    CHECK(text_of(row(value_kind::bcd_word), {0x1234}) == "1234");
    CHECK(text_of(row(value_kind::bcd_pair), {0x9999, 0x9999}) == "99999999");
    CHECK(text_of(row(value_kind::bcd_word), {0x12A4}) == "no number (0x12A4)");
    CHECK(text_of(row(value_kind::bcd_pair), {0xF000, 0}) == "no number (0xF0000000)");
}

TEST_CASE("a sign and a magnitude") {
    const entry e = row(value_kind::sign_magnitude_pair, nullptr, {measure::ampere, 1, 1000});
    CHECK(text_of(e, {0x8000, 0x0BB8}) == "-3.000 A");
    CHECK(text_of(e, {0x8000, 0}) == "0.000 A");
    CHECK(text_of(row(value_kind::sign_magnitude_word), {0xFFFF}) == "-32767");
}

TEST_CASE("parts of a register have signs and codes of their own") {
    constexpr value_form level{.first_bit = 4, .bits = 12}, high{.first_bit = 8, .bits = 8};
    CHECK(text_of(row(value_kind::unsigned_word, &level), {0x0641}) == "100");
    CHECK(text_of(row(value_kind::signed_word, &high), {0xFB15}) == "-5");
    CHECK(text_of(row(value_kind::bcd_word, &high), {0x2315}) == "23");
    static constexpr named_value modes[] = {code(1, "auto")};
    constexpr value_form low{.first_bit = 0, .bits = 4};
    entry mode = row(value_kind::unsigned_word, &low);
    mode.names = naming::names;
    mode.values = modes;
    CHECK(text_of(mode, {0x0641}) == "auto (0x1)");
    CHECK(text_of(mode, {0x0642}) == "0x2");
}

TEST_CASE("an offset, raw values that mean none, and codes beside a unit") {
    static constexpr std::int64_t none[] = {0xFFFF};
    constexpr value_form form{.offset = -1000, .none = none};
    const entry battery = row(value_kind::unsigned_word, &form, celsius);
    CHECK(text_of(battery, {0x04E5}) == "25.3 degC");
    CHECK(text_of(battery, {0xFFFF}) == "no value");
    static constexpr std::int64_t lowest[] = {-0x8000};
    constexpr value_form sunspec{.none = lowest};
    CHECK(text_of(row(value_kind::signed_word, &sunspec), {0x8000}) == "no value");
    static constexpr named_value wide[] = {code(0x8000'0000, "no sensor")};
    entry pair = row(value_kind::unsigned_pair, &sunspec, celsius);
    pair.names = naming::names;
    pair.values = wide;
    CHECK(text_of(pair, {0x8000, 0}) == "no sensor (0x80000000)");
    CHECK(text_of(pair, {0, 5}) == "0.5 degC");
}

TEST_CASE("texts end before the zeros and blanks at their end") {
    constexpr value_form five{.words = 5}, two{.words = 2};
    const entry serial = row(value_kind::text, &five);
    CHECK(text_of(serial, {0x4B50, 0x4537, 0x4230, 0x3132, 0}) == "\"KPE7B012\"");
    CHECK(text_of(row(value_kind::text, &two), {0x4120, 0x2000}) == "\"A\"");
    CHECK(text_of(row(value_kind::text, &two), {0, 0}) == "\"\"");
    CHECK(text_of(row(value_kind::text, &two), {0x220A, 0x5CFF}) == "\"\\x22\\x0A\\x5C\\xFF\"");
}

row_scale exponent_of(const entry& e, i16 n) {
    return scale_from(e, row(value_kind::signed_word),
                      value_of(row(value_kind::signed_word), static_cast<u16>(n)));
}

TEST_CASE("a power of ten of another row") {
    constexpr value_form form{.scaled = scaling::exponent};
    const entry e = row(value_kind::signed_word, &form, {measure::ampere});
    CHECK(text_of(e, {0x04D2}, exponent_of(e, -2)) == "12.34 A");
    CHECK(text_of(e, {0xFB2E}, exponent_of(e, 2)) == "-123400 A");
    CHECK(text_of(e, {1}, exponent_of(e, -10)) == "0.0000000001 A");
    CHECK(text_of(e, {1}, exponent_of(e, 10)) == "10000000000 A");
    CHECK(text_of(e, {0}, exponent_of(e, 10)) == "0 A");
    CHECK(text_of(e, {1}, exponent_of(e, 11)) == "no value");
    CHECK(text_of(e, {1}, exponent_of(e, -11)) == "no value");
    CHECK(text_of(e, {1}, exponent_of(e, std::numeric_limits<i16>::min())) == "no value");
    CHECK(text_of(e, {0x04D2}, unknown_scale(e)) == "1234 * 10^exponent A");
    const entry tenths = row(value_kind::signed_word, &form, celsius);
    CHECK(text_of(tenths, {5}, exponent_of(tenths, 1)) == "5 degC");
    CHECK(text_of(tenths, {5}, exponent_of(tenths, -1)) == "0.05 degC");
    static constexpr std::int64_t none[] = {-0x8000};
    constexpr value_form may_be_none{.none = none};
    const entry scale = row(value_kind::signed_word, &may_be_none);
    CHECK(text_of(e, {1}, scale_from(e, scale, value_of(scale, 0x8000))) == "no value");
}

TEST_CASE("a factor of another row") {
    constexpr value_form form{.scaled = scaling::factor};
    const entry e = row(value_kind::unsigned_word, &form, {measure::ampere, 1, 1000});
    const entry ratio = row(value_kind::signed_word, nullptr, {measure::times, 1, 10});
    CHECK(text_of(e, {40}, scale_from(e, ratio, value_of(ratio, 1000))) == "4.0000 A");
    CHECK(text_of(e, {40}, scale_from(e, ratio, value_of(ratio, 0xFFFF))) == "-0.0040 A");
    CHECK(text_of(e, {40}, unknown_scale(e)) == "0.040 * exponent A");
    const entry wide = row(value_kind::unsigned_quad, &form, {measure::watt, 65535, 1});
    const entry most = row(value_kind::unsigned_quad);
    CHECK(text_of(wide, {0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF},
                  scale_from(wide, most, value_of(most, ~std::uint64_t{0}))) ==
          "22300404916163702200654440152299818807525375 W");
}

TEST_CASE("a unit of the device's own has its symbol from the form") {
    constexpr value_form form{.symbol = "ppm"};
    CHECK(text_of(row(value_kind::unsigned_word, &form, {measure::device_unit}), {415}) == "415 ppm");
    CHECK(symbol(measure::device_unit) == std::string{});
}

TEST_CASE("bits of a number are its value again, or there are none") {
    constexpr value_form part{.first_bit = 4, .bits = 5}, offset{.offset = -1000};
    const entry rows[] = {row(value_kind::unsigned_word),
                          row(value_kind::signed_word),
                          row(value_kind::bcd_word),
                          row(value_kind::sign_magnitude_word),
                          row(value_kind::unsigned_word, &part),
                          row(value_kind::signed_word, &part),
                          row(value_kind::unsigned_word, &offset),
                          row(value_kind::signed_word, &offset)};
    for (const entry& e : rows) {
        unsigned held = 0;
        for (std::int64_t n = -0x1'0000; n <= 0x1'0000; ++n) {
            const number_bits found = bits_of_number(e, n);
            held += found.fits;
            if (found.fits) REQUIRE(count_of(e, found.bits) == n);
        }
        const unsigned all = is_bcd(e) ? 10'000u : 1u << width_of(e);
        CHECK(held == all - (is_sign_and_magnitude(e) ? 1 : 0));
    }
    const entry u = row(value_kind::unsigned_quad), i = row(value_kind::signed_quad);
    CHECK(bits_of_number(u, false, ~std::uint64_t{0}).bits == ~std::uint64_t{0});
    CHECK(bits_of_number(i, std::numeric_limits<std::int64_t>::min()).bits == 1ull << 63);
    CHECK_FALSE(bits_of_number(i, false, 1ull << 63).fits);
    CHECK_FALSE(bits_of_number(i, true, (1ull << 63) + 1).fits);
}

} // namespace

} // namespace value_text_tests
