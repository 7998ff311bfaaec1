// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Functions 07, 08, 0B, 0C, 11 and 18h: the standard's examples (Modbus Application Protocol V1.1b3, 6.7 to 6.10, 6.13,
// 6.18), their limits, and every way in which a request or a response is wrong.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <servobus/modbus/diagnostics.hpp>
#include <servobus/modbus/fifo.hpp>

#include <tests/support/function_cases.hpp>

namespace diagnostics_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::built_pdu;

namespace {

constexpr auto bare_pdu(function code) {
    built_pdu<1> b;
    b.size = put_bare_request(b.data, code);
    return b;
}
template <std::size_t N> constexpr auto query_data_pdu(const std::uint16_t (&data)[N]) {
    built_pdu<3 + 2 * N> b;
    b.size = put_return_query_data_request(b.data, data);
    return b;
}
constexpr auto diagnostic_pdu(diagnostic what) {
    built_pdu<5> b;
    b.size = put_diagnostic_request(b.data, what);
    return b;
}
constexpr auto fifo_pdu(std::uint16_t address) {
    built_pdu<3> b;
    b.size = put_fifo_request(b.data, address);
    return b;
}

static_assert(same_bytes(bare_pdu(function::read_exception_status), hex("07")));
static_assert(same_bytes(bare_pdu(function::get_event_counter), hex("0B")));
static_assert(same_bytes(bare_pdu(function::get_event_log), hex("0C")));
static_assert(same_bytes(bare_pdu(function::report_server_id), hex("11")));
static_assert(same_bytes(query_data_pdu({0xA537}), hex("08 00 00 A5 37")));
static_assert(same_bytes(query_data_pdu({1, 2}), hex("08 00 00 00 01 00 02")));
static_assert(same_bytes(diagnostic_pdu(diagnostic::bus_messages), hex("08 00 0B 00 00")));
static_assert(same_bytes(fifo_pdu(0x04DE), hex("18 04 DE")));

// The numbers of the standard's table in 6.8.
constexpr diagnostic in_order[]{
    diagnostic::clear_counters,
    diagnostic::bus_messages,
    diagnostic::bus_communication_errors,
    diagnostic::bus_exceptions,
    diagnostic::server_messages,
    diagnostic::server_no_responses,
    diagnostic::server_negative_acknowledgements,
    diagnostic::server_busy,
    diagnostic::bus_character_overruns,
};
constexpr bool is_in_order() {
    unsigned number = 0x0A;
    for (const diagnostic each : in_order) {
        if (static_cast<unsigned>(each) != number++) return false;
    }
    return true;
}
static_assert(is_in_order());
static_assert(same_bytes(diagnostic_pdu(diagnostic::diagnostic_register), hex("08 00 02 00 00")));
static_assert(same_bytes(diagnostic_pdu(diagnostic::clear_overrun_counter), hex("08 00 14 00 00")));
static_assert(parse_diagnostic_request(hex("08 00 01 00 00"))->what == diagnostic::restart_communications);
static_assert(parse_diagnostic_request(hex("08 00 03 0D 00"))->what == diagnostic::change_delimiter);
static_assert(parse_diagnostic_request(hex("08 00 04 00 00"))->what == diagnostic::listen_only);
static_assert(diagnostic_request{}.what == diagnostic::return_query_data &&
              diagnostic_request{}.data.size() == 0);
static_assert(!event_counter{}.is_busy && event_counter{}.count == 0);
static_assert(!event_log{}.is_busy && event_log{}.event_count == 0 && event_log{}.message_count == 0 &&
              event_log{}.events.empty());

// A constant request that breaks a rule does not compile.
static_assert(tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_bare_request(pdu, function::get_event_log);
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_bare_request(pdu, function::diagnostics);
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_return_query_data_request(pdu, slice<const std::uint16_t>{});
}));
static_assert(!tests::is_constant([] {
    std::uint8_t pdu[16]{};
    return put_diagnostic_request(pdu, diagnostic::listen_only);
}));

