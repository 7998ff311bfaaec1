// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Functions 01, 02, 05 and 0Fh: the standard's examples (Modbus Application Protocol V1.1b3, 6.1, 6.2, 6.5, 6.11),
// their limits, and every way in which a request or a response is wrong.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/modbus/bits.hpp>

#include <tests/support/function_cases.hpp>

namespace bits_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::built_pdu;

namespace {

constexpr function coils = function::read_coils;
constexpr function inputs = function::read_discrete_inputs;

constexpr auto read_pdu(function code, std::uint16_t address, std::uint16_t quantity) {
    built_pdu<5> b;
    b.size = put_read_bits_request(b.data, code, address, quantity);
    return b;
}
constexpr auto coil_pdu(std::uint16_t address, bool is_on) {
    built_pdu<5> b;
    b.size = put_write_coil_request(b.data, address, is_on);
    return b;
}
constexpr auto coils_pdu(std::uint16_t address, bytes packed, std::uint16_t quantity) {
    built_pdu<max_pdu> b;
    b.size = put_write_coils_request(b.data, address, bits_view{packed, quantity});
    return b;
}
template <std::size_t N> constexpr auto coils_pdu(std::uint16_t address, const bool (&values)[N]) {
    built_pdu<6 + N> b;
    b.size = put_write_coils_request(b.data, address, values);
    return b;
}

static_assert(same_bytes(read_pdu(coils, 0x13, 19), hex("01 00 13 00 13")));
static_assert(same_bytes(read_pdu(inputs, 0xC4, 22), hex("02 00 C4 00 16")));
static_assert(same_bytes(coil_pdu(0xAC, true), hex("05 00 AC FF 00")));
static_assert(same_bytes(coil_pdu(0xAC, false), hex("05 00 AC 00 00")));
static_assert(same_bytes(coils_pdu(0x13, hex("CD 01"), 10), hex("0F 00 13 00 0A 02 CD 01")));
static_assert(same_bytes(coils_pdu(0x13, hex("CD FF"), 10), hex("0F 00 13 00 0A 02 CD 03"))); // padding
static_assert(same_bytes(coils_pdu(0x13, {true, false, true, true, false, false, true, true, true, false}),
                         hex("0F 00 13 00 0A 02 CD 01")));
static_assert(read_pdu(coils, 0, 2000).size == 5 && read_pdu(coils, 0xF830, 2000).size == 5);
static_assert(read_pdu(inputs, 0xFFFF, 1).size == 5);
static_assert(bytes_of_bits(0) == 0 && bytes_of_bits(1) == 1 && bytes_of_bits(8) == 1 &&
              bytes_of_bits(9) == 2 && bytes_of_bits(0xFFFF) == 0x2000);

static_assert(bits_request{}.code == coils && bits_request{}.address == 0 && bits_request{}.quantity == 0 &&
              bits_request{}.coils().size() == 0);
static_assert(coil_on == 0xFF00 && coil_off == 0 && max_read_bits == 2000 && max_write_bits == 1968);

// A constant request that breaks a rule does not compile.
static_assert(tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_read_bits_request(pdu, coils, 0, 2000);
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_read_bits_request(pdu, coils, 0, 2001);
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_read_bits_request(pdu, function::read_holding_registers, 0, 1);
}));
static_assert(tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_write_coils_request(pdu, 0xFFFF, bits_view{hex("CD"), 1});
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_write_coils_request(pdu, 0xFFFF, bits_view{hex("CD"), 2});
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_write_coils_request(pdu, 0, bits_view{hex("CD"), 9});
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_write_coils_request(pdu, 0, slice<const bool>{});
}));

