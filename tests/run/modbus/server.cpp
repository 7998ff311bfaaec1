// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server on a line: which requests get a response, and which are ignored. A small store counts every
// access.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <servobus/modbus/crc_tables.hpp>
#include <servobus/modbus/server.hpp>

namespace server_tests {

using namespace servobus;

namespace {

using byte_list = std::vector<std::uint8_t>;

// Registers 0 .. 199, and the last one of the address space.
struct small_store {
    std::array<std::uint16_t, 200> words{};
    unsigned reads = 0;
    unsigned writes = 0;

    static constexpr bool covers(std::uint16_t address, std::size_t count) {
        return address + count <= 200 || (address == 0xFFFF && count == 1);
    }
    constexpr std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        ++reads;
        if (!covers(address, to.size())) return 2;
        for (std::size_t i = 0; i < to.size(); ++i)
            to[i] = address == 0xFFFF ? std::uint16_t{1} : words[address + i];
        return 0;
    }
    constexpr std::uint8_t write(std::uint16_t address, words_view from) {
        ++writes;
        if (!covers(address, from.size()) || address == 0xFFFF) return 2;
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (from[i] > 1000) return 3;
        }
        for (std::size_t i = 0; i < from.size(); ++i) words[address + i] = from[i];
        return 0;
    }
};

byte_list framed(byte_list body) {
    const std::uint16_t crc = modbus::crc16<modbus::crc_bitwise>(body);
    body.push_back(static_cast<std::uint8_t>(crc & 0xFFu));
    body.push_back(static_cast<std::uint8_t>(crc >> 8));
    return body;
}

// A server of node 1 at 115200 Bd with a clock; bytes arrive with their real spacing.
struct bench {
    small_store store{};
    modbus::rtu_timing timing;
    modbus::server<small_store> server;
    instant now{1'000'000};

    explicit bench(modbus::timing_mode mode = modbus::timing_mode::strict, modbus::server_rules rules = {})
        : timing{modbus::timing_at(115200, mode)}, server{1, store, timing, rules} {}

    void quiet(duration d) {
        now = now + d;
        server.elapse(now);
    }
    void quiet() { quiet(duration{timing.t3_5} + microseconds(10)); }
    void receive(const byte_list& frame) {
        for (const std::uint8_t b : frame) {
            now = now + timing.wire_time(1);
            server.feed(bytes{&b, 1}, now);
        }
    }
    // The response t3.5 after the last byte; empty if there is none.
    byte_list response() {
        CHECK(server.response(now + duration{timing.t3_5 - 1u}).empty());
        quiet(duration{timing.t3_5});
        byte_list got = taken();
        if (got.empty()) { // a function of unknown length ends with a gap
            quiet(timing.visible_gap());
            quiet(duration{timing.t3_5});
            got = taken();
        }
        return got;
    }
    byte_list ask(const byte_list& frame) {
        quiet();
        receive(frame);
        return response();
    }

  private:
    byte_list taken() {
        const bytes frame = server.response(now);
        const byte_list got(frame.begin(), frame.end());
        if (got.empty()) return got;
        now = now + timing.wire_time(got.size());
        server.sent(now);
        return got;
    }
};

const byte_list silence{};
const byte_list write_5_to_2 = framed({1, 0x06, 0, 2, 0, 5});
const byte_list read_2 = framed({1, 0x03, 0, 2, 0, 1});
byte_list exception(std::uint8_t code, std::uint8_t number) {
    return framed({1, static_cast<std::uint8_t>(code | 0x80u), number});
}

} // namespace

TEST_CASE("the server reads, writes one register and writes several") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        bench b{mode};
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
        CHECK(b.ask(framed({1, 0x10, 0, 3, 0, 2, 4, 0, 7, 0, 8})) == framed({1, 0x10, 0, 3, 0, 2}));
        CHECK(b.ask(framed({1, 0x03, 0, 2, 0, 3})) == framed({1, 0x03, 6, 0, 5, 0, 7, 0, 8}));
        CHECK(b.server.dropped() == 0);
    }
}

