// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The tool parses frames as other programs log them, and finds them among noise and beside each other.
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <examples/servobus/frames/log_line.hpp>

namespace log_line_tests {

using servobus::direction;
using servobus::hex;
using tool::captured;
using tool::found_frames;
using tool::frame_bytes;
using tool::parse_captured;
using tool::log_line::find_frames;
using enum servobus::direction;

namespace {

frame_bytes list(servobus::bytes b) { return {b.begin(), b.end()}; }

const frame_bytes request_bytes = list(hex("01 03 00 00 00 02 C4 0B"));
const frame_bytes response_bytes = list(hex("01 03 04 00 01 00 02 2A 32"));

struct row {
    std::string_view line;
    const frame_bytes& frame;
    direction way = unknown;
    direction of_client = unknown;
};

} // namespace

TEST_CASE("a frame is parsed in each form in which programs log it") {
    const row rows[] = {
        {"01 03 00 00 00 02 C4 0B", request_bytes},
        {"010300000002C40B", request_bytes},
        {"> 01 03 00 00 00 02 C4 0B", request_bytes, request},
        {"<010304000100022A32", response_bytes, response},
        {"0x1 0x3 0x0 0x0 0x0 0x2 0xc4 0xb        # pymodbus", request_bytes},
        {"0x01,0x03,0x00,0x00,0x00,0x02,0xC4,0x0B", request_bytes},
        {"{0x01, 0x03, 0x00, 0x00, 0x00, 0x02, 0xC4, 0x0B};", request_bytes},
        {"0x010x030x000x000x000x020xC40x0B", request_bytes},
        {R"(b"\x01\x03\x00\x00\x00\x02\xc4\x0b")", request_bytes},
        {"01.03.00.00.00.02.C4.0B (8)             # ESPHome modbus write", request_bytes},
        {">>> 01:03:00:00:00:02:C4:0B             # ESPHome uart debug", request_bytes, unknown, request},
        {"<<< 01:03:04:00:01:00:02:2A:32", response_bytes, unknown, response},
        {"[01][03][00][00][00][02][C4][0B]        # libmodbus, mbpoll -v", request_bytes, unknown, request},
        {"<01><03><04><00><01><00><02><2A><32>", response_bytes, unknown, response},
        {"<Buffer 01 03 00 00 00 02 c4 0b>        # node", request_bytes},
        {"Tx:000001-01 03 00 00 00 02 C4 0B       # Modbus Poll", request_bytes, unknown, request},
        {"Rx:000002-01 03 04 00 01 00 02 2A 32", response_bytes, unknown, response},
        {"TX: 01-03-00-00-00-02-C4-0B", request_bytes, unknown, request},
        {"01-03-00-00-00-02-C4-0B                 # .NET", request_bytes},
        {"\t-> 01 03 00 00 00 02 C4 0B\r", request_bytes, request},
        {"[2026-01-02 03:04:05.678] <<< 01:03:04:00:01:00:02:2A:32", response_bytes, unknown, response},
        {"2026-01-02T03:04:05Z > 01 03 00 00 00 02 C4 0B", request_bytes, request},
        {"03:04:05,678 [01][03][00][00][00][02][C4][0B]", request_bytes, unknown, request},
        {"/dev/ttyUSB0 sent: 01 03 00 00 00 02 C4 0B", request_bytes},
        {"[D][uart_debug:158]: >>> 01:03:00:00:00:02:C4:0B", request_bytes, unknown, request},
        {"01 03 00 00 00 02 C4 0B and more", request_bytes},
        {"[16:40:36.035][D][modbus_bridge:695]: RTU send: 01 03 00 00 00 02 C4 0B  client_id=1",
         request_bytes},
        {"13:03:20.743 NRG: Modbus register 2, phase 0, rcvd 010304000100022A32, T 0, F 0, value -172.5",
         response_bytes},
    };
    for (const row& r : rows) {
        CAPTURE(r.line);
        const std::optional<captured> c = parse_captured(r.line);
        REQUIRE(c);
        CHECK(c->frame == r.frame);
        CHECK(c->way == r.way);
        CHECK(c->of_client == r.of_client);
        const found_frames found = find_frames(c->frame);
        CHECK(found.frames.size() == 1);
        CHECK(found.left_over() == 0);
    }
}

TEST_CASE("a line that is no frame in hex is refused") {
    for (const std::string_view line :
         {"", "  ", "# 01 03 00 00 00 02 C4 0B", "what is this", "1 3 0 0 0 2 c4 b", "01 03 00 00 00 02 C4 0",
          "01 03 00 00 00 02 C4 0x", "0103000000 2C40B", "0x103", "Tx:", ">", "<Buffer>", "[]", "(8)",
          "frame 01 03 00 00 00 02 C4 0C", "01 03 00 00 00 02 C4 0C and more",
          "00 01 00 00 00 06 01 03 00 0A 00 and more", "at 01 03 00 00 00 02 C4 0B 11 bytes"}) {
        CAPTURE(line);
        CHECK_FALSE(parse_captured(line));
    }
}

TEST_CASE("frames of Modbus TCP are found where a line has them alone, in any form") {
    for (const std::string_view line :
         {"00 01 00 00 00 06 11 03 00 0A 00 02", "[00][01][00][00][00][06][11][03][00][0A][00][02]",
          "2024-08-29 20:58:01,016 DEBUG logging:103 SEND: 0x0 0x1 0x0 0x0 0x0 0x6 0x11 0x3 0x0 0xa 0x0 0x2",
          "sent 000100000006 1103000A0002, sent"}) {
        CAPTURE(line);
        const std::optional<captured> c = parse_captured(line);
        REQUIRE(c);
        const std::vector<tool::tcp_frame> found = tool::tcp_frames_of(c->frame);
        REQUIRE(found.size() == 1);
        CHECK(found[0].transaction == 1);
        CHECK(found[0].unit == 0x11);
        CHECK(found[0].size == 12);
        CHECK(found[0].rtu == list(hex("11 03 00 0A 00 02 E6 99")));
    }
    const auto count = [](servobus::bytes all) { return tool::tcp_frames_of(all).size(); };
    CHECK(count(hex("00 01 00 00 00 06 01 03 00 0A 00 02 00 01 00 00 00 03 01 83 02")) == 2);
    CHECK(count(hex("00 01 00 00 00 06 FF 03 00 0A 00 02")) == 1);
    CHECK(count(hex("00 01 00 01 00 06 01 03 00 0A 00 02")) == 0); // another protocol
    CHECK(count(hex("00 01 00 00 00 07 01 03 00 0A 00 02")) == 0); // not whole
    CHECK(count(hex("00 01 00 00 00 06 01 03 00 0A 00 02 00")) == 0);
    CHECK(count(hex("00 01 00 00 00 01 01")) == 0);                // without a PDU
    CHECK(count(hex("00 01 00 00 00 06 01 03 00 0A 00 00")) == 0); // reads nothing
    CHECK(count(hex("00 01 00 00 00 05 01 65 00 0A 00")) == 0);    // of a function that proves nothing
    CHECK(count(hex("01 03 00 00 00 02 C4 0C")) ==
          0); // a damaged RTU frame: one byte of a PDU proves nothing
    CHECK(count(hex("")) == 0);
}

TEST_CASE("damaged bytes stay what was logged") {
    const std::optional<captured> c = parse_captured("Tx:000001-01 03 00 00 00 02 C4 0C");
    REQUIRE(c);
    CHECK(c->frame == list(hex("01 03 00 00 00 02 C4 0C")));
    CHECK(find_frames(c->frame).frames.empty());
    CHECK(find_frames(c->frame).noise == c->frame);
}

TEST_CASE("a request and its response in one read are two frames") {
    const found_frames found = find_frames(hex("01 03 00 00 00 02 C4 0B 01 03 04 00 01 00 02 2A 32"));
    REQUIRE(found.frames.size() == 2);
    CHECK(found.frames[0].frame == request_bytes);
    CHECK(found.frames[1].frame == response_bytes);
    CHECK(found.left_over() == 0);
}

TEST_CASE("frames of other functions are found beside each other, by their lengths") {
    const std::vector<frame_bytes> dialogue = {
        list(hex("01 01 00 00 00 0A BC 0D")),
        list(hex("01 01 02 CD 01 2C AC")),
        list(hex("01 05 00 AC FF 00 4C 1B")),
        list(hex("01 05 00 AC FF 00 4C 1B")),
        list(hex("01 0F 00 13 00 0A 02 CD 01 72 CB")),
        list(hex("01 0F 00 13 00 0A 24 09")),
        list(hex("11 11 CD EC")),
        list(hex("01 83 02 C0 F1")),
        list(hex("01 2B 0E 01 00 70 77")),
        list(hex("01 2B 0E 01 01 00 00 01 00 01 41 2F A7")),
        list(hex("02 07 41 12")),
        list(hex("02 07 6D 13 DD")),
        list(hex("01 08 00 00 12 34 ED 7C")),
        list(hex("01 08 00 00 12 34 ED 7C")),
    };
    frame_bytes all;
    for (const frame_bytes& f : dialogue) {
        CHECK(servobus::modbus::crc16(f) == 0);
        all.insert(all.end(), f.begin(), f.end());
    }
    const found_frames found = find_frames(all);
    REQUIRE(found.frames.size() == dialogue.size());
    for (std::size_t i = 0; i < dialogue.size(); ++i) CHECK(found.frames[i].frame == dialogue[i]);
    CHECK(found.left_over() == 0);
}

TEST_CASE("noise before and after a frame is no part of it") {
    const found_frames found = find_frames(hex("FF 00 9C 03 04 00 ED 18 AA AC B0 00"));
    REQUIRE(found.frames.size() == 1);
    CHECK(found.frames[0].noise == list(hex("FF 00")));
    CHECK(found.frames[0].frame == list(hex("9C 03 04 00 ED 18 AA AC B0")));
    CHECK(found.noise == list(hex("00")));
    CHECK(found.left_over() == 3);
    // Zeros keep the CRC right; the function's length decides.
    const found_frames zeros = find_frames(hex("01 03 00 00 00 02 C4 0B 00 00 00"));
    REQUIRE(zeros.frames.size() == 1);
    CHECK(zeros.frames[0].frame == request_bytes);
    CHECK(zeros.noise.size() == 3);
}

TEST_CASE("a frame of a function without a known length ends with the line, after an idle line only") {
    const auto user_defined = hex("01 65 06 20 0E 00 08 40 30");
    const auto with = [&](servobus::bytes before) {
        frame_bytes all = list(before);
        frame_bytes framed = list(user_defined);
        framed.resize(framed.size() - 2);
        const std::uint16_t crc = servobus::modbus::crc16(framed);
        framed.push_back(static_cast<std::uint8_t>(crc & 0xFFu));
        framed.push_back(static_cast<std::uint8_t>(crc >> 8));
        all.insert(all.end(), framed.begin(), framed.end());
        return all;
    };
    CHECK(find_frames(with({})).frames.size() == 1);
    CHECK(find_frames(with(hex("FF 00"))).frames.size() == 1);
    CHECK(find_frames(with(hex("12 34"))).frames.empty());
    // Its CRC cuts it where another frame follows, of any function.
    frame_bytes glued = with({});
    for (int i = 0; i < 2; ++i) {
        const frame_bytes again = with({});
        glued.insert(glued.end(), again.begin(), again.end());
    }
    glued.insert(glued.end(), request_bytes.begin(), request_bytes.end());
    const found_frames found = find_frames(glued);
    REQUIRE(found.frames.size() == 4);
    CHECK(found.frames[2].frame == with({}));
    CHECK(found.frames[3].frame == request_bytes);
    CHECK(found.left_over() == 0);
    const frame_bytes one = with({});
    frame_bytes idle = one;
    idle.insert(idle.end(), {0xFF, 0xFF, 0xFF, 0xFF, 0x00});
    REQUIRE(find_frames(idle).frames.size() == 1);
    CHECK(find_frames(idle).frames[0].frame == one);
    CHECK(find_frames(idle).noise.size() == 5);
}

} // namespace log_line_tests
