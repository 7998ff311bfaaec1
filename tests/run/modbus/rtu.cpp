// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// RTU frames, whole and damaged, and the gaps of a line: t1.5 and t3.5 at every baud rate.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/modbus/crc_tables.hpp>
#include <servobus/modbus/rtu.hpp>

#include <tests/support/scripted_port.hpp>

namespace rtu_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::byte_list;
using tests::framed;

namespace {

constexpr auto write_two = write_frame(1, 0x2088, std::array<std::uint16_t, 2>{0x0064, 0x0064});

// Frames that manuals print.
static_assert(same_bytes(read_frame(1, 0x20AB, 2), hex("01 03 20 AB 00 02 BE 2B")));
static_assert(same_bytes(write_frame(1, 0x200E, 0x08), hex("01 06 20 0E 00 08 E2 0F")));
static_assert(same_bytes(write_two, hex("01 10 20 88 00 02 04 00 64 00 64 23 9C")));
static_assert(same_bytes(read_frame(1, 0x0B11, 2), hex("01 03 0B 11 00 02 96 2A")));
static_assert(same_bytes(read_frame(1, 0x0020, 1), hex("01 03 00 20 00 01 85 C0")));

// The same with the other CRC engines.
static_assert(open_frame<crc_bitwise>(write_two)->address == 1);
static_assert(open_frame<crc_table16>(write_two)->address == 1);
static_assert(open_frame<crc_table256>(write_two)->address == 1);

template <class Text> constexpr errc open_error(const Text& text) { return open_frame(text).error(); }
static_assert(open_error(hex("01 03 20 AB 00 02 BE 2B")) == errc::ok);
static_assert(open_error(hex("01 03 20 AB 00 02 2B BE")) == errc::bad_crc);
static_assert(open_error(hex("01 03 00 20 00 01 85 C1")) == errc::bad_crc);
static_assert(open_error(hex("")) == errc::too_short);
static_assert(open_error(hex("01 7E 80")) == errc::too_short);

// The gaps, in whole microseconds rounded up; a character counts 11 bits.
struct silence {
    std::uint32_t baud;
    std::uint16_t t1_5;
    std::uint16_t t3_5;
};
constexpr silence table[] = {
    {600, 27500, 64167}, {1200, 13750, 32084}, {2400, 6875, 16042}, {4800, 3438, 8021},   {9600, 1719, 4011},
    {14400, 1146, 2674}, {19200, 860, 2006},   {19201, 750, 1750},  {38400, 750, 1750},   {57600, 750, 1750},
    {115200, 750, 1750}, {128000, 750, 1750},  {921600, 750, 1750}, {3000000, 750, 1750},
};
constexpr bool table_holds() {
    for (const silence& s : table) {
        const rtu_timing t = timing_at(s.baud);
        if (t.t1_5 != s.t1_5 || t.t3_5 != s.t3_5) return false;
    }
    return true;
}
static_assert(table_holds());

} // namespace

TEST_CASE("G8: t1.5 and t3.5 are those of the standard at every baud rate") {
    for (const silence& s : table) {
        CAPTURE(s.baud);
        CHECK(timing_at(s.baud).t1_5 == s.t1_5);
        CHECK(timing_at(s.baud).t3_5 == s.t3_5);
        CHECK(timing_at(s.baud, timing_mode::strict).t3_5 == s.t3_5);
    }
}

TEST_CASE("G8: the gaps are never shorter than 1.5 and 3.5 characters of 11 bits, nor longer by 1 us") {
    for (std::uint32_t baud = 600; baud <= 19200; ++baud) {
        const rtu_timing t = timing_at(baud);
        REQUIRE(2.0 * baud * t.t1_5 >= 3 * 11e6);
        REQUIRE(2.0 * baud * (t.t1_5 - 1) < 3 * 11e6);
        REQUIRE(2.0 * baud * t.t3_5 >= 7 * 11e6);
        REQUIRE(2.0 * baud * (t.t3_5 - 1) < 7 * 11e6);
        REQUIRE(1.0 * baud * t.character >= 11e6);
        REQUIRE(1.0 * baud * (t.character - 1) < 11e6);
    }
}

