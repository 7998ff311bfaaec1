// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The tool's listener cuts others' traffic into frames, though nothing tells where one ends: chunks of any size,
// damaged bytes anywhere, a start in the middle.
#include <doctest/doctest.h>

#include <tests/support/cut_frames.hpp>

namespace frame_cutter_tests {

using namespace tests::listening;

namespace {

bool has(const frame_list& all, const byte_list& one) {
    for (const byte_list& f : all) {
        if (f == one) return true;
    }
    return false;
}

// All frames of the dialogue except one are found, though nothing separates them.
void check_others(const byte_list& data, std::size_t except) {
    const bench b = cut(data, false);
    for (std::size_t i = 0; i < dialogue.size(); ++i) {
        CAPTURE(i);
        if (i != except) CHECK(has(b.good(), dialogue[i]));
    }
    CHECK(b.frames() + 1 >= dialogue.size() - 1);
}

// The frame in which a byte of the joined dialogue lies.
std::size_t frame_at(std::size_t byte) {
    std::size_t i = 0;
    for (; byte >= dialogue[i].size(); ++i) byte -= dialogue[i].size();
    return i;
}

} // namespace

TEST_CASE("listen: a dialogue is cut into its frames, wherever the chunks end") {
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
        std::size_t begin = 0;
        for (const piece& p : one_by_one.pieces) {
            CHECK(p.begin == begin);
            CHECK(p.end == begin + p.data.size() - 1);
            begin += p.data.size();
        }
    }
}

TEST_CASE("listen: a frame is certain as soon as its last byte is there") {
    bench b;
    b.feed(dialogue[12]);
    REQUIRE(b.frames() == 1);
    for (std::size_t i = 0; i < 12; ++i) {
        CAPTURE(i);
        b.feed(dialogue[i]);
        CHECK(b.frames() == i + 2);
    }
}

TEST_CASE("listen: one damaged byte costs one frame") {
    const byte_list all = joined(dialogue);
    for (std::size_t at = 0; at < all.size(); ++at) {
        for (const unsigned flip : {0x01u, 0x10u, 0x80u, 0xFFu}) {
            CAPTURE(at);
            CAPTURE(flip);
            byte_list hurt = all;
            hurt[at] = static_cast<std::uint8_t>(hurt[at] ^ flip);
            check_others(hurt, frame_at(at));
        }
    }
}

TEST_CASE("listen: so does a lost byte, and a byte too many") {
    const byte_list all = joined(dialogue);
    for (std::size_t at = 0; at < all.size(); ++at) {
        CAPTURE(at);
        byte_list lost = all;
        lost.erase(lost.begin() + static_cast<std::ptrdiff_t>(at));
        check_others(lost, frame_at(at));
        for (const std::uint8_t extra : byte_list{0x00, 0x01, 0x55, 0xFF}) {
            CAPTURE(extra);
            byte_list more = all;
            more.insert(more.begin() + static_cast<std::ptrdiff_t>(at), extra);
            check_others(more, frame_at(at));
        }
    }
}

TEST_CASE("listen: it may begin in the middle of a frame") {
    const byte_list all = joined(dialogue);
    for (std::size_t from = 0; from < all.size(); ++from) {
        CAPTURE(from);
        const bench b = cut(servobus::bytes{all}.subspan(from), false);
        const std::size_t whole = from == 0 ? 0 : frame_at(from - 1) + 1;
        REQUIRE(b.frames() >= dialogue.size() - whole);
        for (std::size_t i = whole; i < dialogue.size(); ++i)
            CHECK(b.good()[b.frames() - dialogue.size() + i] == dialogue[i]);
    }
}

TEST_CASE("listen: frames of functions that the library does not know, without a gap between them") {
    // Discrete inputs, device identification, exception status of another node, diagnostics.
    const frame_list frames = {
        of(hex("01 02 00 00 00 08 79 CC")),
        of(hex("01 02 01 5A 21 B3")),
        of(hex("01 2B 0E 01 00 70 77")),
        of(hex("01 2B 0E 01 01 00 00 01 00 01 41 2F A7")),
        of(hex("02 07 41 12")),
        of(hex("02 07 6D 13 DD")),
        of(hex("01 08 00 00 12 34 ED 7C")),
        of(hex("01 08 00 00 12 34 ED 7C")),
    };
    bench b;
    b.expects = false;
    byte_list all;
    for (int round = 0; round < 40; ++round) {
        for (const byte_list& f : frames) {
            b.feed(f);
            all.insert(all.end(), f.begin(), f.end());
        }
    }
    CHECK(b.frames() > 270); // before any gap: only the last 256 bytes or so wait
    b.close();
    CHECK(b.everything() == all);
    REQUIRE(b.frames() == 40 * frames.size());
    for (std::size_t i = 0; i < b.frames(); ++i) CHECK(b.good()[i] == frames[i % frames.size()]);
    CHECK(b.damaged().empty());
}

} // namespace frame_cutter_tests
