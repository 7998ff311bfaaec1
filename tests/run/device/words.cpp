// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Words of the drives that are sets of bits, at run time: each bit has its own query, no bit is outside the
// word, and the conversion to a word restores it.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <string>

#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

namespace words_tests {

using namespace servobus;

TEST_CASE("C630S: each bit of the status has one query, and to_word restores the word") {
    using c630s::status_flags;
    using question = bool (status_flags::*)() const;
    constexpr std::array<question, 16> questions{
        &status_flags::is_ready,
        &status_flags::is_rotating,
        &status_flags::is_at_zero_speed,
        &status_flags::is_at_speed,
        &status_flags::is_completed,
        &status_flags::is_near,
        &status_flags::is_torque_limited,
        &status_flags::is_speed_limited,
        &status_flags::is_brake_released,
        &status_flags::has_warning,
        &status_flags::has_fault,
        &status_flags::has_reached_speed,
        &status_flags::has_reached_torque,
        &status_flags::is_electrically_home,
        nullptr,
        &status_flags::is_home}; // VDO15 shows that the angle was identified: it has no query
    for (unsigned bit = 0; bit < 16; ++bit) {
        CAPTURE(bit);
        const auto word = static_cast<u16>(1u << bit);
        const status_flags one = status_flags::from_word(word);
        const status_flags others = status_flags::from_word(static_cast<u16>(~word));
        CHECK(one.to_word() == word);
        for (std::size_t n = 0; n < questions.size(); ++n) {
            if (questions[n] == nullptr) continue;
            CHECK((one.*questions[n])() == (n == bit));
            CHECK((others.*questions[n])() == (n != bit));
        }
    }
}

TEST_CASE("C630S: terminals are numbered 1 to 16, and other numbers are ignored") {
    using set = c630s::virtual_inputs;
    for (unsigned number = 1; number <= 16; ++number) {
        CAPTURE(number);
        const auto bit = static_cast<u16>(1u << (number - 1));
        CHECK(set{}.with(number).to_word() == bit);
        CHECK(set{0xFFFF}.without(number).to_word() == static_cast<u16>(~bit));
        CHECK(set::from_word(bit).has(number));
        CHECK_FALSE(set{static_cast<u16>(~bit)}.has(number));
    }
    for (const unsigned number : {0u, 17u, 33u, 0xFFFF'FFFFu}) {
        CAPTURE(number);
        CHECK(set{}.with(number) == set{});
        CHECK(set{0xFFFF}.without(number) == set{0xFFFF});
        CHECK_FALSE(set{0xFFFF}.has(number));
    }
}

TEST_CASE("C630S: a word of functions has 16 functions from its first one on, and ignores those of other "
          "words") {
    using c630s::input_function;
    using second = c630s::input_functions<17>;
    for (unsigned n = 0; n <= 48; ++n) {
        CAPTURE(n);
        const auto one = static_cast<input_function>(n);
        const bool is_in = n >= 17 && n <= 32;
        const u16 bit = is_in ? static_cast<u16>(1u << (n - 17)) : u16{0};
        CHECK(second{}.with(one).to_word() == bit);
        CHECK(second::from_word(0xFFFF).without(one).to_word() == static_cast<u16>(~bit));
        CHECK(second{0xFFFF}.has(one) == is_in);
        CHECK_FALSE(second{static_cast<u16>(~bit)}.has(one));
    }
}

TEST_CASE("C630S: a parameter's number is P, two hexadecimal digits in capitals, and two decimal ones") {
    const auto address = [](const std::string& text) {
        return c630s::detail::parameter_address(text.c_str(), text.size());
    };
    CHECK(address("P0B-17") == 0x0B11);
    CHECK(address("PFA-99") == 0xFA63);
    CHECK(address("P00-00") == 0);
    for (const char* wrong :
         {"", "P", "P0B-1", "P0B-170", "p0B-17", "X0B-17", "P0B17-", "P0B_17", "Pb0-17", "P0b-17", "PG0-17",
          "P0G-17", "P/0-17", "P0:-17", "P@0-17", "P0B-A7", "P0B-1A", "P0B- 1", "P0B-1 "}) {
        CAPTURE(wrong);
        CHECK(address(wrong) < 0);
    }
}

TEST_CASE("ZLAC8015D: each bit of 2019h is one output's polarity") {
    using zlac8015d::output_polarity;
    for (unsigned word = 0; word < 16; ++word) {
        CAPTURE(word);
        const auto got = output_polarity::from_word(static_cast<u16>(word | 0xFFF0u));
        CHECK(got.y0 == ((word & 1u) != 0));
        CHECK(got.y1 == ((word & 2u) != 0));
        CHECK(got.b0 == ((word & 4u) != 0));
        CHECK(got.b1 == ((word & 8u) != 0));
        CHECK(got.to_word() == word); // unused bits are dropped
    }
}

} // namespace words_tests