TEST_CASE("a baud rate below 600 counts as 600, and a character takes at least 1 us at any rate") {
    CHECK(timing_at(0).t3_5 == timing_at(600).t3_5);
    CHECK(timing_at(300).t3_5 == timing_at(600).t3_5);
    for (const std::uint32_t baud : {3'000'000u, 12'000'000u, 4'000'000'000u, 0xFFFF'FFFFu}) {
        CAPTURE(baud);
        CHECK(timing_at(baud).character >= 1);
    }
}

TEST_CASE("G7: the gap after a frame is t3.5 in strict timing, and in host timing the pause between bytes if "
          "longer") {
    CHECK(timing_at(9600, timing_mode::strict).visible_gap() == microseconds(4011));
    CHECK(timing_at(9600).visible_gap() == milliseconds(20));
    CHECK(timing_at(1200).visible_gap() == microseconds(32084));
    CHECK(timing_at(115200, timing_mode::host, milliseconds(16)).visible_gap() == milliseconds(16));
}

TEST_CASE("a frame is closed with its CRC, low byte first, in a buffer of exactly its size") {
    for (std::size_t size = 0; size <= 260; ++size) {
        CAPTURE(size);
        byte_list body(size + 1, 0x5A);
        byte_list out = body;
        out.resize(size + 3 + 4, 0xA5);
        const bool is_sound = size >= 1 && size <= 253;
        byte_list small(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size + 2));
        const byte_list before = small;
        CHECK(close_frame(small, size) == 0);
        CHECK(small == before);
        CHECK(close_frame(byte_buffer{out}.first(size + 3), size) == (is_sound ? size + 3 : 0));
        if (!is_sound) continue;
        const byte_list expected = framed(body);
        CHECK(same_bytes(bytes{out}.first(size + 3), expected));
        for (std::size_t i = size + 3; i < out.size(); ++i) CHECK(out[i] == 0xA5);
    }
}

TEST_CASE("a frame is opened into its address and PDU; fewer than 4 or more than 256 bytes are no frame") {
    for (std::size_t size = 0; size <= 300; ++size) {
        CAPTURE(size);
        byte_list f = size < 2 ? byte_list(size) : framed(byte_list(size - 2, 0x33));
        const auto r = open_frame(f);
        if (size < 4) {
            CHECK(r.error() == errc::too_short);
        } else if (size > 256) {
            CHECK(r.error() == errc::too_long);
        } else {
            REQUIRE(r);
            CHECK(r->address == 0x33);
            CHECK(r->pdu.size() == size - 3);
            CHECK(r->pdu.data() == f.data() + 1);
        }
    }
}

TEST_CASE("G2: the CRC detects any wrong byte, and any burst of 16 bits") {
    const byte_list good = framed({0x01, 0x03, 0x04, 0x00, 0x64, 0x00, 0x64});
    REQUIRE(open_frame(good));
    for (std::size_t i = 0; i < good.size(); ++i) {
        for (unsigned wrong = 1; wrong <= 255; ++wrong) {
            byte_list f = good;
            f[i] = static_cast<std::uint8_t>(f[i] ^ wrong);
            REQUIRE(open_frame(f).error() == errc::bad_crc);
        }
    }
    for (std::size_t i = 0; i + 1 < good.size(); ++i) {
        for (unsigned wrong = 1; wrong <= 0xFFFF; ++wrong) {
            byte_list f = good;
            f[i] = static_cast<std::uint8_t>(f[i] ^ (wrong >> 8));
            f[i + 1] = static_cast<std::uint8_t>(f[i + 1] ^ (wrong & 0xFFu));
            REQUIRE(open_frame(f).error() == errc::bad_crc);
        }
    }
}

