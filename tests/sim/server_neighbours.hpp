// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server on a line with other nodes, in either timing: it responds to a request after their frames (G14, G41), and
// executes nothing that their payloads contain (G6, G13).
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <servobus/modbus/server.hpp>

#include "neighbours.hpp"

namespace trial {

class server_neighbours {
  public:
    explicit server_neighbours(scene& on) : on_{on} {}

    void go() {
        using servobus::modbus::timing_mode;
        for (int i = 0; i < 40; ++i) meet(on_.one_in(2) ? timing_mode::host : timing_mode::strict);
    }

  private:
    static constexpr std::uint8_t own = 1;
    struct store {
        unsigned writes = 0;
        std::uint8_t read(std::uint16_t, std::span<std::uint16_t> to) {
            for (std::uint16_t& w : to) w = 7;
            return 0;
        }
        std::uint8_t write(std::uint16_t, servobus::words_view) {
            ++writes;
            return 0;
        }
    };

    void meet(servobus::modbus::timing_mode mode) {
        store s;
        const servobus::modbus::rtu_timing timing = servobus::modbus::timing_at(115200, mode);
        servobus::modbus::server<store> server{own, s, timing};
        std::uint32_t us = 100'000;
        const auto pass = [&](std::uint32_t by) {
            bool has_responded = false;
            for (const std::uint32_t end = us + by; us < end; us += 250) {
                server.elapse(servobus::instant{us});
                if (server.response(servobus::instant{us}).empty()) continue;
                has_responded = true;
                server.sent(servobus::instant{us});
            }
            return has_responded;
        };
        const neighbour what = any_neighbour(on_);
        ++on_.count->lives.at_servers[played::at(what)];
        const byte_list write = closed({own, 0x06, 0x00, 0x10, 0x00, on_.any_byte()});
        const byte_list foreign =
            frame_of(on_, what, static_cast<std::uint8_t>(on_.between(100, 240)), write);
        (void)pass(50'000);
        using servobus::modbus::timing_mode;
        server.feed(foreign, servobus::instant{us});
        // A gap of t3.5, as the server can see it with a loop of 250 us. All bytes of the request arrive together at
        // its end.
        // With host timing a request may follow on a frame of known length without one.
        const bool is_joined = mode == timing_mode::host && has_known_length(what) && on_.one_in(2);
        const bool has_responded = !is_joined && pass(timing.t3_5 + on_.between(1'500, 20'000));
        if (has_responded || s.writes != 0)
            throw broken{std::string{"G13: a server executes what a frame "} + text(what) +
                         " of another node contains"};
        server.feed(closed({own, 0x03, 0x00, 0x00, 0x00, 0x01}), servobus::instant{us});
        if (!pass(60'000))
            throw broken{std::string{"G14: after a frame "} + text(what) +
                         " of another node a server does not respond to a request"};
    }

    scene& on_;
};

} // namespace trial
