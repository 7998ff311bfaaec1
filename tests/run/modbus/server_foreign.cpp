// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames of other nodes that can be read in two ways, with a whole valid request for this server in their
// payload, where the wrong candidate expects the next frame. Each is built by search, so that every CRC fits.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include <servobus/modbus/server.hpp>

#include <tests/support/scripted_port.hpp>

namespace server_foreign_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::low_byte;
using tests::operator+;

namespace {

constexpr auto both_modes = {modbus::timing_mode::strict, modbus::timing_mode::host};

struct few_words {
    std::array<std::uint16_t, 8> words{};
    unsigned reads = 0;
    unsigned writes = 0;
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        ++reads;
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = words[(address + i) % 8];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        ++writes;
        for (std::size_t i = 0; i < from.size(); ++i) words[(address + i) % 8] = from[i];
        return 0;
    }
};

// A server on a line at 115200 Bd.
struct bench {
    few_words store{};
    modbus::rtu_timing timing;
    modbus::server<few_words> server;
    instant now{1'000'000};

    explicit bench(modbus::timing_mode mode, std::uint8_t node_address = 1, modbus::server_rules rules = {})
        : timing{modbus::timing_at(115200, mode)}, server{node_address, store, timing, rules} {}

    void quiet(duration d) {
        now = now + d;
        server.elapse(now);
    }
    void t3_5() { quiet(duration{timing.t3_5} + microseconds(10)); }
    void silence() { quiet(timing.visible_gap() + milliseconds(1)); }
    // In bursts of `burst` bytes; the server acts on none of them.
    void overhear(const byte_list& frame, std::size_t burst = 1) {
        const unsigned accesses = store.reads + store.writes;
        for (std::size_t at = 0; at < frame.size(); at += burst) {
            feed(bytes{frame}.subspan(at, std::min(burst, frame.size() - at)));
            REQUIRE(!server.is_answering());
        }
        REQUIRE(store.reads + store.writes == accesses);
    }
    // Whether it is executed immediately.
    bool receive(const byte_list& request) {
        for (const std::uint8_t& byte : request) feed(bytes{&byte, 1});
        return server.is_answering();
    }
    byte_list response() {
        t3_5();
        const bytes frame = server.response(now);
        const byte_list got(frame.begin(), frame.end());
        now = now + timing.wire_time(got.size());
        if (!got.empty()) server.sent(now);
        return got;
    }
    // The response that comes immediately, or when a gap has shown that this is a request.
    byte_list ask(const byte_list& request) {
        if (!receive(request)) silence();
        return response();
    }

  private:
    void feed(bytes arrived) {
        now = now + timing.wire_time(arrived.size());
        server.feed(arrived, now);
    }
};

const byte_list write_5 = framed({1, 0x06, 0, 2, 0, 5});
const byte_list write_two = framed({1, 0x10, 0, 2, 0, 2, 4, 0, 7, 0, 8});
const byte_list broadcast_5 = framed({0, 0x06, 0, 2, 0, 5});
const byte_list read_2 = framed({1, 0x03, 0, 2, 0, 1});

byte_list read_of(std::uint8_t node_address, unsigned address, unsigned quantity) {
    return framed({node_address, 0x03, tests::high_byte(address), low_byte(address), 0, low_byte(quantity)});
}

bool is_frame(const byte_list& f, std::size_t size) {
    return size >= 4 && size <= f.size() && tests::crc_of(bytes{f}.first(size)) == 0;
}

// The response of node 2 to a read of `count` / 2 registers. Its first 8 bytes are also a read request to
// node 2, and `inside` are the bytes after them.
byte_list double_faced_response(std::uint8_t count, const byte_list& inside) {
    byte_list body = framed({2, 0x03, count, 0x10, 0, 1}) + inside;
    body.resize(3u + count);
    return framed(body);
}

} // namespace