TEST_CASE("the response is ready t3.5 after the request and not before") {
    bench b;
    b.quiet();
    b.receive(read_2);
    CHECK(b.server.response(b.now).empty());
    CHECK(b.server.response(b.now + microseconds(b.timing.t3_5 - 1u)).empty());
    CHECK(!b.server.response(b.now + microseconds(b.timing.t3_5)).empty());
}

TEST_CASE("G13: a valid request that follows noise without a gap is not executed") {
    for (const byte_list& noise : {byte_list{0x55}, byte_list{0x00, 0x55}, byte_list{0x55, 0x00},
                                   byte_list(5, 0x00), byte_list(5, 0xFF), byte_list{0x01},
                                   byte_list{0x01, 0x03}, byte_list{0x02, 0x06, 1, 2}, byte_list(30, 0x02)}) {
        bench b;
        b.quiet();
        b.receive(noise);
        b.receive(write_5_to_2);
        CHECK(b.response() == silence);
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("G13: a request that begins after a gap of less than t3.5 is not executed") {
    bench b;
    CHECK(b.ask(read_2).size() == 7);
    b.receive({0x42});
    b.quiet(microseconds(b.timing.t3_5 - 20u));
    b.receive(write_5_to_2);
    CHECK(b.response() == silence);
    CHECK(b.store.writes == 0);
    b.quiet();
    b.receive(write_5_to_2);
    CHECK(b.store.writes == 1);
}

TEST_CASE("G13: in strict timing a request with a gap longer than t1.5 inside is not executed") {
    bench b;
    b.quiet();
    b.receive(byte_list(write_5_to_2.begin(), write_5_to_2.begin() + 4));
    b.quiet(microseconds(b.timing.t1_5 + 30u));
    b.receive(byte_list(write_5_to_2.begin() + 4, write_5_to_2.end()));
    CHECK(b.response() == silence);
    CHECK(b.store.writes == 0);
}

TEST_CASE("G7: in host timing a request may arrive in bursts with pauses up to the inter-byte limit") {
    bench b{modbus::timing_mode::host};
    b.quiet(milliseconds(30));
    for (const std::uint8_t byte : write_5_to_2) {
        b.quiet(milliseconds(15));
        b.receive({byte});
    }
    CHECK(b.response() == write_5_to_2);
}

TEST_CASE("G7: in host timing a request is accepted immediately after the server's own response") {
    bench b{modbus::timing_mode::host};
    CHECK(b.ask(write_5_to_2) == write_5_to_2);
    b.receive(read_2);
    CHECK(b.response() == framed({1, 0x03, 2, 0, 5}));
}

TEST_CASE("G13: a valid request inside another node's response is not executed") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        byte_list response{2, 0x03, 12, 0, 0};
        response.insert(response.end(), write_5_to_2.begin(), write_5_to_2.end());
        response.insert(response.end(), {0, 0});
        bench b{mode};
        b.quiet();
        b.receive(framed({2, 0x03, 0, 0, 0, 6}));
        b.quiet();
        b.receive(framed(response));
        CHECK(b.response() == silence);
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("G13: a valid request inside another node's write of several registers is not executed") {
    byte_list request{2, 0x10, 0, 0, 0, 4, 8};
    request.insert(request.end(), write_5_to_2.begin(), write_5_to_2.end());
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        bench b{mode};
        b.quiet();
        b.receive(framed(request));
        CHECK(b.response() == silence);
        CHECK(b.store.writes == 0);
    }
}

TEST_CASE("G14: a request gets its response t3.5 after a request to an absent node") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        bench b{mode};
        for (int i = 0; i < 3; ++i) {
            b.quiet();
            b.receive(framed({2, 0x03, 0x20, 0x88, 0, 2}));
            CHECK(b.ask(write_5_to_2) == write_5_to_2);
        }
    }
}

TEST_CASE("G14: a request gets its response t3.5 after another node's response") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        bench b{mode};
        for (const byte_list& response : {framed({2, 0x03, 4, 1, 2, 3, 4}), framed({2, 0x83, 2}),
                                          framed({2, 0x06, 0, 1, 0, 1}), framed({2, 0x10, 0, 1, 0, 2})}) {
            b.quiet();
            b.receive(response);
            CHECK(b.ask(write_5_to_2) == write_5_to_2);
        }
    }
}

