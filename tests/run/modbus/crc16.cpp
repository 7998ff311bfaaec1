// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every CRC engine against the bit-by-bit one, in constant expressions and at run time: the published check
// value, all lengths at all alignments, messages cut in two and in three, and the residue of a good frame.

#include <servobus/modbus/crc16.hpp>
#include <servobus/modbus/crc_tables.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace crc16_tests {

namespace {

using namespace servobus::modbus;
using view = std::span<const std::uint8_t>;

#define ALL_ENGINES                                                                                          \
    crc_bitwise, crc_table16, crc_table256, crc_slicing8, crc_trinomial<8>, crc_trinomial<16>,               \
        crc_trinomial<32>, crc_trinomial<64>, default_crc

template <class... Engines> struct engines {
    static constexpr bool all(auto holds) { return (... && holds.template operator()<Engines>()); }
};
using all_engines = engines<ALL_ENGINES>;

/// Bytes without a pattern, the same in every run.
template <std::size_t Size> constexpr std::array<std::uint8_t, Size> noise(std::uint32_t seed) {
    std::array<std::uint8_t, Size> bytes{};
    for (std::uint8_t& byte : bytes) {
        seed = seed * 1664525U + 1013904223U;
        byte = static_cast<std::uint8_t>(seed >> 24);
    }
    return bytes;
}

template <crc_engine Engine> constexpr std::uint16_t byte_by_byte(view message) {
    auto state = Engine::begin();
    for (const std::uint8_t byte : message) state = Engine::update(state, byte);
    return Engine::end(state);
}

template <crc_engine Engine> constexpr std::uint16_t in_two(view message, std::size_t cut) {
    return Engine::end(
        Engine::update(Engine::update(Engine::begin(), message.first(cut)), message.subspan(cut)));
}

template <crc_engine Engine>
constexpr std::uint16_t in_three(view message, std::size_t from, std::size_t to) {
    auto state = Engine::update(Engine::begin(), message.first(from));
    state = Engine::update(state, message.subspan(from, to - from));
    return Engine::end(Engine::update(state, message.subspan(to)));
}

constexpr std::array<std::uint8_t, 9> digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};

static_assert(all_engines::all([]<class Engine>() { return crc_engine<Engine>; }));
static_assert(all_engines::all([]<class Engine>() { return crc16<Engine>(digits) == 0x4B37; }));
static_assert(all_engines::all([]<class Engine>() { return byte_by_byte<Engine>(digits) == 0x4B37; }));
static_assert(all_engines::all([]<class Engine>() { return crc16<Engine>({}) == 0xFFFF; }));
static_assert(crc16(digits) == 0x4B37);

// A byte that is not in the message must be noticed.
static_assert(all_engines::all([]<class Engine>() {
    return crc16<Engine>(view{digits}.first(8)) != 0x4B37;
}));

static_assert(all_engines::all([]<class Engine>() {
    constexpr auto message = noise<40>(1);
    for (std::size_t length = 0; length <= message.size(); ++length) {
        const view part = view{message}.first(length);
        if (crc16<Engine>(part) != crc16<crc_bitwise>(part)) return false;
    }
    return true;
}));

static_assert(all_engines::all([]<class Engine>() {
    constexpr auto message = noise<25>(2);
    for (std::size_t cut = 0; cut <= message.size(); ++cut)
        if (in_two<Engine>(message, cut) != crc16<crc_bitwise>(message)) return false;
    return true;
}));

// Read two registers from 0000h at node 1: the CRC is sent as C4h 0Bh.
constexpr std::array<std::uint8_t, 8> request{0x01, 0x03, 0x00, 0x00, 0x00, 0x02, 0xC4, 0x0B};
static_assert(all_engines::all([]<class Engine>() {
    return crc16<Engine>(view{request}.first(6)) == 0x0BC4;
}));
static_assert(all_engines::all([]<class Engine>() { return crc16<Engine>(request) == 0; }));

} // namespace

TEST_CASE_TEMPLATE("the check value is the same at run time", Engine, ALL_ENGINES) {
    std::array<std::uint8_t, 9> message = digits;
    const volatile std::uint8_t first = '1';
    message[0] = first;
    CHECK(crc16<Engine>(message) == 0x4B37);
    CHECK(byte_by_byte<Engine>(message) == 0x4B37);
    CHECK(crc16<Engine>({}) == 0xFFFF);
}

