// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ring between an interrupt and the main loop: order, a full ring, the wrap of its counters, and one
// writer together with one reader.
#include <doctest/doctest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

#include <servobus/line/ring.hpp>

#include <tests/support/scripted_port.hpp>

namespace ring_tests {

using servobus::byte_buffer;
using servobus::ring;
using tests::byte_list;

namespace {
template <class Ring> constexpr std::size_t capacity_of = 0;
template <std::size_t N> constexpr std::size_t capacity_of<ring<N>> = N;
template <std::size_t N> constexpr bool is_a_capacity = requires { typename ring<N>; };
static_assert(is_a_capacity<2> && is_a_capacity<4> && is_a_capacity<16384> && is_a_capacity<32768>);
static_assert(!is_a_capacity<0> && !is_a_capacity<1> && !is_a_capacity<3> && !is_a_capacity<6>);
static_assert(!is_a_capacity<32767> && !is_a_capacity<32769> && !is_a_capacity<65536>);
} // namespace

TEST_CASE("a ring gives back what was put in, in order, and no more") {
    ring<8> r;
    byte_list out(16, 0xA5);
    CHECK(r.pop(out) == 0);
    CHECK(r.is_empty());
    for (std::uint8_t i = 0; i < 5; ++i) CHECK(r.push(i));
    CHECK_FALSE(r.is_empty());
    CHECK(r.pop(byte_buffer{out}.first(3)) == 3);
    CHECK(out[0] == 0);
    CHECK(out[2] == 2);
    CHECK(out[3] == 0xA5);
    CHECK(r.pop(out) == 2);
    CHECK(out[0] == 3);
    CHECK(out[1] == 4);
    CHECK(out[2] == 2);
    CHECK(r.pop(out) == 0);
    CHECK(r.pop(byte_buffer{}) == 0);
}

TEST_CASE_TEMPLATE("a full ring holds its whole capacity, and drops and counts the bytes that come then",
                   Ring, ring<2>, ring<4>, ring<256>, ring<32768>) {
    Ring r;
    std::uint32_t held = 0;
    while (r.push(static_cast<std::uint8_t>(held & 0xFF))) REQUIRE(++held <= 32768);
    CHECK(held == capacity_of<Ring>);
    CHECK_FALSE(r.is_empty());
    CHECK(sizeof(Ring) > held);
    CHECK(r.overruns() == 1);
    CHECK_FALSE(r.push(0xEE));
    CHECK(r.overruns() == 2);
    byte_list out(40'000);
    REQUIRE(r.pop(out) == held);
    bool is_same = true;
    for (std::uint32_t i = 0; i < held; ++i) is_same = is_same && out[i] == (i & 0xFF);
    CHECK(is_same);
    CHECK(r.push(1));
    CHECK(r.overruns() == 2);
}

TEST_CASE("a ring's counters wrap without loss") {
    ring<16> r;
    tests::dice random{16};
    std::uint8_t next_in = 0;
    std::uint8_t next_out = 0;
    std::uint64_t moved = 0;
    byte_list out(16);
    while (moved < 300'000) {
        for (std::uint32_t n = random.below(17); n > 0; --n) {
            if (r.push(next_in)) ++next_in;
        }
        const std::size_t wanted = random.below(17);
        const std::uint16_t n = r.pop(byte_buffer{out}.first(wanted));
        REQUIRE(n <= wanted);
        for (std::uint16_t i = 0; i < n; ++i) REQUIRE(out[i] == next_out++);
        moved += n;
    }
}

TEST_CASE("clearing drops what is there and nothing that comes later") {
    ring<4> r;
    for (std::uint8_t i = 0; i < 4; ++i) r.push(i);
    r.clear();
    byte_list out(4);
    CHECK(r.pop(out) == 0);
    CHECK(r.push(9));
    CHECK(r.pop(out) == 1);
    CHECK(out[0] == 9);
}

TEST_CASE("a concurrent writer and reader lose nothing but what is counted") {
    ring<64> r;
    constexpr std::uint32_t total = 400'000;
    std::uint32_t put = 0;
    std::atomic<bool> is_over{false};
    std::thread writer{[&] {
        for (std::uint32_t i = 0; i < total; ++i) {
            // The n-th byte that fits is n, so that a lost or doubled one is noticed.
            if (r.push(static_cast<std::uint8_t>(put & 0xFF))) ++put;
        }
        is_over = true;
    }};
    std::uint32_t got = 0;
    bool in_order = true;
    byte_list out(64);
    for (;;) {
        const bool last = is_over;
        const std::uint16_t n = r.pop(out);
        for (std::uint16_t i = 0; i < n; ++i) in_order = in_order && out[i] == ((got + i) & 0xFF);
        got += n;
        if (last && n == 0) break;
    }
    writer.join();
    CHECK(in_order);
    CHECK(got == put);
    CHECK(static_cast<std::uint16_t>(total - put) == r.overruns());
}

} // namespace ring_tests
