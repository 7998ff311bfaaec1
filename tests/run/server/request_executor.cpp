// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Requests executed on rows: the examples of the standard, the order of the checks, hooks, computed rows, requests that
// are longer than the buffer, identification in several parts.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <servobus/modbus/identification.hpp>
#include <servobus/server/request_executor.hpp>

#include <tests/support/served_rows.hpp>

namespace request_executor_tests {

using namespace servobus;
using byte_list = std::vector<std::uint8_t>;

namespace {

// The response to a request, as a constant expression or at run time.
template <class Executor, class Values>
constexpr bool responds(Values& values, bytes request, bytes response) {
    std::uint8_t pdu[Executor::buffer_size]{};
    for (std::size_t i = 0; i < sizeof pdu; ++i)
        pdu[i] = i < request.size() ? request[i] : 0xA5; // noise behind it
    const std::size_t size = Executor{values}.execute(pdu, request.size());
    return same_bytes(bytes{pdu, size}, response);
}

// The examples of the standard, with rows at their addresses.
struct example {
    static constexpr profile facts{.name = "example"};
};
using rw = reg<u16, servobus::access::rw, example>;
inline constexpr reg_array<rw, 3> holding{{0x006B, full<u16>, no_unit, 0}, 1};
inline constexpr rw single{0x0001, full<u16>, no_unit, 0}, next{0x0002, full<u16>, no_unit, 0};
inline constexpr rw masked{0x0004, full<u16>, no_unit, 0x12};
inline constexpr reg_array<rw, 6> read_by_17h{{0x0003 + 0x10, full<u16>, no_unit, 0}, 1};
inline constexpr input_reg<u16, example> input{0x0008, full<u16>, no_unit, 10};
inline constexpr coil<servobus::access::rw, example> c00{0x13}, c01{0x14}, c02{0x15}, c03{0x16}, c04{0x17},
    c05{0x18}, c06{0x19}, c07{0x1A}, c08{0x1B}, c09{0x1C};
inline constexpr coil<servobus::access::rw, example> at_ac{0xAC};

using example_values = row_values<holding, single, next, masked, read_by_17h, input, c00, c01, c02, c03, c04,
                                  c05, c06, c07, c08, c09, at_ac>;
using example_executor =
    request_executor<example_values, with_mask_write, with_read_write, with_return_query_data>;

constexpr bool executes_the_examples_of_the_standard() {
    example_values v;
    const auto is = [&v](bytes request, bytes response) {
        return responds<example_executor>(v, request, response);
    };
    v.set<holding>(0, 0x022B);
    v.set<holding>(2, 0x0064);
    return is(hex("0F 00 13 00 0A 02 CD 01"), hex("0F 00 13 00 0A")) && // 6.11
           v.get<c00>() && !v.get<c01>() && v.get<c07>() && v.get<c08>() && !v.get<c09>() &&
           is(hex("01 00 13 00 0A"), hex("01 02 CD 01")) &&                            //
           is(hex("03 00 6B 00 03"), hex("03 06 02 2B 00 00 00 64")) &&                // 6.3
           is(hex("04 00 08 00 01"), hex("04 02 00 0A")) &&                            // 6.4
           is(hex("05 00 AC FF 00"), hex("05 00 AC FF 00")) && v.get<at_ac>() &&       // 6.5
           is(hex("06 00 01 00 03"), hex("06 00 01 00 03")) && v.get<single>() == 3 && // 6.6
           is(hex("08 00 00 A5 37"), hex("08 00 00 A5 37")) &&                         // 6.8
           is(hex("10 00 01 00 02 04 00 0A 01 02"), hex("10 00 01 00 02")) &&          // 6.12
           v.get<single>() == 0x000A && v.get<next>() == 0x0102 &&
           is(hex("16 00 04 00 F2 00 25"), hex("16 00 04 00 F2 00 25")) && v.get<masked>() == 0x17 && // 6.16
           is(hex("17 00 13 00 06 00 14 00 03 06 00 FF 00 FF 00 FF"),                                 // 6.17
              hex("17 0C 00 00 00 FF 00 FF 00 FF 00 00 00 00"));
}
static_assert(executes_the_examples_of_the_standard());

// Each request is wrong in several ways: the first check decides.
constexpr bool checks_in_the_order_of_the_standard() {
    served_rows::values v;
    const auto is = [&v](bytes request, bytes response) {
        return responds<served_rows::executor>(v, request, response);
    };
    return is(hex("07 00 00"), hex("87 01")) &&          // the function before the length
           is(hex("00"), hex("80 01")) &&                // 0 is no function
           is(hex("03 99 99 00 00"), hex("83 03")) &&    // the quantity before the address
           is(hex("03 00 10 00 15"), hex("83 03")) &&    // 21 words: the profile says 20
           is(hex("03 00 10 00"), hex("83 03")) &&       //
           is(hex("03 00 10 00 01 00"), hex("83 03")) && //
           is(hex("03 00 11 00 01"), hex("83 02")) &&    // write-only
           is(hex("03 00 12 00 01"), hex("83 02")) &&    // half of a pair
           is(hex("03 00 13 00 01"), hex("83 02")) &&    // its other half
           is(hex("03 00 13 00 03"), hex("83 02")) &&    //
           is(hex("03 FF FF 00 02"), hex("83 02")) &&    // beyond the address space
           is(hex("03 FF FD 00 03"), hex("03 06 FF FF FF FF 00 00")) &&
           is(hex("06 00 10 00 03"), hex("86 03")) &&                   // a value out of range
           is(hex("06 00 16 00 01"), hex("86 02")) &&                   // read-only
           is(hex("06 00 12 00 01"), hex("86 02")) &&                   // half of a pair
           is(hex("05 99 99 12 34"), hex("85 03")) &&                   // no coil value, before the address
           is(hex("05 00 02 FF 00"), hex("85 02")) &&                   // read-only
           is(hex("10 00 10 00 02 04 00 03 00 00 00"), hex("90 03")) && // a byte too many
           is(hex("10 00 10 00 02 06 00 03 00 00 00 00"), hex("90 03")) &&
           // A bad value before a missing address, and the other way round.
           is(hex("10 00 10 00 07 0E 00 03 00 00 00 00 00 00 00 00 00 00 00 00"), hex("90 02")) &&
           is(hex("10 00 10 00 02 04 00 00 00 0A"), hex("90 03")) &&
           v.get<served_rows::selected>() == served_rows::gear::low &&
           // 17h: the read is checked before the write.
           is(hex("17 00 11 00 01 00 10 00 01 02 00 03"), hex("97 02")) &&
           is(hex("17 00 10 00 01 00 10 00 01 02 00 03"), hex("97 03")) &&
           is(hex("17 00 10 00 01 00 16 00 01 02 00 03"), hex("97 02")) &&
           is(hex("16 00 11 FF FF 00 00"), hex("96 02")) && // reads what is write-only
           is(hex("16 00 10 00 00 00 07"), hex("96 03")) &&
           is(hex("08 00 01 00 00"), hex("88 01")) && // another sub-function
           is(hex("08 00 00 12"), hex("88 03")) && is(hex("83 02"), bytes{}) &&
           is(bytes{}, bytes{}); // no requests
}
static_assert(checks_in_the_order_of_the_standard());

// Functions whose rows a device does not have.
using only_inputs = row_values<served_rows::pressure, served_rows::door, served_rows::level>;
constexpr bool has_the_functions_of_its_rows() {
    only_inputs v;
    const auto is = [&v](bytes request, bytes response) {
        return responds<request_executor<only_inputs>>(v, request, response);
    };
    return is(hex("01 00 07 00 01"), hex("81 01")) && is(hex("02 00 07 00 01"), hex("02 01 00")) &&
           is(hex("03 00 16 00 01"), hex("03 02 00 05")) &&
           is(hex("04 00 10 00 02"), hex("04 04 EE 90 FF FE")) && is(hex("05 00 07 FF 00"), hex("85 01")) &&
           is(hex("06 00 16 00 05"), hex("86 01")) && is(hex("0F 00 07 00 01 01 01"), hex("8F 01")) &&
           is(hex("10 00 16 00 01 02 00 05"), hex("90 01")) &&
           is(hex("16 00 16 00 00 00 00"), hex("96 01")) &&
           is(hex("17 00 16 00 01 00 16 00 01 02 00 05"), hex("97 01")) &&
           is(hex("08 00 00 00 00"), hex("88 01")) && is(hex("11"), hex("91 01")) &&
           is(hex("2B 0E 01 00"), hex("AB 01"));
}
static_assert(has_the_functions_of_its_rows());

// The buffer is as long as the longest run of rows: six words in a request of 17h.
static_assert(served_rows::executor::longest_request == 10 + 2 * 6);

// Runs that are longer than a request: the buffer is as long as a PDU at most.
struct large {
    static constexpr profile facts{.name = "large"};
};
inline constexpr reg_array<reg<u16, servobus::access::rw, large>, 200> many{{0x0100, full<u16>, no_unit, 9},
                                                                            1};
inline constexpr input_reg<u32, large> far_away{0xFFFE, full<u32>, no_unit, 3};
using large_values = row_values<many, far_away>;
// As many rows as a server may have, in an order that must be sorted.
inline constexpr reg_array<reg<u16, servobus::access::rw, large>, 1024> odd{{0x1001, full<u16>, no_unit, 1},
                                                                            2};
inline constexpr reg_array<reg<u16, servobus::access::rw, large>, 1024> even{{0x1000, full<u16>, no_unit, 2},
                                                                             2};
using most_values = row_values<odd, even>;
using large_executor = request_executor<large_values, with_read_write>;
static_assert(large_executor::longest_request == 10 + 2 * 121 && large_executor::longest_response == 252);

constexpr char long_id[] = "0123456789012345678901234567890123456789012345678901234567890123456789";
static_assert(detail::has_each_once<with_mask_write, with_read_write, with_return_query_data,
                                    with_identification<served_rows::about>, with_server_id<long_id>,
                                    with_hooks<int>, with_crc<modbus::default_crc>, with_leading_bytes<4>>());
static_assert(!detail::has_each_once<with_leading_bytes<3>, with_return_query_data, with_leading_bytes<4>>());
constexpr char longest_id[251]{'x'};
static_assert(with_server_id<longest_id>::size == 250);
static_assert(request_executor<only_inputs, with_server_id<long_id>>::longest_response == 70 + 3);
// An ID of one byte, as libmodbus has, and data with a zero inside.
constexpr char one_byte[] = "\xB4";
constexpr char version[] = "T17\0\x02";
using numbered = request_executor<only_inputs, with_server_id<one_byte, version>>;
static_assert(numbered::longest_response == 3 + 1 + 5 && numbered::buffer_size == 9);
static_assert(request_executor<only_inputs, with_server_id<long_id, version>>::longest_response ==
              70 + 3 + 5);
static_assert(with_server_id<long_id>::additional_size == 0);
constexpr bool reports_additional_data() {
    only_inputs v;
    return responds<numbered>(v, hex("11"), hex("11 07 B4 FF 54 31 37 00 02")) &&
           responds<numbered>(v, hex("11 00"), hex("91 03"));
}
static_assert(reports_additional_data());
static_assert(request_executor<only_inputs, with_identification<served_rows::about>>::longest_response ==
              7 + 2 + 16);
static_assert(request_executor<only_inputs>::buffer_size == 7);
inline constexpr identity empty_objects[]{{0, ""}, {1, ""}, {2, ""}};
static_assert(request_executor<only_inputs, with_identification<empty_objects>>::longest_response == 9);
static_assert(detail::option_number<int> == 0); // is none

// A device with coils and holding registers, and without inputs.
using without_inputs = row_values<served_rows::valve, served_rows::selected>;
constexpr bool tells_coils_from_registers() {
    without_inputs v;
    const auto is = [&v](bytes request, bytes response) {
        return responds<request_executor<without_inputs>>(v, request, response);
    };
    return is(hex("03 00 10 00 01"), hex("03 02 00 01")) && is(hex("01 00 00 00 01"), hex("01 01 01")) &&
           is(hex("06 00 10 00 02"), hex("06 00 10 00 02")) &&
           v.get<served_rows::selected>() == served_rows::gear::high;
}
static_assert(tells_coils_from_registers());

struct recorder {
    using changes_of_rows = changes<served_rows::values>;
    std::vector<std::string> calls;
    std::uint8_t refusal = 0;

