// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Register stores that count how often a server reads or writes them, and a server with one of them whose bytes
// arrive with their real spacing.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/modbus/server.hpp>

#include "scripted_port.hpp"

namespace tests::served {

inline constexpr auto both_modes = {servobus::modbus::timing_mode::strict,
                                    servobus::modbus::timing_mode::host};

struct one_word {
    std::uint16_t word = 0;
    unsigned accesses = 0;
    std::uint8_t read(std::uint16_t, std::span<std::uint16_t> to) {
        ++accesses;
        for (std::uint16_t& w : to) w = word;
        return 0;
    }
    std::uint8_t write(std::uint16_t, servobus::words_view from) {
        ++accesses;
        word = from[0];
        return 0;
    }
};

struct sixteen_words {
    std::array<std::uint16_t, 16> words{};
    unsigned accesses = 0;
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        ++accesses;
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = words[(address + i) % 16];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, servobus::words_view from) {
        ++accesses;
        for (std::size_t i = 0; i < from.size(); ++i) words[(address + i) % 16] = from[i];
        return 0;
    }
};

/// A server at 115200 Bd.
struct bench {
    sixteen_words store{};
    servobus::modbus::rtu_timing timing;
    servobus::modbus::server<sixteen_words> server;
    servobus::instant now{1'000'000};

    explicit bench(servobus::modbus::timing_mode mode = servobus::modbus::timing_mode::host,
                   std::uint8_t node_address = 1, servobus::modbus::server_rules rules = {})
        : timing{servobus::modbus::timing_at(115200, mode)}, server{node_address, store, timing, rules} {}

    /// `is_polled`: the program calls `elapse` at the end.
    void quiet(std::uint32_t us, bool is_polled = true) {
        now = now + servobus::microseconds(us);
        if (is_polled) server.elapse(now);
    }
    void t3_5() { quiet(timing.t3_5 + 10u); }
    void gap() { quiet(timing.visible_gap().us + 1'000); }
    /// So many bytes of the frame arrive together.
    void receive(const byte_list& frame, std::size_t burst = 1) {
        for (std::size_t at = 0; at < frame.size(); at += burst) {
            const servobus::bytes arrived =
                servobus::bytes{frame}.subspan(at, std::min(burst, frame.size() - at));
            now = now + timing.wire_time(arrived.size());
            server.feed(arrived, now);
        }
    }
    /// The response, after a visible gap at the latest.
    byte_list response() {
        for (int i = 0; i < 100; ++i) {
            quiet(250);
            const servobus::bytes frame = server.response(now);
            const byte_list got(frame.begin(), frame.end());
            if (got.empty()) continue;
            now = now + timing.wire_time(got.size());
            server.sent(now);
            return got;
        }
        return {};
    }
};

} // namespace tests::served
