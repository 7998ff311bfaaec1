// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Requests and responses of functions 03, 04, 06 and 10h: built and parsed, at compile time and at run time.
// Every malformed one has its own error, and no byte outside a span is touched. The examples of the standard
// (Modbus Application Protocol V1.1b3, 6.3, 6.4, 6.6, 6.12) are used as they are printed.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <servobus/modbus/pdu.hpp>

#include <tests/support/function_cases.hpp>
#include <tests/support/scripted_port.hpp>

namespace pdu_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::built_pdu;
using tests::byte_list;

namespace {

constexpr function holding = function::read_holding_registers;
constexpr function input = function::read_input_registers;

constexpr auto read_pdu(function code, std::uint16_t address, std::uint16_t quantity) {
    built_pdu<5> b;
    b.size = put_read_request(b.data, code, address, quantity);
    return b;
}
constexpr auto write_pdu(std::uint16_t address, std::uint16_t value) {
    built_pdu<5> b;
    b.size = put_write_request(b.data, address, value);
    return b;
}
template <std::size_t N>
constexpr auto write_pdu(std::uint16_t address, const std::array<std::uint16_t, N>& values) {
    built_pdu<6 + 2 * N> b;
    b.size = put_write_request(b.data, address, std::span<const std::uint16_t>{values});
    return b;
}
constexpr auto exception_pdu(std::uint8_t code, std::uint8_t number) {
    built_pdu<2> b;
    b.size = put_exception(b.data, code, number);
    return b;
}

// The standard's examples.
static_assert(same_bytes(read_pdu(holding, 0x006B, 3), hex("03 00 6B 00 03")));
static_assert(same_bytes(read_pdu(input, 0x0008, 1), hex("04 00 08 00 01")));
static_assert(same_bytes(write_pdu(0x0001, 0x0003), hex("06 00 01 00 03")));
static_assert(same_bytes(write_pdu(0x0001, std::array<std::uint16_t, 2>{0x000A, 0x0102}),
                         hex("10 00 01 00 02 04 00 0A 01 02")));
static_assert(same_bytes(exception_pdu(0x03, 2), hex("83 02")));
static_assert(same_bytes(exception_pdu(0x90, 255), hex("90 FF")));

// Their limits.
static_assert(read_pdu(holding, 0, 125).size == 5);
static_assert(read_pdu(holding, 0xFFFF, 1).size == 5);
static_assert(read_pdu(holding, 0xFF83, 125).size == 5);

template <class Text> constexpr errc request_error(const Text& text) { return parse_request(text).error(); }
template <class Text> constexpr errc response_error(const Text& text) { return parse_response(text).error(); }

constexpr auto standard_read = hex("03 00 6B 00 03");
static_assert(parse_request(standard_read)->code == 0x03);
static_assert(parse_request(standard_read)->address == 0x006B);
static_assert(parse_request(standard_read)->quantity == 3);
static_assert(parse_request(standard_read)->values().size() == 0);
constexpr auto standard_write = hex("10 00 01 00 02 04 00 0A 01 02");
static_assert(parse_request(standard_write)->quantity == 2);
static_assert(parse_request(standard_write)->values().size() == 2);
static_assert(parse_request(standard_write)->values()[0] == 0x000A);
static_assert(parse_request(standard_write)->values()[1] == 0x0102);
constexpr auto standard_response = hex("03 06 02 2B 00 00 00 64");
static_assert(parse_response(standard_response)->quantity == 3);
static_assert(parse_response(standard_response)->values()[0] == 0x022B);
static_assert(parse_response(standard_response)->values()[2] == 0x0064);
constexpr auto standard_exception = hex("83 02");
static_assert(parse_response(standard_exception)->is_exception);
static_assert(parse_response(standard_exception)->code == 0x03);
static_assert(parse_response(standard_exception)->exception == 2);

// Every malformed request has its own error.
static_assert(request_error(hex("")) == errc::too_short);
static_assert(request_error(hex("03")) == errc::too_short);
static_assert(request_error(hex("03 00 6B 00")) == errc::too_short);
static_assert(request_error(hex("06 00 01 00")) == errc::too_short);
static_assert(request_error(hex("10 00 01 00 02")) == errc::too_short);
static_assert(request_error(hex("03 00 6B 00 03 00")) == errc::too_long);
static_assert(request_error(hex("06 00 01 00 03 00")) == errc::too_long);
static_assert(request_error(hex("01 00 00 00 01")) == errc::wrong_function);
static_assert(request_error(hex("83 00 00 00 01")) == errc::wrong_function);
static_assert(request_error(hex("03 00 00 00 00")) == errc::wrong_quantity);
static_assert(request_error(hex("04 00 00 00 7E")) == errc::wrong_quantity);
static_assert(request_error(hex("03 00 00 01 01")) == errc::wrong_quantity);
static_assert(request_error(hex("10 00 00 00 00 00")) == errc::wrong_quantity);
static_assert(request_error(hex("10 00 01 00 02 04 00 0A 01")) == errc::wrong_byte_count);
static_assert(request_error(hex("10 00 01 00 02 04 00 0A 01 02 03")) == errc::wrong_byte_count);
static_assert(request_error(hex("10 00 01 00 01 04 00 0A 01 02")) == errc::wrong_byte_count);
static_assert(request_error(hex("10 00 01 00 02 03 00 0A 01")) == errc::wrong_byte_count);
static_assert(request_error(hex("03 FF FF 00 02")) == errc::wrong_address);
static_assert(request_error(hex("03 FF FF 00 01")) == errc::ok);
static_assert(request_error(hex("10 FF FF 00 02 04 00 00 00 00")) == errc::wrong_address);

// Every malformed response has its own error, too.
static_assert(response_error(hex("")) == errc::too_short);
static_assert(response_error(hex("03")) == errc::too_short);
static_assert(response_error(hex("83")) == errc::too_short);
static_assert(response_error(hex("83 02 00")) == errc::too_long);
static_assert(response_error(hex("03 00")) == errc::wrong_byte_count);
static_assert(response_error(hex("03 03 00 01 02")) == errc::wrong_byte_count);
static_assert(response_error(hex("03 04 00 01")) == errc::wrong_byte_count);
static_assert(response_error(hex("03 02 00 01 02")) == errc::wrong_byte_count);
static_assert(response_error(hex("06 00 01 00")) == errc::too_short);
static_assert(response_error(hex("06 00 01 00 03 00")) == errc::too_long);
static_assert(response_error(hex("10 00 01 00 02 04")) == errc::too_long);
static_assert(response_error(hex("10 00 01 00 00")) == errc::wrong_quantity);
static_assert(response_error(hex("10 00 01 00 7C")) == errc::wrong_quantity);
static_assert(response_error(hex("10 00 01 00 7B")) == errc::ok);
static_assert(response_error(hex("01 01 00")) == errc::wrong_function);

// Guard bytes on both sides of a span of exactly `size` bytes.
struct guarded {
    explicit guarded(std::size_t size) : memory(size + 16, 0xA5), size_{size} {}
    byte_buffer inside() { return byte_buffer{memory}.subspan(8, size_); }
    bool are_guards_whole() const {
        for (std::size_t i = 0; i < 8; ++i) {
            if (memory[i] != 0xA5 || memory[memory.size() - 1 - i] != 0xA5) return false;
        }
        return true;
    }
    bool is_untouched() const {
        for (const std::uint8_t b : memory) {
            if (b != 0xA5) return false;
        }
        return true;
    }
    byte_list memory;

