// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server on a line with other nodes that use functions of all kinds. It responds t3.5 after their frames,
// and what their frames contain is never executed.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <servobus/modbus/server.hpp>

#include <tests/support/neighbours.hpp>
#include <tests/support/served_words.hpp>

namespace server_neighbours_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::low_byte;
using tests::operator+;
using namespace tests::served;
namespace neighbours = tests::neighbours;

namespace {

const byte_list write_5 = framed({1, 0x06, 0, 2, 0, 5});
const byte_list write_9 = framed({1, 0x06, 0, 2, 0, 9});
const byte_list broadcast_9 = framed({0, 0x06, 0, 2, 0, 9});
const byte_list write_two = framed({1, 0x10, 0, 2, 0, 2, 4, 0, 9, 0, 9});
constexpr std::uint32_t t3_5 = 1750;

} // namespace

TEST_CASE(
    "G41: after a request and a response of another node, of whatever function, a request gets its response "
    "immediately") {
    for (const auto mode : both_modes) {
        for (const std::uint8_t code : neighbours::functions) {
            for (const std::uint32_t gap : {t3_5, 8'000u, 19'000u, 25'000u}) {
                for (const std::size_t burst : {1u, 5u, 300u}) {
                    for (const bool is_polled : {false, true}) {
                        if (burst != 1 && mode == modbus::timing_mode::strict) continue;
                        CAPTURE(static_cast<int>(mode));
                        CAPTURE(static_cast<int>(code));
                        CAPTURE(gap);
                        CAPTURE(burst);
                        bench b{mode};
                        tests::dice random{code};
                        const neighbours::pair p = neighbours::pair_of(9, code, {1, 2, 3, 4}, random);
                        b.receive(write_9); // else any response could follow
                        CHECK(b.response() == write_9);
                        b.quiet(gap, is_polled);
                        b.receive(p.request, burst);
                        b.quiet(gap, is_polled);
                        b.receive(p.response, burst);
                        b.quiet(gap, is_polled);
                        b.receive(write_5, burst);
                        CHECK(b.server.is_answering());
                        CHECK(b.response() == write_5);
                    }
                }
            }
        }
    }
}

TEST_CASE("G41: a frame of another node, of a function with a known length, is followed by a request without "
          "a gap in "
          "host timing") {
    for (const std::uint8_t code : neighbours::functions) {
        if (!neighbours::has_length(code)) continue;
        CAPTURE(static_cast<int>(code));
        tests::dice random{code};
        const neighbours::pair p = neighbours::pair_of(9, code, {1, 2, 3, 4}, random);
        bench b;
        b.receive(p.request + p.response + write_5, 300);
        CHECK(b.response() == write_5);
        CHECK(b.server.dropped() == 0);
    }
}

TEST_CASE(
    "G41: without a pause of t3.5 a request that follows a frame of unknown length is not executed in host "
    "timing") {
    for (const std::uint32_t gap : {0u, 500u, t3_5 - 1}) {
        for (const std::size_t burst : {1u, 3u, 300u}) {
            bench b;
            b.receive(framed({9, 0x65, 1, 2, 3}), burst);
            b.quiet(gap);
            b.receive(write_9, burst);
            CHECK(b.response().empty());
            CHECK(b.store.accesses == 0);
            b.receive(write_5, burst);
            CHECK(b.response() == write_5);
        }
    }
}

TEST_CASE("G13, G41: a write to the server inside a frame of function 65h is not executed, however the frame "
          "is cut") {
    for (const auto mode : both_modes) {
        for (const byte_list& inside : {write_9, broadcast_9, write_two, write_9 + broadcast_9}) {
            for (std::size_t before = 0; before < 5; ++before) {
                for (std::size_t after = 0; after < 4; ++after) {
                    const byte_list all = framed(byte_list{9, 0x65} + byte_list(before, 0x3C) + inside +
                                                 byte_list(after, 0x00));
                    for (std::size_t cut = 1; cut < all.size(); ++cut) {
                        for (const std::uint32_t pause : {0u, 700u, 2'500u, 19'000u}) {
                            if (pause > 700 && mode == modbus::timing_mode::strict) continue;
                            const auto middle = all.begin() + static_cast<std::ptrdiff_t>(cut);
                            bench b{mode};
                            b.receive({all.begin(), middle});
                            b.quiet(pause);
                            b.receive({middle, all.end()});
                            b.quiet(t3_5 + 10);
                            REQUIRE(b.store.accesses == 0);
                            b.receive(write_5);
                            REQUIRE(b.response() == write_5);
                            REQUIRE(b.store.accesses == 1);
                        }
                    }
                }
            }
        }
    }
}

TEST_CASE("G6, G41: a frame of another node whose CRC fits in its middle goes on if no pause follows there") {
    for (const auto mode : both_modes) {
        for (const byte_list& inside : {write_9, broadcast_9, write_two}) {
            for (const std::uint32_t pause : {0u, 300u, 700u}) {
                const byte_list begun = framed({9, 0x65, 1, 2, 3});
                const byte_list whole = framed(begun + inside);
                bench b{mode};
                b.receive(begun);
                b.quiet(pause);
                b.receive(byte_list(whole.begin() + static_cast<std::ptrdiff_t>(begun.size()), whole.end()));
                b.quiet(t3_5 + 10);
                CHECK(b.store.accesses == 0);
                b.receive(write_5);
                CHECK(b.response() == write_5);
                CHECK(b.store.accesses == 1);
            }
        }
    }
    // Bytes that came together began earlier: if they filled the time since the byte before, there was no
    // pause.
    bench b;
    const byte_list begun = framed({9, 0x65, 1, 2, 3});
    b.receive(begun, 300);
    b.receive(byte_list(12, 0x11) + write_9, 300);
    CHECK(b.response().empty());
    CHECK(b.store.accesses == 0);
}

TEST_CASE("G6, G41: zeros after a frame of another node do not keep it from its end") {
    for (std::size_t zeros = 0; zeros < 12; ++zeros) {
        CAPTURE(zeros);
        bench b;
        b.receive(framed({9, 0x65, 1, 2, 3}) + byte_list(zeros, 0x00));
        b.quiet(t3_5);
        b.receive(write_5);
        CHECK(b.response() == write_5);
        // But a request to the server, with any number of zeros, ends by its counts.
        b.quiet(t3_5);
        b.receive(framed({9, 0x65, 1, 2, 3}) + byte_list(zeros, 0x00) + write_9);
        CHECK(b.response().empty());
        CHECK(b.store.accesses == 1);
    }
}

TEST_CASE("G6, G41: a request to the server whose function gives no length waits for a visible gap in host "
          "timing") {
    bench b;
    const byte_list begun = framed({1, 0x65, 1, 2, 3});
    b.receive(begun);
    b.quiet(19'000);
    CHECK(!b.server.is_answering());
    b.quiet(2'000);
    CHECK(b.response() == tests::exception_response(1, 0x65, 1));
    // It goes on within the gap: its CRC does not end it.
    const byte_list whole = framed(begun + write_9);
    b.receive(begun);
    b.quiet(19'000);
    b.receive(byte_list(whole.begin() + static_cast<std::ptrdiff_t>(begun.size()), whole.end()));
    CHECK(b.response() == tests::exception_response(1, 0x65, 1));
    CHECK(b.store.accesses == 0);
}

TEST_CASE("G13, G41: where a frame of another node ends as a request or as a response, both readings are "
          "followed") {
    struct two_faced {
        const char* what;
        byte_list request; // before it
        byte_list frame;   // with a write to the server after the end of the wrong reading
    };
    std::vector<two_faced> all;
    // A response of 32 bytes that begins like a request of 8.
    for (const std::uint8_t code : {std::uint8_t{0x01}, std::uint8_t{0x02}, std::uint8_t{0x04}}) {
        byte_list body = framed({2, code, 32, 0x10, 0, 1}) + write_9;
        body.resize(3 + 32);
        const std::uint8_t quantity = code == 0x04 ? 16 : 250;
        all.push_back({"reads", framed({2, code, 0, 0, 0, quantity}), framed(body)});
        all.push_back({"reads, nothing known", {}, framed(body)});
    }
    byte_list odd = framed({2, 0x01, 33, 0x10, 0, 1}) + write_9;
    odd.resize(3 + 33);
    all.push_back({"coils, an odd count, nothing known", {}, framed(odd)});
    // A request of 17h that begins like a response of 12 bytes, and one that ends within its byte count.
    const byte_list seven = framed({2, 0x17, 12, 0, 0, 5, 0, 0, 0, 7, 14, 1, 2, 3, 4}) + write_9;
    all.push_back({"17h", framed({2, 0x17, 0, 0, 0, 6, 0, 0, 0, 1, 2, 0, 0}), framed(seven)});
    // A response of 17h that begins like a request with two bytes of data.
    byte_list body = framed({2, 0x17, 40, 0, 0, 5, 0, 0, 0, 1, 2, 3, 4}) + write_9;
    body.resize(3 + 40);
    all.push_back({"17h, response", framed({2, 0x17, 0, 0, 0, 20, 0, 0, 0, 1, 2, 0, 0}), framed(body)});
    // A request of 0Fh of which the CRC of a response is the byte count and the first data.
    for (unsigned low = 0; low < 0xFFFF; ++low) {
        const byte_list begun = framed({2, 0x0F, tests::high_byte(low), low_byte(low), 0, 120});
        if (begun[6] != 15) continue;
        byte_list coils = begun + write_9;
        coils.resize(7 + 15);
        all.push_back({"0Fh", {}, framed(coils)});
        break;
    }
    REQUIRE(all.size() == 10);
    for (const two_faced& t : all) {
        for (const std::size_t burst : {1u, 3u, 300u}) {
            for (const std::uint32_t gap : {0u, t3_5}) {
                CAPTURE(t.what);
                bench b;
                b.receive(t.request, burst);
                b.quiet(gap);
                b.receive(t.frame, burst);
                b.quiet(t3_5);
                REQUIRE(b.store.accesses == 0);
                b.receive(write_5, burst);
                REQUIRE(b.response() == write_5);
                REQUIRE(b.store.accesses == 1);
            }
        }
    }
}

TEST_CASE("G41: a pause that `elapse` has seen counts, also if the whole request then comes in no time") {
    for (const std::uint32_t looked : {t3_5 - 1, t3_5}) { // as on a pseudo-terminal
        bench b;
        b.receive(framed({9, 0x65, 1, 2, 3}));
        b.quiet(looked);
        b.server.feed(write_5, b.now + microseconds(100));
        CHECK(b.server.is_answering() == (looked == t3_5));
    }
}

TEST_CASE("G41: three bytes whose CRC fits are no frame") {
    unsigned tried = 0;
    for (unsigned node = 2; node < 248; ++node) {
        const byte_list three = framed({low_byte(node)});
        if (three[1] == 0 || three[1] >= 0x80 || neighbours::has_length(three[1])) continue;
        ++tried;
        bench b;
        b.receive(three);
        b.quiet(t3_5);
        b.receive(write_9);
        CHECK(b.response().empty());
        CHECK(b.store.accesses == 0);
    }
    CHECK(tried > 50);
}

TEST_CASE("G41: a broadcast with a function of unknown length ends with a pause and changes nothing") {
    bench b;
    b.receive(framed({0, 0x65, 1, 2, 3}));
    b.quiet(t3_5);
    b.receive(write_5);
    CHECK(b.server.is_answering());
    CHECK(b.response() == write_5);
    CHECK(b.server.dropped() == 0);
}

TEST_CASE("G41: a known function of another node with a wrong CRC ends with a visible gap") {
    for (const std::uint8_t code : neighbours::functions) {
        tests::dice random{code};
        byte_list damaged = neighbours::pair_of(9, code, {1, 2, 3, 4}, random).request;
        damaged.back() ^= 0x40u;
        bench b;
        b.receive(damaged);
        b.quiet(8'000);
        b.receive(write_9);
        CHECK(b.response().empty());
        CHECK(b.store.accesses == 0);
        b.receive(write_5);
        CHECK(b.response() == write_5);
    }
}

TEST_CASE("G14: a request of a function that is not executed gets its exception immediately if its length is "
          "known") {
    for (const std::uint8_t code : neighbours::functions) {
        if (!neighbours::has_length(code) || code == 0x03 || code == 0x06 || code == 0x10) continue;
        CAPTURE(static_cast<int>(code));
        tests::dice random{code};
        bench b;
        b.receive(neighbours::pair_of(1, code, {1, 2, 3, 4}, random).request);
        CHECK(b.server.is_answering());
        CHECK(b.response() == tests::exception_response(1, code, 1));
        CHECK(b.store.accesses == 0);
    }
}

namespace {

// A line on which exchanges of other nodes alternate with requests to the server. Nothing in it is decided by
// the server: frames, gaps and bursts come from the dice alone.
class crowd {
  public:
    explicit crowd(std::uint64_t seed, modbus::timing_mode mode) : random_{seed}, b_{mode}, mode_{mode} {}

    std::map<unsigned, unsigned> played;    // by function
    std::map<std::uint32_t, unsigned> gaps; // before a request to the server
    std::map<std::string, unsigned> kinds;  // of payloads and bursts
    unsigned requests = 0;
    unsigned delayed = 0; // requests that waited for a visible gap

    void round() {
        const unsigned exchanges = 1 + random_.below(3);
        for (unsigned i = 0; i < exchanges; ++i) exchange();
        ask();
    }

  private:
    bool is_host() const { return mode_ == modbus::timing_mode::host; }
    std::uint32_t some_gap() {
        constexpr std::uint32_t all[] = {t3_5, 8'000, 19'000, 25'000};
        const std::uint32_t chosen = all[random_.below(4)];
        return chosen == t3_5 ? t3_5 + (random_.below(2) == 0 ? 0 : random_.below(2'000)) : chosen;
    }

    // Often whole requests to the server.
    byte_list payload() {
        const byte_list write = framed({1, 0x06, 0, random_.byte(), 0xBA, 0xD0});
        switch (random_.below(6)) {
        case 0: ++kinds["embedded write"]; return write;
        case 1: ++kinds["embedded broadcast"]; return framed({0, 0x06, 0, 3, 0xBA, 0xD0});
        case 2: ++kinds["several embedded"]; return byte_list(random_.below(4), 0xFF) + write + write;
        case 3: ++kinds["zeros"]; return byte_list(1 + random_.below(30), 0x00);
        default: {
            byte_list any(random_.below(40));
            for (std::uint8_t& byte : any) byte = random_.byte();
            return any;
        }
        }
    }

    void exchange() {
        const std::uint8_t code = neighbours::functions[random_.below(neighbours::functions.size())];
        const auto node = static_cast<std::uint8_t>(2 + random_.below(9));
        ++played[code];
        neighbours::pair p = neighbours::pair_of(node, code, payload(), random_);
        const bool has_length = neighbours::has_length(code);
        if (!has_length && random_.below(4) == 0) {
            ++kinds["CRC that fits in the middle"];
            p.request = framed(p.request + framed({1, 0x06, 0, 4, 0xBA, 0xD0}));
        }
        if (!has_length && random_.below(4) == 0) {
            ++kinds["trailing zeros"];
            p.request = p.request + byte_list(1 + random_.below(3), 0x00);
        }
        pass(some_gap());
        say(p.request, has_length);
        if (random_.below(10) < 3) {
            ++kinds["absent node"];
            return;
        }
        if (random_.below(6) == 0) {
            ++kinds["exception"];
            p.response = tests::exception_response(node, code, random_.byte());
        }
        pass(some_gap());
        say(p.response, has_length);
    }

    void ask() {
        const std::uint32_t gap = some_gap();
        ++gaps[gap < 4'000 ? t3_5 : gap];
        pass(gap);
        ++requests;
        const auto value = static_cast<std::uint16_t>(random_.below(1000));
        const std::uint8_t at = low_byte(random_.below(16));
        const byte_list written{tests::high_byte(value), low_byte(value)};
        byte_list request;
        byte_list expected;
        switch (random_.below(3)) {
        case 0:
            request = expected = framed(byte_list{1, 0x06, 0, at} + written);
            model_[at] = value;
            break;
        case 1:
            request = framed(byte_list{1, 0x10, 0, at, 0, 1, 2} + written);
            expected = framed({1, 0x10, 0, at, 0, 1});
            model_[at] = value;
            break;
        default: request = framed({1, 0x03, 0, at, 0, 1}); expected = tests::read_response(1, {model_[at]});
        }
        say(request, true);
        flush();
        unsigned responses = 0;
        for (std::uint32_t waited = 0; waited < 60'000; waited += 250) {
            b_.quiet(250);
            const bytes frame = b_.server.response(b_.now);
            if (frame.empty()) continue;
            ++responses;
            if (waited > 5'000) ++delayed;
            REQUIRE(same_bytes(frame, expected));
            b_.now = b_.now + b_.timing.wire_time(frame.size());
            b_.server.sent(b_.now);
        }
        REQUIRE(responses == 1);
        REQUIRE(b_.store.words == model_);
        REQUIRE(b_.store.accesses == requests);
    }

    void pass(std::uint32_t us) {
        if (us > 2'000) flush();
        if (pending_.empty() && random_.below(2) == 0) {
            for (; us > 300; us -= 300) b_.quiet(300);
        }
        b_.quiet(us, false);
    }

    // In bursts that are cut anywhere, and in which a frame has no visible gap. One burst may contain the end
    // of a frame and the beginning of the next if the frame's end follows from its function.
    void say(const byte_list& frame, bool may_be_joined) {
        for (std::size_t at = 0; at < frame.size();) {
            std::size_t size = is_host() ? 1 + random_.below(random_.below(3) == 0 ? 8 : 40) : 1;
            size = std::min(size, frame.size() - at);
            pending_.insert(pending_.end(), frame.begin() + static_cast<std::ptrdiff_t>(at),
                            frame.begin() + static_cast<std::ptrdiff_t>(at + size));
            b_.now = b_.now + b_.timing.wire_time(size);
            at += size;
            if (at != frame.size()) {
                flush();
                // A pause inside a frame: of an adapter, or shorter than t3.5.
                if (is_host() && random_.below(4) == 0)
                    b_.now = b_.now + microseconds(random_.below(may_be_joined ? 12'000 : 1'600));
            } else if (may_be_joined && is_host() && pending_.size() < 40 && random_.below(4) == 0) {
                ++kinds["burst with the next frame"];
            } else {
                flush();
            }
        }
    }
    void flush() {
        b_.server.feed(pending_, b_.now);
        pending_.clear();
    }

    tests::dice random_;
    bench b_;
    modbus::timing_mode mode_;
    byte_list pending_;
    std::array<std::uint16_t, 16> model_{};
};

} // namespace

TEST_CASE("G13, G14, G41: among exchanges of other nodes of all functions each request gets exactly one "
          "response, and "
          "nothing that they contain is executed") {
    for (const auto mode : both_modes) {
        crowd all{41, mode};
        for (int i = 0; i < 20'000; ++i) all.round();
        for (const std::uint8_t code : neighbours::functions) {
            CAPTURE(static_cast<int>(code));
            REQUIRE(all.played[code] > 1'000);
        }
        for (const std::uint32_t gap : {t3_5, 8'000u, 19'000u, 25'000u}) REQUIRE(all.gaps[gap] > 1'000);
        for (const char* kind : {"embedded write", "embedded broadcast", "several embedded", "zeros",
                                 "absent node", "exception", "CRC that fits in the middle", "trailing zeros"})
            REQUIRE(all.kinds[kind] > 1'000);
        REQUIRE(all.requests == 20'000);
        if (mode == modbus::timing_mode::host) REQUIRE(all.kinds["burst with the next frame"] > 1'000);
        CHECK(all.delayed < 200);
    }
}

} // namespace server_neighbours_tests
