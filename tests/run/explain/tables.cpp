// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames about a device with rows in all four tables: each table has names of its own, also at the same address.
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/explain/explain.hpp>
#include <servobus/registers/catalogue.hpp>

#include <tests/support/function_cases.hpp>
#include <tests/support/tank.hpp>

namespace explain_tables {

using namespace servobus;
using enum direction;
using tests::printed_pdu;
namespace tank = tests::tank;

namespace {

constexpr named_value valve_names[] = {code(0, "shut"), code(1, "open")};

constexpr entry bit(u16 address, const char* name, servobus::access rights, range limits = {0, 1, false},
                    std::span<const named_value> values = {}) {
    const naming how = values.empty() ? naming::number : naming::names;
    return {address, name,  value_kind::unsigned_word, rights, limits, no_default, no_unit, flag::none,
            how,     values};
}

constexpr entry coils[] = {
    bit(0x0003, "valve", servobus::access::rw, {0, 1, false}, valve_names),
    bit(0x0004, "pump", servobus::access::rw),
    bit(0x0010, "lamp", servobus::access::ro),
    bit(0x0011, "reset", servobus::access::wo, {1, 1}),
};
constexpr entry discrete_inputs[] = {bit(0x0003, "is_full", servobus::access::ro)};
constexpr entry input_registers[] = {
    list("level", tank::level),
    list("temperature", tank::temperature),
    list("volume", tank::volume),
};
constexpr entry holding_registers[] = {
    list("options", tank::options),
    list("ramp", tank::ramp),
    list("target", tank::target),
};
// Word order 1, the low word first, is the factory's; no input register sets it.
constexpr profile facts{
    .name = "tank", .word_order = servobus::word_order::unknown, .word_order_register = 0x0001};
constexpr entry with_word_order[] = {{0x0001,
                                      "pair_word_order",
                                      value_kind::unsigned_word,
                                      servobus::access::rw,
                                      {0, 1},
                                      1,
                                      no_unit,
                                      flag::none}};

constexpr catalogue of_holding{&tank::device::facts, holding_registers};
constexpr catalogue of_coils{&tank::device::facts, coils};
constexpr catalogue of_discrete{&tank::device::facts, discrete_inputs};
constexpr catalogue of_inputs{&tank::device::facts, input_registers};
constexpr catalogue of_switchable{&facts, with_word_order};
constexpr table_catalogues all{.holding_registers = &of_holding,
                               .coils = &of_coils,
                               .discrete_inputs = &of_discrete,
                               .input_registers = &of_inputs};

std::vector<std::uint8_t> framed(bytes pdu) {
    std::vector<std::uint8_t> frame(pdu.size() + 3, 1);
    for (std::size_t i = 0; i < pdu.size(); ++i) frame[i + 1] = pdu[i];
    if (!pdu.empty()) CHECK(modbus::close_frame(frame, pdu.size()) == frame.size());
    return pdu.empty() ? std::vector<std::uint8_t>{} : frame;
}

std::string say(direction way, const printed_pdu& pdu, const printed_pdu& before = {""},
                const table_catalogues& maps = all) {
    char room[512];
    const explanation e = explain(maps, way, framed(pdu), framed(before), room);
    CHECK(e.is_valid());
    return std::string{room, e.size}.substr(std::string{"node 1: "}.size());
}

} // namespace

TEST_CASE("a request of bits has their names, and what has none by its addresses") {
    CHECK(say(request, {"01 00 04 00 01"}) == "read pump (0x0004)");
    CHECK(say(request, {"01 00 03 00 10"}) ==
          "read valve (0x0003), pump (0x0004), coils 0x0005..0x000F, lamp (0x0010), reset (0x0011), "
          "coil 0x0012");
    CHECK(say(request, {"02 00 03 00 02"}) == "read is_full (0x0003), discrete input 0x0004");
    CHECK(say(request, {"01 FF FF 00 01"}) == "read coil 0xFFFF");
}

TEST_CASE("a write of coils has the names of their states, or on and off") {
    CHECK(say(request, {"05 00 03 FF 00"}) == "write valve (0x0003) = open (0x0001)");
    CHECK(say(request, {"05 00 04 00 00"}) == "write pump (0x0004) = off");
    CHECK(say(request, {"05 00 05 FF 00"}) == "write coil 0x0005 = on");
    CHECK(say(request, {"0F 00 02 00 0F 02 05 40"}) ==
          "write coil 0x0002 = on, valve (0x0003) = shut (0x0000), pump (0x0004) = on, "
          "coils 0x0005..0x000F = 00000000 000, lamp (0x0010) = on (read-only)");
    CHECK(say(request, {"05 00 11 00 00"}) == "write reset (0x0011) = off (outside 1..1)");
}

TEST_CASE("a coil may be written with a value that the standard has not, as relay modules toggle and time") {
    CHECK(say(request, {"05 00 03 55 00"}) == "write valve (0x0003) = 0x5500 (no value of the standard)");
    CHECK(say(request, {"05 00 05 00 64"}) == "write coil 0x0005 = 0x0064 (no value of the standard)");
    CHECK(say(response, {"05 00 05 55 00"}, {"05 00 05 55 00"}) ==
          "response, coil 0x0005 = 0x5500 (no value of the standard) written");
    CHECK(say(unknown, {"05 00 05 55 00"}) ==
          "write coil 0x0005 = 0x5500 (no value of the standard) (request, or "
          "the response that echoes it)");
    CHECK(say(response, {"85 03"}, {"05 00 05 55 00"}) ==
          "response, exception 3 (unknown exception) to write coil 0x0005 = 0x5500 (no value of the "
          "standard)");
    for (const unsigned value : {0x0001u, 0x5500u, 0xFF01u, 0xFFFFu, 0xFE00u}) {
        const std::uint8_t pdu[]{0x05, 0, 5, static_cast<std::uint8_t>(value >> 8),
                                 static_cast<std::uint8_t>(value & 0xFFu)};
        CHECK(is_unusual_coil_write(bytes{pdu, 5}));
        CHECK(is_request(bytes{pdu, 5}));
        CHECK(is_response(bytes{pdu, 5}));
        CHECK_FALSE(is_request(bytes{pdu, 4}));
    }
    for (const unsigned value : {0x0000u, 0xFF00u}) {
        const std::uint8_t pdu[]{0x05, 0, 5, static_cast<std::uint8_t>(value >> 8), 0};
        CHECK_FALSE(is_unusual_coil_write(bytes{pdu, 5}));
        CHECK(is_request(bytes{pdu, 5}));
    }
}

TEST_CASE("a response of bits has their names if its request is known") {
    const printed_pdu asked{"01 00 03 00 10"};
    CHECK(say(response, {"01 02 01 A0"}, asked) ==
          "response, valve = open (0x0001), pump = off, coils 0x0005..0x000F = 00000000 000, lamp = on, "
          "reset = off, coil 0x0012 = on");
    CHECK(say(response, {"02 01 01"}, {"02 00 03 00 01"}) == "response, is_full = on");
    CHECK(say(response, {"01 02 01 A0"}) == "response, 2 bytes of coils 01 A0");
    CHECK(say(response, {"05 00 03 00 00"}) == "response, valve (0x0003) = shut (0x0000) written");
    CHECK(say(response, {"0F 00 03 00 03"}) ==
          "response, valve (0x0003), pump (0x0004), coil 0x0005 written");
    CHECK(say(response, {"81 02"}, {"01 00 04 00 01"}) ==
          "response, exception 2 (unknown exception) to read pump (0x0004)");
}

TEST_CASE("input registers have names of their own") {
    CHECK(say(request, {"04 00 00 00 02"}) == "read level (0x0000), temperature (0x0001) as input registers");
    CHECK(say(request, {"03 00 03 00 01"}) == "read ramp (0x0003)");
    CHECK(say(response, {"04 04 00 07 FF 38"}, {"04 00 00 00 02"}) ==
          "response, level = 7, temperature = -20.0 degC");
    CHECK(say(response, {"84 02"}, {"04 00 00 00 01"}) ==
          "response, exception 2 (unknown exception) to read level (0x0000) as input registers");
}

TEST_CASE("a pair of input registers has the word order that a holding register selects") {
    const table_catalogues maps{.holding_registers = &of_switchable, .input_registers = &of_inputs};
    CHECK(say(response, {"04 04 00 01 00 02"}, {"04 00 02 00 02"}, maps) ==
          "response, volume = 131073 (in the factory's word order)");
}

TEST_CASE("without a catalogue of its own, a table of bits has addresses, and input registers the holding "
          "registers' names") {
    const table_catalogues maps{.holding_registers = &of_holding};
    CHECK(say(request, {"01 00 04 00 01"}, {""}, maps) == "read coil 0x0004");
    CHECK(say(request, {"02 00 03 00 01"}, {""}, maps) == "read discrete input 0x0003");
    CHECK(say(request, {"04 00 03 00 01"}, {""}, maps) == "read ramp (0x0003) as input registers");
}

} // namespace explain_tables