TEST_CASE("G13: a request inside another node's response that begins like a request is not executed") {
    for (const auto mode : both_modes) {
        for (const byte_list& inside : {write_5, write_two, broadcast_5, write_5 + write_5}) {
            for (const unsigned count : {24u, 32u, 130u, 250u}) {
                const byte_list response = double_faced_response(low_byte(count), inside);
                REQUIRE(is_frame(response, 8));
                REQUIRE(is_frame(response, response.size()));
                for (std::size_t burst = 1; burst <= response.size(); ++burst) {
                    // No pause, t3.5 or a visible gap before the response; t3.5 or a visible gap after it.
                    for (const int pauses : {0, 1, 2, 3, 4, 5}) {
                        bench b{mode};
                        b.overhear(read_of(2, 0, count / 2), burst);
                        if (pauses % 3 == 1) b.t3_5();
                        if (pauses % 3 == 2) b.silence();
                        b.overhear(response, burst);
                        pauses < 3 ? b.t3_5() : b.silence();
                        REQUIRE(b.store.writes == 0);
                        const bool is_at_once = b.receive(read_2);
                        REQUIRE((is_at_once || (pauses < 3 && mode == modbus::timing_mode::host)));
                        if (!is_at_once) b.silence();
                        REQUIRE(b.response() == tests::read_response(1, {0}));
                    }
                }
            }
        }
    }
}

TEST_CASE("G13: such a request is not executed either if the server did not receive the request before the "
          "response") {
    for (const bool is_after_noise : {false, true}) {
        bench b{modbus::timing_mode::host};
        if (is_after_noise) {
            CHECK(b.ask(read_2) == tests::read_response(1, {0}));
            b.overhear({2, 0x03, 0, 0, 0, 12, 0, 0}); // a wrong CRC
            b.silence();
        }
        b.overhear(double_faced_response(24, write_5));
        b.silence();
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5) == write_5);
    }
}

TEST_CASE("G13: a request inside another node's write that begins like its response is not executed") {
    // A write of 10 registers whose byte count and first byte of data are the CRC of the bytes before.
    std::optional<byte_list> found;
    for (unsigned address = 0; address <= 0xFFFF && !found; ++address) {
        const byte_list begun = framed({2, 0x10, tests::high_byte(address), low_byte(address), 0, 10});
        if (begun[6] == 20) found = begun;
    }
    REQUIRE(found.has_value());
    byte_list body = *found + write_5;
    body.resize(7 + 20);
    const byte_list request = framed(body);
    for (std::size_t burst = 1; burst <= request.size(); ++burst) {
        bench b{modbus::timing_mode::host};
        b.overhear(request, burst);
        b.t3_5();
        CHECK(b.store.writes == 0);
        b.overhear(framed(byte_list(found->begin(), found->begin() + 6)));
        CHECK(b.ask(write_5) == write_5);
    }
}

TEST_CASE("G13: where the same bytes end as a response and as a request, any response may follow") {
    // The response of node 2 to a read of 119 registers. Read in the other way it is a request to node 2,
    // responses of nodes 3, 4 and 5 and a request to node 6: for frames of these lengths both have the right
    // CRC.
    const auto response_of = [](std::uint8_t node_address, std::size_t size) {
        byte_list body{node_address, 0x03, low_byte(static_cast<unsigned>(size - 5))};
        body.resize(size - 2, 0x11);
        return framed(body);
    };
    const byte_list heard = framed({2, 0x03, 238, 0x10, 0, 7}) + response_of(3, 19) + response_of(4, 113) +
                            response_of(5, 95) + read_of(6, 0x30, 12);
    REQUIRE(heard.size() == 3 + 238 + 2);
    REQUIRE(is_frame(heard, heard.size()));
    for (const bool is_first_candidate_known : {false, true}) {
        bench b{modbus::timing_mode::host};
        if (is_first_candidate_known) b.overhear(read_of(2, 0, 119));
        b.overhear(heard);
        b.overhear(double_faced_response(24, write_5));
        b.silence();
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5) == write_5);
    }
}

TEST_CASE(
    "G13: a response after a request that begins like a short response is not read from the byte before") {
    // `06 03 02 ..`, a read request to node 6 with a 0 at its end, is a response of node 6 without that 0.
    // The 0 and the response of node 6 then begin like a broadcast write of one register.
    unsigned found = 0;
    for (unsigned low = 0; low < 256; ++low) {
        for (unsigned quantity = 2; quantity <= 125; ++quantity) {
            const byte_list request = read_of(6, 0x200 + low, quantity);
            if (request[7] != 0) continue;
            REQUIRE(is_frame(request, 7));
            ++found;
            const byte_list inside = framed({0, 6, 3, low_byte(2 * quantity), 0, 5});
            byte_list body(inside.begin() + 1, inside.end());
            body.resize(3 + 2 * quantity);
            bench b{modbus::timing_mode::host};
            b.overhear(request);
            b.overhear(framed(body));
            b.silence();
            CHECK(b.store.writes == 0);
            CHECK(b.ask(write_5) == write_5);
        }
    }
    CHECK(found > 0);
}

