// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The device side on a line: what it answers, what it leaves alone. A small store notes every access.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <servobus/modbus/server.hpp>

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

// A server of unit 1 at 115200 Bd with a clock; bytes come with their real spacing.
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
    void hear(const byte_list& frame) {
        for (const std::uint8_t b : frame) {
            now = now + timing.wire_time(1);
            server.feed(bytes{&b, 1}, now);
        }
    }
    // The response t3.5 after the last byte; empty for silence.
    byte_list response() {
        CHECK(server.response(now + duration{timing.t3_5 - 1u}).empty());
        quiet(duration{timing.t3_5});
        byte_list got = taken();
        if (got.empty()) { // a function of unknown length ends in silence
            quiet(timing.visible_silence());
            quiet(duration{timing.t3_5});
            got = taken();
        }
        return got;
    }
    byte_list ask(const byte_list& frame) {
        quiet();
        hear(frame);
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

TEST_CASE("the response is there t3.5 after the request and not before") {
    bench b;
    b.quiet();
    b.hear(read_2);
    CHECK(b.server.response(b.now).empty());
    CHECK(b.server.response(b.now + microseconds(b.timing.t3_5 - 1u)).empty());
    CHECK(!b.server.response(b.now + microseconds(b.timing.t3_5)).empty());
}

TEST_CASE("G13: a valid request glued behind noise is not executed") {
    for (const byte_list& noise : {byte_list{0x55}, byte_list{0x00}, byte_list{0xFF}, byte_list{0x01},
                                   byte_list{0x01, 0x03}, byte_list{0x02, 0x06, 1, 2}, byte_list(30, 0x02)}) {
        bench b;
        b.quiet();
        b.hear(noise);
        b.hear(write_5_to_2);
        CHECK(b.response() == silence);
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("G13: a request that begins after less than t3.5 of silence is not executed") {
    bench b;
    CHECK(b.ask(read_2).size() == 7);
    b.hear({0x42});
    b.quiet(microseconds(b.timing.t3_5 - 20u));
    b.hear(write_5_to_2);
    CHECK(b.response() == silence);
    CHECK(b.store.writes == 0);
    b.quiet();
    b.hear(write_5_to_2);
    CHECK(b.store.writes == 1);
}

TEST_CASE("G13: a request cut by a gap longer than t1.5 is not executed in strict timing") {
    bench b;
    b.quiet();
    b.hear(byte_list(write_5_to_2.begin(), write_5_to_2.begin() + 4));
    b.quiet(microseconds(b.timing.t1_5 + 30u));
    b.hear(byte_list(write_5_to_2.begin() + 4, write_5_to_2.end()));
    CHECK(b.response() == silence);
    CHECK(b.store.writes == 0);
}

TEST_CASE("G7: in host timing a request may come in bursts with pauses up to the inter-byte limit") {
    bench b{modbus::timing_mode::host};
    b.quiet(milliseconds(30));
    for (const std::uint8_t byte : write_5_to_2) {
        b.quiet(milliseconds(15));
        b.hear({byte});
    }
    CHECK(b.response() == write_5_to_2);
}

TEST_CASE("G7: in host timing a request is accepted at once after the server's own response") {
    bench b{modbus::timing_mode::host};
    CHECK(b.ask(write_5_to_2) == write_5_to_2);
    b.hear(read_2);
    CHECK(b.response() == framed({1, 0x03, 2, 0, 5}));
}

TEST_CASE("G13: a valid request inside another unit's response is not executed") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        byte_list response{2, 0x03, 12, 0, 0};
        response.insert(response.end(), write_5_to_2.begin(), write_5_to_2.end());
        response.insert(response.end(), {0, 0});
        bench b{mode};
        b.quiet();
        b.hear(framed({2, 0x03, 0, 0, 0, 6}));
        b.quiet();
        b.hear(framed(response));
        CHECK(b.response() == silence);
        CHECK(b.store.writes == 0);
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("G13: a valid request inside another unit's write of several registers is not executed") {
    byte_list request{2, 0x10, 0, 0, 0, 4, 8};
    request.insert(request.end(), write_5_to_2.begin(), write_5_to_2.end());
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        bench b{mode};
        b.quiet();
        b.hear(framed(request));
        CHECK(b.response() == silence);
        CHECK(b.store.writes == 0);
    }
}

TEST_CASE("G14: a request is answered t3.5 after a request to an absent unit") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        bench b{mode};
        for (int i = 0; i < 3; ++i) {
            b.quiet();
            b.hear(framed({2, 0x03, 0x20, 0x88, 0, 2}));
            CHECK(b.ask(write_5_to_2) == write_5_to_2);
        }
    }
}

TEST_CASE("G14: a request is answered t3.5 after another unit's response") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        bench b{mode};
        for (const byte_list& response : {framed({2, 0x03, 4, 1, 2, 3, 4}), framed({2, 0x83, 2}),
                                          framed({2, 0x06, 0, 1, 0, 1}), framed({2, 0x10, 0, 1, 0, 2})}) {
            b.quiet();
            b.hear(response);
            CHECK(b.ask(write_5_to_2) == write_5_to_2);
        }
    }
}

