// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Any function of the standard through one check: the requests and responses that it prints (Modbus Application
// Protocol V1.1b3, section 6) are valid, and each response ends where its length rule says. Registers, and codes that
// are none.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/modbus/functions.hpp>
#include <servobus/modbus/growing_response.hpp>

#include <tests/support/function_cases.hpp>

namespace functions_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::ends_where_it_should;
using tests::printed_pdu;

namespace {

static_assert(static_cast<int>(function::read_coils) == 1 &&
              static_cast<int>(function::read_discrete_inputs) == 2 &&
              static_cast<int>(function::write_single_coil) == 5 &&
              static_cast<int>(function::write_multiple_coils) == 15);

struct golden {
    printed_pdu request;
    printed_pdu response;

    constexpr bool is_valid() const {
        return check_request(request) == errc::ok &&
               check_response(request, response).outcome() == outcome::done &&
               ends_where_it_should(request, response);
    }
};
constexpr golden printed[]{
    {"01 00 13 00 13", "01 03 CD 6B 05"},
    {"02 00 C4 00 16", "02 03 AC DB 35"},
    {"03 00 6B 00 03", "03 06 02 2B 00 00 00 64"},
    {"04 00 08 00 01", "04 02 00 0A"},
    {"05 00 AC FF 00", "05 00 AC FF 00"},
    {"06 00 01 00 03", "06 00 01 00 03"},
    {"07", "07 6D"},
    {"08 00 00 A5 37", "08 00 00 A5 37"},
    {"08 00 00 A5 37 00 01", "08 00 00 A5 37 00 01"},
    {"0B", "0B FF FF 01 08"},
    {"0C", "0C 08 00 00 01 08 01 21 20 00"},
    {"0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0A"},
    {"10 00 01 00 02 04 00 0A 01 02", "10 00 01 00 02"},
    {"11", "11 03 42 FF 01"},
    {"16 00 04 00 F2 00 25", "16 00 04 00 F2 00 25"},
    {"17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF", "17 0C 00 FE 0A CD 00 01 00 03 00 0D 00 FF"},
    {"18 04 DE", "18 00 06 00 02 01 B8 12 84"},
    {"18 04 DE", "18 00 02 00 00"},
    {"2B 0E 01 00", "2B 0E 01 01 00 00 02 00 02 41 42 01 00"},
    {"2B 0E 01 00", "2B 0E 01 01 FF 02 02 00 02 41 42 01 01 43"},
};
constexpr bool all_valid() {
    for (const golden& each : printed) {
        if (!each.is_valid()) return false;
    }
    return true;
}
static_assert(all_valid());

constexpr tests::request_case requests[]{
    {"function 0 is none", "00 00 00 00 01", errc::wrong_function},
    {"user-defined", "41 00 00 00 01", errc::wrong_function},
    {"08 of an exception's code", "88 00 00 00 01", errc::wrong_function},
    {"20 is not built here", "14 07 06 00 04 00 01 00 02", errc::wrong_function},
    {"03", "03 00 6B 00 03"},
    {"03 of 126", "03 00 6B 00 7E", errc::wrong_quantity},
    {"10 with a wrong count", "10 00 01 00 01 04 00 0A 01 02", errc::wrong_byte_count},
};
static_assert(tests::all_hold(requests));

constexpr tests::response_case responses[]{
    {"03 with a word too few", "03 00 6B 00 02", "03 02 02 2B", errc::wrong_byte_count},
    {"03 by 04", "03 00 6B 00 01", "04 02 02 2B", errc::wrong_function},
    {"06 at another address", "06 00 01 00 03", "06 00 02 00 03", errc::wrong_address},
    {"06 with another value", "06 00 01 00 03", "06 00 01 00 04", errc::wrong_value},
    {"06 cut", "06 00 01 00 03", "06 00 01 00", errc::too_short},
    {"10 at another address", "10 00 01 00 01 02 00 0A", "10 01 01 00 01", errc::wrong_address},
    {"10 with another quantity", "10 00 01 00 01 02 00 0A", "10 00 01 00 02", errc::wrong_quantity},
    {"10 as its request", "10 00 01 00 01 02 00 0A", "10 00 01 00 01 02 00 0A", errc::too_long},
    {"no request", "", "83 02", errc::bad_argument},
    {"no function", "00", "80 02", errc::bad_argument},
    {"a wrong request", "03 00 6B 00 00", "03 00", errc::bad_argument},
};
static_assert(tests::all_hold(responses));

std::size_t least(bytes request, bytes begun) { return growing_response{request}.least_length(begun); }

} // namespace