TEST_CASE("G13: where a gap leaves two candidates in which all frames are whole, nothing is executed") {
    // By one candidate node 2 is asked and responds, and then comes a request to this server. In the other it
    // responds to what it was asked before, and then node 3 responds twice. The CRCs of the first candidate
    // together make the last CRC of the second fit: this is so with frames that end at these places.
    byte_list line = read_of(2, 0x6C00, 57);
    line.insert(line.end(), {2, 3, 114});
    line.resize(111);
    line = framed(line) + tests::read_response(3, {0x1234}) + byte_list{3, 3, 10, 0, 0};
    const byte_list response = framed(byte_list(line.begin() + 8, line.end()));
    line = read_of(2, 0x6C00, 57) + response + write_5;
    const auto part = [&line](int from, int to) { return byte_list(line.begin() + from, line.begin() + to); };
    REQUIRE(line.size() == 135);
    REQUIRE(is_frame(part(0, 113), 113));
    REQUIRE(is_frame(part(113, 120), 7));
    REQUIRE(is_frame(part(120, 135), 15));
    REQUIRE(is_frame(part(8, 127), 119));
    for (const bool is_at_once : {false, true}) {
        bench b{modbus::timing_mode::host};
        b.overhear(read_of(2, 0, 54));
        b.silence();
        b.overhear(line);
        // Both candidates agree on what comes next.
        is_at_once ? b.t3_5() : b.silence();
        CHECK(b.receive(read_2));
        CHECK(b.store.writes == 0);
    }
}

TEST_CASE("G14: between polls of other nodes, t3.5 apart, a request is executed immediately") {
    for (const auto mode : both_modes) {
        for (const unsigned quantity : {1u, 2u, 12u, 16u, 125u}) {
            for (const unsigned address : {0u, 0x200u, 0x0410u, 0x2088u, 0xFA00u}) {
                if (address >> 8 == 2 * quantity) continue; // such a request may be the response
                bench b{mode};
                const byte_list response =
                    tests::read_response(2, std::vector<std::uint16_t>(quantity, 0xA5A5));
                for (int round = 0; round < 5; ++round) {
                    b.t3_5();
                    CHECK(b.receive(read_2));
                    CHECK(b.response() == tests::read_response(1, {0}));
                    b.t3_5();
                    b.overhear(read_of(2, address, quantity));
                    b.t3_5();
                    if (round % 2 == 0) b.overhear(response); // the other node is sometimes absent
                    b.t3_5();
                    CHECK(b.receive(read_2));
                    CHECK(b.response() == tests::read_response(1, {0}));
                    b.t3_5();
                    b.overhear(framed({3, 0x06, 0, 2, 0, 1}));
                    b.t3_5();
                    b.overhear(framed({3, 0x86, 2}));
                }
            }
        }
    }
}

TEST_CASE("G14: a request after one that may be a response is executed when a gap has shown which it is") {
    bench b{modbus::timing_mode::host};
    // Node 2 is absent. Its second request begins like a response to the first.
    for (int round = 0; round < 4; ++round) {
        b.silence();
        b.overhear(read_of(2, 0x2000, 16));
        b.t3_5();
        if (round == 0) continue;
        CHECK(!b.receive(write_5));
        b.quiet(milliseconds(15));
        CHECK(b.store.writes == static_cast<unsigned>(round) - 1);
        b.quiet(milliseconds(6));
        CHECK(b.store.writes == static_cast<unsigned>(round));
        CHECK(b.response() == write_5);
    }
    // Where a CRC shows it first, the server does not wait for a response any more.
    b.silence();
    b.overhear(read_of(2, 0x2000, 16));
    b.overhear(write_5);
    for (int i = 0; i < 3; ++i) b.overhear(framed({3, 0x06, 0, 2, 0, 1}));
    CHECK(b.receive(write_5));
    CHECK(b.response() == write_5);
    CHECK(b.server.dropped() == 0);
}

TEST_CASE("G14: on a line without pauses, whose frames can be read in two ways, a request is executed after "
          "a gap at the latest") {
    for (const unsigned quantity : {1u, 2u, 125u}) {
        bench b{modbus::timing_mode::host};
        for (int round = 0; round < 20; ++round) {
            b.overhear(read_of(2, 0xFA88, quantity));
            b.overhear(tests::read_response(2, std::vector<std::uint16_t>(quantity, 0x0102)));
        }
        CHECK(b.ask(write_5) == write_5);
        CHECK(b.server.dropped() == 0);
    }
}