constexpr tests::request_case requests[]{
    {"01, the standard's", "01 00 13 00 13"},
    {"01, all", "01 00 00 07 D0"},
    {"02, the last", "02 FF FF 00 01"},
    {"05, on", "05 00 AC FF 00"},
    {"05, off", "05 FF FF 00 00"},
    {"0F, the standard's", "0F 00 13 00 0A 02 CD 01"},
    {"0F, padding is ignored", "0F 00 13 00 0A 02 CD FF"},
    {"0F, a whole byte", "0F FF F8 00 08 01 CD"},
    {"nothing", "", errc::too_short},
    {"01 cut", "01 00 13 00", errc::too_short},
    {"01 with a byte more", "01 00 13 00 13 00", errc::too_long},
    {"01 of none", "01 00 13 00 00", errc::wrong_quantity},
    {"01 of 2001", "01 00 13 07 D1", errc::wrong_quantity},
    {"02 of 2001 before its address", "02 FF FF 07 D1", errc::wrong_quantity},
    {"01 beyond the last", "01 FF FF 00 02", errc::wrong_address},
    {"02 beyond the last", "02 F8 31 07 D0", errc::wrong_address},
    {"05 cut", "05 00 AC FF", errc::too_short},
    {"05 with a byte more", "05 00 AC FF 00 00", errc::too_long},
    {"05 with FF01", "05 00 AC FF 01", errc::wrong_value},
    {"05 with 0100", "05 00 AC 01 00", errc::wrong_value},
    {"05 with 0001", "05 00 AC 00 01", errc::wrong_value},
    {"05 with FFFF", "05 00 AC FF FF", errc::wrong_value},
    {"0F cut", "0F 00 13 00 0A", errc::too_short},
    {"0F of none", "0F 00 13 00 00 00", errc::wrong_quantity},
    {"0F of 1969", "0F 00 13 07 B1 02 CD 01", errc::wrong_quantity},
    {"0F whose count is not the bytes that follow", "0F 00 13 00 0A 02 CD", errc::wrong_byte_count},
    {"0F that counts too few", "0F 00 13 00 0A 02 CD 01 00", errc::wrong_byte_count},
    {"0F with a byte too few for its coils", "0F 00 13 00 0A 01 CD", errc::wrong_byte_count},
    {"0F with a byte too many for its coils", "0F 00 13 00 08 02 CD 00", errc::wrong_byte_count},
    {"0F beyond the last", "0F FF FF 00 02 01 03", errc::wrong_address},
    {"0F beyond the last, and a wrong count first", "0F FF FF 00 02 02 03 00", errc::wrong_byte_count},
};
static_assert(tests::all_hold(requests));

constexpr tests::response_case responses[]{
    {"01, the standard's", "01 00 13 00 13", "01 03 CD 6B 05"},
    {"02, the standard's", "02 00 C4 00 16", "02 03 AC DB 35"},
    {"01, whole bytes have no padding", "01 00 13 00 08", "01 01 FF"},
    {"05, the standard's", "05 00 AC FF 00", "05 00 AC FF 00"},
    {"0F, the standard's", "0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0A"},
    {"01 refused", "01 00 13 00 13", "81 02", errc::exception},
    {"01 refused by a byte too many", "01 00 13 00 13", "81 02 00", errc::too_long},
    {"01 refused by one byte", "01 00 13 00 13", "81", errc::too_short},
    {"01 by the exception of 02", "01 00 13 00 13", "82 02", errc::wrong_function},
    {"01 by 02", "01 00 13 00 13", "02 03 CD 6B 05", errc::wrong_function},
    {"01 with a bit beyond the last", "01 00 13 00 13", "01 03 CD 6B 0D", errc::unexpected_value},
    {"02 with the highest bit beyond the last", "02 00 C4 00 16", "02 03 AC DB B5", errc::unexpected_value},
    {"01 with a byte too few", "01 00 13 00 13", "01 02 CD 6B", errc::wrong_byte_count},
    {"01 with a byte too many", "01 00 13 00 13", "01 04 CD 6B 05 00", errc::wrong_byte_count},
    {"01 cut", "01 00 13 00 13", "01 03 CD 6B", errc::wrong_byte_count},
    {"01 lengthened", "01 00 13 00 13", "01 03 CD 6B 05 00", errc::wrong_byte_count},
    {"05 at another address", "05 00 AC FF 00", "05 00 AD FF 00", errc::wrong_address},
    {"05 with another value", "05 00 AC FF 00", "05 00 AC 00 00", errc::wrong_value},
    {"05 with no value of a coil", "05 00 AC 00 00", "05 00 AC 00 01", errc::wrong_value},
    {"05 cut", "05 00 AC FF 00", "05 00 AC FF", errc::too_short},
    {"05 lengthened", "05 00 AC FF 00", "05 00 AC FF 00 00", errc::too_long},
    {"0F at another address", "0F 00 13 00 0A 02 CD 01", "0F 01 13 00 0A", errc::wrong_address},
    {"0F with another quantity", "0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0B", errc::wrong_quantity},
    {"0F cut", "0F 00 13 00 0A 02 CD 01", "0F 00 13 00", errc::too_short},
    {"0F as its whole request", "0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0A 02 CD 01", errc::too_long},
    {"05 to a wrong request", "05 00 AC 12 34", "05 00 AC 12 34", errc::bad_argument},
};
static_assert(tests::all_hold(responses));

} // namespace