    void note(const char* hook, const changes_of_rows& c) {
        std::string text = hook;
        if (c.is_written<served_rows::selected>()) text += " selected";
        if (c.is_written<served_rows::travel>()) text += " travel";
        if (c.is_written<served_rows::level>()) text += " level";
        if (c.is_written<served_rows::valve>()) text += " valve";
        if (c.is_written<served_rows::pump>()) text += " pump";
        for (std::size_t i = 0; i < 3; ++i) {
            if (c.is_written<served_rows::lows>(i)) text += " low " + std::to_string(i);
        }
        calls.push_back(text);
    }
    std::uint8_t before_write(const changes_of_rows& c) {
        note("before", c);
        seen = c.get<served_rows::travel>().count();
        seen_valve = c.get<served_rows::valve>();
        seen_pump = c.get<served_rows::pump>();
        seen_low = c.get<served_rows::lows>(1).count();
        seen_last = c.get<served_rows::pairs>(1);
        return refusal;
    }
    void after_write(const changes_of_rows& c) { note("after", c); }
    int seen = 0, seen_low = 0;
    u32 seen_last = 0;
    bool seen_valve = false, seen_pump = false;
};

struct hooked {
    served_rows::values values;
    recorder hooks;
    request_executor<served_rows::values, with_hooks<recorder>, with_mask_write> executor{values, hooks};