TEST_CASE("G6: zero bytes after a frame keep its CRC at 0, so that the CRC alone never ends a frame") {
    byte_list f = framed({0x01, 0x06, 0x20, 0x0E, 0x00, 0x08});
    for (int i = 0; i < 16; ++i) {
        CHECK(crc16(f) == 0);
        f.push_back(0);
    }
}

TEST_CASE("frames for read and write are built at run time as at compile time, or have size 0") {
    for (unsigned node_address = 0; node_address <= 255; ++node_address) {
        const auto u = static_cast<std::uint8_t>(node_address);
        CHECK(same_bytes(read_frame(u, 0x20AB, 2), framed({u, 0x03, 0x20, 0xAB, 0, 2})));
        CHECK(same_bytes(read_frame(u, 1, 125, function::read_input_registers),
                         framed({u, 0x04, 0, 1, 0, 125})));
        CHECK(same_bytes(write_frame(u, 0x200E, 7), framed({u, 0x06, 0x20, 0x0E, 0, 7})));
        CHECK(same_bytes(write_frame(u, 0x2088, std::array<std::uint16_t, 2>{1, 0xFFFF}),
                         framed({u, 0x10, 0x20, 0x88, 0, 2, 4, 0, 1, 0xFF, 0xFF})));
    }
    std::uint16_t none = 0;
    std::uint16_t many = 126;
    CHECK(read_frame(1, 0, none).size == 0);
    CHECK(read_frame(1, 0, many).size == 0);
    CHECK(read_frame(1, 0xFFFF, static_cast<std::uint16_t>(none + 2)).size == 0);
}

TEST_CASE("G6, G41: the length of a response follows from its first three bytes") {
    for (const std::uint8_t code : std::array<std::uint8_t, 5>{0x01, 0x02, 0x03, 0x04, 0x17}) {
        CHECK(response_length(code, 4) == 9);
        CHECK(response_length(code, 250) == 255);
    }
    for (const std::uint8_t code : std::array<std::uint8_t, 4>{0x05, 0x06, 0x0F, 0x10})
        CHECK(response_length(code, 0x20) == 8);
    CHECK(response_length(0x16, 0x20) == 10);
    for (unsigned code = 0x80; code <= 255; ++code)
        CHECK(response_length(static_cast<std::uint8_t>(code), 9) == 5);
    unsigned unknown = 0;
    for (unsigned code = 0; code < 0x80; ++code) {
        const bool is_known =
            (code >= 1 && code <= 6) || code == 0x0F || code == 0x10 || code == 0x16 || code == 0x17;
        if (is_known) continue;
        ++unknown;
        CHECK(response_length(static_cast<std::uint8_t>(code), 9) == 0);
    }
    CHECK(unknown == 118);
}

TEST_CASE("G6, G41: the length of a request follows from its first bytes, and is 0 while these are too few") {
    const auto length = [](std::uint8_t code, std::size_t size) {
        std::array<std::uint8_t, 16> begun{};
        begun.fill(20);
        begun[1] = code;
        return request_length(bytes{begun}.first(size));
    };
    for (unsigned code = 0; code <= 255; ++code) {
        CAPTURE(code);
        for (std::size_t size = 0; size <= 16; ++size) {
            CAPTURE(size);
            std::size_t expected = 0;
            if (code >= 1 && code <= 6) expected = size >= 2 ? 8 : 0;
            if (code == 0x0F || code == 0x10) expected = size >= 7 ? 29 : 0;
            if (code == 0x16) expected = size >= 2 ? 10 : 0;
            if (code == 0x17) expected = size >= 11 ? 33 : 0;
            CHECK(length(static_cast<std::uint8_t>(code), size) == expected);
        }
    }
}

TEST_CASE("node addresses are 1..247") {
    for (unsigned node_address = 0; node_address <= 255; ++node_address)
        CHECK(is_node_address(static_cast<std::uint8_t>(node_address)) ==
              (node_address >= 1 && node_address <= 247));
}

} // namespace rtu_tests