TEST_CASE("G14: a wrong CRC, another unit and a broadcast read meet silence and change nothing") {
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

TEST_CASE("G14: broadcast writes are executed in silence, also when the store refuses them") {
    bench b;
    CHECK(b.ask(framed({0, 0x06, 0, 2, 0, 5})) == silence);
    CHECK(b.store.words[2] == 5);
    CHECK(b.ask(framed({0, 0x10, 0, 3, 0, 2, 4, 0, 7, 0, 8})) == silence);
    CHECK(b.store.words[4] == 8);
    CHECK(b.ask(framed({0, 0x06, 0xF0, 0, 0, 5})) == silence);
    CHECK(b.ask(framed({0, 0x44, 1, 2})) == silence);
    CHECK(b.ask(read_2) == framed({1, 0x03, 2, 0, 5}));
}

TEST_CASE("G13: a request glued behind a broadcast is not executed in strict timing") {
    bench b;
    b.quiet();
    b.hear(framed({0, 0x06, 0, 2, 0, 5}));
    b.hear(framed({1, 0x06, 0, 3, 0, 9}));
    CHECK(b.response() == silence);
    CHECK(b.store.words[2] == 5);
    CHECK(b.store.words[3] == 0);
    bench host{modbus::timing_mode::host};
    host.quiet(milliseconds(50));
    host.hear(framed({0, 0x06, 0, 2, 0, 5}));
    CHECK(host.ask(read_2) == framed({1, 0x03, 2, 0, 5}));
}

TEST_CASE("G14: a frame of another unit whose function tells no length ends in silence, and is counted") {
    bench b;
    CHECK(b.ask(framed({2, 0x44, 1, 2})) == silence);
    CHECK(b.server.dropped() == 1);
    CHECK(b.ask(read_2) == framed({1, 0x03, 2, 0, 0}));
    CHECK(b.server.dropped() == 1);
}

TEST_CASE("G14: a byte count that is not twice the quantity never writes") {
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

TEST_CASE("G14: quantity 0 and too many are exception 3, before the address is looked at") {
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

TEST_CASE("G14: the last register with quantity 2 is exception 2 and does not wrap") {
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

TEST_CASE("G14: a write that the store refuses has changed nothing") {
    bench b;
    CHECK(b.ask(framed({1, 0x10, 0, 3, 0, 2, 4, 0, 7, 0xFF, 0xFF})) == exception(0x10, 3));
    CHECK(b.store.words[3] == 0);
    CHECK(b.ask(framed({1, 0x06, 1, 0, 0, 5})) == exception(0x06, 2));
}

TEST_CASE("function 04 reads the same registers where the rules grant it, and limits can be a device's own") {
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

TEST_CASE("G14: a device that answers a damaged frame by an exception does so for its own frames only") {
    modbus::server_rules rules;
    rules.bad_crc = 1;
    bench b{modbus::timing_mode::strict, rules};
    byte_list damaged = write_5_to_2;
    damaged.back() = static_cast<std::uint8_t>(damaged.back() ^ 1u);
    CHECK(b.ask(damaged) == exception(0x06, 1));
    CHECK(b.store.writes == 0);
    damaged[0] = 2;
    CHECK(b.ask(damaged) == silence);
    damaged[0] = 0;
    CHECK(b.ask(damaged) == silence);
    CHECK(b.store.writes == 0);
    CHECK(b.ask(write_5_to_2) == write_5_to_2);
    CHECK(b.store.words[2] == 5);
}

TEST_CASE(
    "a device may say the byte count where the quantity belongs, in the response to 10h and nowhere else") {
    modbus::server_rules rules;
    rules.echoes_byte_count = true;
    bench b{modbus::timing_mode::strict, rules};
    CHECK(b.ask(framed({1, 0x10, 0, 2, 0, 2, 4, 0, 7, 0, 8})) == framed({1, 0x10, 0, 2, 0, 4}));
    CHECK(b.store.words[3] == 8);
    CHECK(b.ask(write_5_to_2) == write_5_to_2);
    CHECK(b.ask(read_2) == framed({1, 0x03, 2, 0, 5}));
    CHECK(b.ask(framed({1, 0x10, 0, 2, 0, 2, 3, 0, 7, 0})) == exception(0x10, 3));
}

TEST_CASE("G32: a request that is too long is dropped, and the next one is answered") {
    for (const std::size_t size : {257u, 300u, 5000u}) {
        bench b;
        b.quiet();
        b.hear(byte_list(size, 0x01));
        CHECK(b.response() == silence);
        CHECK(b.server.dropped() > 0);
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("G9, G32: after any bytes and t3.5 of silence a request is answered") {
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
        b.hear(noise);
        (void)b.response();
        CHECK(b.ask(write_5_to_2) == write_5_to_2);
    }
}

TEST_CASE("a server keeps its time through the wrap of the clock") {
    bench b;
    b.now = instant{0xFFFF'F000u};
    for (int i = 0; i < 5; ++i) CHECK(b.ask(write_5_to_2) == write_5_to_2);
    CHECK(b.now.us < 0x1000'0000u);
}

TEST_CASE("G9: a server that saw silence knows it when the clock has gone all round since") {
    for (const auto mode : {modbus::timing_mode::strict, modbus::timing_mode::host}) {
        const byte_list damaged{1, 0x03, 0, 2, 0, 1, 0, 0}; // it is deaf to what comes right behind that
        for (const byte_list& before :
             {byte_list{0x55}, framed({2, 0x03, 0, 2, 0, 1}), damaged, byte_list{}}) {
            bench b{mode};
            b.hear(before);
            const instant heard = b.now;
            b.quiet(milliseconds(100));
            b.now = heard + microseconds(1); // and 71 minutes
            b.hear(read_2);
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
