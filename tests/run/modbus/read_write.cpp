// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Functions 16h and 17h: the standard's examples (Modbus Application Protocol V1.1b3, 6.16, 6.17), their limits, and
// every way in which a request or a response is wrong.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <servobus/modbus/read_write.hpp>

#include <tests/support/function_cases.hpp>

namespace read_write_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::built_pdu;

namespace {

constexpr auto mask_pdu(mask_write change) {
    built_pdu<7> b;
    b.size = put_mask_write_request(b.data, change);
    return b;
}
template <std::size_t N>
constexpr auto read_write_pdu(std::uint16_t from, std::uint16_t quantity, std::uint16_t to,
                              const std::uint16_t (&values)[N]) {
    built_pdu<10 + 2 * N> b;
    b.size = put_read_write_request(b.data, from, quantity, to, values);
    return b;
}

static_assert(same_bytes(mask_pdu({4, 0xF2, 0x25}), hex("16 00 04 00 F2 00 25")));
static_assert(mask_write{4, 0xF2, 0x25}.applied_to(0x12) == 0x17); // the standard's example
static_assert(mask_write{}.applied_to(0xA5C3) == 0xA5C3 &&
              mask_write{0, 0, 0x1234}.applied_to(0xFFFF) == 0x1234);
static_assert(same_bytes(read_write_pdu(3, 6, 14, {255, 255, 255}),
                         hex("17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF")));
static_assert(read_write_pdu(0xFF83, 125, 0xFFFF, {1}).size == 12);

static_assert(read_write{}.read_address == 0 && read_write{}.quantity == 0 &&
              read_write{}.write_address == 0 && read_write{}.values.size() == 0);
static_assert(mask_write{} == mask_write{0, 0xFFFF, 0});

// A constant request that breaks a rule does not compile.
static_assert(tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_read_write_request(pdu, 0, 1, 0, std::array<std::uint16_t, 1>{});
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_read_write_request(pdu, 0, 126, 0, std::array<std::uint16_t, 1>{});
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_read_write_request(pdu, 0, 1, 0xFFFF, std::array<std::uint16_t, 2>{});
}));

constexpr tests::request_case requests[]{
    {"16, the standard's", "16 00 04 00 F2 00 25"},
    {"17, the standard's", "17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF"},
    {"17, both parts at the end", "17 FF 83 00 7D FF FF 00 01 02 00 FF"},
    {"16 cut", "16 00 04 00 F2 00", errc::too_short},
    {"16 lengthened", "16 00 04 00 F2 00 25 00", errc::too_long},
    {"17 cut in its head", "17 00 03 00 06 00 0E 00 01", errc::too_short},
    {"17 cut", "17 00 03 00 06 00 0E 00 01 02 00", errc::wrong_byte_count},
    {"17 lengthened", "17 00 03 00 06 00 0E 00 01 02 00 FF 00", errc::wrong_byte_count},
    {"17 reads none", "17 00 03 00 00 00 0E 00 01 02 00 FF", errc::wrong_quantity},
    {"17 reads 126", "17 00 03 00 7E 00 0E 00 01 02 00 FF", errc::wrong_quantity},
    {"17 writes none", "17 00 03 00 06 00 0E 00 00 00", errc::wrong_quantity},
    {"17 writes 122", "17 00 03 00 06 00 0E 00 7A 02 00 FF", errc::wrong_quantity},
    {"17 with fewer bytes than values", "17 00 03 00 06 00 0E 00 02 02 00 FF", errc::wrong_byte_count},
    {"17 with more bytes than values", "17 00 03 00 06 00 0E 00 01 04 00 FF 00 FF", errc::wrong_byte_count},
    {"17 with half a value", "17 00 03 00 06 00 0E 00 01 01 00", errc::wrong_byte_count},
    {"17 reads beyond the last", "17 FF FF 00 02 00 0E 00 01 02 00 FF", errc::wrong_address},
    {"17 writes beyond the last", "17 00 03 00 06 FF FF 00 02 04 00 FF 00 FF", errc::wrong_address},
    {"17 reads beyond the last, a wrong count first", "17 FF FF 00 02 00 0E 00 02 02 00 FF",
     errc::wrong_byte_count},
    {"17 reads beyond the last, a wrong second quantity first", "17 FF FF 00 02 00 0E 00 00 00",
     errc::wrong_quantity},
};
static_assert(tests::all_hold(requests));

