// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Bytes 00 or FF at the beginning of a burst, as an RS-485 driver sends them that is switched on. A server
// skips them, and still executes a broadcast, whose address is 00.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/modbus/server.hpp>

#include <tests/support/served_words.hpp>

namespace server_leading_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::operator+;
using namespace tests::served;

namespace {

byte_list write_to(std::uint8_t node_address, std::uint8_t value) {
    return framed({node_address, 0x06, 0, 2, 0, value});
}
byte_list leading(std::size_t zeros, std::size_t ones) {
    return byte_list(zeros, 0x00) + byte_list(ones, 0xFF);
}

} // namespace

TEST_CASE("G5, G13: a server skips up to k bytes 00 or FF after a gap, and not one more") {
    for (const auto mode : both_modes) {
        for (const unsigned k : {0u, 1u, 4u, 9u, 255u}) {
            for (const std::uint8_t node_address : std::array<std::uint8_t, 6>{1, 3, 16, 23, 0x21, 247}) {
                for (std::size_t n = 0; n <= 11; ++n) {
                    for (const byte_list& lead : {leading(n, 0), leading(0, n), leading(n / 2, n - n / 2)}) {
                        CAPTURE(static_cast<int>(mode));
                        CAPTURE(k);
                        CAPTURE(node_address);
                        CAPTURE(n);
                        modbus::server_rules rules;
                        rules.leading_bytes = static_cast<std::uint8_t>(k);
                        bench b{mode, node_address, rules};
                        b.receive(write_to(node_address, 3));
                        REQUIRE(b.response() == write_to(node_address, 3));
                        b.t3_5();
                        b.receive(lead + write_to(node_address, 5));
                        const byte_list got = b.response();
                        REQUIRE(got == (n <= k ? write_to(node_address, 5) : byte_list{}));
                        REQUIRE(b.store.words[2] == (n <= k ? 5 : 3));
                    }
                }
            }
        }
    }
    CHECK(modbus::server_rules{}.leading_bytes == 4);
}

TEST_CASE("G5, G13: a broadcast is executed where it ends, with and without skipped bytes before it") {
    const byte_list broadcast = framed({0, 0x06, 0, 2, 0, 5});
    const byte_list two = framed({0, 0x10, 0, 2, 0, 2, 4, 0, 5, 0, 6});
    for (const auto mode : both_modes) {
        for (const std::uint8_t node_address : std::array<std::uint8_t, 5>{1, 6, 16, 0x21, 247}) {
            for (const byte_list& frame : {broadcast, two}) {
                for (std::size_t n = 0; n <= 4; ++n) {
                    for (const byte_list& lead : {leading(n, 0), leading(0, n)}) {
                        CAPTURE(node_address);
                        CAPTURE(n);
                        bench b{mode, node_address};
                        b.receive(lead + frame);
                        if (n == 0) REQUIRE(b.store.words[2] == 5); // immediately
                        b.gap();
                        REQUIRE(b.store.words[2] == 5);
                        REQUIRE(b.store.accesses == 1);
                        REQUIRE(!b.server.is_answering());
                        b.receive(write_to(node_address, 7));
                        REQUIRE(b.response() == write_to(node_address, 7));
                    }
                }
            }
        }
    }
}

TEST_CASE("G13: bytes 00 or FF inside a burst, and any others, are not skipped") {
    for (const auto mode : both_modes) {
        for (const byte_list& before :
             {write_to(2, 5), framed({0, 0x06, 0, 3, 0, 9}), framed({9, 0x65, 1, 2}), byte_list{0x41}}) {
            for (const byte_list& between : {leading(1, 0), leading(0, 1), leading(2, 1)}) {
                bench b{mode};
                b.receive(before + between + write_to(1, 5));
                b.gap();
                CHECK(b.store.words[2] == 0);
                CHECK(!b.server.is_answering());
                // After a pause of t3.5 they are, where the end of the frame before is known.
                if (before.size() == 1) continue;
                b.receive(before);
                b.t3_5();
                b.receive(between + write_to(1, 5));
                CHECK(b.response() == write_to(1, 5));
            }
        }
    }
}