TEST_CASE_TEMPLATE("an engine agrees with the bit-by-bit one at every length and alignment", Engine,
                   ALL_ENGINES) {
    constexpr std::size_t longest = 300;
    alignas(8) std::array<std::uint8_t, longest + 8> buffer{};
    for (std::size_t offset = 0; offset != 8; ++offset) {
        buffer = noise<longest + 8>(static_cast<std::uint32_t>(offset));
        for (std::size_t length = 0; length <= longest; ++length) {
            const view message = view{buffer}.subspan(offset, length);
            const std::uint16_t expected = crc16<crc_bitwise>(message);
            CAPTURE(offset);
            CAPTURE(length);
            REQUIRE(crc16<Engine>(message) == expected);
            REQUIRE(byte_by_byte<Engine>(message) == expected);
        }
    }
}

TEST_CASE_TEMPLATE("a message may be cut anywhere", Engine, ALL_ENGINES) {
    alignas(8) const auto buffer = noise<64 + 8>(3);
    for (const std::size_t length : {1U, 2U, 3U, 6U, 7U, 8U, 9U, 15U, 16U, 17U, 25U, 33U, 64U})
        for (const std::size_t offset : {0U, 1U, 2U, 3U, 7U}) {
            const view message = view{buffer}.subspan(offset, length);
            const std::uint16_t expected = crc16<crc_bitwise>(message);
            for (std::size_t from = 0; from <= length; ++from) {
                CAPTURE(offset);
                CAPTURE(length);
                CAPTURE(from);
                REQUIRE(in_two<Engine>(message, from) == expected);
                for (std::size_t to = from; to <= length; ++to)
                    REQUIRE(in_three<Engine>(message, from, to) == expected);
            }
        }
}

TEST_CASE_TEMPLATE("a state continues correctly after any first two bytes", Engine, ALL_ENGINES) {
    // All 65536 remainders occur; the rest takes every length of step.
    constexpr auto rest = noise<15>(4);
    bool equal = true;
    for (std::uint32_t first = 0; first != 0x10000; ++first) {
        const std::array<std::uint8_t, 2> head{static_cast<std::uint8_t>(first & 0xFF),
                                               static_cast<std::uint8_t>(first >> 8)};
        const auto state = Engine::update(Engine::begin(), head);
        const auto reference = crc_bitwise::update(crc_bitwise::begin(), head);
        equal = equal && Engine::end(state) == crc_bitwise::end(reference) &&
                Engine::end(Engine::update(state, rest)) ==
                    crc_bitwise::end(crc_bitwise::update(reference, rest));
    }
    CHECK(equal);
}

TEST_CASE_TEMPLATE("a frame with its own CRC has the CRC zero", Engine, ALL_ENGINES) {
    auto frame = noise<260>(5);
    for (std::size_t length = 0; length + 2 <= frame.size(); ++length) {
        frame = noise<260>(5);
        const std::uint16_t crc = crc16<Engine>(view{frame}.first(length));
        frame[length] = static_cast<std::uint8_t>(crc & 0xFF);
        frame[length + 1] = static_cast<std::uint8_t>(crc >> 8);
        CAPTURE(length);
        REQUIRE(crc16<Engine>(view{frame}.first(length + 2)) == 0);
        frame[length + 1] = static_cast<std::uint8_t>(frame[length + 1] ^ 0x10);
        REQUIRE(crc16<Engine>(view{frame}.first(length + 2)) != 0);
    }
}

TEST_CASE_TEMPLATE("zero bytes after a good frame keep the CRC zero", Engine, ALL_ENGINES) {
    std::array<std::uint8_t, 40> line{};
    for (std::size_t i = 0; i != request.size(); ++i) line[i] = request[i];
    for (std::size_t length = request.size(); length <= line.size(); ++length) {
        CAPTURE(length);
        REQUIRE(crc16<Engine>(view{line}.first(length)) == 0);
    }
    line[20] = 1;
    CHECK(crc16<Engine>(view{line}.first(20)) == 0);
    CHECK(crc16<Engine>(line) != 0);
}

#undef ALL_ENGINES

} // namespace crc16_tests
