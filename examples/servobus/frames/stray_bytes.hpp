// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Keeps the bytes that came beside the responses of a session, and names their cause: a second device at the address,
// a response after its time limit, another program or master that sends.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <servobus/line/observer.hpp>

#include "line_words.hpp"
#include "log_line.hpp"

namespace tool {

/// Keeps the bytes that belong to no response.
struct stray_bytes : servobus::counters {
    std::vector<std::uint8_t> all{};

    void on_unexpected(servobus::bytes b) {
        servobus::counters::on_unexpected(b);
        constexpr std::size_t most = 4096; // of a line that never rests
        const std::size_t room = most - std::min(most, all.size());
        all.insert(all.end(), b.begin(), b.begin() + static_cast<std::ptrdiff_t>(std::min(room, b.size())));
    }

    /// In words; empty if nothing came but what a driver gives as it is switched. `timeout_ms`: how long a response may
    /// take.
    std::string text(std::uint8_t node, std::uint32_t timeout_ms) const {
        const auto count = static_cast<std::size_t>(
            std::count_if(all.begin(), all.end(), [](std::uint8_t b) { return b != 0 && b != 0xFF; }));
        if (count == 0) return {};
        if (std::string late = late_text(node, timeout_ms); !late.empty()) return late;
        if (count_of(node) != 0) return words_on_two_responses("node " + std::to_string(node), false);
        return std::to_string(all.size()) + (all.size() == 1 ? " byte" : " bytes") +
               " came beside the responses: another program or master sends on this line, or it picks up "
               "noise";
    }
    /// Of responses that came too late alone; empty if none did.
    std::string late_text(std::uint8_t node, std::uint32_t timeout_ms) const {
        if (timeouts == 0 || count_of(node) == 0) return {};
        return "responses of node " + std::to_string(node) + " came after " + std::to_string(timeout_ms) +
               " ms: give --timeout more, or two devices have this address";
    }

  private:
    std::size_t count_of(std::uint8_t node) const {
        const found_frames found = log_line::find_frames(all);
        return static_cast<std::size_t>(
            std::count_if(found.frames.begin(), found.frames.end(),
                          [&](const found_frame& f) { return f.frame[0] == node; }));
    }
};

} // namespace tool
