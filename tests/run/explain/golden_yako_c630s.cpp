// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every frame that the manuals of the YAKOTEC steppers and the C630S print (tests/manuals/*_frames.csv):
// parsed, built again from its parts, exchanged as printed, and explained in the words next to it. Frames
// that are wrong in print are rejected for their own reasons; golden.cpp has those one by one.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/explain/explain.hpp>
#include <servobus/modbus/exchange.hpp>

#include <tests/support/manual.hpp>
#include <tests/support/scripted_port.hpp>

namespace golden_yako_c630s_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::byte_list;

namespace {

struct row {
    bool is_request;
    byte_list data;
    std::string meaning;
    std::string explained;
};

std::vector<row> rows_of(const std::string& file) {
    std::vector<row> rows;
    for (const std::string& line : tests::manual(file)) {
        if (line.rfind("direction", 0) == 0) continue;
        const auto quoted = tests::split(line, '"');
        REQUIRE(quoted.size() == 5); // two quoted fields
        const auto plain = tests::split(quoted[0], ',');
        row r{plain[0] == "request", {}, quoted[1], quoted[3]};
        REQUIRE((r.is_request || plain[0] == "response"));
        for (const std::string& byte : tests::split(plain[1], ' '))
            r.data.push_back(static_cast<std::uint8_t>(std::stoul(byte, nullptr, 16)));
        rows.push_back(std::move(r));
    }
    return rows;
}

bool is_invalid(const row& r) { return r.explained.find("invalid") != std::string::npos; }

/// A frame of a function beyond registers, which `made_again` does not build.
bool is_of_other_function(const row& r) {
    const std::uint8_t code = r.data[1];
    return code < exception_flag && !is_read(code) && !is_write(code);
}

/// The frame that the library builds from the same parts.
byte_list made_again(const row& p) {
    const auto f = open_frame(p.data);
    REQUIRE(f);
    byte_list again(40);
    again[0] = f->address;
    const byte_buffer body = byte_buffer{again}.subspan(1);
    std::size_t size = 0;
    if (p.is_request) {
        const auto r = parse_request(f->pdu);
        REQUIRE(r);
        std::vector<std::uint16_t> words;
        for (std::size_t i = 0; i < r->values().size(); ++i) words.push_back(r->values()[i]);
        size = is_read(r->code)
                   ? put_read_request(body, static_cast<function>(r->code), r->address, r->quantity)
               : r->code == 0x06 ? put_write_request(body, r->address, words[0])
                                 : put_write_request(body, r->address, words);
    } else {
        const auto r = parse_response(f->pdu);
        REQUIRE(r);
        if (r->is_exception) {
            body[0] = static_cast<std::uint8_t>(r->code | 0x80u);
            body[1] = r->exception;
            size = 2;
        } else if (is_read(r->code)) {
            body[0] = r->code;
            body[1] = static_cast<std::uint8_t>(2 * r->quantity);
            for (std::size_t i = 0; i < r->quantity; ++i) store_word(body, 2 + 2 * i, r->values()[i]);
            size = 2u + 2u * r->quantity;
        } else {
            body[0] = r->code;
            store_word(body, 1, r->address);
            store_word(body, 3, r->code == 0x06 ? r->values()[0] : r->quantity);
            size = 5;
        }
    }
    again.resize(close_frame(again, size));
    return again;
}

void check_frames(const std::string& file, const catalogue& map, std::size_t count) {
    const auto rows = rows_of(file);
    CHECK(rows.size() == count);
    byte_list before;
    for (const row& r : rows) {
        CAPTURE(r.meaning);
        char room[400];
        const explanation e = r.is_request ? explain(map, direction::request, r.data, room)
                                           : explain(map, direction::response, r.data, before, room);
        CHECK(std::string(room, e.size) == r.explained);
        CHECK(e.is_valid() == !is_invalid(r));
        if (open_frame(r.data) && !(r.is_request && is_invalid(r)) && !is_of_other_function(r))
            CHECK(made_again(r) == r.data);
        if (r.is_request) before = r.data;
    }
}

/// How the exchange of a printed request ends after the printed response.
status ends(const row& request, const row& response, const response_limits& limits) {
    byte_list room(80);
    const rtu_timing timing = timing_at(115200);
    exchange x{request.data, room, timing, limits};
    x.sent({0});
    x.feed(response.data, {2000});
    return x.status();
}

void check_dialogues(const std::string& file, const profile& facts) {
    const auto rows = rows_of(file);
    std::size_t dialogues = 0;
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        if (!rows[i].is_request || rows[i + 1].is_request || is_invalid(rows[i]) ||
            is_of_other_function(rows[i]))
            continue;
        CAPTURE(rows[i].meaning);
        const auto response = parse_response(open_frame(rows[i + 1].data)->pdu);
        const status why = ends(rows[i], rows[i + 1], facts.limits);
        CHECK(why.error() == (response->is_exception ? errc::exception : errc::ok));
        CHECK(why.exception() == (response->is_exception ? response->exception : 0));
        ++dialogues;
    }
    CHECK(dialogues >= 3);
}

} // namespace

TEST_CASE("YAKO: every printed frame is built again and explained in the listed words") {
    check_frames("yako_frames.csv", yako::closed_loop::catalogue, 46);
}

TEST_CASE("YAKO: every printed dialogue ends as the manual states, with its own exception numbers") {
    check_dialogues("yako_frames.csv", yako::closed_loop::device::facts);
    check_dialogues("yako_frames.csv", yako::open_loop::device::facts);
}

TEST_CASE("YAKO, 3.4: address 003Ch is empty in open loop only [errata A7]") {
    CHECK(yako::open_loop::catalogue.find(0x003C) == nullptr);
    CHECK(yako::closed_loop::catalogue.find(0x003C) != nullptr);
}

TEST_CASE("C630S: every printed frame is built again and explained in the listed words") {
    check_frames("c630s_frames.csv", c630s::catalogue, 7);
}

TEST_CASE(
    "C630S: every printed dialogue ends as the manual states, also the one with the byte count as quantity") {
    check_dialogues("c630s_frames.csv", c630s::device::facts);
    const auto rows = rows_of("c630s_frames.csv");
    REQUIRE(rows.size() == 7);
    CHECK(ends(rows[4], rows[5], yako::closed_loop::device::facts.limits).error() == errc::wrong_quantity);
}

TEST_CASE("a 32-bit value is explained in the word order that is given, or in the factory's, which is then "
          "stated") {
    const byte_list response = rows_of("c630s_frames.csv")[1].data;
    const byte_list request = rows_of("c630s_frames.csv")[0].data;
    char room[200];
    const auto words = [&](word_order order) {
        const explanation e = explain(c630s::catalogue, direction::response, response, request, room, order);
        return std::string(room, e.size);
    };
    CHECK(words(word_order::low_first) == "node 1: response, feedback_pulses = 13107300 counts");
    CHECK(words(word_order::high_first) == "node 1: response, feedback_pulses = 6553800 counts");
    CHECK(words(word_order::unknown) ==
          "node 1: response, feedback_pulses = 13107300 counts (in the factory's word order)");
}

} // namespace golden_yako_c630s_tests