constexpr tests::response_case responses[]{
    {"16, the standard's", "16 00 04 00 F2 00 25", "16 00 04 00 F2 00 25"},
    {"17, the standard's", "17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF",
     "17 0C 00 FE 0A CD 00 01 00 03 00 0D 00 FF"},
    {"16 refused", "16 00 04 00 F2 00 25", "96 02", errc::exception},
    {"16 by 06", "16 00 04 00 F2 00 25", "06 00 04 00 F2 00 25", errc::wrong_function},
    {"16 at another address", "16 00 04 00 F2 00 25", "16 00 05 00 F2 00 25", errc::wrong_address},
    {"16 with another and-mask", "16 00 04 00 F2 00 25", "16 00 04 00 F3 00 25", errc::wrong_value},
    {"16 with another or-mask", "16 00 04 00 F2 00 25", "16 00 04 00 F2 00 24", errc::wrong_value},
    {"16 without its or-mask", "16 00 04 00 F2 00 25", "16 00 04 00 F2", errc::too_short},
    {"16 lengthened", "16 00 04 00 F2 00 25", "16 00 04 00 F2 00 25 00", errc::too_long},
    {"17 refused", "17 00 03 00 01 00 0E 00 01 02 00 FF", "97 03", errc::exception},
    {"17 by 03", "17 00 03 00 01 00 0E 00 01 02 00 FF", "03 02 00 FE", errc::wrong_function},
    {"17 with a word too few", "17 00 03 00 02 00 0E 00 01 02 00 FF", "17 02 00 FE", errc::wrong_byte_count},
    {"17 with a word too many", "17 00 03 00 01 00 0E 00 01 02 00 FF", "17 04 00 FE 00 00",
     errc::wrong_byte_count},
    {"17 cut", "17 00 03 00 01 00 0E 00 01 02 00 FF", "17 02 00", errc::wrong_byte_count},
    {"17 lengthened", "17 00 03 00 01 00 0E 00 01 02 00 FF", "17 02 00 FE 00", errc::wrong_byte_count},
    {"17 as its request's head", "17 00 03 00 01 00 0E 00 01 02 00 FF", "17 00 03 00 01",
     errc::wrong_byte_count},
};
static_assert(tests::all_hold(responses));

} // namespace

TEST_CASE("16h and 17h: each request is judged by its rule") { tests::check_all(requests); }

TEST_CASE("16h and 17h: each response is judged against its request") { tests::check_all(responses); }

TEST_CASE("the parts of 16h and 17h are those of the PDU") {
    CHECK(*parse_mask_write_request(hex("16 00 04 00 F2 00 25")) == mask_write{4, 0xF2, 0x25});
    CHECK(parse_mask_write_request(hex("")).error() == errc::too_short);
    CHECK(parse_mask_write_request(hex("06 00 04 00 F2")).error() == errc::wrong_function);
    const auto asked = hex("17 00 03 00 06 00 0E 00 02 04 12 34 00 FF");
    const auto both = parse_read_write_request(asked);
    REQUIRE(both);
    CHECK((both->read_address == 3 && both->quantity == 6 && both->write_address == 14));
    CHECK((both->values.size() == 2 && both->values[0] == 0x1234 && both->values[1] == 0xFF));
    CHECK(parse_read_write_request(hex("")).error() == errc::too_short);
    CHECK(parse_read_write_request(hex("10 00 04 00 F2")).error() == errc::wrong_function);
    const auto words = parse_read_write_response(1, hex("17 02 00 FE"));
    REQUIRE(words);
    CHECK(words->size() == 1);
    CHECK(parse_read_write_response(1, hex("97 0B")).exception() == 0x0B);
}

TEST_CASE("a request of 16h or 17h that breaks a rule is not built, and nothing is written") {
    std::array<std::uint8_t, max_pdu> out{};
    const std::array<std::uint16_t, 122> values{1};
    const auto put = [&](std::uint16_t from, std::uint16_t quantity, std::uint16_t to, std::size_t count) {
        return put_read_write_request(out, from, quantity, to,
                                      slice<const std::uint16_t>{values}.first(count));
    };
    CHECK(put(0, 0, 0, 1) == 0);
    CHECK(put(0, 126, 0, 1) == 0);
    CHECK(put(0xFFFF, 2, 0, 1) == 0);
    CHECK(put(0, 1, 0, 0) == 0);
    CHECK(put(0, 1, 0, 122) == 0);
    CHECK(put(0, 1, 0xFFFF, 2) == 0);
    CHECK(put_read_write_request(byte_buffer{out}.first(11), 0, 1, 0,
                                 slice<const std::uint16_t>{values}.first(1)) == 0);
    CHECK(put_mask_write_request(byte_buffer{out}.first(6), {}) == 0);
    CHECK(out == std::array<std::uint8_t, max_pdu>{});
    CHECK(put(0, 125, 0, 121) == 252);
    CHECK(check_request(bytes{out}.first(252)) == errc::ok);
}

} // namespace read_write_tests
