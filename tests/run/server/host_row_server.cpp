// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of rows in host timing: beside frames of other nodes of each function, with pauses inside its own, and with
// requests whose length their function does not tell.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <servobus/server/host_row_server.hpp>

#include <tests/support/byte_times.hpp>
#include <tests/support/served_rows.hpp>

namespace host_row_server_tests {

using namespace servobus;
using byte_times::byte_list;
using byte_times::framed;

namespace {

const modbus::rtu_timing timing = modbus::timing_at(115200);

struct bench {
    byte_times::uart port{};
    served_rows::values values{};
    host_row_server<byte_times::uart, served_rows::values, with_mask_write, with_read_write,
                    with_return_query_data, with_identification<served_rows::about>,
                    with_server_id<served_rows::id>>
        server;

    explicit bench(std::uint8_t node_address = 7) : server{port, values, node_address, timing} {
        port.burst = 64;
    }
    void step(std::uint32_t us) {
        port.time.us += us;
        server.step();
    }
    void quiet(std::uint32_t us) {
        for (; us > 500; us -= 500) step(500);
        step(us);
    }
    void t3_5() { quiet(timing.t3_5 + 10u); }
    void receive(const byte_list& all) {
        for (const std::uint8_t byte : all) {
            port.arrived.push_back(byte);
            step(timing.character);
        }
    }
    byte_list response() {
        for (unsigned i = 0; i < 100 && server.is_answering(); ++i) step(100);
        byte_list sent;
        sent.swap(port.sent_bytes);
        return sent;
    }
    // The response if the request is executed where it ends, without a visible gap.
    byte_list ask(const byte_list& request) {
        receive(request);
        t3_5();
        return response();
    }
    // The same for a request that a visible gap ends.
    byte_list ask_and_wait(const byte_list& request) {
        receive(request);
        t3_5();
        REQUIRE(!server.is_answering());
        quiet(timing.inter_byte.us + 1000);
        return response();
    }
};

const byte_list read_selected = framed({7, 3, 0, 0x10, 0, 1});
const byte_list is_selected = framed({7, 3, 2, 0, 1});
const byte_list write_selected = framed({7, 6, 0, 0x10, 0, 2});

// Frames of node 8 that no other reading of the line continues.
const std::vector<byte_list> neighbours{
    framed({8, 1, 0x77, 1, 0, 9}),
    framed({8, 1, 2, 0x55, 1}),
    framed({8, 2, 0x77, 1, 0, 9}),
    framed({8, 2, 2, 0x55, 1}),
    framed({8, 3, 0x77, 1, 0, 2}),
    framed({8, 3, 4, 1, 2, 3, 4}),
    framed({8, 4, 0x77, 1, 0, 2}),
    framed({8, 4, 4, 1, 2, 3, 4}),
    framed({8, 5, 0, 1, 0xFF, 0}),
    framed({8, 6, 0, 1, 0, 7}),
    framed({8, 0x0F, 0, 1, 0, 9, 2, 0x55, 1}),
    framed({8, 0x0F, 0, 1, 0, 9}),
    framed({8, 0x10, 0, 1, 0, 2, 4, 1, 2, 3, 4}),
    framed({8, 0x10, 0, 1, 0, 2}),
    framed({8, 0x16, 0, 1, 0, 2, 0, 3}),
    framed({8, 0x17, 0, 1, 0, 2, 0, 3, 0, 1, 2, 5, 6}),
    framed({8, 0x83, 2}),
};
// Functions without a known length.
const std::vector<byte_list> open_ended{
    framed({8, 7}),
    framed({8, 7, 0x6D}),
    framed({8, 8, 0, 0, 1, 2}),
    framed({8, 0x0B}),
    framed({8, 0x0C}),
    framed({8, 0x11}),
    framed({8, 0x18, 4, 0xDE}),
    framed({8, 0x2B, 14, 1, 0}),
    framed({8, 0x65, 1, 2}),
    framed({8, 0x42, 7, 6, 0, 0x10, 0, 2}),
};

} // namespace

TEST_CASE("G7: a request is executed where it ends, however it is cut, and its response waits for t3.5") {
    bench b;
    b.receive(read_selected);
    CHECK(b.server.is_answering());
    b.step(timing.t3_5 - 10u);
    CHECK(b.port.sent_bytes.empty());
    CHECK(b.response() == is_selected);
    for (std::size_t at = 1; at < write_selected.size(); ++at) {
        b.receive(byte_list(write_selected.begin(), write_selected.begin() + static_cast<long>(at)));
        b.quiet(19'000);
        CHECK(b.ask(byte_list(write_selected.begin() + static_cast<long>(at), write_selected.end())) ==
              write_selected);
    }
    CHECK(b.ask(read_selected) == framed({7, 3, 2, 0, 2}));
}

TEST_CASE("a request that comes immediately after the response is executed, as on a pseudo-terminal") {
    bench b;
    for (int i = 0; i < 3; ++i) {
        b.receive(read_selected);
        while (b.port.sent_bytes.empty()) b.step(100);
        b.port.arrived.insert(b.port.arrived.end(), write_selected.begin(), write_selected.end());
        CHECK(b.response() == is_selected);
        b.t3_5();
        CHECK(b.response() == write_selected);
        CHECK(b.ask(framed({7, 6, 0, 0x10, 0, 1})) == framed({7, 6, 0, 0x10, 0, 1}));
    }
}

TEST_CASE("G5, G13: a server of rows skips up to four bytes 00 or FF after a gap, and not five") {
    for (const std::uint8_t glitch : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
        for (std::size_t n = 0; n <= 5; ++n) {
            CAPTURE(n);
            bench b;
            REQUIRE(b.ask(read_selected) == is_selected);
            b.t3_5();
            b.receive(byte_list(n, glitch));
            b.receive(read_selected);
            b.quiet(timing.inter_byte.us + 1000); // the frame may begin with a byte 00 or FF until then
            CHECK(b.response() == (n <= 4 ? is_selected : byte_list{}));
        }
    }
}

TEST_CASE("each function of the rows, and those with a length of their own") {
    bench b;
    CHECK(b.ask(framed({7, 1, 0, 0, 0, 4})) == framed({7, 1, 1, 5}));
    CHECK(b.ask(framed({7, 2, 0, 7, 0, 3})) == framed({7, 2, 1, 6}));
    CHECK(b.ask(framed({7, 4, 0, 0x12, 0, 1})) == framed({7, 4, 2, 0, 3}));
    CHECK(b.ask(framed({7, 5, 0, 1, 0xFF, 0})) == framed({7, 5, 0, 1, 0xFF, 0}));
    CHECK(b.ask(framed({7, 0x0F, 0, 0, 0, 2, 1, 0})) == framed({7, 0x0F, 0, 0, 0, 2}));
    CHECK(b.ask(framed({7, 0x10, 0, 0x10, 0, 1, 2, 0, 0})) == framed({7, 0x10, 0, 0x10, 0, 1}));
    CHECK(b.ask(framed({7, 0x16, 0, 0x10, 0, 0, 0, 1})) == framed({7, 0x16, 0, 0x10, 0, 0, 0, 1}));
    CHECK(b.ask(framed({7, 0x17, 0, 0x10, 0, 1, 0, 0x10, 0, 1, 2, 0, 2})) == framed({7, 0x17, 2, 0, 2}));
    CHECK(b.ask(framed({7, 6, 0, 0x10, 0, 3})) == framed({7, 0x86, 3}));
    CHECK(b.ask_and_wait(framed({7, 8, 0, 0, 1, 2})) == framed({7, 8, 0, 0, 1, 2}));
    CHECK(b.ask_and_wait(framed({7, 0x11})) == framed({7, 0x11, 5, 'r', 'o', 'w', 's', 0xFF}));
    CHECK(b.ask_and_wait(framed({7, 0x2B, 14, 4, 1})) ==
          framed({7, 0x2B, 14, 4, 0x83, 0, 0, 1, 1, 3, 'R', '-', '1'}));
    CHECK(b.ask_and_wait(framed({7, 0x65, 1})) == framed({7, 0xE5, 1}));
    CHECK(b.ask_and_wait(framed({7, 0x83, 1})).empty());
}

TEST_CASE("G14: a request t3.5 after a frame of another node is executed, whatever its function") {
    for (const auto& frames : {neighbours, open_ended}) {
        for (const byte_list& frame : frames) {
            CAPTURE(frame);
            bench b;
            CHECK(b.ask(read_selected) == is_selected);
            for (int round = 0; round < 3; ++round) {
                b.t3_5();
                b.receive(frame);
                REQUIRE(!b.server.is_answering());
                b.t3_5();
                CHECK(b.ask(read_selected) == is_selected);
            }
        }
    }
}

TEST_CASE("G13: a request inside another node's frame is not executed") {
    for (const unsigned code : {1u, 2u, 3u, 4u, 0x17u}) {
        byte_list body{8, row_model::low_byte(code), 8};
        body.insert(body.end(), write_selected.begin(), write_selected.end());
        for (const std::size_t burst : {1u, 3u, 64u}) {
            bench b;
            CHECK(b.ask(read_selected) == is_selected);
            b.port.burst = burst;
            b.receive(framed(body));
            b.quiet(30'000);
            CHECK(b.response().empty());
            CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
            CHECK(b.ask(write_selected) == write_selected);
        }
    }
    for (const unsigned code : {0x0Fu, 0x10u}) { // in a request
        byte_list body{8, row_model::low_byte(code), 0, 0, 0, row_model::low_byte(code == 0x10 ? 4 : 64), 8};
        body.insert(body.end(), write_selected.begin(), write_selected.end());
        bench b;
        b.receive(framed(body));
        b.quiet(30'000);
        CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
    }
}

TEST_CASE("G14: broadcasts in host timing") {
    bench b;
    CHECK(b.ask(framed({0, 6, 0, 0x10, 0, 2})).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::high);
    CHECK(b.ask(framed({0, 0x17, 0, 0x10, 0, 1, 0, 0x10, 0, 1, 2, 0, 0})).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::high);
    CHECK(b.ask(framed({0, 0x0F, 0, 0, 0, 2, 1, 0})).empty());
    CHECK(!b.values.get<served_rows::valve>());
    CHECK(b.ask(read_selected) == framed({7, 3, 2, 0, 2}));
}

TEST_CASE("a port that takes few bytes, or fails") {
    bench b;
    b.port.takes = 2;
    CHECK(b.ask(read_selected) == is_selected);
    b.port.fails = true;
    CHECK(b.ask(read_selected).empty());
    b.port.fails = false;
    CHECK(b.ask(read_selected) == is_selected);
    for (std::size_t at = 0; at < write_selected.size(); ++at) {
        b.receive(byte_list(write_selected.begin(), write_selected.begin() + static_cast<long>(at)));
        b.port.is_garbled = true; // in place of a byte
        b.step(96);
        b.receive(byte_list(write_selected.begin() + static_cast<long>(at) + 1, write_selected.end()));
        b.quiet(30'000);
        CHECK(b.response().empty());
        CHECK(b.ask(read_selected) == is_selected);
    }
    // A request after a garbled character is in its frame.
    b.port.is_garbled = true;
    b.step(96);
    b.receive(write_selected);
    b.quiet(30'000);
    CHECK(b.response().empty());
    CHECK(b.ask(read_selected) == is_selected);
}

TEST_CASE("a response leaves once, and the next request is taken when its last bit has left") {
    bench b;
    b.port.has_left = false; // the bytes are queued
    b.receive(read_selected);
    b.t3_5();
    b.quiet(5000);
    CHECK(b.server.is_answering());
    CHECK(b.port.sent_bytes == is_selected);
    b.port.has_left = true;
    CHECK(b.response() == is_selected);
    CHECK(!b.server.is_answering());
    CHECK(b.ask(read_selected) == is_selected);
}

TEST_CASE("a garbled character is no byte of a frame, whatever the address of the server") {
    for (const unsigned number : {0x54u, 0x55u, 0x56u}) {
        CAPTURE(number);
        const auto node_address = static_cast<std::uint8_t>(number);
        bench b{node_address};
        const byte_list write = framed({node_address, 6, 0, 0x10, 0, 2});
        b.port.is_garbled = true; // in place of the address
        b.step(96);
        b.receive({write.begin() + 1, write.end()});
        b.quiet(30'000);
        CHECK(b.response().empty());
        CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
        CHECK(b.ask(write) == write);
    }
}

} // namespace host_row_server_tests
