// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A response that arrives in one piece ends like one that arrives byte by byte, also where it is as long as its request,
// and where a rule says its length.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/modbus/exchange.hpp>
#include <servobus/modbus/response_lengths.hpp>

#include <tests/support/exchange_runs.hpp>

namespace whole_responses_tests {

using namespace servobus;
using namespace tests::exchange_runs;
using modbus::length_rule;
using tests::byte_list;
using tests::framed;

namespace {
using open_exchange = modbus::basic_exchange<modbus::default_crc, modbus::open_lengths>;

struct end {
    errc why;
    bool differs; // from its request
    byte_list response;

    bool operator==(const end&) const = default;
};

template <class Exchange> end end_of(Exchange& x, const byte_list& response, std::size_t piece) {
    x.sent({0});
    std::uint32_t now = 2000;
    for (std::size_t at = 0; at < response.size() && !x.done(); at += piece) {
        const std::size_t size = response.size() - at < piece ? response.size() - at : piece;
        now += host.wire_time(size).us;
        x.feed(bytes{response}.subspan(at, size), {now});
    }
    x.elapse({now + 300'000});
    REQUIRE(x.done());
    return {x.status().error(), x.differs_from_request(), {x.response().begin(), x.response().end()}};
}
// In one piece; the other sizes end alike.
end end_of(const byte_list& request, const byte_list& response) {
    end ends[3]{};
    std::size_t i = 0;
    for (const std::size_t piece : {response.size(), std::size_t{1}, std::size_t{3}}) {
        std::array<std::uint8_t, 256> room{};
        modbus::exchange x{request, byte_buffer{room}.first(response.size()), host, usual};
        if (request[1] == 0x17) x.judge_like(modbus::like(0x17));
        ends[i++] = end_of(x, response, piece);
    }
    CHECK(ends[0] == ends[1]);
    CHECK(ends[0] == ends[2]);
    return ends[0];
}
} // namespace

TEST_CASE("a response as long as its request differs from it, or is its echo, however it arrives") {
    const byte_list coils = framed({0x01, 0x01, 0x03, 0x13, 0x00, 0x18}); // 24 of them: 3 bytes
    const byte_list values = framed({0x01, 0x01, 0x03, 0xCD, 0x6B, 0x05});
    CHECK(end_of(coils, values) == end{errc::ok, true, values});
    CHECK(end_of(coils, coils) == end{errc::ok, false, coils});

    const byte_list both = framed({0x01, 0x17, 0x0A, 0x10, 0, 5, 0, 0, 0, 1, 2, 0, 7});
    const byte_list words = framed({0x01, 0x17, 0x0A, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5});
    CHECK(both.size() == words.size());
    CHECK(end_of(both, words) == end{errc::ok, true, words});
    CHECK(end_of(both, both) == end{errc::ok, false, both});
}

} // namespace whole_responses_tests
