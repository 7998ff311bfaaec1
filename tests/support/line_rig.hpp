// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line over a scripted port in virtual time, the requests that its tests send, and a device that responds
// to them.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <utility>

#include <servobus/line/line.hpp>

#include "scripted_port.hpp"

namespace tests::whole_line {

using namespace servobus;
using modbus::exchange;
using modbus::timing_at;
using modbus::timing_mode;

inline const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
inline const byte_list read_other = framed({0x01, 0x03, 0x20, 0xA5, 0x00, 0x01});
inline const byte_list write_one = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x64});
inline const byte_list write_two = framed({0x01, 0x10, 0x20, 0x88, 0x00, 0x02, 0x04, 0x00, 0x64, 0x00, 0x64});
inline const byte_list one_word = tests::read_response(1, {0x0960});

inline byte_list good_response(const byte_list& request) {
    return request[1] == 0x03 ? tests::read_response(1, {0x0960}) : tests::acknowledgement(request);
}

/// Responds to every request to node 1 after `delay` us.
inline auto answering(std::uint32_t delay) {
    return [delay](auto& port, const tests::sent_frame& f) { port.say(delay, good_response(f.data)); };
}

template <class Port = scripted_port> struct rig {
    Port port;
    response_limits limits;
    bus_gaps gaps{{}, milliseconds(100)};
    servobus::priority priority = servobus::priority::ordinary;
    modbus::rtu_timing timing;
    line<Port> on;

    explicit rig(modbus::rtu_timing t = timing_at(115200), Port p = {})
        : port{std::move(p)}, timing{t}, on{port, t} {
        port.character_us = t.character;
    }

    struct ended {
        status why;
        bool was_sent;
        byte_list response;
    };
    ended run(const byte_list& request) {
        std::array<std::uint8_t, 256> room{};
        exchange x{request, room, on.timing(), limits, priority};
        on.run(x, gaps);
        REQUIRE_FALSE(port.ran_away);
        REQUIRE(x.done());
        return {x.status(), x.was_sent(), {x.response().begin(), x.response().end()}};
    }
    /// Runs one successful exchange, so that no quarantine is pending.
    void settle() {
        const auto device = port.device;
        port.device = answering(500);
        REQUIRE(run(read_one).why.error() == errc::ok);
        port.device = device;
        port.frames.clear();
    }
    std::uint64_t bound(const byte_list& request, std::size_t response) const {
        return on.bound(request.size(), response, limits, gaps).us;
    }
};

} // namespace tests::whole_line