TEST_CASE("G14: a wrong CRC, another node and a broadcast read get no response and change nothing") {
    for (std::size_t at = 0; at < write_5_to_2.size(); ++at) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            bench b;
            byte_list frame = write_5_to_2;
            frame[at] = static_cast<std::uint8_t>(frame[at] ^ (1u << bit));
            CHECK(b.ask(frame) == silence);
            CHECK(b.store.writes == 0);
        }
    }
    bench b;
    CHECK(b.ask(framed({2, 0x06, 0, 2, 0, 5})) == silence);
    CHECK(b.ask(framed({0, 0x03, 0, 2, 0, 1})) == silence);
    CHECK(b.store.reads + b.store.writes == 0);
    CHECK(b.ask(read_2) == framed({1, 0x03, 2, 0, 0}));
}

TEST_CASE("G14: broadcast writes are executed without a response, also when the store refuses them") {
    bench b;
    CHECK(b.ask(framed({0, 0x06, 0, 2, 0, 5})) == silence);
    CHECK(b.store.words[2] == 5);
    CHECK(b.ask(framed({0, 0x10, 0, 3, 0, 2, 4, 0, 7, 0, 8})) == silence);
    CHECK(b.store.words[4] == 8);
    CHECK(b.ask(framed({0, 0x06, 0xF0, 0, 0, 5})) == silence);
    CHECK(b.ask(framed({0, 0x44, 1, 2})) == silence);
    CHECK(b.ask(read_2) == framed({1, 0x03, 2, 0, 5}));
}

TEST_CASE("G13: in strict timing a request that follows a broadcast without a gap is not executed") {
    bench b;
    b.quiet();
    b.receive(framed({0, 0x06, 0, 2, 0, 5}));
    b.receive(framed({1, 0x06, 0, 3, 0, 9}));
    CHECK(b.response() == silence);
    CHECK(b.store.words[2] == 5);
    CHECK(b.store.words[3] == 0);
    bench host{modbus::timing_mode::host};
    host.quiet(milliseconds(50));
    host.receive(framed({0, 0x06, 0, 2, 0, 5}));
    CHECK(host.ask(read_2) == framed({1, 0x03, 2, 0, 5}));
}

TEST_CASE("G14: a frame of another node whose function has no known length ends with a gap, and is counted") {
    bench b;
    CHECK(b.ask(framed({2, 0x44, 1, 2})) == silence);
    CHECK(b.server.dropped() == 1);
    CHECK(b.ask(read_2) == framed({1, 0x03, 2, 0, 0}));
    CHECK(b.server.dropped() == 1);
}

TEST_CASE("G14: a write whose byte count is not twice its quantity is never executed") {
    for (unsigned count = 0; count < 256; ++count) {
        for (const unsigned data : {3u, 4u, 5u, count}) {
            if (count == 4 && data == 4) continue;
            byte_list request{1, 0x10, 0, 3, 0, 2, static_cast<std::uint8_t>(count)};
            request.insert(request.end(), data, std::uint8_t{0});
            bench b;
            const byte_list got = b.ask(framed(request));
            CHECK(b.store.writes == 0);
            CHECK((got == silence || got == exception(0x10, 3)));
        }
    }
}

TEST_CASE("G14: a quantity of 0 or too many is exception 3, before the address is checked") {
    bench b;
    for (const std::uint8_t high : {std::uint8_t{0}, std::uint8_t{0xF0}}) {
        CHECK(b.ask(framed({1, 0x03, high, 0, 0, 0})) == exception(0x03, 3));
        CHECK(b.ask(framed({1, 0x03, high, 0, 0, 126})) == exception(0x03, 3));
        CHECK(b.ask(framed({1, 0x03, high, 0, 0xFF, 0xFF})) == exception(0x03, 3));
        CHECK(b.ask(framed({1, 0x10, high, 0, 0, 0, 0})) == exception(0x10, 3));
        byte_list many{1, 0x10, high, 0, 0, 124, 248};
        many.insert(many.end(), 247,
                    std::uint8_t{0}); // a frame of 256 bytes: one byte too few for 124 registers
        CHECK(b.ask(framed(many)) == silence);
    }
    CHECK(b.store.reads + b.store.writes == 0);
    CHECK(b.ask(framed({1, 0x03, 0, 0, 0, 125})).size() == 255);
    byte_list most{1, 0x10, 0, 0, 0, 123, 246};
    most.insert(most.end(), 246, std::uint8_t{1});
    most[7] = 0;
    for (std::size_t i = 7; i < most.size(); i += 2) most[i] = 0;
    CHECK(b.ask(framed(most)) == framed({1, 0x10, 0, 0, 0, 123}));
}

