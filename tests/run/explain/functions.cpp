// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Functions beyond registers in words: the examples of the standard (Modbus Application Protocol V1.1b3, section 6) and
// what may be wrong with each of them.
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/explain/explain.hpp>

#include <tests/support/function_cases.hpp>

namespace explain_functions {

using namespace servobus;
using enum direction;
using tests::printed_pdu;

namespace {

std::vector<std::uint8_t> framed(bytes pdu, std::uint8_t node_address = 1) {
    std::vector<std::uint8_t> frame(pdu.size() + 3, node_address);
    for (std::size_t i = 0; i < pdu.size(); ++i) frame[i + 1] = pdu[i];
    if (!pdu.empty()) CHECK(modbus::close_frame(frame, pdu.size()) == frame.size());
    return pdu.empty() ? std::vector<std::uint8_t>{} : frame;
}

struct said {
    std::string text;
    explanation what;
};
said say(direction way, bytes pdu, bytes before = {}, std::uint8_t node_address = 1) {
    char room[4096];
    const explanation e = explain(zlac8015d::catalogue, way, framed(pdu, node_address), framed(before), room);
    return {std::string{room, e.size}, e};
}

// A request and its response, which are well-formed in one direction each.
struct pair {
    printed_pdu request;
    const char* asks;
    printed_pdu response;
    const char* alone;
    const char* answers;
};

constexpr pair pairs[] = {
    {"01 00 13 00 13", "read coils 0x0013..0x0025", "01 03 CD 6B 05", "3 bytes of coils CD 6B 05",
     "coils 0x0013..0x0025 = 10110011 11010110 101"},
    {"01 00 AC 00 01", "read coil 0x00AC", "01 01 01", "1 byte of coils 01", "coil 0x00AC = on"},
    {"02 00 C4 00 16", "read discrete inputs 0x00C4..0x00D9", "02 03 AC DB 35",
     "3 bytes of discrete inputs AC DB 35", "discrete inputs 0x00C4..0x00D9 = 00110101 11011011 101011"},
    {"07", "read exception status", "07 6D", "exception status 0x6D", "exception status 0x6D"},
    {"0B", "read event counter", "0B FF FF 01 08", "event counter 264, busy", "event counter 264, busy"},
    {"0C", "read event log", "0C 08 00 00 01 08 01 21 20 00",
     "event log of 264 events and 289 messages, newest first: 20 00",
     "event log of 264 events and 289 messages, newest first: 20 00"},
    {"0C", "read event log", "0C 06 00 00 01 08 01 21", "event log of 264 events and 289 messages",
     "event log of 264 events and 289 messages"},
    {"0F 00 13 00 0A 02 CD 01", "write coils 0x0013..0x001C = 10110011 10", "0F 00 13 00 0A",
     "coils 0x0013..0x001C written", "coils 0x0013..0x001C written"},
    {"11", "report server ID", "11 03 07 FF 41", "server ID 07 FF 41", "server ID 07 FF 41"},
    {"17 20 AB 00 02 20 80 00 01 02 01 F4",
     "write left_acceleration_time (0x2080) = 500 ms, then read left_actual_speed (0x20AB), "
     "right_actual_speed (0x20AC)",
     "17 04 00 64 00 64", "2 words 0x0064 0x0064",
     "left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min"},
    {"18 04 DE", "read FIFO queue (0x04DE)", "18 00 06 00 02 01 B8 12 84",
     "FIFO queue, 2 words 0x01B8 0x1284", "FIFO queue (0x04DE), 2 words 0x01B8 0x1284"},
    {"18 04 DE", "read FIFO queue (0x04DE)", "18 00 02 00 00", "FIFO queue, 0 words",
     "FIFO queue (0x04DE), 0 words"},
    {"2B 0E 01 00", "read basic identification", "2B 0E 01 01 00 00 02 00 02 41 42 01 01 22",
     "identification, vendor name \"AB\", product code \"\\x22\"",
     "identification, vendor name \"AB\", product code \"\\x22\""},
    {"2B 0E 04 05", "read identification, model name", "2B 0E 04 02 00 00 01 05 04 7E 5C 7F 20",
     "identification, model name \"~\\x5C\\x7F \"", "identification, model name \"~\\x5C\\x7F \""},
    {"2B 0E 03 80", "read extended identification, from object 0x80 on", "2B 0E 03 83 FF 81 01 80 01 0A",
     "identification, object 0x80 \"\\x0A\", more from object 0x81 on",
     "identification, object 0x80 \"\\x0A\", more from object 0x81 on"},
    {"2B 0E 04 02", "read identification, revision", "2B 0E 04 81 00 00 01 02 03 31 2E 30",
     "identification, revision \"1.0\"", "identification, revision \"1.0\""},
};

// Requests whose responses equal them.
struct repeated {
    printed_pdu pdu;
    const char* asks;
    const char* answers;
};
constexpr repeated all_repeated[] = {
    {"05 00 AC FF 00", "write coil 0x00AC = on", "coil 0x00AC = on written"},
    {"05 00 AC 00 00", "write coil 0x00AC = off", "coil 0x00AC = off written"},
    {"08 00 00 A5 37 00 01", "return query data 0xA537 0x0001", "return query data 0xA537 0x0001"},
    {"08 00 01 00 00", "restart communications", "restart communications, done"},
    {"08 00 01 FF 00", "restart communications and clear the event log",
     "restart communications and clear the event log, done"},
    {"08 00 03 0A 00", "change ASCII delimiter to 0x0A", "change ASCII delimiter to 0x0A, done"},
    {"08 00 0A 00 00", "clear counters and diagnostic register",
     "clear counters and diagnostic register, done"},
    {"08 00 14 00 00", "clear overrun counter", "clear overrun counter, done"},
    {"16 20 34 00 F2 00 25", "mask write left_max_current (0x2034), and 0x00F2, or 0x0025",
     "left_max_current (0x2034), and 0x00F2, or 0x0025 written"},
};

} // namespace

TEST_CASE("each function of the standard is explained in both directions") {
    for (const pair& p : pairs) {
        CAPTURE(p.asks);
        for (const direction way : {unknown, request}) {
            const said asked = say(way, p.request);
            CHECK(asked.text == std::string{"node 1: "} + p.asks);
            CHECK(asked.what.is_valid());
            CHECK(asked.what.way == request);
        }
        for (const direction way : {unknown, response}) {
            const said alone = say(way, p.response);
            CHECK(alone.text == std::string{"node 1: response, "} + p.alone);
            CHECK(alone.what.is_valid());
            const said answer = say(way, p.response, p.request);
            CHECK(answer.text == std::string{"node 1: response, "} + p.answers);
            CHECK(answer.what.is_valid());
            CHECK(answer.what.way == response);
            CHECK(answer.what.mismatch == errc::ok);
        }
        CHECK_FALSE(say(response, p.request).what.is_valid());
        CHECK_FALSE(say(request, p.response).what.is_valid());
    }
}

TEST_CASE("a response that repeats its request is told from it by the given direction alone") {
    for (const repeated& r : all_repeated) {
        CAPTURE(r.asks);
        CHECK(say(request, r.pdu).text == std::string{"node 1: "} + r.asks);
        CHECK(say(response, r.pdu, r.pdu).text == std::string{"node 1: response, "} + r.answers);
        const said either = say(unknown, r.pdu);
        CHECK(either.text == std::string{"node 1: "} + r.asks + " (request, or the response that echoes it)");
        CHECK(either.what.way == unknown);
        CHECK(say(unknown, r.pdu, r.pdu).text ==
              std::string{"node 1: "} + r.asks + " (the request again, or the response that echoes it)");
    }
}

TEST_CASE("a frame that is well-formed in both directions is a response if it fits the request before it") {
    const printed_pdu both{"01 03 00 00 01"};
    CHECK(say(unknown, both).text == "node 1: read coil 0x0300");
    CHECK(say(unknown, both, printed_pdu{"01 00 00 00 11"}).text ==
          "node 1: response, coils 0x0000..0x0010 = 00000000 00000000 1");
    CHECK(say(unknown, both, printed_pdu{"01 00 00 00 20"}).text == "node 1: read coil 0x0300");
    CHECK(say(response, both).text == "node 1: response, 3 bytes of coils 00 00 01");
}

TEST_CASE("an exception names the function, or the request that is refused") {
    CHECK(say(unknown, printed_pdu{"81 02"}).text ==
          "node 1: response, exception 2 (illegal data address) to function 01 (read coils)");
    CHECK(say(unknown, printed_pdu{"81 02"}, printed_pdu{"01 00 13 00 13"}).text ==
          "node 1: response, exception 2 (illegal data address) to read coils 0x0013..0x0025");
    CHECK(say(unknown, printed_pdu{"AB 01"}).text ==
          "node 1: response, exception 1 (illegal function) to function 2Bh (encapsulated interface)");
    CHECK(say(unknown, printed_pdu{"E5 01"}).text ==
          "node 1: response, exception 1 (illegal function) to function 65h (user-defined)");
}

TEST_CASE("a counter of function 08 that is 0 makes the response equal to its request") {
    const printed_pdu counter{"08 00 0B 00 00"};
    CHECK(say(request, counter).text == "node 1: read bus message count");
    CHECK(say(unknown, counter).text ==
          "node 1: read bus message count (request, or the response that echoes it)");
    CHECK(say(response, counter, counter).text == "node 1: response, bus message count 0");
    CHECK(say(unknown, printed_pdu{"08 00 0B 01 08"}, counter).text ==
          "node 1: response, bus message count 264");
    CHECK(say(unknown, printed_pdu{"08 00 02 A5 37"}).text == "node 1: response, diagnostic register 0xA537");
}

TEST_CASE("each counter of function 08 has its name, and its response its count") {
    constexpr const char* names[] = {"bus message count",        "bus communication error count",
                                     "bus exception count",      "server message count",
                                     "server no response count", "server negative acknowledgement count",
                                     "server busy count",        "bus character overrun count"};
    std::uint8_t asked[]{8, 0, 0x0B, 0, 0};
    std::uint8_t answer[]{8, 0, 0x0B, 0x01, 0x08};
    for (const char* name : names) {
        CAPTURE(name);
        CHECK(say(request, asked).text == std::string{"node 1: read "} + name);
        CHECK(say(unknown, answer).text == std::string{"node 1: response, "} + name + " 264");
        ++asked[2];
        ++answer[2];
    }
    CHECK(say(request, printed_pdu{"08 00 02 00 00"}).text == "node 1: read diagnostic register");
    CHECK(say(unknown, printed_pdu{"08 00 04 00 00"}).text ==
          "node 1: force listen-only mode"); // no response
}

TEST_CASE("functions 41h to 48h and 64h to 6Eh are user-defined, their neighbours are not in the standard") {
    const auto name = [](std::uint8_t code) {
        const std::uint8_t pdu[]{code, 7};
        return say(unknown, pdu).text.substr(std::string{"node 1: valid frame of function "}.size());
    };
    CHECK(name(0x40) == "40h (not in the standard), data 07");
    CHECK(name(0x41) == "41h (user-defined), data 07");
    CHECK(name(0x48) == "48h (user-defined), data 07");
    CHECK(name(0x49) == "49h (not in the standard), data 07");
    CHECK(name(0x63) == "63h (not in the standard), data 07");
    CHECK(name(0x64) == "64h (user-defined), data 07");
    CHECK(name(0x6E) == "6Eh (user-defined), data 07");
    CHECK(name(0x6F) == "6Fh (not in the standard), data 07");
}

TEST_CASE("a broadcast of a function that reads is invalid, of one that writes it is not") {
    for (const printed_pdu& pdu : {printed_pdu{"05 00 AC FF 00"}, printed_pdu{"0F 00 13 00 0A 02 CD 01"},
                                   printed_pdu{"16 20 34 00 F2 00 25"}, printed_pdu{"08 00 0A 00 00"}}) {
        const said s = say(unknown, pdu, {}, 0);
        CHECK(s.what.is_valid());
        CHECK(s.what.way == request);
        CHECK(s.text.find("all nodes: ") == 0);
    }
    for (const pair& p : pairs) {
        if (bytes{p.request}[0] == 0x0F) continue;
        const said s = say(unknown, p.request, {}, 0);
        CHECK(s.what.why.error() == errc::bad_argument);
        CHECK(s.text.find("a broadcast read gets no response") != std::string::npos);
    }
}

TEST_CASE("a response that does not fit its request is said to be none") {
    struct row {
        printed_pdu request;
        printed_pdu response;
        errc mismatch;
    };
    constexpr row rows[] = {
        {"01 00 13 00 13", "01 02 CD 6B", errc::wrong_byte_count},
        {"01 00 13 00 13", "01 03 CD 6B 0D", errc::unexpected_value}, // padding
        {"01 00 13 00 13", "02 03 CD 6B 05", errc::wrong_function},
        {"05 00 AC FF 00", "05 00 AD FF 00", errc::wrong_address},
        {"05 00 AC FF 00", "05 00 AC 00 00", errc::wrong_value},
        {"05 00 AC FF 00", "05 00 AC 55 00", errc::wrong_value},
        {"05 00 AC 55 00", "05 00 AC 55 01", errc::wrong_value},
        {"05 00 AC 55 00", "05 00 AC FF 00", errc::wrong_value},
        {"05 00 AC 55 00", "05 00 AC 00 00", errc::wrong_value},
        {"05 00 AC 55 00", "05 00 AD 55 00", errc::wrong_address},
        {"05 00 AC 55 00", "0F 00 AC 00 01", errc::wrong_function},
        {"0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0B", errc::wrong_quantity},
        {"16 20 34 00 F2 00 25", "16 20 34 00 F2 00 24", errc::wrong_value},
        {"08 00 00 A5 37", "08 00 00 A5 38", errc::wrong_value},
        {"2B 0E 04 02", "2B 0E 04 81 00 00 01 03 03 31 2E 30", errc::wrong_address},
    };
    for (const row& r : rows) {
        const said s = say(response, r.response, r.request);
        CAPTURE(s.text);
        CHECK(s.what.is_valid());
        CHECK(s.what.mismatch == r.mismatch);
        CHECK(s.text.find("no response to the request before it") != std::string::npos);
        CHECK(s.text.find("a register holds") == std::string::npos);
    }
}

TEST_CASE("what is wrong with a frame of a function beyond registers is said") {
    struct row {
        direction way;
        printed_pdu pdu;
        errc why;
        const char* text;
    };
    constexpr row rows[] = {
        {unknown, "05 00 01 FF", errc::too_short,
         "request of function 05 (write single coil): frame too short"},
        {unknown, "01 00 00 07 D1", errc::wrong_quantity,
         "request of function 01 (read coils): wrong quantity 2001"},
        {unknown, "01 FF FF 00 02", errc::wrong_address,
         "request of function 01 (read coils): coils beyond 0xFFFF"},
        {unknown, "02 FF FF 00 02", errc::wrong_address,
         "request of function 02 (read discrete inputs): discrete inputs beyond 0xFFFF"},
        {unknown, "02 03 AC DB", errc::wrong_byte_count,
         "response to function 02 (read discrete inputs): wrong byte count 3 with 2 data bytes"},
        {unknown, "0F 00 13 00 0A 01 CD", errc::wrong_byte_count,
         "request of function 0Fh (write multiple coils): wrong byte count 1 with 1 data byte for 10 coils"},
        {unknown, "0F FF FF 00 02", errc::wrong_address,
         "response to function 0Fh (write multiple coils): coils beyond 0xFFFF"},
        {response, "0F 00 00 07 B1", errc::wrong_quantity,
         "response to function 0Fh (write multiple coils): wrong quantity 1969"},
        {response, "0F 00 00 00 00", errc::wrong_quantity,
         "response to function 0Fh (write multiple coils): wrong quantity 0"},
        {unknown, "07 01 02", errc::too_long,
         "response to function 07 (read exception status): frame too long"},
        {request, "07 01", errc::too_long, "request of function 07 (read exception status): frame too long"},
        {unknown, "08 00", errc::too_short, "request of function 08 (diagnostics): frame too short"},
        {unknown, "08 00 00 A5 37 01", errc::wrong_byte_count,
         "request of function 08 (diagnostics): data of half a word"},
        {unknown, "08 00 0A 00 01", errc::wrong_value,
         "request of function 08 (diagnostics): wrong value 0x0001"},
        {response, "08 00 04 00 00", errc::unexpected_value,
         "response to function 08 (diagnostics): content that the standard does not allow"},
        {unknown, "0B 12 34 00 00", errc::unexpected_value,
         "response to function 0Bh (get event counter): content that the standard does not allow"},
        {unknown, "0C 05 00 00 00 00 00", errc::wrong_byte_count,
         "response to function 0Ch (get event log): wrong byte count 5 with 5 data bytes"},
        {unknown, "11 00", errc::wrong_byte_count,
         "response to function 11h (report server ID): wrong byte count 0 with 0 data bytes"},
        {unknown, "16 00 04 00 F2 00", errc::too_short,
         "request of function 16h (mask write register): frame too short"},
        {unknown, "17 00 03 00 00 00 0E 00 01 02 00 FF", errc::wrong_quantity,
         "request of function 17h (read and write registers): wrong quantity 0 to read, 1 to write"},
        {unknown, "17 00 03 00 01 00 0E 00 01 03 00 FF", errc::wrong_byte_count,
         "request of function 17h (read and write registers): wrong byte count 3 with 2 data bytes for 1 "
         "register"},
        {unknown, "17 03 00 FE 01", errc::wrong_byte_count,
         "response to function 17h (read and write registers): wrong byte count 3 with 3 data bytes"},
        {unknown, "18 00 06 00 03 01 B8 12 84", errc::wrong_quantity,
         "response to function 18h (read FIFO queue): wrong quantity 3"},
        {unknown, "18 00 07 00 02 01 B8 12 84", errc::wrong_byte_count,
         "response to function 18h (read FIFO queue): wrong byte count 7 with 6 data bytes"},
        {unknown, "2B", errc::too_short, "request of function 2Bh (encapsulated interface): frame too short"},
        {unknown, "2B 0E 05 00", errc::wrong_value,
         "request of function 2Bh (encapsulated interface): wrong value 0x05"},
        {unknown, "2B 0E 05 01 00 00 01 00 00", errc::wrong_value,
         "response to function 2Bh (encapsulated interface): wrong value 0x05"},
        {unknown, "2B 0E 00 01 00 00 01 00 00", errc::wrong_value,
         "response to function 2Bh (encapsulated interface): wrong value 0x00"},
        {unknown, "2B 0E 01 01 00 00 00 00 00", errc::wrong_quantity,
         "response to function 2Bh (encapsulated interface): wrong quantity 0"},
        {unknown, "2B 0E 01 01 00 00 01 00 05", errc::too_short,
         "response to function 2Bh (encapsulated interface): frame too short"},
    };
    for (const row& r : rows) {
        const said s = say(r.way, r.pdu);
        CHECK(s.text == std::string{"node 1: invalid "} + r.text);
        CHECK(s.what.why.error() == r.why);
        CHECK(s.what.way == unknown);
    }
}

} // namespace explain_functions