TEST_CASE("G14: after a request that cannot be a response to an earlier one, the next request is executed "
          "immediately") {
    struct passed {
        const char* what;
        byte_list frames;
    };
    const passed all[] = {
        {"nothing known, an odd byte count", read_of(2, 0x2100, 1)},
        {"nothing known, a byte count that is too large", read_of(2, 0xFC00, 1)},
        {"the byte count of another node", read_of(2, 0, 16) + read_of(3, 0x2000, 1)},
        {"another byte count", read_of(2, 0, 16) + read_of(2, 0x2200, 1)},
        {"more registers than can be read", read_of(2, 0, 144) + read_of(2, 0x2000, 1)},
        {"a write", read_of(2, 0, 16) + framed({3, 6, 0, 1, 0, 2}) + read_of(2, 0x2000, 1)},
        {"an exception", read_of(2, 0, 16) + framed({2, 0x83, 2}) + read_of(2, 0x2000, 1)},
        {"a write's acknowledgement", framed({2, 0x10, 0, 1, 0, 2})},
    };
    for (const passed& p : all) {
        CAPTURE(p.what);
        bench b{modbus::timing_mode::host};
        b.overhear(p.frames);
        b.t3_5();
        CHECK(b.receive(write_5));
        CHECK(b.response() == write_5);
        CHECK(b.server.dropped() == 0);
    }
}

TEST_CASE("G13: while two candidates are possible, a damaged frame to the server ends its candidate") {
    byte_list damaged = write_5;
    damaged[5] ^= 1u;
    bench b{modbus::timing_mode::host};
    b.overhear(read_of(2, 0x2000, 1));
    b.overhear(damaged);
    b.overhear(write_5);
    b.silence();
    CHECK(b.store.writes == 0);
    CHECK(b.server.dropped() == 1);
    CHECK(b.ask(write_5) == write_5);
}

TEST_CASE("G13, G14: a gap that is noticed only with the next byte ends the other candidates, and a pending "
          "request is lost") {
    for (const bool is_due : {false, true}) {
        bench b{modbus::timing_mode::host};
        b.overhear(read_of(2, 0x2000, 16));
        if (is_due) b.overhear(write_two);
        b.now = b.now + milliseconds(21);
        // The response of node 2 would begin like this.
        b.overhear(read_of(2, 0x2000, 1));
        CHECK(b.server.dropped() == (is_due ? 1u : 0u));
        CHECK(b.store.writes == 0);
        CHECK(!b.receive(write_5));
        b.silence();
        CHECK(b.response() == write_5);
        // Node 2 did not respond to that either. Only a frame with the byte count that it was asked for may
        // be its response.
        b.overhear(read_of(2, 0x2200, 1));
        CHECK(b.receive(write_5));
    }
}

TEST_CASE(
    "G14, G32: a frame without a known length is none when it becomes too long, and its candidate ends") {
    // The last byte of the request, a 0, and a frame of node 43 may be a broadcast of function 43.
    std::optional<byte_list> request;
    for (unsigned low = 0; !request; ++low) {
        const byte_list r = read_of(6, 0x200 + low % 256, 1 + low / 256);
        if (r[7] == 0) request = r;
    }
    bench b{modbus::timing_mode::host};
    b.overhear(*request);
    for (int i = 0; i < 30; ++i) b.overhear(framed({43, 6, 0, 1, 0, 2}));
    CHECK(!b.receive(write_5)); // it has 249 bytes
    b.overhear(framed({43, 6, 0, 1, 0, 2}));
    CHECK(b.receive(write_5));
    CHECK(b.response() == write_5);
    CHECK(b.server.dropped() == 0);
}

TEST_CASE("G13, G32: with more candidates than the server follows it ignores all frames until a gap") {
    bench b{modbus::timing_mode::host};
    for (int i = 0; i < 3; ++i) b.overhear(read_of(2, 0xF000, 120));
    CHECK(b.server.dropped() == 0);
    b.overhear(read_of(2, 0xF000, 120));
    CHECK(b.server.dropped() == 1);
    b.overhear(write_5);
    b.silence();
    b.silence();
    CHECK(b.store.writes == 0);
    CHECK(b.server.dropped() == 1);
    CHECK(b.ask(write_5) == write_5);
}

