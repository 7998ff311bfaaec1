// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A request without a pause before it: a server executes it in host timing, where t3.5 cannot be seen, and
// ignores it in strict timing, whatever frame came before.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <servobus/modbus/server.hpp>

#include <tests/support/served_words.hpp>

namespace server_pauses_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::operator+;
using namespace tests::served;

namespace {

const byte_list write_5 = framed({1, 0x06, 0, 2, 0, 5});

} // namespace

TEST_CASE("G13, G14: a request that follows directly on a frame without a response is executed in host "
          "timing only") {
    struct before {
        const char* what;
        byte_list frame;
        unsigned accesses;
    };
    const before all[] = {{"a broadcast read", framed({0, 0x03, 0, 2, 0, 1}), 0},
                          {"a broadcast read of input registers", framed({0, 0x04, 0, 2, 0, 1}), 0},
                          {"a broadcast write", framed({0, 0x06, 0, 2, 0, 9}), 1},
                          {"a broadcast write of two", framed({0, 0x10, 0, 2, 0, 2, 4, 0, 9, 0, 9}), 1},
                          {"another node's request", framed({2, 0x03, 0, 2, 0, 1}), 0},
                          {"another node's response", tests::read_response(2, {1}), 0}};
    for (const before& b : all) {
        for (const auto mode : {modbus::timing_mode::host, modbus::timing_mode::strict}) {
            const bool is_host = mode == modbus::timing_mode::host;
            CAPTURE(b.what);
            CAPTURE(is_host);
            const modbus::rtu_timing timing = modbus::timing_at(115200, mode);
            one_word store;
            modbus::server<one_word> server{1, store, timing};
            instant now{1'000'000};
            for (const std::uint8_t byte : b.frame + write_5) {
                now = now + timing.wire_time(1);
                server.feed(bytes{&byte, 1}, now);
            }
            CHECK(store.accesses == b.accesses + (is_host ? 1 : 0));
            CHECK((store.word == 5) == is_host);
            CHECK(server.is_answering() == is_host);
            now = now + duration{timing.t3_5};
            CHECK(same_bytes(server.response(now), is_host ? bytes{write_5} : bytes{}));
            // After a gap it is executed in both.
            if (is_host) server.sent(now);
            now = now + timing.visible_gap() + milliseconds(1);
            server.elapse(now);
            server.feed(write_5, now + timing.wire_time(write_5.size()));
            CHECK(server.is_answering());
        }
    }
}

TEST_CASE("G14: a response begins only after a gap of t3.5, however many bytes follow the request") {
    for (const auto mode : {modbus::timing_mode::host, modbus::timing_mode::strict}) {
        for (const std::uint32_t after_us : {100u, 800u, 1'700u}) {
            for (const unsigned more : {1u, 7u, 300u}) {
                CAPTURE(static_cast<int>(mode));
                CAPTURE(after_us);
                CAPTURE(more);
                const modbus::rtu_timing timing = modbus::timing_at(115200, mode);
                one_word store;
                modbus::server<one_word> server{1, store, timing};
                instant now{0xFFFF'F000u}; // the clock wraps meanwhile
                for (const std::uint8_t byte : write_5) {
                    now = now + timing.wire_time(1);
                    server.feed(bytes{&byte, 1}, now);
                }
                const std::uint8_t noise = 0x5A;
                for (unsigned i = 0; i < more; ++i) {
                    for (const instant until = now + microseconds(after_us); now != until;) {
                        CHECK(server.response(now).empty());
                        now = now + microseconds(after_us < 200 ? 50 : 100);
                        server.elapse(now);
                    }
                    CHECK(server.response(now).empty());
                    server.feed(bytes{&noise, 1}, now);
                }
                CHECK(server.response(now + (duration{timing.t3_5} - microseconds(1))).empty());
                CHECK(same_bytes(server.response(now + duration{timing.t3_5}), write_5));
                CHECK(store.accesses == 1);
            }
        }
    }
}

TEST_CASE("G14: a request without a function is one of an unknown function") {
    one_word store;
    std::array<std::uint8_t, modbus::max_pdu> out{};
    CHECK(modbus::respond(store, bytes{}, out, {}) == 2);
    CHECK(out[0] == 0x80);
    CHECK(out[1] == 1);
    CHECK(store.accesses == 0);
}

} // namespace server_pauses_tests
