// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Bytes that are sent at given times, by a device or as noise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <servobus/modbus/crc16.hpp>
#include <servobus/sim/station.hpp>

#include "scene.hpp"

namespace trial {

using byte_list = std::vector<std::uint8_t>;

inline byte_list closed(byte_list frame) {
    const std::uint16_t crc = servobus::modbus::crc16(frame);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFFu));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    return frame;
}
inline byte_list random_bytes(scene& on, std::size_t size) {
    byte_list b(size);
    for (std::uint8_t& v : b) v = on.any_byte();
    return b;
}

class timed_sender {
  public:
    explicit timed_sender(scene& on) : on_{&on} {}

    /// Sends the bytes from `at_us` on, in wire time, and divides them if they are long. Returns the time
    /// at which they end.
    std::uint64_t send_at(std::uint64_t at_us, servobus::bytes what) {
        constexpr std::size_t most = servobus::modbus::max_frame;
        for (std::size_t begin = 0; begin < what.size(); begin += most) {
            const servobus::bytes part =
                what.subspan(begin, what.size() - begin < most ? what.size() - begin : most);
            const std::uint64_t start = at_us + on_->wire_time(begin);
            std::size_t place = pieces_.size();
            while (place > 0 && pieces_[place - 1].at_us > start) --place;
            pieces_.insert(pieces_.begin() + static_cast<std::ptrdiff_t>(place),
                           {start, {part.begin(), part.end()}});
        }
        return at_us + on_->wire_time(what.size());
    }
    /// The piece whose first bit leaves now.
    servobus::bytes due() {
        if (pieces_.empty() || pieces_.front().at_us > on_->now()) return {};
        sent_ = std::move(pieces_.front().data);
        pieces_.erase(pieces_.begin());
        return sent_;
    }
    servobus::duration until_due() const {
        if (pieces_.empty()) return servobus::sim::line_device::until_it_receives;
        const std::uint64_t at = pieces_.front().at_us;
        return servobus::duration{at > on_->now() ? static_cast<std::uint32_t>(at - on_->now()) : 1u};
    }
    void stop() { pieces_.clear(); }

  private:
    struct piece {
        std::uint64_t at_us;
        byte_list data;
    };

    scene* on_;
    std::vector<piece> pieces_;
    byte_list sent_;
};

/// A node that sends without listening: noise, and bytes that collide with frames of others.
class babbler final : public servobus::sim::line_device {
  public:
    babbler(scene& on, std::uint32_t baud) : sender{on}, on_{&on}, baud_{baud} {}

    /// Sends only bytes 00 for a time, like a stuck transceiver. Returns the time at which it ends.
    std::uint64_t drone(std::uint32_t us) {
        return sender.send_at(on_->now() + 1, byte_list(us / on_->wire_time(1) + 1));
    }
    /// Sends bursts of random bytes for a time, like a crashed node. Returns the time at which it ends.
    std::uint64_t babble(std::uint32_t us) {
        std::uint64_t at = on_->now() + 1;
        const std::uint64_t end = at + us;
        while (at < end) {
            byte_list burst = random_bytes(*on_, on_->between(1, 200));
            burst[0] = nobody; // since some drives respond to a damaged request
            at = sender.send_at(at, burst) + (on_->one_in(2) ? 0 : on_->random.below(20'000));
        }
        return at;
    }

    void receive(std::uint8_t, bool, servobus::instant) override {}
    servobus::duration run(servobus::instant) override { return sender.until_due(); }
    servobus::bytes send(servobus::instant) override { return sender.due(); }
    std::uint32_t baud() const override { return baud_; }

    timed_sender sender;

  private:
    static constexpr std::uint8_t nobody = 0xF9;

    scene* on_;
    std::uint32_t baud_;
};

} // namespace trial