TEST_CASE("G14: a quantity of 2 at the last register is exception 2 and does not wrap") {
    bench b;
    CHECK(b.ask(framed({1, 0x03, 0xFF, 0xFF, 0, 1})) == framed({1, 0x03, 2, 0, 1}));
    CHECK(b.ask(framed({1, 0x03, 0xFF, 0xFF, 0, 2})) == exception(0x03, 2));
    CHECK(b.ask(framed({1, 0x10, 0xFF, 0xFF, 0, 2, 4, 0, 1, 0, 1})) == exception(0x10, 2));
    CHECK(b.ask(framed({1, 0x03, 0, 199, 0, 2})) == exception(0x03, 2));
}

TEST_CASE("G14: an unknown function is exception 1, whatever its length") {
    for (unsigned code = 1; code < 128; ++code) {
        if (code == 0x03 || code == 0x06 || code == 0x10 || code == 0x04) continue;
        for (const std::size_t size : {0u, 1u, 4u, 100u}) {
            bench b;
            byte_list request{1, static_cast<std::uint8_t>(code)};
            request.insert(request.end(), size, std::uint8_t{7});
            CHECK(b.ask(framed(request)) == exception(static_cast<std::uint8_t>(code), 1));
        }
    }
    bench b;
    CHECK(b.ask(framed({1, 0x04, 0, 0, 0, 1})) == exception(0x04, 1));
}

TEST_CASE("G14: a write that the store refuses changes nothing") {
    bench b;
    CHECK(b.ask(framed({1, 0x10, 0, 3, 0, 2, 4, 0, 7, 0xFF, 0xFF})) == exception(0x10, 3));
    CHECK(b.store.words[3] == 0);
    CHECK(b.ask(framed({1, 0x06, 1, 0, 0, 5})) == exception(0x06, 2));
}

TEST_CASE(
    "function 04 reads the same registers where the rules allow it, and a device can have its own limits") {
    small_store store;
    std::array<std::uint8_t, modbus::max_pdu> out{};
    const std::array<std::uint8_t, 5> read_04{0x04, 0, 0, 0, 1};
    CHECK(modbus::respond(store, read_04, out, {.reads_input_registers = true}) == 4);
    CHECK(out[0] == 0x04);
    const std::array<std::uint8_t, 5> read_17{0x03, 0, 0, 0, 17};
    CHECK(modbus::respond(store, read_17, out, {.max_read = 16, .illegal_value = 5}) == 2);
    CHECK(out[0] == 0x83);
    CHECK(out[1] == 5);
}

TEST_CASE(
    "G14: a device that responds to a damaged frame with an exception does so for its own frames only") {
    for (const std::uint8_t leading :
         {std::uint8_t{0}, std::uint8_t{4}}) { // without it a byte 00 is an address only
        CAPTURE(leading);
        modbus::server_rules rules;
        rules.bad_crc = 1;
        rules.leading_bytes = leading;
        bench b{modbus::timing_mode::strict, rules};
        byte_list damaged = write_5_to_2;
        damaged.back() = static_cast<std::uint8_t>(damaged.back() ^ 1u);
        CHECK(b.ask(damaged) == exception(0x06, 1));
        CHECK(b.server.dropped() == 1);
        CHECK(b.store.writes == 0);
        damaged[0] = 2;
        CHECK(b.ask(damaged) == silence);
        damaged[0] = 0;
        CHECK(b.ask(damaged) == silence);
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
        CHECK(b.store.words[2] == 5);
    }
}