TEST_CASE("coils and discrete inputs: each request is judged by its rule") { tests::check_all(requests); }

TEST_CASE("coils and discrete inputs: each response is judged against its request") {
    tests::check_all(responses);
}

TEST_CASE("bits are read where the standard's example has them, from the lowest of the first byte on") {
    const auto response = hex("01 03 CD 6B 05");
    const auto bits = parse_bits_response(*parse_bits_request(hex("01 00 13 00 13")), response);
    REQUIRE(bits);
    const std::vector<bool> printed{true,  false, true,  true, false, false, true, true,  true, true,
                                    false, true,  false, true, true,  false, true, false, true};
    REQUIRE(bits->size() == printed.size());
    for (std::size_t i = 0; i < printed.size(); ++i) CHECK((*bits)[i] == printed[i]);
    CHECK(bits->packed().size() == 3);
}

TEST_CASE("a parsed request has its own function, address, quantity and coils") {
    const auto single = hex("05 00 AC FF 00");
    const auto on = parse_bits_request(single);
    REQUIRE(on);
    CHECK((on->code == function::write_single_coil && on->address == 0xAC && on->quantity == 1 &&
           !on->is_read()));
    CHECK(on->coils()[0]);
    CHECK_FALSE(parse_bits_request(hex("05 00 AC 00 00"))->coils()[0]);
    const auto block = hex("0F 00 13 00 0A 02 CD 01");
    const auto several = parse_bits_request(block);
    REQUIRE(several);
    CHECK((several->coils().size() == 10 && several->coils()[0] && !several->coils()[1] &&
           several->coils()[8]));
    CHECK(parse_bits_request(hex("02 00 C4 00 16"))->is_read());
    CHECK(parse_bits_request(hex("03 00 C4 00 16")).error() == errc::wrong_function);
    CHECK(parse_bits_request(hex("00 00 C4 00 16")).error() == errc::wrong_function);
    CHECK(parse_bits_request(bytes{}).error() == errc::too_short);
    CHECK(parse_bits_response(*on, single)->size() == 1);
    CHECK(parse_bits_response(*several, hex("8F 04")).exception() == 4);
}

