// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The texts of errors, outcomes and access rights, and a line of text that may be too short for them.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <servobus/core/result.hpp>
#include <servobus/core/text.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/format.hpp>

namespace text_tests {

using namespace servobus;

TEST_CASE("outcomes and access rights have texts of their own") {
    CHECK(std::string{text(outcome::done)} == "done");
    CHECK(std::string{text(outcome::refused)} == "refused");
    CHECK(std::string{text(outcome::not_sent)} == "not sent");
    CHECK(std::string{text(outcome::unknown)} == "unknown");
    CHECK(std::string{text(static_cast<outcome>(4))} == "unknown"); // outside the enumeration
    CHECK(std::string{text(access::ro)} == "ro");
    CHECK(std::string{text(access::rw)} == "rw");
    CHECK(std::string{text(access::wo)} == "wo");
    CHECK(std::string{text(value_kind::unsigned_word)} == "u16");
    CHECK(std::string{text(value_kind::signed_word)} == "i16");
    CHECK(std::string{text(value_kind::unsigned_pair)} == "u32");
    CHECK(std::string{text(value_kind::signed_pair)} == "i32");
}

TEST_CASE("a write states why it ended as it did, with the exception number") {
    const status refused = status::sent(errc::exception, 7);
    CHECK(refused.outcome() == outcome::refused);
    CHECK(refused.error() == errc::exception);
    CHECK(refused.exception() == 7);
    CHECK(status::sent(errc::timeout) != status{errc::timeout});
    CHECK(status::sent(errc::timeout).outcome() == outcome::unknown);
    CHECK(status{errc::timeout}.with_sent(true) == status::sent(errc::timeout));
    CHECK(status{} == status{});
    CHECK_FALSE(status{}.was_sent());
}

TEST_CASE("text that does not fit is cut, reported as cut, ends in dots and never leaves its buffer") {
    const std::string words = "abcdefghij";
    for (std::size_t size = 0; size <= 12; ++size) {
        CAPTURE(size);
        std::string memory(size + 8, '#');
        text_writer out{std::span<char>{memory}.subspan(4, size)};
        CHECK_FALSE(out.is_cut());
        out << words.c_str();
        const bool fits = size >= words.size();
        CHECK(out.is_cut() == !fits);
        CHECK(out.size() == (fits ? words.size() : size));
        const std::string said = memory.substr(4, out.size());
        const std::size_t dots = size < 3 ? size : 3;
        CHECK(said == (fits ? words : words.substr(0, size - dots) + std::string(dots, '.')));
        out << 'k' << "lm";
        out.number(-12345).hex_word(0xABCD); // later output does not change a cut text
        if (!fits) CHECK(memory.substr(4, out.size()) == said);
        CHECK(out.is_cut());
        CHECK(memory.substr(0, 4) == "####");
        CHECK(memory.substr(size + 4) == "####");
    }
}

TEST_CASE("G32: however many decimals are requested, a number has 40 digits at most") {
    const auto digits_of = [](std::int64_t value, unsigned decimals) {
        std::array<char, 100> room{};
        text_writer out{room};
        out.scaled(value, decimals);
        return std::string{room.data(), out.size()};
    };
    CHECK(digits_of(5, 39) == "0." + std::string(38, '0') + "5");
    CHECK(digits_of(-5, 1'000'000).size() == 41); // with its sign
    CHECK(digits_of(5, 40).size() == 40);
}

TEST_CASE("value_or returns the value of a result, or the other one if there is none") {
    const result<int> good{7};
    const result<int> bad{status{errc::timeout}};
    CHECK(good.value_or(9) == 7);
    CHECK(bad.value_or(9) == 9);
    CHECK(status::sent(errc::exception, 2) == status::sent(errc::exception, 2));
    CHECK_FALSE(status::sent(errc::exception, 2) == status::sent(errc::exception, 3));
    CHECK_FALSE(status::sent(errc::exception, 2) == status::sent(errc::ok, 2));
}

TEST_CASE("a register value is written in words, or as one token without a blank") {
    for (const unsigned bit : {0u, 15u}) { // at run time as at compile time
        const auto mask = static_cast<std::uint16_t>(1u << bit);
        const named_value one = named_bit(mask, "one");
        CHECK(one.applies(mask));
        CHECK(one.applies(0xFFFF));
        CHECK_FALSE(one.applies(0xFFFFu ^ mask));
        const named_value other = field(mask, 0, "other");
        CHECK_FALSE(other.applies(mask));
        CHECK(other.applies(0xFFFFu ^ mask));
        const named_value whole = code(mask, "whole");
        CHECK(whole.applies(mask));
        CHECK_FALSE(whole.applies(0xFFFF));
        CHECK_FALSE(whole.applies(0));
    }
    static constexpr named_value bits[] = {named_bit(0x0001, "left locked"), named_bit(0x0002, "fault"),
                                           field(0x0030, 0x0020, "not ready")};
    entry e{};
    e.names = naming::names;
    e.values = bits;
    const auto said = [&e](u32 word, value_format how) {
        std::array<char, 100> room{};
        text_writer out{room};
        put_value(out, e, word, how);
        return std::string{room.data(), out.size()};
    };
    using enum value_format;
    CHECK(said(0x0021, words) == "left locked + not ready (0x0021)");
    CHECK(said(0x0021, tokens) == "left_locked+not_ready (0x0021)");
    CHECK(said(0x0103, words) == "left locked + fault + 0x0100 (0x0103)");
    CHECK(said(0x0103, tokens) == "left_locked+fault+0x0100 (0x0103)");
    CHECK(said(0x0100, words) == "0x0100");
    CHECK(said(0x0100, tokens) == "0x0100");
    e.names = naming::halves;
    e.unit_of_count = units::degree_celsius / 10;
    e.kind = value_kind::unsigned_word;
    CHECK(said(0x23FF, words) == "left 3.5 degC / right 25.5 degC");
    CHECK(said(0x23FF, tokens) == "3.5/25.5 degC");
    e.kind = value_kind::signed_word;
    CHECK(said(0x23FF, tokens) == "3.5/-0.1 degC");
    e.kind = value_kind::unsigned_pair; // it has no halves
    CHECK(said(0x23FF, tokens) == "921.5 degC");
    e.kind = value_kind::signed_word;
    for (const naming how : {naming::number, static_cast<naming>(7)}) { // 7 is outside the enumeration
        e.names = how;
        CHECK(said(0xFFFB, words) == "-0.5 degC");
        CHECK(said(0xFFFB, tokens) == "-0.5 degC");
    }
}

TEST_CASE("a number that has names for some of its values keeps its unit for all others") {
    static constexpr named_value codes[] = {code(0xFFFF, "no limit"), code(0x7FFF, "no sensor")};
    entry e{};
    e.limits = {-400, 1250};
    e.unit_of_count = units::degree_celsius / 10;
    e.values = codes;
    const auto said = [&e](u32 word) {
        std::array<char, 100> room{};
        text_writer out{room};
        put_value(out, e, word);
        return std::string{room.data(), out.size()};
    };
    for (const value_kind kind : {value_kind::unsigned_word, value_kind::signed_word}) {
        const bool is_signed = kind == value_kind::signed_word;
        e.kind = kind;
        e.names = naming::names;
        CHECK(e.is_quantity());
        CHECK(said(250) == "25.0 degC");
        CHECK(said(0x7FFF) == "no sensor (0x7FFF)");
        CHECK(said(0xFFFF) == "no limit (0xFFFF)");
        CHECK(said(0xFFFE) == (is_signed ? "-0.2 degC" : "6553.4 degC"));
        CHECK(e.is_code(0x7FFF));
        CHECK(e.is_code(is_signed ? -1 : 0xFFFF));
        CHECK_FALSE(e.is_code(is_signed ? 0xFFFF : -1));
        CHECK_FALSE(e.is_code(250));
        CHECK(e.takes(0x7FFF)); // a code, although the range ends before it
        CHECK(e.takes(1250));
        CHECK_FALSE(e.takes(1251));
        CHECK_FALSE(e.takes(0x7FFE));
        e.names = naming::number;
        CHECK(e.is_quantity());
    }
    e.names = naming::names;
    e.unit_of_count = {};
    CHECK_FALSE(e.is_quantity());
    CHECK(said(250) == "0x00FA");
    static constexpr named_value bits[] = {named_bit(0x0004, "ready"), field(0x0003, 0x0002, "slow")};
    e.values = bits;
    for (const std::int64_t bit : {4, 2, 6}) CHECK_FALSE(e.is_code(bit));
}

TEST_CASE("the names of a 32-bit register are of its whole value") {
    static constexpr named_value codes[] = {code(0, "off"), code(1, "on"), code(0xFFFF, "all")};
    static constexpr named_value bits[] = {named_bit(0x0001, "locked"), field(0x0030, 0x0020, "not ready")};
    entry e{};
    e.names = naming::names;
    const auto said = [&e](u32 value) {
        std::array<char, 100> room{};
        text_writer out{room};
        put_value(out, e, value);
        return std::string{room.data(), out.size()};
    };
    for (const value_kind kind : {value_kind::unsigned_pair, value_kind::signed_pair}) {
        e.kind = kind;
        e.values = codes;
        CHECK(said(1) == "on (0x00000001)");
        CHECK(said(0x1'0001) == "0x00010001");
        CHECK(said(0x1'0000) == "0x00010000");
        CHECK(said(0xFFFF) == "all (0x0000FFFF)");
        CHECK(said(0xFFFF'FFFF) == "0xFFFFFFFF");
        e.values = bits;
        CHECK(said(0x1'0021) == "locked + not ready + 0x00010000 (0x00010021)");
        CHECK(said(0x21) == "locked + not ready (0x00000021)");
    }
    e.kind = value_kind::unsigned_word;
    e.values = codes;
    CHECK(said(0xFFFF) == "all (0xFFFF)");
    e.kind = value_kind::signed_word; // as -1 is given, and as it is read
    CHECK(said(0xFFFF'FFFF) == "all (0xFFFF)");
}

} // namespace text_tests
