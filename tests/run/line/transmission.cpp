// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The time of bytes on the wire, against figures worked out by hand.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/line/transmission.hpp>

namespace transmission_tests {

using namespace servobus;

namespace {

constexpr bool has_left_at(transmission t, std::uint32_t us) { return t.is_over(instant{us}); }

// 8 characters of 10 bits: 80 bits at 115200 Bd are 694.4 us, at 9600 Bd 8333.3 us.
constexpr transmission eight(std::uint32_t baud, unsigned bits, std::uint32_t at) {
    transmission t{baud, bits};
    t.add(8, instant{at});
    return t;
}
static_assert(!has_left_at(eight(115200, 10, 1000), 1694) && has_left_at(eight(115200, 10, 1000), 1695));
static_assert(!has_left_at(eight(9600, 10, 1000), 9333) && has_left_at(eight(9600, 10, 1000), 9334));
static_assert(!has_left_at(eight(9600, 11, 0), 9166) && has_left_at(eight(9600, 11, 0), 9167));

} // namespace

TEST_CASE("bytes that follow while others are on the wire wait for them, and later ones do not") {
    transmission t{9600, 10};
    CHECK_FALSE(t.is_under_way());
    t.add(4, instant{100}); // until 4266.7 us
    t.add(4, instant{200}); // until 8433.3 us
    CHECK(t.is_under_way());
    CHECK_FALSE(t.is_over(instant{8432}));
    CHECK(t.is_over(instant{8434}));
    t.add(1, instant{50'000});
    CHECK_FALSE(t.is_over(instant{51'041}));
    CHECK(t.is_over(instant{51'042}));
    t.finish();
    CHECK_FALSE(t.is_under_way());
    t.add(1, instant{50'100}); // the bytes before count as sent: this one begins at once
    CHECK_FALSE(t.is_over(instant{51'141}));
    CHECK(t.is_over(instant{51'142}));
}

TEST_CASE("a response may have begun t3.5 after the last stop bit") {
    const auto first_at = [](std::uint32_t baud) {
        const transmission t = eight(baud, 10, 0);
        std::uint32_t us = 0;
        while (!t.may_be_answered(instant{us})) ++us;
        return us;
    };
    CHECK(first_at(9600) == 8334 + 4011);  // 3.5 characters of 11 bits are 4010.4 us
    CHECK(first_at(19200) == 4167 + 2006); // 2005.2 us
    CHECK(first_at(115200) == 695 + 1750); // the standard's fixed time above 19200 Bd
}

TEST_CASE("it works across the wrap of the clock") {
    const transmission t = eight(115200, 10, UINT32_MAX - 99);
    CHECK_FALSE(t.is_over(instant{UINT32_MAX}));
    CHECK_FALSE(t.is_over(instant{594}));
    CHECK(t.is_over(instant{595}));
}

TEST_CASE("without a rate every byte has left at once") {
    transmission t;
    t.add(200, instant{5});
    CHECK(t.is_over(instant{5}));
    t = transmission{0, 11};
    t.add(200, instant{5});
    CHECK(t.is_over(instant{5}));
}

TEST_CASE("an adapter echoes if all bytes of the last request that was decided in time came back") {
    constexpr std::uint32_t in_time = 695 + 1749;
    constexpr std::uint32_t late = in_time + 1;
    transmission t{115200};
    const auto discards_late_after = [&](std::size_t returned, std::uint32_t us) {
        t.add(8, instant{0});
        t.note_arrival(returned, instant{us});
        CHECK(t.most_to_discard(instant{in_time}) != 0);
        t.decide_echo(instant{us});
        t.finish();
        t.add(8, instant{0});
        const bool discards = t.most_to_discard(instant{late}) != 0;
        t.finish();
        return discards;
    };
    CHECK_FALSE(discards_late_after(0, in_time));
    CHECK_FALSE(discards_late_after(7, in_time)); // noise
    CHECK_FALSE(discards_late_after(8, late));    // a response
    CHECK(discards_late_after(8, in_time));
    CHECK(discards_late_after(0, late)); // nothing new is known
    t.restart(9600);
    t.add(8, instant{0});
    CHECK(t.most_to_discard(instant{50'000}) == 8);
    t.restart(115200);
    CHECK_FALSE(discards_late_after(0, in_time));
    t.note_arrival(8, instant{0}); // nothing is under way
    CHECK_FALSE(discards_late_after(7, in_time));
    // All came back in time, and the thread was delayed before it was asked.
    t.add(8, instant{0});
    t.note_arrival(8, instant{in_time});
    t.decide_echo(instant{late});
    t.finish();
    t.add(8, instant{0});
    CHECK(t.most_to_discard(instant{late}) != 0);
}

TEST_CASE("when a response can have come no more bytes are discarded than are missing of the echo") {
    constexpr instant in_time{695 + 1749};
    constexpr instant late{1129 + 1750}; // also after 13 bytes
    transmission t{115200};
    t.add(8, instant{0});
    CHECK(t.most_to_discard(in_time) > 1000);
    t.note_discarded(8);
    t.decide_echo(in_time);
    t.finish();
    t.add(13, instant{0});
    t.note_arrival(3, instant{700});
    CHECK(t.most_to_discard(in_time) > 1000);
    CHECK(t.most_to_discard(late) == 10);
    t.note_discarded(4);
    CHECK(t.most_to_discard(late) == 6);
    t.note_discarded(6);
    CHECK(t.most_to_discard(late) == 0);
    t.decide_echo(late);
    t.finish();
    t.add(8, instant{0});
    CHECK(t.most_to_discard(late) == 8);
    t.note_arrival(9, instant{600}); // one byte of noise beside the echo
    CHECK(t.most_to_discard(late) == 0);
}

} // namespace transmission_tests
