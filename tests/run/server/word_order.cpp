// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The word order of a server's 32-bit values: fixed by the profile, or switched by a register. Frames are written by
// hand, and pass through a server on a UART.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/server/row_server.hpp>

#include <tests/support/byte_times.hpp>

namespace word_order_tests {

using namespace servobus;
using byte_times::byte_list;
using byte_times::framed;

namespace {

template <word_order Order> struct fixed {
    static constexpr profile facts{.name = "fixed", .word_order = Order};
};
template <class Device>
inline constexpr reg<u32, servobus::access::rw, Device> dose{0x0010, {0, 0x2'0000}, no_unit, 0x1'0002};

/// The switch is in front of a pair, so that one request can write both.
struct switched {
    static constexpr profile facts{
        .name = "switched", .word_order = word_order::unknown, .word_order_register = 0x000F};
};
enum class order_setting : std::uint16_t { high_first, low_first };
inline constexpr reg<order_setting, servobus::access::rw, switched> pair_word_order{
    0x000F, {0, 1}, no_unit, 1};
inline constexpr reg<u16, servobus::access::rw, switched> first{0x000D, full<u16>, no_unit, 1};
inline constexpr input_reg<i32, switched> weight{0x0000, full<i32>, no_unit, -2};
// The slot of the switch is not the first.
using switched_values = row_values<first, pair_word_order, dose<switched>, weight>;

constexpr modbus::rtu_timing timing = modbus::timing_at(115200, modbus::timing_mode::strict);

template <class Values, class... Options> struct bench {
    template <class... Hooks> explicit bench(Hooks&... hooks) : server{port, values, 7, hooks...} {}

    byte_times::uart port{};
    Values values{};
    row_server<byte_times::uart, Values, timing, Options...> server;

    void step(std::uint32_t us) {
        port.time = port.time + duration{us};
        server.step();
    }
    /// The response to a PDU, without its address and CRC.
    byte_list ask(byte_list pdu) {
        pdu.insert(pdu.begin(), 7);
        for (const std::uint8_t byte : framed(pdu)) {
            port.arrived.push_back(byte);
            step(96);
        }
        for (unsigned i = 0; i < 300; ++i) step(100);
        byte_list sent;
        sent.swap(port.sent_bytes);
        if (sent.size() < 4) return {};
        byte_list inner{sent.begin() + 1, sent.end() - 2};
        CHECK(framed({sent.begin(), sent.end() - 2}) == sent);
        return inner;
    }
};

const byte_list read_dose{3, 0, 0x10, 0, 2};

struct recorder {
    u32 before = 0, after = 0;
    std::uint8_t before_write(const changes<switched_values>& c) {
        before = c.get<dose<switched>>();
        return 0;
    }
    void after_write(const changes<switched_values>& c) { after = c.get<dose<switched>>(); }
};

} // namespace

TEST_CASE("a server sends and receives 32-bit values in the order of its profile") {
    bench<row_values<dose<fixed<word_order::high_first>>>> high;
    CHECK(high.ask(read_dose) == byte_list{3, 4, 0, 1, 0, 2});
    CHECK(high.ask({0x10, 0, 0x10, 0, 2, 4, 0, 1, 0, 9}) == byte_list{0x10, 0, 0x10, 0, 2});
    CHECK(high.values.get<dose<fixed<word_order::high_first>>>() == 0x1'0009);
    CHECK(high.ask({0x10, 0, 0x10, 0, 2, 4, 0, 9, 0, 1}) == byte_list{0x90, 3});

    bench<row_values<dose<fixed<word_order::low_first>>>> low;
    CHECK(low.ask(read_dose) == byte_list{3, 4, 0, 2, 0, 1});
    CHECK(low.ask({0x10, 0, 0x10, 0, 2, 4, 0, 9, 0, 1}) == byte_list{0x10, 0, 0x10, 0, 2});
    CHECK(low.values.get<dose<fixed<word_order::low_first>>>() == 0x1'0009);
    CHECK(low.ask({0x10, 0, 0x10, 0, 2, 4, 0, 1, 0, 9}) == byte_list{0x90, 3});
}

TEST_CASE("the register of the word order switches it, for clients and for the device itself") {
    bench<switched_values> b;
    CHECK(b.ask(read_dose) == byte_list{3, 4, 0, 2, 0, 1});
    CHECK(b.ask({4, 0, 0, 0, 2}) == byte_list{4, 4, 0xFF, 0xFE, 0xFF, 0xFF});
    CHECK(b.ask({6, 0, 0x0F, 0, 0}) == byte_list{6, 0, 0x0F, 0, 0});
    CHECK(b.ask(read_dose) == byte_list{3, 4, 0, 1, 0, 2});
    CHECK(b.ask({4, 0, 0, 0, 2}) == byte_list{4, 4, 0xFF, 0xFF, 0xFF, 0xFE});
    CHECK(b.ask({0x10, 0, 0x10, 0, 2, 4, 0, 1, 0, 9}) == byte_list{0x10, 0, 0x10, 0, 2});
    CHECK(b.values.get<dose<switched>>() == 0x1'0009);
    CHECK(b.ask({0x10, 0, 0x10, 0, 2, 4, 0, 9, 0, 1}) == byte_list{0x90, 3});
    CHECK(b.ask({6, 0, 0x0F, 0, 2}) == byte_list{0x86, 3});
    b.values.set<pair_word_order>(order_setting::low_first);
    CHECK(b.ask(read_dose) == byte_list{3, 4, 0, 9, 0, 1});
    CHECK(b.ask({0x10, 0, 0x10, 0, 2, 4, 0, 8, 0, 1}) == byte_list{0x10, 0, 0x10, 0, 2});
    CHECK(b.values.get<dose<switched>>() == 0x1'0008);
}

TEST_CASE("a request that switches the word order has the order from before, also in its hooks") {
    recorder hooks;
    bench<switched_values, with_read_write, with_hooks<recorder>> b{hooks};
    // The switch to high first, and a value in low first.
    CHECK(b.ask({0x10, 0, 0x0F, 0, 3, 6, 0, 0, 0, 7, 0, 1}) == byte_list{0x10, 0, 0x0F, 0, 3});
    CHECK(b.values.get<dose<switched>>() == 0x1'0007);
    CHECK(hooks.before == 0x1'0007);
    CHECK(hooks.after == 0x1'0007);
    CHECK(b.ask(read_dose) == byte_list{3, 4, 0, 1, 0, 7});
    // 17h writes, then reads: in the new order.
    CHECK(b.ask({0x17, 0, 0x10, 0, 2, 0, 0x0F, 0, 3, 6, 0, 1, 0, 1, 0, 6}) == byte_list{0x17, 4, 0, 6, 0, 1});
    CHECK(b.values.get<dose<switched>>() == 0x1'0006);
}

} // namespace word_order_tests
