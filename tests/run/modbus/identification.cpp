// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Function 2Bh/0Eh: the standard's example in one part and in two (Modbus Application Protocol V1.1b3, 6.21), every way
// in which a request or a response is wrong, and devices that would never end.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <servobus/modbus/identification.hpp>

#include <tests/support/function_cases.hpp>

namespace identification_tests {

using namespace servobus;
using namespace servobus::modbus;

namespace {

constexpr auto pdu_of(identification kind, std::uint8_t object) {
    tests::built_pdu<4> b;
    b.size = put_identification_request(b.data, {kind, object});
    return b;
}
static_assert(same_bytes(pdu_of(identification::basic, 0), hex("2B 0E 01 00")));
static_assert(same_bytes(pdu_of(identification::single, 0x80), hex("2B 0E 04 80")));

static_assert(identification_request{}.kind == identification::basic && identification_request{}.object == 0);
static_assert(identification_object{}.id == 0 && identification_part{}.count == 0 &&
              identification_part{}.next == 0 && identification_part{}.conformity == 0);
static_assert(pdu_of(identification::regular, 3).data[2] == 2 &&
              pdu_of(identification::extended, 3).data[2] == 3);

// A constant request that breaks a rule does not compile.
static_assert(tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_identification_request(pdu, {});
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_identification_request(pdu, {static_cast<identification>(5), 0});
}));

constexpr tests::request_case requests[]{
    {"basic", "2B 0E 01 00"},
    {"extended", "2B 0E 03 FF"},
    {"one object", "2B 0E 04 05"},
    {"nothing but its code", "2B", errc::too_short},
    {"another MEI type", "2B 0D 01 00", errc::wrong_function},
    {"another MEI type before its length", "2B 0D", errc::wrong_function},
    {"cut", "2B 0E 01", errc::too_short},
    {"lengthened", "2B 0E 01 00 00", errc::too_long},
    {"kind 0", "2B 0E 00 00", errc::wrong_value},
    {"kind 5", "2B 0E 05 00", errc::wrong_value},
};
static_assert(tests::all_hold(requests));

constexpr tests::response_case responses[]{
    {"two objects", "2B 0E 01 00", "2B 0E 01 01 00 00 02 00 02 41 42 01 00"},
    {"goes on at 2", "2B 0E 01 00", "2B 0E 01 01 FF 02 02 00 02 41 42 01 01 43"},
    {"a single object", "2B 0E 04 05", "2B 0E 04 82 00 00 01 05 01 41"},
    {"begins again, since object 5 is unknown", "2B 0E 01 05", "2B 0E 01 01 00 00 01 00 01 41"},
    {"extended, single objects too", "2B 0E 03 00", "2B 0E 03 83 00 00 01 FF 00"},
    {"refused", "2B 0E 04 05", "AB 02", errc::exception},
    {"cut in its head", "2B 0E 01 00", "2B 0E 01 01 00 00", errc::too_short},
    {"another MEI type", "2B 0E 01 00", "2B 0D 01 01 00 00 01 00 01 41", errc::wrong_function},
    {"another kind", "2B 0E 01 00", "2B 0E 02 01 00 00 01 00 01 41", errc::wrong_value},
    {"conformity 0", "2B 0E 01 00", "2B 0E 01 00 00 00 01 00 01 41", errc::unexpected_value},
    {"conformity 4", "2B 0E 01 00", "2B 0E 01 04 00 00 01 00 01 41", errc::unexpected_value},
    {"conformity 80h", "2B 0E 01 00", "2B 0E 01 80 00 00 01 00 01 41", errc::unexpected_value},
    {"conformity 41h", "2B 0E 01 00", "2B 0E 01 41 00 00 01 00 01 41", errc::unexpected_value},
    {"more follows: 01", "2B 0E 01 00", "2B 0E 01 01 01 02 01 00 01 41", errc::unexpected_value},
    {"more follows: FE", "2B 0E 01 00", "2B 0E 01 01 FE 02 01 00 01 41", errc::unexpected_value},
    {"a next object, but none follows", "2B 0E 01 00", "2B 0E 01 01 00 02 01 00 01 41",
     errc::unexpected_value},
    {"no object", "2B 0E 01 00", "2B 0E 01 01 00 00 00", errc::wrong_quantity},
    {"goes on after no object", "2B 0E 01 00", "2B 0E 01 01 FF 01 00", errc::wrong_quantity},
    {"a value cut", "2B 0E 01 00", "2B 0E 01 01 00 00 02 00 02 41 42 01 09 43", errc::too_short},
    {"an object missing", "2B 0E 01 00", "2B 0E 01 01 00 00 02 00 02 41 42", errc::too_short},
    {"half an object's head", "2B 0E 01 00", "2B 0E 01 01 00 00 02 00 02 41 42 01", errc::too_short},
    {"lengthened", "2B 0E 01 00", "2B 0E 01 01 00 00 01 00 02 41 42 01", errc::too_long},
    {"an object twice", "2B 0E 01 00", "2B 0E 01 01 00 00 02 01 00 01 00", errc::unexpected_value},
    {"objects that descend", "2B 0E 01 00", "2B 0E 01 01 00 00 02 01 00 00 00", errc::unexpected_value},
    {"goes on at its last object", "2B 0E 01 00", "2B 0E 01 01 FF 01 02 00 02 41 42 01 01 43",
     errc::unexpected_value},
    {"goes on before its last object", "2B 0E 01 00", "2B 0E 01 01 FF 01 01 02 01 43",
     errc::unexpected_value},
    {"goes on at 0", "2B 0E 01 00", "2B 0E 01 01 FF 00 01 00 01 43", errc::unexpected_value},
    {"a single object that goes on", "2B 0E 04 05", "2B 0E 04 82 FF 06 01 05 01 41", errc::unexpected_value},
    {"two for a single object", "2B 0E 04 05", "2B 0E 04 82 00 00 02 05 00 06 00", errc::wrong_quantity},
    {"another single object", "2B 0E 04 05", "2B 0E 04 82 00 00 01 06 01 41", errc::wrong_address},
};
static_assert(tests::all_hold(responses));

