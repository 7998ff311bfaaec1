// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Slices: what they are made from, what they convert to, and their parts.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include <servobus/core/slice.hpp>

namespace slice_tests {

using servobus::slice;

namespace {

using words = slice<std::uint16_t>;
using constants = slice<const std::uint16_t>;

// A slice is made from whatever std::span is made from, and from nothing else.
static_assert(std::is_convertible_v<std::array<std::uint16_t, 3>&, words>);
static_assert(std::is_convertible_v<std::vector<std::uint16_t>&, words>);
static_assert(std::is_convertible_v<std::uint16_t (&)[3], words>);
static_assert(std::is_convertible_v<std::span<std::uint16_t>, words>);
static_assert(std::is_convertible_v<std::uint16_t (&)[3], constants>);
static_assert(std::is_convertible_v<const std::uint16_t (&)[3], constants>);
static_assert(std::is_convertible_v<const std::array<std::uint16_t, 3>&, constants>);
static_assert(std::is_convertible_v<std::array<std::uint16_t, 3>, constants>);
static_assert(std::is_convertible_v<std::span<std::uint16_t>, constants>);
static_assert(std::is_convertible_v<std::span<const std::uint16_t>, constants>);
static_assert(std::is_convertible_v<words, constants>);
static_assert(std::is_convertible_v<words&, constants>);
static_assert(!std::is_convertible_v<constants, words>);
static_assert(!std::is_convertible_v<std::array<std::uint16_t, 3>, words>);
static_assert(!std::is_convertible_v<const std::array<std::uint16_t, 3>&, words>);
static_assert(!std::is_convertible_v<const std::uint16_t (&)[3], words>);
static_assert(!std::is_convertible_v<std::span<const std::uint16_t>, words>);
static_assert(!std::is_convertible_v<std::array<std::uint32_t, 3>&, words>);
static_assert(!std::is_convertible_v<std::array<std::int16_t, 3>&, constants>);
static_assert(!std::is_convertible_v<int, words>);

// And std::span is made from slices of every kind.
static_assert(std::is_convertible_v<words, std::span<std::uint16_t>>);
static_assert(std::is_convertible_v<words&, std::span<std::uint16_t>>);
static_assert(std::is_convertible_v<const words, std::span<std::uint16_t>>);
static_assert(std::is_convertible_v<const words&, std::span<std::uint16_t>>);
static_assert(std::is_convertible_v<words, std::span<const std::uint16_t>>);
static_assert(std::is_convertible_v<const words&, std::span<const std::uint16_t>>);
static_assert(std::is_convertible_v<constants, std::span<const std::uint16_t>>);
static_assert(std::is_convertible_v<constants&, std::span<const std::uint16_t>>);
static_assert(!std::is_convertible_v<constants, std::span<std::uint16_t>>);

static_assert(std::is_trivially_copyable_v<words>);
static_assert(sizeof(words) == sizeof(std::span<std::uint16_t>));

constexpr std::uint16_t numbers[] = {1, 2, 3, 4, 5};

constexpr unsigned sum(constants of) {
    unsigned all = 0;
    for (const std::uint16_t n : of) all += n;
    return all;
}
static_assert(sum({}) == 0);
static_assert(sum(numbers) == 15);
static_assert(sum(constants{numbers}.first(2)) == 3);
static_assert(sum(constants{numbers}.last(2)) == 9);
static_assert(sum(constants{numbers}.subspan(3)) == 9);
static_assert(sum(constants{numbers}.subspan(1, 3)) == 9);
static_assert(sum(constants{numbers}.subspan(5)) == 0);
static_assert(constants{numbers}.front() == 1);
static_assert(constants{numbers}.back() == 5);
static_assert(constants{}.empty());
static_assert(!constants{numbers}.empty());

} // namespace

TEST_CASE("a slice is a pointer and a size, and converts to std::span and back") {
    std::array<std::uint16_t, 4> room{1, 2, 3, 4};
    const words all{room};
    all[2] = 7;
    CHECK(room[2] == 7);
    const std::span<std::uint16_t> there = all;
    CHECK(there.data() == room.data());
    CHECK(there.size() == 4);
    const std::span<std::uint16_t> part = all.subspan(1, 2);
    CHECK(part.data() == room.data() + 1);
    CHECK(part.size() == 2);
    const words back = there.last(1);
    CHECK(&back.front() == &room[3]);
    CHECK(&all.back() == &room[3]);
    CHECK(all.begin() == room.data());
    CHECK(all.end() - all.begin() == 4);
}

} // namespace slice_tests
