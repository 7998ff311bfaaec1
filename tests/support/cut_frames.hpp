// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// For the tests of the tool's listener: frames of the drives' manuals, and a cutter with the pieces that it made.
#pragma once

#include <optional>
#include <vector>

#include <doctest/doctest.h>

#include <examples/servobus/capture/frame_cutter.hpp>

namespace tests::listening {

using servobus::hex;
using tool::frame_cutter;
using tool::piece;

using byte_list = std::vector<std::uint8_t>;
using frame_list = std::vector<byte_list>;

inline byte_list of(servobus::bytes b) { return {b.begin(), b.end()}; }

constexpr tool::moment gap = 20'000;

// Requests and their responses, of two drives.
inline const frame_list dialogue = {
    of(hex("01 03 20 AB 00 02 BE 2B")),
    of(hex("01 03 04 00 64 00 64 BA 07")),
    of(hex("01 06 20 0E 00 08 E2 0F")),
    of(hex("01 06 20 0E 00 08 E2 0F")),
    of(hex("01 10 20 30 00 02 04 04 00 00 00 68 4A")),
    of(hex("01 10 20 30 00 02 4A 07")),
    of(hex("01 03 00 0A 00 03 25 C9")),
    of(hex("01 03 06 00 00 13 88 00 00 A5 DB")),
    of(hex("01 03 00 3C 00 01 44 06")),
    of(hex("01 83 03 01 31")),
    of(hex("01 10 20 8A 00 04 08 00 00 50 00 00 00 50 00 E3 2C")),
    of(hex("01 10 20 8A 00 04 EB E0")),
    of(hex("01 06 20 0E 00 07 A2 0B")),
    of(hex("01 06 20 0E 00 07 A2 0B")),
};

inline byte_list joined(const frame_list& frames) {
    byte_list all;
    for (const byte_list& f : frames) all.insert(all.end(), f.begin(), f.end());
    return all;
}

struct bench {
    frame_cutter cutter{gap};
    std::vector<piece> pieces{};
    bool expects = true; ///< every second frame is the response to the one before

    void drain() {
        while (std::optional<piece> p = cutter.next()) {
            const bool is_request = p->is_frame() && frames() % 2 == 0;
            if (expects) cutter.expect(is_request ? p->data : byte_list{});
            pieces.push_back(*p);
        }
    }
    void feed(servobus::bytes data, tool::moment now = 0) {
        cutter.feed(data, now);
        drain();
    }
    void close() {
        cutter.close();
        drain();
    }
    std::size_t frames() const { return good().size(); }
    frame_list good() const {
        frame_list all;
        for (const piece& p : pieces) {
            if (p.is_frame()) all.push_back(p.data);
        }
        return all;
    }
    frame_list damaged() const {
        frame_list all;
        for (const piece& p : pieces) {
            if (!p.is_frame()) all.push_back(p.data);
        }
        return all;
    }
    byte_list everything() const {
        byte_list all;
        for (const piece& p : pieces) all.insert(all.end(), p.data.begin(), p.data.end());
        return all;
    }
};

inline bench cut(servobus::bytes data, bool expects = true) {
    bench b;
    b.expects = expects;
    b.feed(data);
    b.close();
    CHECK(b.everything() == of(data));
    return b;
}

} // namespace tests::listening