TEST_CASE(
    "a device may send the byte count in place of the quantity, in the response to 10h and nowhere else") {
    modbus::server_rules rules;
    rules.echoes_byte_count = true;
    bench b{modbus::timing_mode::strict, rules};
    CHECK(b.ask(framed({1, 0x10, 0, 2, 0, 2, 4, 0, 7, 0, 8})) == framed({1, 0x10, 0, 2, 0, 4}));
    CHECK(b.store.words[3] == 8);
    CHECK(b.ask(write_5_to_2) == write_5_to_2);
    CHECK(b.ask(read_2) == framed({1, 0x03, 2, 0, 5}));
    CHECK(b.ask(framed({1, 0x10, 0, 2, 0, 2, 3, 0, 7, 0})) == exception(0x10, 3));
}

TEST_CASE("G13: in strict timing a request less than t3.5 after the response is not executed") {
    for (const bool is_late : {false, true}) {
        bench b;
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
        b.now = b.now + duration{b.timing.t3_5 + (is_late ? 0u : 0u - 20u)};
        b.receive(read_2);
        CHECK(b.response() == (is_late ? framed({1, 0x03, 2, 0, 5}) : silence));
    }
}

TEST_CASE(
    "G13: bytes while the server answers do not make a request after its response one that a gap precedes") {
    bench b;
    b.quiet();
    b.receive(write_5_to_2);
    b.quiet();
    b.receive({0x5A}); // after a gap
    b.now = b.now + duration{b.timing.t3_5};
    REQUIRE(same_bytes(b.server.response(b.now), write_5_to_2));
    b.server.sent(b.now);
    b.receive(read_2);
    CHECK(b.response() == silence);
}

TEST_CASE("no bytes are no end of a gap") {
    bench b;
    b.quiet();
    b.receive(write_5_to_2);
    b.now = b.now + duration{b.timing.t3_5 - 1u};
    b.server.feed_late(bytes{}, b.now);
    b.server.feed(bytes{}, b.now);
    CHECK(b.server.response(b.now).empty());
    CHECK(same_bytes(b.server.response(b.now + duration{1}), write_5_to_2));
}

TEST_CASE("G32: a request that is too long is dropped, and the next one gets a response") {
    for (const std::size_t size : {257u, 300u, 5000u}) {
        bench b;
        b.quiet();
        b.receive(byte_list(size, 0x01));
        CHECK(b.response() == silence);
        CHECK(b.server.dropped() > 0);
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("G9, G32: after any bytes and a gap of t3.5 a request gets a response") {
    std::uint32_t random = 1;
    for (int round = 0; round < 2000; ++round) {
        bench b;
        b.quiet();
        byte_list noise;
        for (std::size_t i = random % 40; i != 0; --i) {
            random = random * 1664525u + 1013904223u;
            noise.push_back(static_cast<std::uint8_t>(random >> 24 & (round % 2 == 0 ? 0xFFu : 0x13u)));
        }
        random = random * 1664525u + 1013904223u;
        b.receive(noise);
        (void)b.response();
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("a server keeps its times through the wrap of the clock") {
    bench b;
    b.now = instant{0xFFFF'F000u};
    for (int i = 0; i < 5; ++i) CHECK(b.ask(write_5_to_2) == write_5_to_2);
    CHECK(b.now.us < 0x1000'0000u);
}

TEST_CASE("G9: a gap that a server has detected still counts after a whole wrap of the clock") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        const byte_list damaged{1, 0x03, 0, 2, 0, 1, 0, 0}; // the server ignores what follows directly
        for (const byte_list& before :
             {byte_list{0x55}, framed({2, 0x03, 0, 2, 0, 1}), damaged, byte_list{}}) {
            bench b{mode};
            b.receive(before);
            const instant heard = b.now;
            b.quiet(milliseconds(100));
            b.now = heard + microseconds(1); // and 71 minutes
            b.receive(read_2);
            CHECK(b.response() == framed({1, 0x03, 2, 0, 0}));
        }
    }
}

namespace {
constexpr bool answers_at_compile_time() {
    small_store store;
    modbus::server<small_store> server{1, store, modbus::timing_at(115200)};
    server.feed(hex("01 06 00 02 00 05 E8 09"), instant{1000});
    const bytes response = server.response(instant{10'000});
    return store.words[2] == 5 && same_bytes(response, hex("01 06 00 02 00 05 E8 09"));
}
static_assert(answers_at_compile_time());
} // namespace

} // namespace server_tests
