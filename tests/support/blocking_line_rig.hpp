// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A blocking line over a scripted port in virtual time, and clients on it.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <tests/support/line_and_client.hpp>

#include "scripted_port.hpp"

namespace tests::blocking {

using namespace servobus;
using modbus::timing_at;
using modbus::timing_mode;

// An invented device.
struct device {
    static constexpr profile facts{.name = "fixture", .max_read = 4, .max_write = 6, .highest_address = 99};
};
template <wire_value T> using rw = reg<T, access::rw, device>;
inline constexpr rw<u16> ramp{0x0100, {0, 5000}, units::millisecond, 10};
inline constexpr rw<i16> speed{0x0101, {-300, 300}, units::r_per_min, 0};
inline constexpr rw<i32> position{0x0102, full<i32>, units::pulse, 0};
inline constexpr reg<u16, access::ro, device> state{0x0200, full<u16>, no_unit, no_default};

inline const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
inline const byte_list read_other = framed({0x01, 0x03, 0x20, 0xA5, 0x00, 0x01});
inline const byte_list write_one = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x64});
inline const byte_list write_two = framed({0x01, 0x10, 0x20, 0x88, 0x00, 0x02, 0x04, 0x00, 0x64, 0x00, 0x64});
inline const byte_list one_word = tests::read_response(1, {0x0960});
inline const byte_list stale = tests::read_response(1, {0xDEAD});

inline byte_list good_response(const byte_list& q) {
    return q[1] == 0x03 ? tests::read_response(q[0], std::vector<std::uint16_t>(q[5], 0x0960))
                        : tests::acknowledgement(q);
}
inline std::size_t response_size(const byte_list& q) { return q[1] == 0x03 ? 5 + 2 * std::size_t{q[5]} : 8; }

using device_script = std::function<void(scripted_port&, const sent_frame&)>;
inline device_script answering(std::uint32_t delay) {
    return [delay](scripted_port& p, const sent_frame& f) { p.say(delay, good_response(f.data)); };
}
inline device_script saying(byte_list what, std::uint32_t after = 500) {
    return [what, after](scripted_port& p, const sent_frame&) { p.say(after, what); };
}

/// The constants of a blocking line.
template <class Port, modbus::rtu_timing Timing = timing_at(115200), duration Quarantine = milliseconds(100)>
struct setup {
    using port = Port;
    using line = blocking_line<Port, Timing, Quarantine>;
    static constexpr modbus::rtu_timing timing = Timing;
    static constexpr bool is_strict = Timing.mode == timing_mode::strict;
    static constexpr std::uint64_t after_trouble = longer_of(Timing.visible_gap(), Quarantine).us;
};
constexpr modbus::rtu_timing slow_strict = timing_at(9600, timing_mode::strict);
using polls = setup<scripted_port>;
using sleeps = setup<waiting_scripted_port>;
using polls_strict = setup<scripted_port, slow_strict>;
using sleeps_slow = setup<waiting_scripted_port, timing_at(1200)>;
using sleeps_strict = setup<waiting_scripted_port, slow_strict>;

template <class Setup = sleeps> struct rig {
    typename Setup::port port;
    register_file file;
    response_limits limits{};
    bus_gaps gaps{{}, {}};
    servobus::priority priority = servobus::priority::ordinary;
    typename Setup::line on{port};
    client<typename Setup::line, device, fixed_node<device, 1>> fixed{on, {}};
    client<typename Setup::line, device> open{on, node<device>{1}};

    explicit rig(device_script answers = {}) {
        port.character_us = Setup::timing.character;
        for (std::uint16_t a = 0x0100; a < 0x0104; ++a) file.words[a] = static_cast<std::uint16_t>(a + 7);
        file.words[0x0200] = 0xBEEF;
        settle();
        port.device = std::move(answers);
    }
    rig(const rig&) = delete;

    template <bool IsBroadcast>
    using exchange_for = typename Setup::line::template exchange_for<response_limits, IsBroadcast>;
    struct ended {
        status why;
        bool was_sent;
        byte_list response;
    };
    ended run(const byte_list& request) {
        byte_list room(response_size(request) + 4, 0xA5);
        const bool is_broadcast = request[0] == 0;
        const byte_buffer response = byte_buffer{room}.first(room.size() - 4);
        const status w =
            is_broadcast
                ? on.run(exchange_for<true>{request, response, on.timing(), limits, priority}, gaps)
                : on.run(exchange_for<false>{request, response, on.timing(), limits, priority}, gaps);
        REQUIRE_FALSE(port.ran_away);
        REQUIRE(std::count(room.end() - 4, room.end(), 0xA5) == 4); // G10
        return {w, w.was_sent(), {room.begin(), room.end() - 4}};
    }
    errc ask(const byte_list& request) { return run(request).why.error(); }
    /// Runs one successful exchange, so that no quarantine is pending.
    void settle() {
        const auto before = std::exchange(port.device, answering(500));
        const std::uint32_t cost = std::exchange(port.call_us, 1);
        REQUIRE(ask(read_one) == errc::ok);
        port.device = before;
        port.call_us = cost;
        port.frames.clear();
    }
    void serve() {
        port.device = [this](scripted_port& p, const sent_frame& f) { file(p, f); };
    }
    byte_list last() const { return port.frames.back().data; }
    std::uint64_t bound(const byte_list& q) const {
        return on.bound(q.size(), response_size(q), limits, gaps).us;
    }
    /// Checks that the exchange ends within its bound, whatever the port does.
    ended run_in_time(const byte_list& q) {
        const std::uint64_t begun = port.time;
        const ended e = run(q);
        REQUIRE(port.time - begun <= bound(q) + 200);
        REQUIRE(port.frames.size() <= 1);
        REQUIRE(e.was_sent == (port.frames.size() == 1));
        return e;
    }
};

} // namespace tests::blocking
