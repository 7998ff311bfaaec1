// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames about rows of every form: floats, 64 bits, texts, parts of a register, numbers that another row scales, named
// words of function 05.
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/explain/explain.hpp>

#include <tests/support/function_cases.hpp>

namespace explain_values {

using namespace servobus;
using enum direction;
using tests::printed_pdu;

namespace {

constexpr value_form text_form{.words = 4}, high_byte{.first_bit = 8, .bits = 8}, low_byte{.bits = 8},
    swapped{.is_low_byte_first = true};
constexpr std::int64_t none[] = {-0x8000};
constexpr value_form scaled{.none = none, .scaled = scaling::exponent, .scale_address = 0x31};

constexpr entry row(u16 address, const char* name, value_kind kind, const value_form* form = nullptr,
                    unit worth = {}, range limits = {0, 0, false}, word_order order = word_order::unknown) {
    return {address, name,       kind,           access::rw, limits, no_default,
            worth,   flag::none, naming::number, {},         order,  form};
}
constexpr entry rows[] = {
    row(0x10, "voltage", value_kind::float_pair, nullptr, unit{measure::volt}, {0, 300}),
    row(0x12, "energy", value_kind::unsigned_quad, nullptr, unit{measure::watt_hour}),
    row(0x16, "serial", value_kind::text, &text_form),
    row(0x1A, "hour", value_kind::unsigned_word, &high_byte),
    row(0x1A, "minute", value_kind::unsigned_word, &low_byte),
    row(0x1B, "balance", value_kind::float_pair, &swapped, {}, {0, 0, false}, word_order::low_first),
    row(0x30, "power", value_kind::signed_word, &scaled, unit{measure::watt}),
    row(0x31, "power_exponent", value_kind::signed_word),
};
static_assert(is_in_order(rows));
constexpr named_value states[] = {code(1, "closed"), code(0x5500, "toggle")};
constexpr entry coils[] = {{0x00,
                            "relay",
                            value_kind::unsigned_word,
                            access::rw,
                            {0, 1, false},
                            no_default,
                            no_unit,
                            flag::none,
                            naming::names,
                            states}};
constexpr profile facts{.name = "meter"};
constexpr catalogue holding{&facts, rows}, of_coils{&facts, coils};
constexpr table_catalogues maps{.holding_registers = &holding, .coils = &of_coils};

std::vector<std::uint8_t> framed(bytes pdu) {
    std::vector<std::uint8_t> frame(pdu.size() + 3, 1);
    for (std::size_t i = 0; i < pdu.size(); ++i) frame[i + 1] = pdu[i];
    if (!pdu.empty()) CHECK(modbus::close_frame(frame, pdu.size()) == frame.size());
    return pdu.empty() ? std::vector<std::uint8_t>{} : frame;
}

std::string say(direction way, const printed_pdu& pdu, const printed_pdu& before = {""}) {
    char room[512];
    const explanation e = explain(maps, way, framed(pdu), framed(before), room);
    CHECK(e.is_valid());
    return std::string{room, e.size}.substr(std::string{"node 1: "}.size());
}
std::string of_request(const printed_pdu& pdu) { return say(request, pdu); }
std::string of_response(const printed_pdu& before, const printed_pdu& pdu) {
    return say(response, pdu, before);
}

} // namespace

TEST_CASE("explain: values of every form in a response") {
    CHECK(of_response({"03 00 10 00 02"}, {"03 04 43 66 19 9A"}) == "response, voltage = 230.1 V");
    CHECK(of_response({"03 00 12 00 04"}, {"03 08 00 00 00 01 00 00 00 02"}) ==
          "response, energy = 4294967298 Wh");
    CHECK(of_response({"03 00 16 00 04"}, {"03 08 4B 50 45 37 0A 00 00 00"}) ==
          "response, serial = \"KPE7\\x0A\"");
    CHECK(of_response({"03 00 1A 00 01"}, {"03 02 0C 1E"}) == "response, hour = 12, minute = 30");
    CHECK(of_response({"03 00 1B 00 02"}, {"03 04 9A 19 66 43"}) == "response, balance = 230.1");
}

TEST_CASE("explain: a row is scaled by another one of the same frame") {
    CHECK(of_response({"03 00 30 00 02"}, {"03 04 04 D2 FF FE"}) ==
          "response, power = 12.34 W, power_exponent = -2");
    CHECK(of_response({"03 00 30 00 02"}, {"03 04 80 00 FF FE"}) ==
          "response, power = no value, power_exponent = -2");
    CHECK(of_response({"03 00 30 00 01"}, {"03 02 04 D2"}) == "response, power = 1234 * 10^power_exponent W");
}

TEST_CASE("explain: a part of a value has its word, and a write is judged") {
    CHECK(of_request({"03 00 12 00 02"}) == "read part of energy (0x0012), part of energy (0x0013)");
    CHECK(of_request({"10 00 10 00 02 04 44 7A 00 00"}) ==
          "write voltage (0x0010) = 1000 V (outside 0..300)");
    CHECK(of_request({"10 00 10 00 02 04 7F C0 00 00"}) == "write voltage (0x0010) = no value");
}

TEST_CASE("explain: a word of function 05 that has a name") {
    CHECK(of_request({"05 00 00 55 00"}) == "write relay (0x0000) = toggle (0x5500)");
    CHECK(of_request({"05 00 00 AA 00"}) == "write relay (0x0000) = 0xAA00 (no value of the standard)");
    CHECK(of_request({"05 00 00 00 00"}) == "write relay (0x0000) = off");
    CHECK(of_request({"05 00 00 FF 00"}) == "write relay (0x0000) = closed (0x0001)");
    CHECK(of_response({"01 00 00 00 01"}, {"01 01 00"}) == "response, relay = off");
    static constexpr named_value inverse[] = {code(0, "on")};
    entry lamp = coils[0];
    lamp.values = inverse;
    CHECK_FALSE(is_on_or_off(lamp, true)); // the word would mean the other state
}

} // namespace explain_values
