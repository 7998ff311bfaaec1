// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The words of errors, outcomes and rights, and a line of text that may be too short for them.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <servobus/registers/catalogue.hpp>
#include <servobus/result.hpp>
#include <servobus/text.hpp>

using namespace servobus;

TEST_CASE("outcomes and rights have words of their own") {
    CHECK(std::string{text(outcome::done)} == "done");
    CHECK(std::string{text(outcome::refused)} == "refused");
    CHECK(std::string{text(outcome::not_sent)} == "not sent");
    CHECK(std::string{text(outcome::unknown)} == "unknown");
    CHECK(std::string{text(static_cast<outcome>(4))} == "unknown"); // whatever memory holds
    CHECK(std::string{text(access::ro)} == "ro");
    CHECK(std::string{text(access::rw)} == "rw");
    CHECK(std::string{text(access::wo)} == "wo");
    CHECK(std::string{text(value_kind::unsigned_word)} == "u16");
    CHECK(std::string{text(value_kind::signed_word)} == "i16");
    CHECK(std::string{text(value_kind::unsigned_pair)} == "u32");
    CHECK(std::string{text(value_kind::signed_pair)} == "i32");
}

TEST_CASE("a write says why it ended as it did, exception number and all") {
    const written refused{failure{errc::exception, 7}, true};
    CHECK(refused.outcome() == outcome::refused);
    CHECK(refused.why() == failure{errc::exception, 7});
    CHECK(written{failure{errc::timeout}, true}.why() == failure{errc::timeout});
    CHECK(written{}.why() == failure{});
    CHECK_FALSE(written{}.was_sent());
}

TEST_CASE("text that does not fit is cut, says so, ends in dots and never leaves its room") {
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
        out.number(-12345).hex_word(0xABCD); // what comes behind changes a cut text no more
        if (!fits) CHECK(memory.substr(4, out.size()) == said);
        CHECK(out.is_cut());
        CHECK(memory.substr(0, 4) == "####");
        CHECK(memory.substr(size + 4) == "####");
    }
}
