// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port in front of a virtual line that hands each byte of a response over at a given time after its request, as a
// slow drive, adapter or network would. The bytes are the simulated drive's own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>

#include <servobus/sim/line.hpp>

namespace tests {

class late_port {
  public:
    explicit late_port(servobus::sim::virtual_line& wire) : wire_{&wire} {}

    /// When byte number `i` of a response comes, in us after the last bit of its request; earlier than it is on the
    /// wire it never does. Empty: as it comes.
    std::function<std::uint64_t(std::size_t i)> due{};
    std::uint32_t delayed = 0; ///< bytes that came later than they were on the wire

    servobus::transfer send(servobus::bytes out) {
        has_left_ = false;
        came_ = 0;
        return wire_->send(out);
    }
    bool sent() {
        const bool is = wire_->sent();
        if (is && !has_left_) sent_at_ = wire_->time_us();
        has_left_ = has_left_ || is;
        return is;
    }
    servobus::transfer receive(servobus::byte_buffer in) {
        fetch();
        std::uint16_t given = 0;
        while (given < in.size() && !held_.empty() && held_.front().at <= wire_->time_us()) {
            in[given++] = held_.front().value;
            held_.pop_front();
        }
        return given;
    }
    servobus::instant now() { return wire_->now(); }
    void wait(servobus::duration longest) {
        const std::uint64_t end = wire_->time_us() + longest.us;
        while (wire_->time_us() < end) {
            fetch(); // which takes time
            const std::uint64_t now = wire_->time_us();
            const std::uint64_t next = held_.empty() || end < held_.front().at ? end : held_.front().at;
            if (next <= now) return;
            wire_->wait(servobus::duration{static_cast<std::uint32_t>(next - now)});
        }
    }

  private:
    struct held_byte {
        std::uint64_t at;
        std::uint8_t value;
    };
    void fetch() {
        std::uint8_t byte = 0;
        for (;;) {
            const servobus::transfer came = wire_->receive({&byte, 1});
            if (!came || *came == 0) return;
            const std::uint64_t now = wire_->time_us();
            const std::uint64_t at = due ? sent_at_ + due(came_) : now;
            delayed += at > now ? 1u : 0u;
            held_.push_back({at > now ? at : now, byte});
            ++came_;
        }
    }

    servobus::sim::virtual_line* wire_;
    std::deque<held_byte> held_{};
    std::uint64_t sent_at_ = 0;
    std::size_t came_ = 0; // bytes since the last request
    bool has_left_ = true;
};

} // namespace tests
