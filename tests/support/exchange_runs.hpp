// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Runs one exchange without a port: which bytes it receives and when, and how it ends. Has four requests with
// their responses.
#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/modbus/exchange.hpp>

#include "scripted_port.hpp"

namespace tests::exchange_runs {

using namespace servobus;
using namespace servobus::modbus;

inline constexpr rtu_timing host = timing_at(115200);
inline constexpr rtu_timing strict = timing_at(9600, timing_mode::strict);
inline constexpr response_limits usual{};

/// How an exchange ended.
struct ended {
    status why;
    std::vector<std::uint16_t> words;
    byte_list response;
    std::uint32_t at = 0; // when it ended, in us after the request's last bit
};

/// Bytes that arrive together, `at` us after the request's last bit.
struct burst {
    std::uint32_t at;
    byte_list data;
};

inline ended run(const byte_list& request, const std::vector<burst>& bursts, const rtu_timing& timing = host,
                 const response_limits& limits = usual, std::size_t room = 256) {
    byte_list memory(room + 32, 0xA5);
    exchange x{request, byte_buffer{memory}.subspan(16, room), timing, limits};
    const instant start{0xFFFF'F000u}; // the clock wraps during the exchange
    ended result;
    x.sent(start);
    std::uint32_t time = 0;
    const auto rest_until = [&](std::uint32_t until) {
        for (; time < until && !x.done(); time += 50) x.elapse(start + microseconds(time));
        if (!x.done()) time = until;
    };
    for (const burst& b : bursts) {
        rest_until(b.at);
        if (x.done()) break;
        x.feed(b.data, start + microseconds(time));
        if (!x.done()) x.elapse(start + microseconds(time));
    }
    rest_until(2'000'000);
    REQUIRE(x.done());
    result.at = time;
    result.why = x.status();
    REQUIRE(x.response().size() <= room);
    result.response.assign(x.response().begin(), x.response().end());
    for (std::size_t i = 0; i < x.words().size(); ++i) result.words.push_back(x.words()[i]);
    for (std::size_t i = 0; i < 16; ++i) {
        REQUIRE(memory[i] == 0xA5);
        REQUIRE(memory[memory.size() - 1 - i] == 0xA5);
    }
    return result;
}

inline ended run(const byte_list& request, const byte_list& response, const response_limits& limits = usual) {
    return run(request, std::vector<burst>{{2000, response}}, host, limits);
}

inline const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
inline const byte_list read_two = framed({0x01, 0x03, 0x20, 0xAB, 0x00, 0x02});
inline const byte_list write_one = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x64});
inline const byte_list write_many =
    framed({0x01, 0x10, 0x20, 0x88, 0x00, 0x02, 0x04, 0x00, 0x64, 0x00, 0x64});

inline const byte_list one_word = tests::read_response(1, {0x0960});
inline const byte_list two_words = tests::read_response(1, {0x0064, 0xFF9C});
inline const byte_list one_done = write_one;
inline const byte_list many_done = framed({0x01, 0x10, 0x20, 0x88, 0x00, 0x02});

struct pair {
    const char* name;
    byte_list request;
    byte_list response;
};
inline const std::vector<pair>& pairs() {
    static const std::vector<pair> all{{"read of one", read_one, one_word},
                                       {"read of two", read_two, two_words},
                                       {"write of one", write_one, one_done},
                                       {"write of two", write_many, many_done}};
    return all;
}

inline byte_list part(const byte_list& all, std::size_t from, std::size_t to) {
    return {all.begin() + static_cast<std::ptrdiff_t>(from), all.begin() + static_cast<std::ptrdiff_t>(to)};
}

} // namespace tests::exchange_runs