  private:
    std::size_t size_;
};

} // namespace

TEST_CASE("a request is built the same at run time as at compile time") {
    for (const std::uint16_t address : std::array<std::uint16_t, 4>{0x0000, 0x006B, 0x2088, 0xFF83}) {
        for (std::uint16_t quantity = 1; quantity <= 125; ++quantity) {
            byte_list out(5);
            REQUIRE(put_read_request(out, input, address, quantity) == 5);
            const byte_list expected{4, tests::high_byte(address), tests::low_byte(address), 0,
                                     static_cast<std::uint8_t>(quantity)};
            REQUIRE(out == expected);
        }
    }
}

TEST_CASE("a read of 0 or more than 125 registers, or past 0xFFFF, is not built at run time") {
    guarded g{5};
    for (const unsigned quantity : {0u, 126u, 127u, 256u, 0xFFFFu}) {
        CHECK(put_read_request(g.inside(), holding, 0, static_cast<std::uint16_t>(quantity)) == 0);
    }
    CHECK(put_read_request(g.inside(), holding, 0xFFFF, 2) == 0);
    CHECK(put_read_request(g.inside(), holding, 0xFF84, 125) == 0);
    CHECK(g.is_untouched());
}

TEST_CASE("a write of 0 or more than 123 registers, or past 0xFFFF, is not built at run time") {
    guarded g{300};
    const std::vector<std::uint16_t> words(0x1'0001, 7);
    const std::span<const std::uint16_t> all{words};
    for (const std::size_t n :
         {std::size_t{0}, std::size_t{124}, std::size_t{256}, std::size_t{0x1'0000}, std::size_t{0x1'0001}}) {
        CHECK(put_write_request(g.inside(), 0, all.first(n)) == 0);
    }
    CHECK(put_write_request(g.inside(), 0xFFFF, all.first(2)) == 0);
    CHECK(put_write_request(g.inside(), 0xFF86, all.first(123)) == 0);
    CHECK(g.is_untouched());
    CHECK(put_write_request(g.inside(), 0xFF85, all.first(123)) == 252);
    CHECK(g.are_guards_whole());
}

TEST_CASE("a buffer that is a byte too small is not written, one that fits is filled to the last byte") {
    const std::array<std::uint16_t, 3> words{0x0102, 0x0304, 0x0506};
    for (std::size_t size = 0; size <= 14; ++size) {
        CAPTURE(size);
        guarded read{size};
        CHECK(put_read_request(read.inside(), holding, 1, 1) == (size < 5 ? 0 : 5));
        CHECK(read.are_guards_whole());
        guarded write{size};
        CHECK(put_write_request(write.inside(), 1, std::uint16_t{1}) == (size < 5 ? 0 : 5));
        CHECK(write.are_guards_whole());
        guarded many{size};
        CHECK(put_write_request(many.inside(), 1, words) == (size < 12 ? 0 : 12));
        CHECK(many.are_guards_whole());
        guarded refusal{size};
        CHECK(put_exception(refusal.inside(), 3, 4) == (size < 2 ? 0 : 2));
        CHECK(refusal.are_guards_whole());
        if (size < 2) CHECK(refusal.is_untouched());
        if (size < 12) CHECK(many.is_untouched());
    }
}

TEST_CASE("every request that is built is parsed into the same fields") {
    std::vector<std::uint16_t> words;
    for (std::uint16_t n = 1; n <= 123; ++n) {
        words.push_back(static_cast<std::uint16_t>(n * 517));
        byte_list pdu(6 + 2 * words.size());
        REQUIRE(put_write_request(pdu, 0x2030, words) == pdu.size());
        const auto r = parse_request(pdu);
        REQUIRE(r);
        REQUIRE(r->code == 0x10);
        REQUIRE(r->address == 0x2030);
        REQUIRE(r->quantity == n);
        REQUIRE(r->values().size() == n);
        for (std::uint16_t i = 0; i < n; ++i) REQUIRE(r->values()[i] == words[i]);
    }
    for (unsigned value = 0; value <= 0xFFFF; value += 257) {
        byte_list pdu(5);
        put_write_request(pdu, static_cast<std::uint16_t>(~value & 0xFFFFu),
                          static_cast<std::uint16_t>(value));
        const auto r = parse_request(pdu);
        REQUIRE(r);
        REQUIRE(r->address == (~value & 0xFFFFu));
        REQUIRE(r->quantity == 1);
        REQUIRE(r->values()[0] == value);
        const auto same = parse_response(pdu); // the acknowledgement of 06 is its request
        REQUIRE(same);
        REQUIRE(same->address == r->address);
        REQUIRE(same->values()[0] == value);
    }
}

TEST_CASE("every function code but 03, 04, 06 and 10h is a wrong function") {
    for (unsigned code = 0; code <= 255; ++code) {
        CAPTURE(code);
        const byte_list pdu{static_cast<std::uint8_t>(code), 0, 1, 0, 1};
        const bool is_known = code == 3 || code == 4 || code == 6 || code == 16;
        CHECK((parse_request(pdu).error() == errc::wrong_function) == !is_known);
        if (code < 0x80) {
            CHECK((parse_response(pdu).error() == errc::wrong_function) == !is_known);
        } else {
            CHECK(parse_response(pdu).error() == errc::too_long);
        }
    }
}

TEST_CASE("G12: an exception response keeps every number from 0 to 255 and its function") {
    for (unsigned number = 0; number <= 255; ++number) {
        for (const unsigned code : {0x03u, 0x04u, 0x06u, 0x10u, 0x2Bu, 0x7Fu}) {
            byte_list pdu(2);
            REQUIRE(put_exception(pdu, static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(number)) ==
                    2);
            const auto r = parse_response(pdu);
            REQUIRE(r);
            REQUIRE(r->is_exception);
            REQUIRE(r->code == code);
            REQUIRE(r->exception == number);
        }
    }
}

TEST_CASE("a PDU of no bytes is too short, in either direction") {
    CHECK(parse_request(bytes{}).error() == errc::too_short);
    CHECK(parse_response(bytes{}).error() == errc::too_short);
}

TEST_CASE("the acknowledgement of a write of several registers has a quantity of 1..123, and no other") {
    for (unsigned quantity = 0; quantity <= 0x0180; ++quantity) {
        const byte_list pdu{0x10, 0x00, 0x20, tests::high_byte(quantity), tests::low_byte(quantity)};
        const auto r = parse_response(pdu);
        if (quantity >= 1 && quantity <= 123) {
            REQUIRE(r);
            REQUIRE(r->quantity == quantity);
        } else {
            REQUIRE(r.error() == errc::wrong_quantity);
        }
    }
}

TEST_CASE("a read response has as many words as fit a PDU, 1..125, and no more") {
    for (std::size_t count = 0; count <= 255; ++count) {
        CAPTURE(count);
        byte_list pdu(2 + count, 0x11);
        pdu[0] = 0x03;
        pdu[1] = static_cast<std::uint8_t>(count);
        const bool is_sound = count != 0 && count % 2 == 0 && count <= 250;
        CHECK(static_cast<bool>(parse_response(pdu)) == is_sound);
    }
}

TEST_CASE("a request PDU of any length and byte count is accepted only if they agree") {
    for (std::size_t data = 0; data <= 260; ++data) {
        for (unsigned quantity = 0; quantity <= 130; ++quantity) {
            byte_list pdu(6 + data);
            pdu[0] = 0x10;
            pdu[4] = static_cast<std::uint8_t>(quantity);
            pdu[5] = static_cast<std::uint8_t>(data & 0xFF);
            const bool is_sound = data == 2 * quantity && quantity >= 1 && quantity <= 123;
            REQUIRE(static_cast<bool>(parse_request(pdu)) == is_sound);
        }
    }
}

TEST_CASE("a text in hex is converted to its bytes, in either case, with or without blanks") {
    constexpr auto spaced = hex(" 01 ab  CD0f ");
    static_assert(same_bytes(spaced, hex("01ABCD0F")));
    static_assert(spaced.size == 4 && spaced.data[0] == 0x01 && spaced.data[1] == 0xAB &&
                  spaced.data[2] == 0xCD && spaced.data[3] == 0x0F);
    static_assert(hex("").size == 0);
    static_assert(!same_bytes(hex("01 02"), hex("01 03")));
    static_assert(!same_bytes(hex("01 02"), hex("01 02 03")));
    const byte_list expected{0x01, 0xAB, 0xCD, 0x0F};
    CHECK(same_bytes(spaced, expected));
    for (int c = -128; c < 128; ++c) {
        CAPTURE(c);
        const std::size_t place = std::string_view{"0123456789ABCDEFabcdef"}.find(static_cast<char>(c));
        const std::size_t digit = place == std::string_view::npos ? 0xFF : place < 16 ? place : place - 6;
        CHECK(servobus::hex_digit(static_cast<char>(c)) == digit);
    }
}

TEST_CASE("a response is parsed only if its byte count is that of its data, and its registers exist") {
    for (std::size_t data = 0; data <= 255; ++data) {
        byte_list pdu(2 + data, 0x11);
        pdu[0] = 0x04;
        for (const std::size_t count : {data - 2, data - 1, data, data + 1, data + 2}) {
            CAPTURE(data);
            CAPTURE(count);
            pdu[1] = static_cast<std::uint8_t>(count);
            const bool is_sound = pdu[1] == data && data != 0 && data % 2 == 0 && data <= 250;
            CHECK(static_cast<bool>(parse_response(pdu)) == is_sound);
        }
    }
    for (const unsigned quantity : {0u, 1u, 2u, 122u, 123u, 124u}) {
        for (const unsigned address : {0u, 0xFF84u, 0xFF85u, 0xFF86u, 0xFFFEu, 0xFFFFu}) {
            CAPTURE(quantity);
            CAPTURE(address);
            const byte_list pdu{0x10, static_cast<std::uint8_t>(address >> 8),
                                static_cast<std::uint8_t>(address), 0x00,
                                static_cast<std::uint8_t>(quantity)};
            const bool is_possible = quantity >= 1 && quantity <= 123;
            const auto r = parse_response(pdu);
            CHECK(static_cast<bool>(r) == (is_possible && address + quantity <= 0x1'0000));
            if (!r) CHECK(r.error() == (is_possible ? errc::wrong_address : errc::wrong_quantity));
        }
    }
}

} // namespace pdu_tests