constexpr tests::request_case requests[]{
    {"07", "07"},
    {"08, the standard's", "08 00 00 A5 37"},
    {"08, several words", "08 00 00 A5 37 00 00 12 34"},
    {"08, restart", "08 00 01 00 00"},
    {"08, restart and clear the log", "08 00 01 FF 00"},
    {"08, the diagnostic register", "08 00 02 00 00"},
    {"08, a delimiter", "08 00 03 0D 00"},
    {"08, listen only", "08 00 04 00 00"},
    {"08, clear", "08 00 0A 00 00"},
    {"08, the last counter", "08 00 12 00 00"},
    {"08, clear the overruns", "08 00 14 00 00"},
    {"0B", "0B"},
    {"0C", "0C"},
    {"11", "11"},
    {"18, the standard's", "18 04 DE"},
    {"07 with a byte more", "07 00", errc::too_long},
    {"0B with a byte more", "0B 00", errc::too_long},
    {"0C with a byte more", "0C 00", errc::too_long},
    {"11 with a byte more", "11 00", errc::too_long},
    {"08 cut", "08 00 00 A5", errc::too_short},
    {"08 without data", "08 00 00", errc::too_short},
    {"08 with half a word", "08 00 00 A5 37 00", errc::wrong_byte_count},
    {"08 of reserved 05", "08 00 05 00 00", errc::wrong_function},
    {"08 of reserved 09", "08 00 09 00 00", errc::wrong_function},
    {"08 of reserved 13", "08 00 13 00 00", errc::wrong_function},
    {"08 of reserved 15", "08 00 15 00 00", errc::wrong_function},
    {"08 of reserved 0100", "08 01 00 00 00", errc::wrong_function},
    {"08 of a reserved one before its length", "08 00 05 00 00 00", errc::wrong_function},
    {"08 of a counter with two words", "08 00 0B 00 00 00 00", errc::too_long},
    {"08 of a counter with data", "08 00 0B 00 01", errc::wrong_value},
    {"08 of the register with data", "08 00 02 01 00", errc::wrong_value},
    {"08 of a clear with data", "08 00 14 FF 00", errc::wrong_value},
    {"08 of listen only with data", "08 00 04 00 01", errc::wrong_value},
    {"08 of a restart with FF01", "08 00 01 FF 01", errc::wrong_value},
    {"08 of a delimiter with two characters", "08 00 03 0D 0A", errc::wrong_value},
    {"18 cut", "18 04", errc::too_short},
    {"18 with a byte more", "18 04 DE 00", errc::too_long},
};
static_assert(tests::all_hold(requests));