TEST_CASE("a broadcast write after a request that may be a response is executed when a gap has shown it") {
    bench b{modbus::timing_mode::host};
    b.overhear(read_of(2, 0x2000, 16));
    b.overhear(broadcast_5);
    b.silence();
    CHECK(b.store.writes == 1);
    CHECK(!b.server.is_answering());
    b.overhear(read_of(2, 0x2000, 16));
    b.overhear(framed({0, 0x03, 0, 2, 0, 1}));
    b.silence();
    CHECK(b.store.reads == 0);
    CHECK(b.ask(write_5) == write_5);
}

namespace {

// A request of 17h of node 7 for 12 registers, whose bytes are also a response of node 7, one of node 3, a request of 8
// bytes and `last`, of 8 bytes: for frames of these lengths each has the right CRC.
byte_list chain_in_a_request(const byte_list& last, const byte_list& before = framed({4, 0x06, 0, 2, 0, 9})) {
    byte_list of_3{3, 0x01, 107};
    of_3.resize(110, 0x11);
    const byte_list chain = framed({7, 0x17, 8, 0, 0, 12, 0, 0, 0, 64, 128}) + framed(of_3) + before + last;
    REQUIRE(last.size() == 8);
    REQUIRE(chain.size() == 11 + 128 + 2);
    REQUIRE(is_frame(chain, 13));
    REQUIRE(is_frame(chain, chain.size()));
    return chain;
}

} // namespace

TEST_CASE("G13: where reads of two nodes end with the same byte, the response of either may follow") {
    for (const bool is_at_once : {false, true}) {
        bench b{modbus::timing_mode::host};
        b.overhear(chain_in_a_request(read_of(2, 0x30, 12)));
        if (!is_at_once) b.t3_5();
        b.overhear(double_faced_response(24, write_5)); // of node 2
        b.silence();
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5) == write_5);
    }
}

TEST_CASE("G13: a frame to the server of unknown length may go on after a pause, where another frame has "
          "ended too") {
    const byte_list begun = framed({1, 0x65, 1, 2, 3, 4});
    const byte_list whole = framed(begun + write_5);
    bench b{modbus::timing_mode::host};
    b.overhear(chain_in_a_request(begun));
    b.t3_5();
    b.overhear(byte_list(whole.begin() + 8, whole.end()));
    b.silence();
    CHECK(b.store.writes == 0);
    CHECK(b.response() == framed({1, 0xE5, 1}));
    CHECK(b.ask(write_5) == write_5);
}

TEST_CASE("G13, G14: after a short response that may be a longer request, and skipped bytes, a request waits "
          "for a gap") {
    // FF, which is skipped, and a response of node 255; or FF FF, and a frame of node 2 with function 0Bh. Both end
    // with a response of node 5, which may also be the beginning of its request.
    byte_list of_255{0xFF, 0x02, 11};
    of_255.resize(14, 0x21);
    const byte_list heard = framed(of_255) + framed({5, 0x17, 0});
    REQUIRE(is_frame(byte_list(heard.begin() + 1, heard.end()), heard.size() - 1));
    bench b{modbus::timing_mode::host};
    b.overhear(byte_list{0xFF} + heard);
    b.t3_5();
    CHECK_FALSE(b.receive(write_5));
    CHECK(b.store.writes == 0);
    b.silence();
    CHECK(b.store.writes == 1);
    CHECK(b.response() == write_5);
}

TEST_CASE("G14: where frames with and without skipped bytes before them end together, a request is executed "
          "immediately") {
    // After the chain, node 2 responds with 28 bytes; or it is asked, and 17 bytes 00 and FF come before a response of
    // node 3: after so many both candidates have the same CRC.
    byte_list skipped(17, 0x00);
    for (const std::size_t at : {0u, 1u, 3u, 14u, 16u}) skipped[at] = 0xFF;
    const byte_list asked = framed({2, 0x03, 28, 0x10, 0, 1});
    const byte_list rest = skipped + framed({3, 0x10, 0, 2, 0, 2});
    REQUIRE(is_frame(asked + rest, 5 + 28));
    modbus::server_rules rules;
    rules.leading_bytes = 20;
    bench b{modbus::timing_mode::host, 1, rules};
    b.overhear(chain_in_a_request(asked, read_of(2, 0x20, 14)));
    b.t3_5();
    b.overhear(rest);
    CHECK(b.receive(write_5));
    CHECK(b.response() == write_5);
    CHECK(b.store.writes == 1);
}

} // namespace server_foreign_tests