    byte_list respond(const byte_list& request) {
        std::uint8_t pdu[decltype(executor)::buffer_size]{};
        std::copy_n(request.begin(), std::min(request.size(), sizeof pdu), pdu);
        const std::size_t size = executor.execute(pdu, request.size());
        return {pdu, pdu + size};
    }
};

constexpr char long_text[] =
    "0123456789012345678901234567890123456789012345678901234567890123456789012345678901234567890123456789"
    "01234567890123456789012345678901234567890123456789";
inline constexpr identity long_objects[]{{0, long_text}, {1, long_text}, {2, "end"}};

inline constexpr identity basic_objects[]{{0, "A"}, {1, "B"}, {2, "C"}};
inline constexpr identity regular_objects[]{{0, "A"}, {1, "B"}, {2, "C"}, {0x7F, "D"}};
inline constexpr identity extended_objects[]{{0, "A"}, {1, "B"}, {2, "C"}, {0x80, "D"}};

} // namespace

TEST_CASE("the examples of the standard, the order of its checks, the functions of the rows") {
    CHECK(executes_the_examples_of_the_standard());
    CHECK(checks_in_the_order_of_the_standard());
    CHECK(has_the_functions_of_its_rows());
}

TEST_CASE("a hook gets the rows that are written, with the values that all rows will have") {
    hooked d;
    CHECK(d.respond({0x10, 0, 0x10, 0, 4, 8, 0, 2, 0, 9, 0x11, 0x70, 0, 1}) ==
          byte_list{0x10, 0, 0x10, 0, 4});
    CHECK(d.hooks.calls == std::vector<std::string>{"before selected travel", "after selected travel"});
    CHECK(d.hooks.seen == 70'000);
    CHECK(d.hooks.seen_valve); // not written: its present value
    CHECK(d.hooks.seen_low == -100);
    CHECK(d.hooks.seen_last == 7);
    CHECK(d.values.get<served_rows::travel>().count() == 70'000);
    d.hooks.calls.clear();
    CHECK(d.respond({0x0F, 0, 0, 0, 2, 1, 2}).size() == 5);
    CHECK(!d.hooks.seen_valve);
    CHECK(d.hooks.seen_pump);
    CHECK(d.respond({0x05, 0, 1, 0, 0}).size() == 5);
    CHECK(!d.hooks.seen_pump);
    CHECK(d.respond({0x06, 0, 0x19, 0, 5}).size() == 5);
    CHECK(d.hooks.seen_low == 5);
    CHECK(d.respond({0x16, 0, 0x19, 0, 0, 0, 6}).size() == 7);
    CHECK(d.hooks.seen_low == 6);
    CHECK(d.hooks.calls == std::vector<std::string>{"before valve pump", "after valve pump", "before pump",
                                                    "after pump", "before low 1", "after low 1",
                                                    "before low 1", "after low 1"});
    CHECK(!d.values.get<served_rows::valve>());
    CHECK(d.respond({0x10, 0, 0x40, 0, 4, 8, 0, 1, 0, 2, 0, 3, 0, 4}).size() == 5);
    CHECK(d.hooks.seen_last == 0x0004'0003);
    CHECK(d.hooks.calls.back() == "after"); // none of those that are named
    CHECK(d.respond({0x10, 0, 0x18, 0, 2, 4, 0, 100, 0xFF, 0xFE}).size() == 5);
    CHECK(d.hooks.seen_low == -2);
}

TEST_CASE("a hook refuses a write with an exception of its own, and nothing changes") {
    hooked d;
    for (const unsigned number : {1u, 4u, 6u, 0x55u, 0xFFu}) {
        d.hooks.refusal = static_cast<std::uint8_t>(number);
        CHECK(d.respond({0x06, 0, 0x10, 0, 2}) == byte_list{0x86, static_cast<std::uint8_t>(number)});
        CHECK(d.respond({0x05, 0, 1, 0xFF, 0}) == byte_list{0x85, static_cast<std::uint8_t>(number)});
        CHECK(d.respond({0x16, 0, 0x10, 0, 0, 0, 2}) == byte_list{0x96, static_cast<std::uint8_t>(number)});
    }
    CHECK(d.values.get<served_rows::selected>() == served_rows::gear::low);
    CHECK(!d.values.get<served_rows::pump>());
    CHECK(d.hooks.calls.size() == 15); // none after a write
    d.hooks.calls.clear();
    CHECK(d.respond({0x06, 0, 0x10, 0, 3}) == byte_list{0x86, 3});
    CHECK(d.respond({0x03, 0, 0x10, 0, 1}).size() == 4);
    CHECK(d.hooks.calls.empty()); // neither for a value out of range nor for a read
}

TEST_CASE("a computed row is computed once in a read, and not at all in a read that is refused") {
    served_rows::values v;
    const auto is = [&v](bytes request, bytes response) {
        return responds<served_rows::executor>(v, request, response);
    };
    served_rows::computed_reads = 0;
    CHECK(is(hex("03 00 14 00 02"), hex("03 04 00 02 00 01")));
    CHECK(served_rows::computed_reads == 1);
    CHECK(is(hex("03 00 14 00 0A"), hex("83 02")));
    CHECK(is(hex("03 00 14 00 01"), hex("83 02")));
    CHECK(is(hex("17 00 14 00 0A 00 10 00 01 02 00 02"), hex("97 02")));
    CHECK(is(hex("17 00 14 00 02 00 10 00 01 02 00 03"), hex("97 03")));
    CHECK(served_rows::computed_reads == 1);
    CHECK(is(hex("17 00 14 00 02 00 10 00 01 02 00 02"), hex("17 04 00 02 00 01")));
    CHECK(served_rows::computed_reads == 2);
    CHECK(is(hex("02 00 07 00 03"), hex("02 01 06")));
    CHECK(is(hex("04 00 10 00 03"), hex("04 06 EE 90 FF FE 00 03")));
}

TEST_CASE("a request that is longer than the buffer is refused as a shorter one") {
    served_rows::values v;
    byte_list pdu{0x10, 0, 0x40, 0, 123, 246};
    pdu.resize(6 + 246);
    CHECK(responds<served_rows::executor>(v, pdu, hex("90 03"))); // the profile: 12 words
    example_values all;
    pdu[2] = 1;
    CHECK(responds<example_executor>(all, pdu, hex("90 02")));
    CHECK(all.get<single>() == 0);
    pdu.push_back(0);
    CHECK(responds<example_executor>(all, pdu, hex("90 03")));
    byte_list coils{0x0F, 0, 0x13, 7, 0xB0, 246};
    coils.resize(6 + 246, 0xFF);
    CHECK(responds<example_executor>(all, coils, hex("8F 02")));
    CHECK(!all.get<c00>());
    coils[4] = 0xB1; // 1969 coils
    coils[5] = 247;
    coils.push_back(0xFF);
    CHECK(responds<example_executor>(all, coils, hex("8F 03")));
    byte_list echo{8, 0, 0};
    echo.resize(example_executor::buffer_size - example_executor::buffer_size % 2 + 1, 7);
    CHECK(responds<example_executor>(
        all, echo, echo.size() > example_executor::buffer_size ? bytes{hex("88 03")} : bytes{echo}));
    echo.resize(253, 7);
    CHECK(responds<example_executor>(all, echo, hex("88 03")));
    echo.resize(254, 7); // no PDU
    CHECK(responds<example_executor>(all, echo, bytes{}));
}

TEST_CASE("runs that are longer than a request") {
    large_values v;
    byte_list response{3, 250};
    for (int i = 0; i < 125; ++i) response.insert(response.end(), {0, 9});
    CHECK(responds<large_executor>(v, hex("03 01 4B 00 7D"), response)); // the last 125 of the run
    CHECK(responds<large_executor>(v, hex("03 01 4C 00 7D"), hex("83 02")));
    CHECK(responds<large_executor>(v, hex("03 01 00 00 7E"), hex("83 03")));
    byte_list write{0x10, 1, 0x4D, 0, 123, 246};
    write.resize(6 + 246, 1);
    CHECK(responds<large_executor>(v, write, hex("10 01 4D 00 7B")));
    CHECK(v.get<many>(76) == 9);
    CHECK(v.get<many>(77) == 0x0101);
    CHECK(v.get<many>(199) == 0x0101);
    byte_list both{0x17, 1, 0, 0, 1, 1, 0, 0, 121, 242};
    both.resize(10 + 242, 2);
    CHECK(responds<large_executor>(v, both, hex("17 02 02 02")));
    CHECK(v.get<many>(120) == 0x0202);
    CHECK(v.get<many>(121) == 0x0101);
    CHECK(responds<large_executor>(v, hex("04 FF FE 00 02"), hex("04 04 00 00 00 03")));
}

TEST_CASE("a server of 2048 rows") {
    most_values v;
    v.set<even>(1023, 7);
    v.set<odd>(0, 8);
    CHECK(responds<request_executor<most_values>>(v, hex("03 10 00 00 04"),
                                                  hex("03 08 00 02 00 08 00 02 00 01")));
    CHECK(responds<request_executor<most_values>>(v, hex("03 17 FD 00 03"), hex("03 06 00 01 00 07 00 01")));
    CHECK(responds<request_executor<most_values>>(v, hex("03 17 FD 00 04"), hex("83 02")));
    CHECK(responds<request_executor<most_values>>(v, hex("06 14 01 12 34"), hex("06 14 01 12 34")));
    CHECK(v.get<odd>(512) == 0x1234);
}

TEST_CASE("an identification comes in as many parts as the buffer needs") {
    served_rows::values v;
    std::vector<std::string> texts;
    unsigned parts = 0;
    modbus::identification_parts all{modbus::identification::extended};
    while (!all.is_done()) {
        std::uint8_t pdu[served_rows::executor::buffer_size]{};
        REQUIRE(modbus::put_identification_request(pdu, all.request()) == 4);
        const std::size_t size = served_rows::executor{v}.execute(pdu, 4);
        const auto part = all.take(bytes{pdu, size});
        REQUIRE(part);
        CHECK(part->conformity == 0x83);
        for (const auto object : *part) texts.emplace_back(object.value.begin(), object.value.end());
        ++parts;
    }
    CHECK(parts > 1);
    CHECK(texts == std::vector<std::string>{"Works", "R-1", "1.0", "Rows of a test", "first of its own", "",
                                            "last of its own"});
    // The conformity level: basic, regular, extended; single objects can be read.
    std::uint8_t pdu[64]{0x2B, 0x0E, 3, 0};
    CHECK(request_executor<served_rows::values, with_identification<basic_objects>>{v}.execute(pdu, 4) == 16);
    CHECK(pdu[3] == 0x81);
    CHECK(pdu[6] == 3);
    std::uint8_t regular[64]{0x2B, 0x0E, 3, 0};
    CHECK(request_executor<served_rows::values, with_identification<regular_objects>>{v}.execute(regular,
                                                                                                 4) == 19);
    CHECK(regular[3] == 0x82);
    std::uint8_t extended[64]{0x2B, 0x0E, 2, 0};
    CHECK(request_executor<served_rows::values, with_identification<extended_objects>>{v}.execute(extended,
                                                                                                  4) == 16);
    CHECK(extended[3] == 0x83);
    // A larger buffer makes no response longer than a PDU.
    std::uint8_t large[400]{0x2B, 0x0E, 1, 0};
    CHECK(request_executor<served_rows::values, with_identification<long_objects>>{v}.execute(large, 4) ==
          7 + 2 + 150);
    CHECK(large[4] == 0xFF);
    const auto is = [&v](bytes request, bytes response) {
        return responds<served_rows::executor>(v, request, response);
    };
    CHECK(is(hex("2B 0E 04 01"), hex("2B 0E 04 83 00 00 01 01 03 52 2D 31")));
    CHECK(is(hex("2B 0E 04 03"), hex("AB 02")));
    // The others begin again with an object that does not exist, or is not of their kind.
    std::uint8_t again[64]{0x2B, 0x0E, 1, 5};
    CHECK(request_executor<served_rows::values, with_identification<basic_objects>>{v}.execute(again, 4) ==
          16);
    CHECK(again[7] == 0);
    std::uint8_t beyond[64]{0x2B, 0x0E, 2, 0x80};
    CHECK(request_executor<served_rows::values, with_identification<extended_objects>>{v}.execute(beyond,
                                                                                                  4) == 16);
    CHECK(beyond[7] == 0);
    CHECK(is(hex("2B 0D 04 01"), hex("AB 01")));
    CHECK(is(hex("2B 0E 05 01"), hex("AB 03")));
    CHECK(is(hex("2B 0E 01"), hex("AB 03")));
    CHECK(is(hex("2B"), hex("AB 03")));
    CHECK(is(hex("11"), hex("11 05 72 6F 77 73 FF")));
    CHECK(is(hex("11 00"), hex("91 03")));
}

} // namespace request_executor_tests