TEST_CASE("G5, G41: bytes 00 or FF before the frames of other nodes do not delay a request that follows") {
    for (const auto mode : both_modes) {
        for (const byte_list& lead : {leading(1, 0), leading(0, 1), leading(4, 0), leading(1, 3)}) {
            for (const byte_list& other :
                 {framed({9, 0x03, 4, 1, 2, 3, 4}), framed({9, 0x01, 1, 7}), framed({9, 0x65, 1, 2, 3}),
                  framed({0x21, 0x06, 0, 2, 0, 9}), framed({0x21, 0x65, 0, 2, 0, 9})}) {
                bench b{mode};
                for (int i = 0; i < 5; ++i) {
                    b.t3_5();
                    b.receive(lead + other);
                    b.t3_5();
                    b.receive(write_to(1, 5));
                    CHECK(b.server.is_answering());
                    CHECK(b.response() == write_to(1, 5));
                }
            }
        }
    }
}

TEST_CASE(
    "G14: a broadcast of 256 bytes after a byte 00 ends where it ends, and the next request has a response") {
    byte_list broadcast{0, 0x0F, 0, 0, 0x07, 0xB8, 0xF7};
    for (unsigned i = 0; i < 0xF7; ++i) broadcast.push_back(static_cast<std::uint8_t>(i * 7 + 1));
    REQUIRE(framed(broadcast).size() == modbus::max_frame);
    for (std::size_t n = 0; n <= 2; ++n) {
        CAPTURE(n);
        bench b{modbus::timing_mode::host};
        b.receive(leading(n, 0) + framed(broadcast));
        b.t3_5();
        b.receive(write_to(1, 5));
        CHECK(b.response() == write_to(1, 5));
    }
}

TEST_CASE(
    "G13: a write inside a broadcast of unknown length is not executed by skipping the broadcast's address") {
    // Skipping the 00, node 65h responds to a read; then comes a write to the server.
    for (const auto mode : both_modes) {
        const byte_list response = framed({0x65, 0x03, 2, 1, 2});
        bench b{mode};
        const byte_list all = framed(byte_list{0} + response + write_to(1, 9));
        b.receive(all);
        b.gap();
        CHECK(b.store.accesses == 0);
        b.receive(write_to(1, 5));
        CHECK(b.response() == write_to(1, 5));
    }
}

TEST_CASE(
    "G13: a write that begins after the address of a broadcast is not executed if the broadcast goes on") {
    // In the one reading a broadcast write of several registers, in the other a write to node 16 that ends
    // earlier.
    unsigned found = 0;
    for (unsigned low = 0; low < 256; ++low) {
        // 10 06 low 00 02 04 are node, function, address and value; the CRC would be the first register.
        const byte_list own = framed({0x10, 0x06, tests::low_byte(low), 0, 2, 4});
        const byte_list all = framed(byte_list{0} + own + byte_list{0, 7});
        REQUIRE(all.size() == 13);
        ++found;
        for (const auto mode : both_modes) {
            bench b{mode, 0x10};
            b.receive(all);
            b.gap();
            REQUIRE(!b.server.is_answering());
            REQUIRE(b.store.accesses == 1);
            REQUIRE(b.store.words[(0x0600 + low) % 16] == (own[6] << 8 | own[7]));
        }
    }
    CHECK(found == 256);
}

TEST_CASE(
    "G5: after a byte 00 or FF and an address that is no function a request is executed where it ends") {
    for (const auto mode : both_modes) {
        for (const std::uint8_t node_address : std::array<std::uint8_t, 3>{0x81, 0x85, 247}) {
            for (const byte_list& lead : {leading(1, 0), leading(0, 1), leading(4, 0)}) {
                CAPTURE(static_cast<int>(mode));
                CAPTURE(node_address);
                CAPTURE(lead);
                bench b{mode, node_address};
                b.receive(lead + write_to(node_address, 5));
                CHECK(b.server.is_answering());
                CHECK(b.store.words[2] == 5);
            }
        }
    }
}

TEST_CASE("G13, G14: a byte 00 or FF that is the server's address is not skipped") {
    for (const auto mode : both_modes) {
        for (const std::uint8_t code : {std::uint8_t{0x00}, std::uint8_t{0x65}, std::uint8_t{0x81}}) {
            CAPTURE(static_cast<int>(mode));
            CAPTURE(code);
            bench b{mode, 0xFF};
            b.receive(framed({0xFF, code}));
            CHECK(b.response() == tests::exception_response(0xFF, code, 1));
            b.t3_5();
            b.receive(write_to(0xFF, 5));
            CHECK(b.response() == write_to(0xFF, 5));
        }
    }
}

} // namespace server_leading_tests