constexpr std::size_t length_of_all(bytes pdu) {
    std::size_t length = 0;
    const auto part = parse_identification_response({}, pdu);
    for (const identification_object object : *part) length += object.value.size();
    return length;
}
static_assert(length_of_all(hex("2B 0E 01 01 00 00 03 00 02 41 42 01 00 02 01 43")) == 3);

// A device of 256 objects that responds with one object a part.
std::vector<std::uint8_t> one_object(std::uint8_t id, std::uint8_t next) {
    const bool has_more = next != 0;
    return {0x2B, 0x0E, 3, 0x83, has_more ? std::uint8_t{0xFF} : std::uint8_t{0}, next, 1, id, 1, id};
}

} // namespace

TEST_CASE("identification: each request is judged by its rule") { tests::check_all(requests); }

TEST_CASE("identification: each response is judged against its request") { tests::check_all(responses); }

TEST_CASE("the standard's example in one part and in two gives the same objects") {
    const std::string names[]{"Company identification", "Product code XX", "V2.11"};
    const auto response = [&](std::uint8_t from, std::uint8_t to, std::uint8_t next) {
        std::vector<std::uint8_t> pdu{0x2B,
                                      0x0E,
                                      1,
                                      1,
                                      next != 0 ? std::uint8_t{0xFF} : std::uint8_t{0},
                                      next,
                                      static_cast<std::uint8_t>(to - from)};
        for (std::uint8_t id = from; id < to; ++id) {
            pdu.push_back(id);
            pdu.push_back(static_cast<std::uint8_t>(names[id].size()));
            pdu.insert(pdu.end(), names[id].begin(), names[id].end());
        }
        return pdu;
    };
    const std::vector<std::vector<std::vector<std::uint8_t>>> sessions{
        {response(0, 3, 0)}, {response(0, 2, 2), response(2, 3, 0)}};
    for (const auto& parts : sessions) {
        identification_parts all{identification::basic};
        std::vector<std::string> read;
        for (const auto& pdu : parts) {
            REQUIRE_FALSE(all.is_done());
            CHECK(all.request().object == read.size());
            const auto part = all.take(pdu);
            REQUIRE(part);
            for (const identification_object object : *part) {
                CHECK(object.id == read.size());
                read.emplace_back(object.value.begin(), object.value.end());
            }
        }
        CHECK(all.is_done());
        CHECK(read == std::vector<std::string>{names[0], names[1], names[2]});
    }
}

TEST_CASE("an identification of 256 parts ends; one that begins again, or is refused, is not taken") {
    identification_parts all{identification::extended};
    for (unsigned id = 0; id < 256; ++id) {
        REQUIRE_FALSE(all.is_done());
        CHECK((all.request().kind == identification::extended && all.request().object == id));
        const auto next = static_cast<std::uint8_t>((id + 1) % 256);
        if (id == 7) {
            CHECK(all.take(one_object(6, 7)).error() == errc::unexpected_value);
            CHECK(all.take(one_object(0, 8)).error() == errc::unexpected_value);
            CHECK(all.take(hex("AB 04")).exception() == 4);
            CHECK(all.take(hex("2B 0E 03 83 FF")).error() == errc::too_short);
            CHECK((!all.is_done() && all.request().object == 7)); // the same request again
        }
        const auto part = all.take(one_object(static_cast<std::uint8_t>(id), next));
        REQUIRE(part);
        CHECK((part->count == 1 && part->next == next && part->conformity == 0x83));
    }
    CHECK(all.is_done());
}

TEST_CASE("an identification may leave objects out, also the first that it named") {
    identification_parts all{identification::extended};
    REQUIRE(all.take(one_object(1, 4)));
    REQUIRE(all.take(one_object(9, 200)));
    CHECK(all.request().object == 200);
}

TEST_CASE("a response of identification is at most as long as a PDU") {
    std::vector<std::uint8_t> pdu{0x2B, 0x0E, 1, 1, 0, 0, 1, 0, 244};
    pdu.resize(253);
    CHECK(parse_identification_response({}, pdu));
    pdu[8] = 245;
    pdu.resize(254);
    CHECK(parse_identification_response({}, pdu).error() == errc::too_long);
}

TEST_CASE("a request for identification that breaks a rule is not built, and nothing is written") {
    std::array<std::uint8_t, 4> out{};
    CHECK(put_identification_request(out, {static_cast<identification>(0), 0}) == 0);
    CHECK(put_identification_request(out, {static_cast<identification>(5), 0}) == 0);
    CHECK(put_identification_request(byte_buffer{out}.first(3), {}) == 0);
    CHECK(out == std::array<std::uint8_t, 4>{});
    CHECK(parse_identification_request(hex("")).error() == errc::too_short);
    CHECK(parse_identification_request(hex("2A 0E 01 00")).error() == errc::wrong_function);
    const auto single = parse_identification_request(hex("2B 0E 04 85"));
    REQUIRE(single);
    CHECK((single->kind == identification::single && single->object == 0x85));
}

} // namespace identification_tests
