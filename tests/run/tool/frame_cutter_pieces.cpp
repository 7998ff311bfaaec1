// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The tool's listener cuts others' traffic into frames: what each piece is, what is waited for, what a gap ends, and
// frames of which the beginning, or the content, is another one.
#include <doctest/doctest.h>

#include <tests/support/cut_frames.hpp>

namespace frame_cutter_pieces_tests {

using namespace tests::listening;

TEST_CASE("listen: damaged frames, each with what is wrong") {
    using kind = piece::kind;
    struct damage {
        byte_list data;
        std::vector<kind> what;
    };
    const std::vector<damage> all = {
        {of(hex("01 03 20 AB 00 02 BE 2C")), {kind::bad_crc}},
        {of(hex("01 03 04 00 64 00 64 BA 08")), {kind::bad_crc}},
        {of(hex("01 03 20 AB 00 02 BE")), {kind::incomplete}},
        {of(hex("01 03")), {kind::incomplete}},
        {of(hex("01 10 20 30 00 02 04 04 00")), {kind::incomplete}},
        {of(hex("01")), {kind::noise}},
        {of(hex("00 00 FF")), {kind::noise}},
        {of(hex("55 55 55 55 55 55")), {kind::bad_crc}},
        {of(hex("01 83 03 01 32")), {kind::bad_crc}},
        {of(hex("01 06 20 0E 00 08 E2 0E 01 06 20 0E 00 08 E2 0E")), {kind::bad_crc, kind::bad_crc}},
        {of(hex("FF 01 03 20 AB 00 02 BE 2B")), {kind::noise, kind::frame}},
        {of(hex("01 06 20 0E 00 08 E2 0F 00 00")), {kind::frame, kind::noise}},
        {of(hex("01 03 20 AB 00 02 BE 2B FF")), {kind::frame, kind::noise}},
    };
    for (const damage& d : all) {
        CAPTURE(d.data);
        const bench b = cut(d.data);
        REQUIRE(b.pieces.size() == d.what.size());
        for (std::size_t i = 0; i < d.what.size(); ++i) CHECK(b.pieces[i].what == d.what[i]);
    }
}

TEST_CASE("listen: a gap ends an incomplete frame, a late chunk does not") {
    const servobus::bytes request = dialogue[12];
    bench b;
    b.feed(request.first(5), 0);
    b.feed(request.subspan(5), 5 * gap); // read late by a busy host
    CHECK(b.good() == frame_list{dialogue[12]});
    b.feed(request.first(5), 6 * gap);
    b.cutter.elapse(7 * gap - 1);
    b.drain();
    CHECK(b.pieces.size() == 1);
    b.cutter.elapse(7 * gap);
    b.feed(request, 8 * gap);
    REQUIRE(b.pieces.size() == 3);
    CHECK(b.pieces[1].what == piece::kind::incomplete);
    CHECK(b.pieces[1].data.size() == 5);
    CHECK(b.pieces[2].data == dialogue[12]);
}

TEST_CASE("listen: functions that the library does not know end by their CRC") {
    const byte_list request = of(hex("01 02 00 00 00 04 79 C9"));
    const byte_list refused = of(hex("01 82 02 C1 61"));
    CHECK(cut(request).good() == frame_list{request});
    CHECK(cut(joined({request, refused, dialogue[0]})).good() == frame_list{request, refused, dialogue[0]});
    CHECK(cut(joined({dialogue[0], dialogue[1], request, refused, request})).frames() == 5);
    byte_list too_long(300, 0x41);
    const std::uint16_t crc = servobus::modbus::crc16(too_long);
    too_long.push_back(static_cast<std::uint8_t>(crc & 0xFFu));
    too_long.push_back(static_cast<std::uint8_t>(crc >> 8));
    CHECK(cut(too_long).frames() == 0);
}

TEST_CASE("listen: a frame with a right CRC and a wrong length is one, for explain says what is wrong") {
    // A manual's own example: the byte count is 12, 13 bytes follow.
    const byte_list wrong = of(hex("01 10 00 21 00 05 0C 00 0A 00 64 00 64 00 3C 00 00 00 03 E8 04 76"));
    const byte_list response = of(hex("01 10 00 21 00 05 50 00"));
    CHECK(cut(wrong).good() == frame_list{wrong});
    CHECK(cut(joined({wrong, response})).good() == frame_list{wrong, response});
    const byte_list reads_none = of(hex("01 03 20 AB 00 00 3F EA"));
    CHECK(cut(reads_none).good() == frame_list{reads_none});
}

TEST_CASE("listen: a whole request is one although a longer response could begin so") {
    // The high byte of the address is an even number: the byte count of a response of 37 bytes.
    const byte_list request = dialogue[0];
    bench b;
    b.feed(request, 0); // as listening begins nothing is known, so a response may be under way
    CHECK(b.pieces.empty());
    b.cutter.elapse(gap);
    b.drain();
    REQUIRE(b.good() == frame_list{request});
    b.feed(dialogue[1], gap);
    b.feed(request, 2 * gap);
    CHECK(b.frames() == 3);
}

TEST_CASE("listen: a response of which the beginning is a whole request is a response") {
    // 6 words are asked for; the first 8 bytes of the response have a right CRC by themselves.
    const byte_list request = of(servobus::modbus::read_frame(1, 0x20A0, 6));
    byte_list response = of(servobus::modbus::read_frame(1, 0x0C0D, 2));
    response.resize(15);
    const std::uint16_t first_word = 0x1234;
    servobus::store_word(response, 13, first_word);
    response.resize(17);
    REQUIRE(servobus::modbus::close_frame(response, 14) == 17);
    for (std::size_t split = 1; split < response.size(); ++split) {
        CAPTURE(split);
        bench b;
        b.feed(joined({dialogue[2], dialogue[3], request}));
        b.feed(servobus::bytes{response}.first(split));
        b.feed(servobus::bytes{response}.subspan(split));
        CHECK(b.good().back() == response);
        CHECK(b.frames() == 4);
        bench middle; // listening begins with the response
        middle.feed(servobus::bytes{response}.first(split));
        middle.feed(servobus::bytes{response}.subspan(split));
        middle.close();
        CHECK(middle.good() == frame_list{response});
    }
}

TEST_CASE("listen: a frame in the values of a response is none") {
    const byte_list request = of(servobus::modbus::read_frame(1, 0x20A0, 6));
    byte_list response = {1, 3, 12, 0, 0};
    response.insert(response.end(), dialogue[2].begin(), dialogue[2].end());
    response.resize(17);
    REQUIRE(servobus::modbus::close_frame(response, 14) == 17);
    for (std::size_t split = 1; split < response.size(); ++split) {
        CAPTURE(split);
        bench b;
        b.feed(joined({dialogue[2], dialogue[3], request}));
        b.feed(servobus::bytes{response}.first(split));
        b.feed(servobus::bytes{response}.subspan(split));
        CHECK(b.good() == frame_list{dialogue[2], dialogue[3], request, response});
    }
}

TEST_CASE("listen: a request that is repeated in place of its response is a request") {
    const byte_list request =
        of(servobus::modbus::read_frame(1, 0x0406, 2)); // 04h is the response's byte count too
    bench b;
    b.feed(joined({dialogue[2], dialogue[3], request, request}));
    b.cutter.elapse(gap);
    b.drain();
    CHECK(b.good() == frame_list{dialogue[2], dialogue[3], request, request});
    b.expects = false;
    b.cutter.expect(request);
    // A line that no one drives adds a zero: 9 bytes, as the response has, and the CRC is right again.
    b.feed(request, gap);
    const byte_list zero{0};
    b.feed(zero, gap);
    b.cutter.elapse(2 * gap);
    b.drain();
    CHECK(b.good().back() == request);
    CHECK(b.damaged() == frame_list{zero});
}

TEST_CASE("listen: whatever arrives, in whatever chunks and with whatever gaps, no byte is lost or doubled") {
    std::uint32_t seed = 7;
    const auto random = [&](std::uint32_t below) {
        seed = seed * 1664525u + 1013904223u;
        return (seed >> 8) % below;
    };
    constexpr std::uint8_t likely[] = {0, 1, 2, 3, 4, 6, 0x10, 0x83, 0x90, 0xFF};
    for (int round = 0; round < 300; ++round) {
        CAPTURE(round);
        bench b;
        byte_list fed;
        tool::moment now = 0;
        for (int chunk = 0; chunk < 40; ++chunk) {
            byte_list data;
            if (random(3) != 0) data = dialogue[random(static_cast<std::uint32_t>(dialogue.size()))];
            for (std::uint32_t more = random(4); more != 0; --more) data.push_back(likely[random(10)]);
            if (!data.empty() && random(4) == 0)
                data[random(static_cast<std::uint32_t>(data.size()))] ^= 0x10;
            fed.insert(fed.end(), data.begin(), data.end());
            b.cutter.feed(data, now);
            if (random(2) == 0) b.drain();
            now += random(2) * gap;
            b.cutter.elapse(now);
        }
        b.close();
        CHECK(b.everything() == fed);
        for (const byte_list& one : b.good())
            CHECK(servobus::modbus::open_frame(one).error() == servobus::errc::ok);
    }
}

TEST_CASE("listen: nothing is waited for that cannot come") {
    bench b;
    b.feed(joined({dialogue[2], dialogue[3]}));
    b.feed(of(servobus::modbus::read_frame(1, 0x0A00, 1)));
    CHECK(b.frames() == 3);
    b.feed(of(servobus::modbus::read_frame(1, 0x0A00, 1))); // again: the response would have a count of 2
    CHECK(b.frames() == 4);
    b.expects = false;
    b.cutter.expect(of(servobus::modbus::read_frame(1, 0x0A00, 1)));
    byte_list one_word{1, 3, 2, 0x12, 0x34};
    one_word.resize(7);
    REQUIRE(servobus::modbus::close_frame(one_word, 4) == 7);
    b.feed(one_word); // shorter than a request
    CHECK(b.good().back() == one_word);
    bench all_nodes;
    all_nodes.feed(of(servobus::modbus::read_frame(0, 0x20AB, 2))); // has no response that could begin so
    CHECK(all_nodes.frames() == 1);
    // A byte count that is odd, zero or more than 250.
    for (const std::uint8_t count : byte_list{0xFB, 0x81, 0xFE, 0x00}) {
        CAPTURE(count);
        bench damaged;
        damaged.feed(byte_list{1, 3, count, 0xAB, 0, 2, 0, 0});
        damaged.feed(dialogue[2]);
        CHECK(damaged.good() == frame_list{dialogue[2]});
    }
    bench too_long; // a write of 127 registers would have 263 bytes
    too_long.feed(byte_list{1, 0x10, 0x20, 0x30, 0, 0x7F, 0xFE});
    too_long.feed(dialogue[2]);
    CHECK(too_long.good() == frame_list{dialogue[2]});
}

TEST_CASE("listen: after damaged bytes only a well-formed frame counts") {
    const byte_list noise{0x55};
    const byte_list reads_none = of(hex("01 03 20 AB 00 00 3F EA"));
    CHECK(cut(joined({noise, reads_none})).frames() == 0);
    CHECK(cut(joined({noise, reads_none, dialogue[2]})).good() == frame_list{dialogue[2]});
}

TEST_CASE("listen: damaged frames one after the other, each by the length that it should have") {
    byte_list response = dialogue[1];
    byte_list request = dialogue[0];
    response[4] ^= 1;
    request[4] ^= 1;
    const bench b = cut(joined({dialogue[2], dialogue[3], dialogue[0], response, request}));
    CHECK(b.frames() == 3);
    CHECK(b.damaged() == frame_list{response, request});
}

TEST_CASE("listen: what a gap separates is not one frame") {
    const servobus::bytes request = dialogue[2];
    bench b;
    b.cutter.feed(request.first(5), 0);
    b.cutter.elapse(gap);
    b.cutter.feed(request.subspan(5), 2 * gap); // before the pieces of the first are taken
    b.drain();
    b.close();
    CHECK(b.frames() == 0);
    CHECK(b.damaged().size() == 2);
}

TEST_CASE("listen: endless noise is passed on in pieces, and a frame after it is found") {
    std::uint32_t seed = 1;
    byte_list noise;
    for (int i = 0; i < 5000; ++i) {
        seed = seed * 1664525u + 1013904223u;
        noise.push_back(static_cast<std::uint8_t>(seed >> 24));
    }
    bench b;
    for (std::size_t i = 0; i < noise.size(); i += 50) b.feed(servobus::bytes{noise}.subspan(i, 50));
    CHECK(b.pieces.size() > 5);
    b.feed(dialogue[0]);
    b.close();
    CHECK(b.good().back() == dialogue[0]);
    byte_list wanted = noise;
    wanted.insert(wanted.end(), dialogue[0].begin(), dialogue[0].end());
    CHECK(b.everything() == wanted);
}

} // namespace frame_cutter_pieces_tests