constexpr tests::response_case responses[]{
    {"07, the standard's", "07", "07 6D"},
    {"08, the standard's", "08 00 00 A5 37", "08 00 00 A5 37"},
    {"08, several words", "08 00 00 A5 37 12 34", "08 00 00 A5 37 12 34"},
    {"08, a counter", "08 00 0B 00 00", "08 00 0B 12 34"},
    {"08, the last counter", "08 00 12 00 00", "08 00 12 00 09"},
    {"08, the diagnostic register", "08 00 02 00 00", "08 00 02 80 01"},
    {"08, clear", "08 00 0A 00 00", "08 00 0A 00 00"},
    {"0B, the standard's", "0B", "0B FF FF 01 08"},
    {"0C, the standard's", "0C", "0C 08 00 00 01 08 01 21 20 00"},
    {"0C without events", "0C", "0C 06 FF FF 01 08 01 21"},
    {"11", "11", "11 03 42 FF 01"},
    {"18, the standard's", "18 04 DE", "18 00 06 00 02 01 B8 12 84"},
    {"18 empty", "18 04 DE", "18 00 02 00 00"},
    {"07 refused", "07", "87 01", errc::exception},
    {"07 cut", "07", "07", errc::too_short},
    {"07 lengthened", "07", "07 6D 00", errc::too_long},
    {"08 refused", "08 00 00 A5 37", "88 03", errc::exception},
    {"08 with another word", "08 00 00 A5 37", "08 00 00 A5 36", errc::wrong_value},
    {"08 with another second word", "08 00 00 A5 37 12 34", "08 00 00 A5 37 12 35", errc::wrong_value},
    {"08 without its second word", "08 00 00 A5 37 12 34", "08 00 00 A5 37", errc::too_short},
    {"08 with a word more", "08 00 00 A5 37", "08 00 00 A5 37 00 00", errc::too_long},
    {"08 of another sub-function", "08 00 0B 00 00", "08 00 0C 00 00", errc::wrong_function},
    {"08, clear with data", "08 00 0A 00 00", "08 00 0A 00 01", errc::wrong_value},
    {"08, clear overruns with data", "08 00 14 00 00", "08 00 14 00 01", errc::wrong_value},
    {"08, restart with other data", "08 00 01 FF 00", "08 00 01 00 00", errc::wrong_value},
    {"08, a response in listen-only mode", "08 00 04 00 00", "08 00 04 00 00", errc::unexpected_value},
    {"0B cut", "0B", "0B FF FF 01", errc::too_short},
    {"0B lengthened", "0B", "0B FF FF 01 08 00", errc::too_long},
    {"0B half busy", "0B", "0B FF 00 01 08", errc::unexpected_value},
    {"0C cut", "0C", "0C 08 00 00 01 08 01 21 20", errc::wrong_byte_count},
    {"0C lengthened", "0C", "0C 06 00 00 01 08 01 21 20", errc::wrong_byte_count},
    {"0C of five bytes", "0C", "0C 05 00 00 01 08 01", errc::wrong_byte_count},
    {"0C half busy", "0C", "0C 06 00 01 01 08 01 21", errc::unexpected_value},
    {"11 of nothing", "11", "11 00", errc::wrong_byte_count},
    {"11 cut", "11", "11 03 42 FF", errc::wrong_byte_count},
    {"11 lengthened", "11", "11 02 42 FF 01", errc::wrong_byte_count},
    {"18 refused", "18 04 DE", "98 03", errc::exception},
    {"18 without a count of words", "18 04 DE", "18 00 02 00", errc::too_short},
    {"18 cut", "18 04 DE", "18 00 06 00 02 01 B8 12", errc::wrong_byte_count},
    {"18 lengthened", "18 04 DE", "18 00 06 00 02 01 B8 12 84 00", errc::wrong_byte_count},
    {"18 with fewer words than it counts", "18 04 DE", "18 00 04 00 02 01 B8", errc::wrong_quantity},
    {"18 with more words than it counts", "18 04 DE", "18 00 06 00 01 01 B8 12 84", errc::wrong_quantity},
    {"18 with half a word", "18 04 DE", "18 00 03 00 00 01", errc::wrong_quantity},
    {"18 that counts 32767 words", "18 04 DE", "18 00 02 7F FF", errc::wrong_quantity},
    {"18 that counts 32768 words", "18 04 DE", "18 00 02 80 00", errc::wrong_quantity},
};
static_assert(tests::all_hold(responses));

} // namespace

TEST_CASE("07, 08, 0B, 0C, 11 and 18h: each request is judged by its rule") { tests::check_all(requests); }

TEST_CASE("07, 08, 0B, 0C, 11 and 18h: each response is judged against its request") {
    tests::check_all(responses);
}

TEST_CASE("the parts of diagnostic responses are those of the PDU") {
    CHECK(*parse_exception_status(hex("07 6D")) == 0x6D);
    const auto counter = parse_event_counter(hex("0B FF FF 01 08"));
    REQUIRE(counter);
    CHECK((counter->is_busy && counter->count == 0x108));
    CHECK_FALSE(parse_event_counter(hex("0B 00 00 01 08"))->is_busy);
    const auto log = hex("0C 08 00 00 01 08 01 21 20 00");
    const auto events = parse_event_log(log);
    REQUIRE(events);
    CHECK((!events->is_busy && events->event_count == 0x108 && events->message_count == 0x121));
    CHECK(same_bytes(events->events, hex("20 00")));
    CHECK(parse_event_log(hex("0C 06 FF FF 01 08 01 21"))->is_busy);
    const auto id = hex("11 03 42 FF 01");
    CHECK(same_bytes(*parse_server_id(id), hex("42 FF 01")));
    const auto parts = parse_server_id(id, 1);
    REQUIRE(parts);
    CHECK(
        (same_bytes(parts->id, hex("42")) && parts->is_running && same_bytes(parts->additional, hex("01"))));
    CHECK_FALSE(parse_server_id(hex("11 02 42 00"), 1)->is_running);
    CHECK(parse_server_id(hex("11 02 42 00"), 1)->additional.empty());
    CHECK(parse_server_id(hex("11 02 42 00"), 2).error() == errc::wrong_byte_count);
    CHECK(parse_server_id(hex("11 02 42 00"), 200).error() == errc::wrong_byte_count);
    CHECK(parse_server_id(hex("11 03 42 01 FF"), 1).error() == errc::unexpected_value);
    CHECK(parse_server_id(hex("91 01"), 1).exception() == 1);
    const auto queue = hex("18 00 06 00 02 01 B8 12 84");
    const auto words = parse_fifo_response(queue);
    REQUIRE(words);
    CHECK((words->size() == 2 && (*words)[0] == 0x1B8 && (*words)[1] == 0x1284));
    const auto asked = hex("08 00 0C 00 00");
    const auto answer = hex("08 00 0C 12 34");
    CHECK((*parse_diagnostic_response(*parse_diagnostic_request(asked), answer))[0] == 0x1234);
    CHECK(parse_diagnostic_response(*parse_diagnostic_request(asked), hex("88 01")).exception() == 1);
}

