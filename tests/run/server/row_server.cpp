// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of rows on a UART in virtual time: which frames it executes, when it responds, and what it ignores.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/line/line.hpp>
#include <servobus/modbus/crc_tables.hpp>
#include <servobus/server/row_server.hpp>

#include <examples/own_device/hoist_server.hpp>
#include <tests/support/byte_times.hpp>
#include <tests/support/served_rows.hpp>

namespace row_server_tests {

using namespace servobus;
using byte_times::byte_list;
using byte_times::framed;

namespace {

constexpr modbus::rtu_timing timing = modbus::timing_at(115200, modbus::timing_mode::strict);

template <class... Options> struct bench {
    byte_times::uart port{};
    served_rows::values values{};
    row_server<byte_times::uart, served_rows::values, timing, Options...> server{port, values, 7};

    void quiet(std::uint32_t us) {
        for (; us > 50; us -= 50) step(50);
        step(us);
    }
    void step(std::uint32_t us) {
        port.time = port.time + duration{us};
        server.step();
    }
    // Byte by byte at 115200 Bd.
    void receive(const byte_list& all) {
        for (const std::uint8_t byte : all) {
            port.arrived.push_back(byte);
            step(96);
        }
    }
    // The response, after t3.5.
    byte_list ask(const byte_list& request) {
        receive(request);
        quiet(timing.t3_5 + 100u);
        return response();
    }
    byte_list response() {
        for (unsigned i = 0; i < 300 && (i < 4 || server.is_answering()); ++i) step(50);
        byte_list sent;
        sent.swap(port.sent_bytes);
        quiet(timing.t3_5 + 100u);
        return sent;
    }
};

const byte_list read_selected = framed({7, 3, 0, 0x10, 0, 1});
const byte_list is_selected = framed({7, 3, 2, 0, 1});
const byte_list write_selected = framed({7, 6, 0, 0x10, 0, 2});

} // namespace

TEST_CASE("a request is executed after t3.5, and its response is a frame") {
    bench b;
    b.receive(read_selected);
    b.quiet(timing.t3_5 - 1u);
    CHECK(!b.server.is_answering());
    CHECK(b.port.sent_bytes.empty());
    b.step(1);
    CHECK(b.server.is_answering());
    CHECK(b.response() == is_selected);
    CHECK(!b.server.is_answering());
    CHECK(b.ask(write_selected) == write_selected);
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::high);
    CHECK(b.ask(framed({7, 6, 0, 0x10, 0, 3})) == framed({7, 0x86, 3}));
}

TEST_CASE("each engine of the CRC, and each way in which bytes come") {
    bench<with_crc<modbus::crc_table16>> b;
    CHECK(b.ask(read_selected) == is_selected);
    bench all;
    for (const std::size_t burst : {2u, 3u, 8u, 100u}) {
        all.port.burst = burst;
        for (const std::uint8_t byte : read_selected) all.port.arrived.push_back(byte);
        all.quiet(1000); // within t1.5 and the time of the bytes
        CHECK(all.ask({}) == is_selected);
    }
    all.port.takes = 1;
    CHECK(all.ask(read_selected) == is_selected);
}

TEST_CASE("G13, G14: no response to a bad CRC, to a frame of another address, and to what is no request") {
    bench b;
    byte_list damaged = write_selected;
    damaged[5] ^= 1u;
    for (const byte_list& frame : {damaged, framed({8, 6, 0, 0x10, 0, 2}), framed({7, 0x83, 2}), framed({7}),
                                   byte_list{7}, byte_list(300, 0)}) {
        CHECK(b.ask(frame).empty());
        CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
        CHECK(b.ask(read_selected) == is_selected);
    }
}

