// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every frame that a manual prints: the library builds it from the meaning that the manual states, parses it,
// accepts its response and explains it. Frames that are wrong in print are rejected, each for its own reason.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/explain/explain.hpp>
#include <servobus/modbus/exchange.hpp>
#include <servobus/modbus/rtu.hpp>

#include <tests/manuals/zlac8015d_frames.hpp>
#include <tests/support/manual.hpp>
#include <tests/support/scripted_port.hpp>

namespace golden_tests {

using namespace servobus;
using namespace servobus::modbus;
using tests::byte_list;
using tests::printed_frame;
using tests::zlac8015d_frames;

namespace {

// At compile time: each frame is opened, parsed and built again from its fields.
constexpr bool is_made_again(const printed_frame& p) {
    const auto f = open_frame(p.frame());
    if (!f || f->address != 1) return false;
    std::array<std::uint8_t, 17> again{1};
    const byte_buffer body = byte_buffer{again}.subspan(1);
    std::size_t size = 0;
    if (p.is_request) {
        const auto r = parse_request(f->pdu);
        if (!r) return false;
        std::array<std::uint16_t, 4> words{};
        for (std::size_t i = 0; i < r->values().size(); ++i) words[i] = r->values()[i];
        if (is_read(r->code)) {
            size = put_read_request(body, static_cast<function>(r->code), r->address, r->quantity);
        } else if (r->code == 0x06) {
            size = put_write_request(body, r->address, words[0]);
        } else {
            size =
                put_write_request(body, r->address, std::span<const std::uint16_t>{words}.first(r->quantity));
        }
    } else {
        const auto r = parse_response(f->pdu);
        if (!r || r->is_exception) return false;
        body[0] = r->code;
        if (is_read(r->code)) {
            body[1] = static_cast<std::uint8_t>(2 * r->quantity);
            for (std::size_t i = 0; i < r->quantity; ++i) store_word(body, 2 + 2 * i, r->values()[i]);
            size = 2u + 2u * r->quantity;
        } else {
            store_word(body, 1, r->address);
            store_word(body, 3, r->code == 0x06 ? r->values()[0] : r->quantity);
            size = 5;
        }
    }
    return same_bytes(bytes{again}.first(close_frame(again, size)), p.frame());
}
template <std::size_t From, std::size_t To> constexpr bool are_made_again() {
    for (std::size_t i = From; i < To; ++i) {
        if (!is_made_again(zlac8015d_frames[i])) return false;
    }
    return true;
}
static_assert(std::size(zlac8015d_frames) == 133);
static_assert(are_made_again<0, 45>());
static_assert(are_made_again<45, 90>());
static_assert(are_made_again<90, 133>());

/// One register and its value, out of "0x2088 left target speed = -100 r/min".
struct said {
    std::uint16_t address;
    std::int64_t value;
    bool is_pair;
};
std::vector<said> registers_of(const std::string& meaning) {
    std::vector<said> all;
    for (const std::string& part : tests::split(meaning, ',')) {
        const std::size_t at = part.find("0x");
        const std::size_t equals = part.find(" = ");
        if (at == std::string::npos || equals == std::string::npos) continue;
        all.push_back({static_cast<std::uint16_t>(std::stoul(part.substr(at + 2), nullptr, 16)),
                       std::stoll(part.substr(equals + 3)), part.find("pulses") != std::string::npos});
    }
    return all;
}

/// The frame that has this meaning, built by the library.
byte_list frame_of(const std::string& meaning) {
    const auto made = [](bytes b) { return byte_list(b.begin(), b.end()); };
    if (meaning.rfind("read ", 0) == 0) {
        const auto quantity = static_cast<std::uint16_t>(std::stoul(meaning.substr(5)));
        const auto address =
            static_cast<std::uint16_t>(std::stoul(meaning.substr(meaning.find("0x") + 2), nullptr, 16));
        return made(read_frame(1, address, quantity));
    }
    const std::vector<said> all = registers_of(meaning);
    REQUIRE_FALSE(all.empty());
    std::vector<std::uint16_t> words;
    for (const said& s : all) {
        if (s.is_pair) words.push_back(static_cast<std::uint16_t>(s.value >> 16 & 0xFFFF));
        words.push_back(static_cast<std::uint16_t>(s.value & 0xFFFF));
    }
    if (words.size() == 1) return made(write_frame(1, all[0].address, words[0]));
    byte_list frame(9 + 2 * words.size(), 1);
    const std::size_t size =
        close_frame(frame, put_write_request(byte_buffer{frame}.subspan(1), all[0].address, words));
    return made(bytes{frame}.first(size));
}

std::string words_of(const catalogue& map, direction way, bytes frame, bytes request, explanation& found) {
    std::array<char, 400> room{};
    found = explain(map, way, frame, request, room);
    return {room.data(), found.size};
}

} // namespace

TEST_CASE("the table of printed frames in the program is the manual's list, row by row") {
    const auto lines = tests::manual("zlac8015d_frames.csv");
    REQUIRE(lines.size() == std::size(zlac8015d_frames) + 1);
    CHECK(lines[0] == "direction,hex,meaning");
    for (std::size_t i = 0; i < std::size(zlac8015d_frames); ++i) {
        CAPTURE(i);
        const printed_frame& p = zlac8015d_frames[i];
        std::string text = p.is_request ? "request" : "response";
        for (std::size_t k = 0; k < p.size; ++k) {
            const char* digits = "0123456789ABCDEF";
            text += k == 0 ? ',' : ' ';
            text += digits[p.data[k] >> 4];
            text += digits[p.data[k] & 15];
        }
        text += std::string{",\""} + p.meaning + '"';
        CHECK(text == lines[i + 1]);
        CHECK(is_made_again(p));
    }
}

TEST_CASE("every printed request and every echo is the frame that the library builds from its meaning") {
    unsigned made = 0;
    for (const printed_frame& p : zlac8015d_frames) {
        std::string meaning = p.meaning;
        CAPTURE(meaning);
        if (meaning.rfind("echo of ", 0) == 0) meaning = meaning.substr(8);
        if (meaning.rfind("write ", 0) != 0 && meaning.rfind("read ", 0) != 0) continue;
        CHECK(same_bytes(frame_of(meaning), p.frame()));
        ++made;
    }
    CHECK(made == 121);
}

TEST_CASE("every printed request accepts the response that is printed below it, and no other") {
    const response_limits usual;
    const rtu_timing timing = timing_at(115200);
    unsigned answered = 0;
    for (std::size_t i = 0; i + 1 < std::size(zlac8015d_frames); ++i) {
        const printed_frame& q = zlac8015d_frames[i];
        if (!q.is_request || zlac8015d_frames[i + 1].is_request) continue; // one response is not printed
        CAPTURE(i);
        for (const printed_frame& a : zlac8015d_frames) {
            if (a.is_request) continue;
            std::array<std::uint8_t, 32> room{};
            exchange x{q.frame(), room, timing, usual};
            x.sent({0});
            x.feed(a.frame(), {1000});
            x.elapse({50'000});
            x.elapse({150'000});
            REQUIRE(x.done());
            const bool is_its_own = same_bytes(a.frame(), zlac8015d_frames[i + 1].frame());
            REQUIRE((x.status().error() == errc::ok) == is_its_own);
        }
        ++answered;
    }
    CHECK(answered == 66);
}

TEST_CASE("the printed response to the printed read of the speeds is 10.0 r/min for each wheel") {
    const response_limits usual;
    const rtu_timing timing = timing_at(115200);
    std::array<std::uint8_t, 9> room{};
    exchange x{zlac8015d_frames[0].frame(), room, timing, usual};
    x.sent({0});
    x.feed(zlac8015d_frames[1].frame(), {1000});
    REQUIRE(x.words().size() == 2);
    CHECK(x.words()[0] == 100);
    CHECK(x.words()[1] == 100);
}

TEST_CASE("every printed frame is explained without an error and names its registers") {
    const catalogue& map = zlac8015d::catalogue;
    bytes before{};
    for (const printed_frame& p : zlac8015d_frames) {
        CAPTURE(p.meaning);
        explanation found{};
        const direction way = p.is_request ? direction::request : direction::response;
        const std::string words = words_of(map, way, p.frame(), p.is_request ? bytes{} : before, found);
        CAPTURE(words);
        CHECK(found.is_valid());
        CHECK(found.mismatch == errc::ok);
        CHECK(found.way == way);
        if (p.is_request) before = p.frame();
        const auto request = parse_request(open_frame(before)->pdu);
        REQUIRE(request);
        for (unsigned i = 0; i < request->quantity; ++i) {
            const entry* e = map.find(static_cast<u16>(request->address + i));
            REQUIRE(e != nullptr);
            CHECK(words.find(e->name) != std::string::npos);
        }
        if (p.is_request) {
            for (const said& s : registers_of(p.meaning)) {
                if (map.find(s.address)->names != naming::number) continue;
                CHECK(words.find(std::to_string(s.value)) != std::string::npos);
            }
        }
    }
}

// Frames that are wrong in print, or that show how a device deviates from the standard.

TEST_CASE("YAKO, 3.4: the request with a CRC made wrong on purpose is rejected for its CRC") {
    constexpr auto wrong = hex("01 03 00 20 00 01 85 C1");
    static_assert(open_frame(wrong).error() == errc::bad_crc);
    constexpr auto right = hex("01 03 00 20 00 01 85 C0");
    static_assert(same_bytes(read_frame(1, 0x0020, 1), right));
    CHECK(open_frame(wrong).error() == errc::bad_crc);
    CHECK(open_frame(right));
}

TEST_CASE("YAKO, 4.1: the malformed write with a good CRC is rejected for its byte count") {
    // Five registers, a byte count of 12, and 13 bytes of data.
    constexpr auto wrong = hex("01 10 00 21 00 05 0C 00 0A 00 64 00 64 00 3C 00 00 00 03 E8 04 76");
    static_assert(open_frame(wrong));
    static_assert(parse_request(open_frame(wrong)->pdu).error() == errc::wrong_byte_count);
    CHECK(open_frame(wrong));
    CHECK(parse_request(open_frame(wrong)->pdu).error() == errc::wrong_byte_count);
    // The frame that was meant.
    constexpr auto meant = hex("01 10 00 20 00 06 0C 00 0A 00 64 00 64 00 3C 00 00 03 E8 DD 68");
    constexpr std::array<std::uint16_t, 6> words{10, 100, 100, 60, 0, 1000};
    static_assert(same_bytes(write_frame(1, 0x0020, words), meant));
    const auto r = parse_request(open_frame(meant)->pdu);
    REQUIRE(r);
    CHECK(r->quantity == 6);
    explanation found{};
    (void)words_of(zlac8015d::catalogue, direction::request, wrong, {}, found);
    CHECK(found.why.error() == errc::wrong_byte_count);
}

TEST_CASE("YAKO, 3.4: exceptions keep the device's own numbers") {
    constexpr auto crc_error = hex("01 83 01 80 F0");
    constexpr auto violation = hex("01 86 06 C2 62");
    CHECK(parse_response(open_frame(crc_error)->pdu)->exception == 1);
    CHECK(parse_response(open_frame(violation)->pdu)->exception == 6);
    CHECK(parse_response(open_frame(violation)->pdu)->code == 6);
}

TEST_CASE("C630S, 9.2.3: a response with the byte count as quantity is accepted only where the device's "
          "limits allow it") {
    constexpr auto request = hex("01 10 11 0C 00 02 04 38 80 00 01 FE E2");
    constexpr auto printed = hex("01 10 11 0C 00 04 04 F5");
    constexpr auto standard = hex("01 10 11 0C 00 02 84 F7");
    constexpr std::array<std::uint16_t, 2> words{0x3880, 0x0001}; // 80000, low word first
    static_assert(same_bytes(write_frame(1, 0x110C, words), request));
    const rtu_timing timing = timing_at(19200);
    const auto ends = [&](bytes response, bool has_quirk) {
        response_limits limits;
        limits.echoes_byte_count = has_quirk;
        std::array<std::uint8_t, 8> room{};
        exchange x{request, room, timing, limits};
        x.sent({0});
        x.feed(response, {5000});
        return x.status().error();
    };
    CHECK(ends(standard, false) == errc::ok);
    CHECK(ends(standard, true) == errc::ok);
    CHECK(ends(printed, true) == errc::ok);
    CHECK(ends(printed, false) == errc::wrong_quantity);
}

TEST_CASE("C630S, 9.2.1 and 9.2.4: a 32-bit value has its low word first, and an exception is parsed without "
          "its request") {
    constexpr auto request = hex("01 03 0B 11 00 02 96 2A");
    constexpr auto response = hex("01 03 04 00 64 00 C8 BA 7A");
    static_assert(same_bytes(read_frame(1, 0x0B11, 2), request));
    const auto r = parse_response(open_frame(response)->pdu);
    REQUIRE(r);
    CHECK(join_words(r->values()[0], r->values()[1], word_order::low_first) == 13'107'300);
    constexpr auto refused = hex("01 83 02 C0 F1");
    CHECK(parse_response(open_frame(refused)->pdu)->exception == 2);
}

} // namespace golden_tests