TEST_CASE("a request of bits that breaks a rule is not built, and nothing is written") {
    std::array<std::uint8_t, 5> out{9, 9, 9, 9, 9};
    CHECK(put_read_bits_request(out, coils, 0, 0) == 0);
    CHECK(put_read_bits_request(out, coils, 0, 2001) == 0);
    CHECK(put_read_bits_request(out, inputs, 0xFFFF, 2) == 0);
    CHECK(put_read_bits_request(out, function::read_holding_registers, 0, 1) == 0);
    CHECK(put_read_bits_request(byte_buffer{out}.first(4), coils, 0, 1) == 0);
    CHECK(put_write_coil_request(byte_buffer{out}.first(4), 0, true) == 0);
    CHECK(out == std::array<std::uint8_t, 5>{9, 9, 9, 9, 9});
    std::array<std::uint8_t, max_pdu> many{};
    const std::array<std::uint8_t, 247> packed{};
    const auto put = [&](std::uint16_t address, std::size_t count, std::uint16_t quantity) {
        return put_write_coils_request(many, address, bits_view{bytes{packed}.first(count), quantity});
    };
    CHECK(put(0, 246, 1968) == 252);
    CHECK(put(0, 247, 1969) == 0);
    CHECK(put(0, 0, 0) == 0);
    CHECK(put(0xFFFF, 1, 2) == 0);
    CHECK(put(0, 1, 9) == 0);
    CHECK(put(0, 3, 9) == 0);
    CHECK(put_write_coils_request(byte_buffer{many}.first(6), 0, bits_view{bytes{packed}.first(1), 1}) == 0);
    CHECK(many == std::array<std::uint8_t, max_pdu>{0x0F, 0, 0, 7, 0xB0, 246});
    std::array<std::uint8_t, 8> same_place{9, 9, 9,    9,
                                           9, 9, 0xFF, 0xFF}; // coils that lie where they are sent
    CHECK(put_write_coils_request(same_place, 1, bits_view{bytes{same_place}.last(2), 12}) == 8);
    CHECK(same_bytes(same_place, hex("0F 00 01 00 0C 02 FF 0F")));
    CHECK(put_write_coils_request(same_place, 1, slice<const bool>{std::array<bool, 9>{}}) == 8);
    CHECK(same_bytes(same_place, hex("0F 00 01 00 09 02 00 00"))); // over what was there
    const std::array<bool, 1969> values{};
    CHECK(put_write_coils_request(many, 0, slice<const bool>{values}) == 0);
    CHECK(put_write_coils_request(many, 0, slice<const bool>{values}.first(1968)) == 252);
    CHECK(put_write_coils_request(many, 0xFFFF, slice<const bool>{values}.first(2)) == 0);
    CHECK(put_write_coils_request(many, 0, slice<const bool>{}) == 0);
    CHECK(put_write_coils_request(byte_buffer{many}.first(7), 0, slice<const bool>{values}.first(9)) == 0);
}

TEST_CASE("padding of bits is judged by the last byte alone") {
    for (std::uint16_t quantity = 1; quantity <= 16; ++quantity) {
        CAPTURE(quantity);
        for (unsigned last = 0; last < 256; ++last) {
            const std::array<std::uint8_t, 2> packed{quantity > 8 ? std::uint8_t{0xFF}
                                                                  : static_cast<std::uint8_t>(last),
                                                     static_cast<std::uint8_t>(last)};
            const bits_view view{bytes{packed}.first(bytes_of_bits(quantity)), quantity};
            const unsigned used = (quantity - 1u) % 8 + 1;
            REQUIRE(view.has_zero_padding() == (last < 1u << used));
        }
    }
    CHECK(bits_view{}.has_zero_padding());
}

TEST_CASE("the coils of a request are those that were given, and its padding is zero") {
    std::array<std::uint8_t, 246> packed{};
    for (std::size_t i = 0; i < packed.size(); ++i)
        packed[i] = static_cast<std::uint8_t>(0xFF - 37 * i % 256);
    std::array<bool, 1968> single{};
    for (std::size_t i = 0; i < single.size(); ++i) single[i] = (packed[i / 8] >> i % 8 & 1) != 0;
    for (const auto quantity : std::array<std::uint16_t, 9>{1, 7, 8, 9, 15, 16, 17, 1961, 1968}) {
        CAPTURE(quantity);
        const std::size_t count = (quantity + 7u) / 8;
        std::array<std::uint8_t, max_pdu> of_view{}, of_bools{};
        REQUIRE(put_write_coils_request(of_view, 0x13, bits_view{bytes{packed}.first(count), quantity}) ==
                6 + count);
        REQUIRE(put_write_coils_request(of_bools, 0x13, slice<const bool>{single}.first(quantity)) ==
                6 + count);
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < 8 * count; ++i)
            wrong += (of_view[6 + i / 8] >> i % 8 & 1) != (i < quantity && single[i] ? 1 : 0) ? 1u : 0u;
        CHECK(wrong == 0);
        CHECK(of_view == of_bools);
    }
}

} // namespace bits_tests