TEST_CASE("G7: a gap above t1.5 rejects a frame, also if the program notices it late") {
    for (std::size_t at = 1; at < write_selected.size(); ++at) {
        for (const std::uint32_t gap : {timing.t1_5 + 97u, timing.t3_5 - 1u}) {
            for (const bool is_stalled : {false, true}) {
                bench b;
                b.receive(byte_list(write_selected.begin(), write_selected.begin() + static_cast<long>(at)));
                is_stalled ? b.step(gap - 96) : b.quiet(gap - 96);
                b.receive(byte_list(write_selected.begin() + static_cast<long>(at), write_selected.end()));
                b.quiet(5000);
                CHECK(b.response().empty());
                CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
                CHECK(b.ask(read_selected) == is_selected);
            }
        }
        bench b; // the longest gap that is allowed
        b.receive(byte_list(write_selected.begin(), write_selected.begin() + static_cast<long>(at)));
        b.quiet(timing.t1_5);
        CHECK(b.ask(byte_list(write_selected.begin() + static_cast<long>(at), write_selected.end())) ==
              write_selected);
    }
}

TEST_CASE("G13: a request inside a frame of another node, or before t3.5 has passed, is not executed") {
    bench b;
    byte_list inside{8, 3, 10};
    inside.insert(inside.end(), write_selected.begin(), write_selected.end());
    inside.push_back(0);
    inside.push_back(0);
    CHECK(b.ask(framed(inside)).empty());
    byte_list two = framed({8, 3, 0, 0, 0, 1});
    two.insert(two.end(), write_selected.begin(), write_selected.end());
    CHECK(b.ask(two).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
    // After its own response too.
    b.receive(read_selected);
    b.quiet(timing.t3_5 + 100u);
    b.quiet(100);
    CHECK(!b.server.is_answering());
    CHECK(b.ask(write_selected) == is_selected); // the response before; the write came too early
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
    CHECK(b.ask(write_selected) == write_selected);
}

TEST_CASE("G13: bytes 00 or FF after a gap are skipped before a frame, as many as the option says") {
    for (const unsigned noise : {0x00u, 0xFFu}) {
        for (std::size_t count = 0; count <= 5; ++count) {
            CAPTURE(count);
            byte_list before(count, row_model::low_byte(noise));
            const auto with_noise = [&before](const byte_list& frame) {
                byte_list all = before;
                all.insert(all.end(), frame.begin(), frame.end());
                return all;
            };
            bench<with_leading_bytes<4>, with_read_write> b;
            const bool is_skipped = count <= 4;
            CHECK(b.ask(with_noise(write_selected)) == (is_skipped ? write_selected : byte_list{}));
            CHECK(b.ask(with_noise(read_selected)) == (is_skipped ? framed({7, 3, 2, 0, 2}) : byte_list{}));
            // The longest request of these rows.
            const byte_list longest =
                framed({7, 0x17, 0, 0x10, 0, 1, 0, 0x17, 0, 6, 12, 0, 5, 0, 105, 0, 6, 0, 106, 0, 7, 0, 107});
            CHECK(b.ask(with_noise(longest)) == (is_skipped ? framed({7, 0x17, 2, 0, 2}) : byte_list{}));
            CHECK(b.ask(with_noise(framed({0, 6, 0, 0x10, 0, 0}))).empty());
            CHECK(b.values.get<served_rows::selected>() ==
                  (is_skipped ? served_rows::gear::neutral : served_rows::gear::low));
            CHECK(b.ask(with_noise(framed({8, 6, 0, 0x10, 0, 1}))).empty());
            bench plain;
            CHECK(plain.ask(with_noise(write_selected)).empty() == (count != 0));
        }
    }
    bench<with_leading_bytes<4>> b;
    CHECK(b.ask(byte_list(4, 0)).empty());
    CHECK(b.ask(byte_list(8, 0xFF)).empty());
    byte_list too_long{0, 7, 0x10, 0, 0x10, 0, 60, 120}; // a frame for which the buffer has no room
    too_long.resize(8 + 120, 1);
    CHECK(b.ask(too_long).empty());
    too_long.erase(too_long.begin());
    CHECK(b.ask(too_long).empty());
    byte_list other{0x01};
    other.insert(other.end(), write_selected.begin(), write_selected.end());
    CHECK(b.ask(other).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
    CHECK(b.ask(write_selected) == write_selected);
}

TEST_CASE("G14: a request t3.5 after any frame of another node is executed") {
    for (const byte_list& frame : {framed({8, 3, 0, 0, 0, 1}), framed({8, 3, 2, 7, 6}),
                                   framed({8, 0x65, 1, 2, 3}), framed({8, 0x2B, 14, 1, 0}),
                                   framed({0, 6, 0x99, 0, 0, 1}), byte_list{1, 2, 3}, byte_list(256, 7)}) {
        bench b;
        b.receive(frame);
        b.quiet(timing.t3_5);
        CHECK(b.ask(write_selected) == write_selected);
    }
}

TEST_CASE("G14: broadcasts that write are executed without a response, and those that read are ignored") {
    bench<with_mask_write, with_read_write> b;
    CHECK(b.ask(framed({0, 6, 0, 0x10, 0, 2})).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::high);
    CHECK(b.ask(framed({0, 0x10, 0, 0x10, 0, 1, 2, 0, 0})).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::neutral);
    CHECK(b.ask(framed({0, 5, 0, 1, 0xFF, 0})).empty());
    CHECK(b.values.get<served_rows::pump>());
    CHECK(b.ask(framed({0, 0x0F, 0, 1, 0, 1, 1, 0})).empty());
    CHECK(!b.values.get<served_rows::pump>());
    CHECK(b.ask(framed({0, 0x16, 0, 0x10, 0, 0, 0, 1})).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
    CHECK(b.ask(framed({0, 0x17, 0, 0x10, 0, 1, 0, 0x10, 0, 1, 2, 0, 2})).empty());
    CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
    served_rows::computed_reads = 0;
    CHECK(b.ask(framed({0, 3, 0, 0x14, 0, 2})).empty());
    CHECK(served_rows::computed_reads == 0);
    CHECK(b.ask(framed({0, 6, 0, 0x10, 0, 3})).empty()); // nor is there an exception
    CHECK(b.ask(read_selected) == is_selected);
}

TEST_CASE("a request longer than the buffer gets its exception") {
    bench<with_return_query_data> b;
    for (const std::size_t words : {13u, 60u, 123u}) {
        byte_list request{7, 0x10, 0, 0x10, 0, row_model::low_byte(words), row_model::low_byte(2 * words)};
        request.resize(7 + 2 * words, 1);
        CHECK(b.ask(framed(request)) == framed({7, 0x90, 3})); // the profile says 12 words
        request[2] = 0x77;
        request[5] = 12;
        CHECK(b.ask(framed(request)) == framed({7, 0x90, 3}));
    }
    byte_list coils{7, 0x0F, 0, 0, 7, 0xB0, 246};
    coils.resize(7 + 246, 0);
    CHECK(b.ask(framed(coils)) == framed({7, 0x8F, 2}));
    byte_list echo{7, 8, 0, 0};
    echo.resize(254, 9);
    CHECK(b.ask(framed(echo)) == framed({7, 0x88, 3}));
    echo.resize(255, 9);
    CHECK(b.ask(framed(echo)).empty()); // 257 bytes are no frame
    CHECK(b.values.get<served_rows::valve>());
    CHECK(b.ask(read_selected) == is_selected);
}

TEST_CASE("G10: what does not fit the buffer is not stored beyond it") {
    constexpr std::size_t room = request_executor<served_rows::values>::buffer_size + 3;
    bench b;
    for (std::size_t i = 0; i < 300; ++i) {
        b.receive({7});
        REQUIRE(b.port.asked == (i < room ? room - i : 1));
    }
    b.quiet(5000);
    CHECK(b.ask(read_selected) == is_selected);
    b.port.burst = 1000;
    for (int i = 0; i < 300; ++i) b.port.arrived.push_back(9);
    b.quiet(20'000);
    CHECK(b.ask(read_selected) == is_selected);
}

TEST_CASE("a garbled character rejects its frame, and the next one is executed") {
    for (std::size_t at = 0; at <= write_selected.size(); ++at) {
        bench b;
        b.receive(byte_list(write_selected.begin(), write_selected.begin() + static_cast<long>(at)));
        b.port.is_garbled = true;
        b.step(96);
        CHECK(b.ask(byte_list(write_selected.begin() + static_cast<long>(at), write_selected.end())).empty());
        CHECK(b.values.get<served_rows::selected>() == served_rows::gear::low);
        CHECK(b.ask(write_selected) == write_selected);
    }
}

TEST_CASE("a garbled character alone costs no frame after a gap") {
    bench b;
    b.port.is_garbled = true;
    b.step(96);
    b.quiet(timing.t3_5 + 100u);
    CHECK(b.ask(write_selected) == write_selected);
}

TEST_CASE("a port that waits for its last stop bit, or fails to send") {
    bench b;
    b.port.has_left = false;
    b.receive(read_selected);
    b.quiet(5000);
    CHECK(b.server.is_answering());
    b.port.has_left = true;
    CHECK(b.response() == is_selected);
    b.port.fails = true;
    CHECK(b.ask(write_selected).empty());
    b.port.fails = false;
    CHECK(b.ask(write_selected) == write_selected);
}

TEST_CASE("the clock may wrap, and the address may change") {
    bench b;
    b.port.time = {0xFFFF'FF00u};
    CHECK(b.ask(read_selected) == is_selected);
    b.server.set_address(9);
    CHECK(b.server.address() == 9);
    CHECK(b.ask(read_selected).empty());
    CHECK(b.ask(framed({9, 3, 0, 0x10, 0, 1})) == framed({9, 3, 2, 0, 1}));
}

namespace {

struct motor {
    i32 at = 0, goal = 0;
    reading<hoist::position> position() const { return reading<hoist::position>{at}; }
    u16 current() const { return 7; }
    void go_to(reading<hoist::target> target) { goal = target.count(); }
};
using firmware = hoist::firmware<byte_times::uart>;

// The client's side of the wire: each byte arrives at the server 96 us after the one before.
struct other_end {
    byte_times::uart* wire;
    firmware* device;
    motor* shaft;
    std::size_t given = 0;

    transfer send(bytes all) {
        for (const std::uint8_t byte : all) {
            wire->arrived.push_back(byte);
            wire->time = wire->time + duration{96};
            device->step(*shaft);
        }
        return static_cast<std::uint16_t>(all.size());
    }
    bool sent() { return true; }
    transfer receive(byte_buffer into) {
        std::size_t n = 0;
        for (; given < wire->sent_bytes.size() && n < into.size(); ++n) into[n] = wire->sent_bytes[given++];
        return static_cast<std::uint16_t>(n);
    }
    instant now() {
        wire->time = wire->time + duration{25};
        device->step(*shaft);
        return wire->time;
    }
};

} // namespace

TEST_CASE("both sides of a protocol are one header: a client and the example's firmware") {
    byte_times::uart wire;
    firmware device{wire, 7};
    motor shaft;
    other_end far{&wire, &device, &shaft};
    line on{far, timing};
    client io{on, node<hoist::device>{7}};
    shaft.at = -77;
    const auto position = io.read<hoist::position>();
    REQUIRE(position);
    CHECK(*position == -77 * units::pulse);
    CHECK(io.write<hoist::ramp, hoist::target>(20 * units::millisecond, -9 * units::pulse));
    CHECK(shaft.goal == 0);
    CHECK(io.write<hoist::operating_mode>(hoist::mode::move));
    CHECK(shaft.goal == -9);
    const auto all = io.read<hoist::ramp, hoist::load, hoist::operating_mode, hoist::target>();
    REQUIRE(all);
    CHECK(all->get<hoist::ramp>() == 20 * units::millisecond);
    CHECK(all->get<hoist::load>().count() == 7);
    CHECK(all->get<hoist::operating_mode>() == hoist::mode::move);
    CHECK(all->get<hoist::target>() == -9 * units::pulse);
    CHECK(io.write_word(0x0005, 300).exception() == 3);
    CHECK(io.write_word(0x0007, 1).exception() == 2);
}

} // namespace row_server_tests