TEST_CASE("a parser of one diagnostic function refuses the others") {
    CHECK(*parse_bare_request(hex("0C")) == function::get_event_log);
    CHECK(parse_bare_request(hex("")).error() == errc::too_short);
    CHECK(parse_bare_request(hex("08")).error() == errc::wrong_function);
    CHECK(parse_diagnostic_request(hex("")).error() == errc::too_short);
    CHECK(parse_diagnostic_request(hex("07 00 00 00 00")).error() == errc::wrong_function);
    CHECK(*parse_fifo_request(hex("18 04 DE")) == 0x04DE);
    CHECK(parse_fifo_request(hex("")).error() == errc::too_short);
    CHECK(parse_fifo_request(hex("17 04 DE")).error() == errc::wrong_function);
}

TEST_CASE("an event log has at most 64 events, a queue 31 words, a server's ID fits a PDU") {
    for (unsigned count = 0; count < 256; ++count) {
        CAPTURE(count);
        std::array<std::uint8_t, 257> pdu{0x0C, static_cast<std::uint8_t>(count)};
        const bytes whole = bytes{pdu}.first(2 + count);
        CHECK(static_cast<bool>(parse_event_log(whole)) == (count >= 6 && count <= 70));
        pdu[0] = 0x11;
        CHECK(static_cast<bool>(parse_server_id(whole)) == (count >= 1 && count <= 251));
    }
    for (unsigned words = 0; words < 120; ++words) {
        CAPTURE(words);
        std::array<std::uint8_t, max_pdu> pdu{0x18, 0, static_cast<std::uint8_t>(2 + 2 * words), 0,
                                              static_cast<std::uint8_t>(words)};
        CHECK(static_cast<bool>(parse_fifo_response(bytes{pdu}.first(5 + 2 * words))) == (words <= 31));
    }
}

TEST_CASE("a diagnostic request that breaks a rule is not built, and nothing is written") {
    std::array<std::uint8_t, 255> out{};
    const std::array<std::uint16_t, 126> data{};
    CHECK(put_bare_request(out, function::diagnostics) == 0);
    CHECK(put_bare_request(byte_buffer{}, function::get_event_log) == 0);
    CHECK(put_return_query_data_request(out, slice<const std::uint16_t>{}) == 0);
    CHECK(put_return_query_data_request(out, data) == 0);
    CHECK(put_return_query_data_request(byte_buffer{out}.first(4),
                                        slice<const std::uint16_t>{data}.first(1)) == 0);
    for (const unsigned what : {0u, 1u, 3u, 4u, 5u, 9u, 0x13u, 0x15u, 0x100u})
        CHECK(put_diagnostic_request(out, static_cast<diagnostic>(what)) == 0);
    CHECK(put_diagnostic_request(byte_buffer{out}.first(4), diagnostic::bus_messages) == 0);
    CHECK(put_fifo_request(byte_buffer{out}.first(2), 1) == 0);
    CHECK(out == std::array<std::uint8_t, 255>{});
    CHECK(put_return_query_data_request(out, slice<const std::uint16_t>{data}.first(125)) == max_pdu);
    CHECK(check_request(bytes{out}.first(253)) == errc::ok);
    out[0] = 8;
    CHECK(check_request(out) == errc::too_long);
    for (const unsigned what : {2u, 0x0Au, 0x0Bu, 0x12u, 0x14u})
        CHECK(put_diagnostic_request(out, static_cast<diagnostic>(what)) == 5);
}

} // namespace diagnostics_tests
