// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The tool's listener cuts frames of every function whose bytes give their length: glued, in any chunks, and with a
// damaged byte. The frames are the standard's examples.
#include <doctest/doctest.h>

#include <tests/support/byte_times.hpp>
#include <tests/support/cut_frames.hpp>

namespace frame_cutter_functions_tests {

using namespace tests::listening;
using byte_times::framed;

namespace {

// A request and its response by turns, all of node 11h.
const frame_list dialogue = [] {
    frame_list all;
    for (const byte_list& pdu : std::initializer_list<byte_list>{
             of(hex("01 00 13 00 13")),
             of(hex("01 03 CD 6B 05")), //
             of(hex("02 00 C4 00 16")),
             of(hex("02 03 AC DB 35")), //
             of(hex("05 00 AC FF 00")),
             of(hex("05 00 AC FF 00")), //
             of(hex("07")),
             of(hex("07 6D")), //
             of(hex("08 00 00 A5 37")),
             of(hex("08 00 00 A5 37")), //
             of(hex("08 00 0B 00 00")),
             of(hex("08 00 0B 01 02")), //
             of(hex("0B")),
             of(hex("0B FF FF 01 08")), //
             of(hex("0C")),
             of(hex("0C 08 00 00 01 08 01 21 20 00")), //
             of(hex("0F 00 13 00 0A 02 CD 01")),
             of(hex("0F 00 13 00 0A")), //
             of(hex("11")),
             of(hex("11 05 70 75 6D 70 FF")), //
             of(hex("16 00 04 00 F2 00 25")),
             of(hex("16 00 04 00 F2 00 25")),                            //
             of(hex("17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF")), //
             of(hex("17 0C 00 FE 0A CD 00 01 00 03 00 0D 00 FF")),       //
             of(hex("18 04 DE")),
             of(hex("18 00 06 00 02 01 B8 12 84")), //
             of(hex("2B 0E 01 00")),
             of(hex("2B 0E 01 01 00 00 03 00 02 41 42 01 01 43 02 04 56 31 2E 30")), //
             of(hex("2B 0E 04 02")),
             of(hex("2B 0E 04 81 00 00 01 02 01 56")),
             of(hex("2B 0E 02 00")),
             of(hex("AB 03"))}) { //
        byte_list frame{0x11};
        frame.insert(frame.end(), pdu.begin(), pdu.end());
        all.push_back(framed(frame));
    }
    return all;
}();

} // namespace

TEST_CASE("listen: glued frames of all functions are cut, wherever the chunks end") {
    const byte_list all = joined(dialogue);
    for (const bool expects : {true, false}) {
        CAPTURE(expects);
        CHECK(cut(all, expects).good() == dialogue);
        for (std::size_t split = 1; split < all.size(); ++split) {
            CAPTURE(split);
            bench b;
            b.expects = expects;
            b.feed(servobus::bytes{all}.first(split), 1);
            b.feed(servobus::bytes{all}.subspan(split), 2);
            b.close();
            CHECK(b.good() == dialogue);
            CHECK(b.damaged().empty());
        }
        bench one_by_one;
        one_by_one.expects = expects;
        for (std::size_t i = 0; i < all.size(); ++i) one_by_one.feed(servobus::bytes{all}.subspan(i, 1), i);
        one_by_one.close();
        CHECK(one_by_one.good() == dialogue);
    }
}

TEST_CASE("listen: a frame of any function is certain as soon as its last byte is there") {
    bench b;
    b.feed(tests::listening::dialogue[2]);
    b.feed(tests::listening::dialogue[3]);
    for (std::size_t i = 0; i < dialogue.size(); ++i) {
        CAPTURE(i);
        b.feed(dialogue[i]);
        CHECK(b.frames() == i + 3);
    }
}

TEST_CASE("listen: a damaged byte costs no frame but its own, of all functions") {
    const byte_list all = joined(dialogue);
    std::size_t frame = 0;
    std::size_t end = dialogue[0].size();
    for (std::size_t at = 0; at < all.size(); ++at) {
        if (at == end) end += dialogue[++frame].size();
        for (const unsigned flip : {0x01u, 0x10u, 0x80u, 0xFFu}) {
            CAPTURE(at);
            CAPTURE(flip);
            byte_list hurt = all;
            hurt[at] = static_cast<std::uint8_t>(hurt[at] ^ flip);
            frame_list others = dialogue;
            others.erase(others.begin() + static_cast<std::ptrdiff_t>(frame));
            CHECK(cut(hurt, false).good() == others);
        }
    }
}

TEST_CASE("listen: a longer Return Query Data, and another encapsulated interface, end by their CRC") {
    const byte_list query_data = framed({0x11, 8, 0, 0, 1, 2, 3, 4, 5, 6});
    const byte_list canopen = framed({0x11, 0x2B, 0x0D, 1, 2, 3, 4, 5, 6, 7, 8, 9});
    const byte_list read = dialogue[0];
    CHECK(cut(joined({query_data, query_data, canopen, read}), false).good() ==
          frame_list{query_data, query_data, canopen, read});
}

TEST_CASE("listen: counts that no frame has wait for nothing") {
    const byte_list next = tests::listening::dialogue[2];
    for (const byte_list& begun : frame_list{{0x11, 1, 0xFB},
                                             {0x11, 2, 0},
                                             {0x11, 0x0C, 5},
                                             {0x11, 0x0C, 71},
                                             {0x11, 0x17, 3},
                                             {0x11, 0x11, 0xFB},
                                             {0x11, 0x18, 1, 2},
                                             {0x11, 0x18, 0, 66},
                                             {0x11, 0x2B, 0x0E, 1, 4},
                                             {0x11, 0x0F, 0, 0, 0, 9, 1},
                                             {0x11, 0x17, 0, 0, 0, 1, 0, 0, 0, 1, 4}}) {
        CAPTURE(begun);
        bench b;
        b.expects = false;
        b.feed(begun);
        b.feed(byte_list{0x55, 0x55, 0x55, 0x55, 0x55});
        b.feed(next);
        CHECK(b.good() == frame_list{next});
    }
}

} // namespace frame_cutter_functions_tests