TEST_CASE("what the standard prints is valid and ends where its length rule says") {
    for (const golden& each : printed) {
        CAPTURE(each.request.data[0]);
        CHECK(each.is_valid());
    }
    tests::check_all(requests);
    tests::check_all(responses);
}

TEST_CASE("an exception is its function xor 80h, has two bytes and keeps its number") {
    for (const golden& each : printed) {
        const std::vector<std::uint8_t> refusal{static_cast<std::uint8_t>(each.request.data[0] ^ 0x80), 0xAB};
        const status found = check_response(each.request, refusal);
        CHECK((found == errc::exception && found.exception() == 0xAB && found.outcome() == outcome::refused));
        CHECK(ends_where_it_should(each.request, refusal));
    }
}

TEST_CASE("a response's length is known as soon as its bytes determine it") {
    CHECK(least(hex("01 00 13 00 13"), bytes{}) == 2);
    CHECK(least(hex("01 00 13 00 13"), hex("01")) == 2);
    CHECK(least(hex("01 00 13 00 13"), hex("01 03")) == 5);
    CHECK(least(hex("06 00 01 00 03"), hex("06 00")) == 5);
    CHECK(least(hex("07"), hex("07 6D")) == 2);
    CHECK(least(hex("18 04 DE"), hex("18 00")) == 3);
    CHECK(least(hex("18 04 DE"), hex("18 00 06")) == 9);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E")) == 7);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E 01 01 00 00 02")) == 9);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E 01 01 00 00 02 00 02")) == 13);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E 01 01 00 00 02 00 02 41 42 01 00")) == 13);
}

TEST_CASE("a length that no PDU has ends where it shows") {
    CHECK(least(hex("11"), hex("11 FB")) == 253);
    CHECK(least(hex("11"), hex("11 FC")) == 2);
    CHECK(least(hex("18 04 DE"), hex("18 00 FA")) == 253);
    CHECK(least(hex("18 04 DE"), hex("18 00 FB")) == 3);
    CHECK(least(hex("18 04 DE"), hex("18 FF FF")) == 3);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E 01 01 00 00 01 00 F4")) == 253);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E 01 01 00 00 01 00 F5")) == 9);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E 01 01 00 00 02 00 F2")) == 253);
    CHECK(least(hex("2B 0E 01 00"), hex("2B 0E 01 01 00 00 02 00 F3")) == 9);
    CHECK(least(hex("01 00 13 00 13"), hex("02 03")) == 2); // of another function
    CHECK(least(hex("41 00"), hex("41 03")) == 2);          // without a rule
    CHECK(least(bytes{}, hex("00 03")) == 2);
    CHECK(least(bytes{}, hex("01 03")) == 2);
}

TEST_CASE("a Return Query Data request is as long as its request, other diagnostics have five bytes") {
    CHECK(least(hex("08 00 00 A5 37 00 01"), hex("08 00")) == 7);
    CHECK(least(hex("08 00 0B 00 00"), hex("08 00")) == 5);
    CHECK(least(hex("08 01 00 00 00 00 00"), hex("08 00")) == 5);
    CHECK(least(hex("08 00 00"), hex("08 00")) == 5);
    const std::vector<std::uint8_t> longest{[] {
        std::vector<std::uint8_t> all(253);
        all[0] = 8;
        return all;
    }()};
    CHECK(least(longest, hex("08 00")) == 253);
    const std::vector<std::uint8_t> too_long{[] {
        std::vector<std::uint8_t> all(261);
        all[0] = 8;
        return all;
    }()};
    CHECK(least(too_long, hex("08 00")) == 5);
}

} // namespace functions_tests
