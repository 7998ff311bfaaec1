// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Records what one run of a command sends: the last frames on the wire for a finding, and which requests are like
// others. Each byte is noted by sim/conformance/trial.hpp.
//
//     sim::wire_log log;
//     log.note({.at_us = 90, .value = 0x01, .is_from_client = true}, 1); // a byte of the first request
//     const bool is_alone = !log.is_repeated(0);
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/modbus/pdu.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/line.hpp>

namespace servobus::sim {

/// Numbers of the requests at which a mishap makes a run of its own, in their order.
struct chosen_requests {
    std::array<std::uint16_t, 200> numbers{};
    unsigned count = 0;

    const std::uint16_t* begin() const { return numbers.data(); }
    const std::uint16_t* end() const { return numbers.data() + count; }
};

class wire_log {
  public:
    /// Notes a byte, and how many requests have begun since `begin`, this one among them.
    void note(const wire_byte& b, unsigned requests) {
        // A frame ends where the direction changes, or a pause follows.
        const bool goes_on =
            kept_ != 0 && newest().is_request == b.is_from_client && b.at_us - newest().at_us < 1'700;
        if (!goes_on) {
            frames_[next_] = {};
            frames_[next_].is_request = b.is_from_client;
            next_ = (next_ + 1) % frames_.size();
            kept_ = kept_ < frames_.size() ? kept_ + 1 : kept_;
        }
        traced_frame& f = newest();
        f.at_us = b.at_us;
        if (f.size < sizeof f.data) f.data[f.size] = b.value;
        if (f.size < 255) ++f.size;
        if (!b.is_from_client) return;
        const bool is_write = f.size == 2 && modbus::is_write(b.value);
        if (is_write) ++writes_;
        known_ = requests < sent_.size() ? requests : static_cast<unsigned>(sent_.size());
        if (requests == 0 || requests > sent_.size()) return;
        sent& s = sent_[requests - 1];
        s.sum = f.size == 1 ? b.value : s.sum * 31 + b.value;
        s.is_write = s.is_write || is_write;
        if (f.size == 3 || f.size == 4) s.address = static_cast<std::uint16_t>(s.address << 8 | b.value);
    }
    /// Another run begins; the frames stay.
    void begin() {
        writes_ = known_ = 0;
        sent_ = {};
    }

    /// Requests that write.
    unsigned writes() const { return writes_; }
    /// Counts the requests that are kept: a wait may send more.
    unsigned requests() const { return known_; }
    /// True for a read that is like others: between the same two writes at least two equal ones precede it, and one
    /// follows it. In a wait all but the first, the second and the last are repeated.
    bool is_repeated(unsigned request) const {
        unsigned before = 0;
        for (unsigned i = request; i != 0 && before < 2 && !sent_[i].is_write; --i)
            before += is_equal(request, i - 1) ? 1u : 0u;
        if (before < 2) return false;
        for (unsigned i = request + 1; i < known_ && !sent_[i].is_write; ++i) {
            if (is_equal(request, i)) return true;
        }
        return false;
    }
    /// Returns the first requests that are not repeated, 200 at most.
    chosen_requests chosen() const {
        chosen_requests all;
        for (unsigned i = 0; i < known_ && all.count < all.numbers.size(); ++i) {
            if (!is_repeated(i)) all.numbers[all.count++] = static_cast<std::uint16_t>(i);
        }
        return all;
    }
    /// True if this request writes the register that the one before it has read.
    bool writes_what_was_read(unsigned request) const {
        if (request == 0 || request >= known_) return false;
        const sent& read = sent_[request - 1];
        return sent_[request].is_write && !read.is_write && sent_[request].address == read.address;
    }
    /// The last frames, in order.
    std::span<const traced_frame> trace() {
        for (std::size_t i = 0; i < kept_; ++i)
            ordered_[i] = frames_[(next_ + frames_.size() - kept_ + i) % frames_.size()];
        return {ordered_.data(), kept_};
    }

  private:
    struct sent {
        std::uint32_t sum = 0;
        std::uint16_t address = 0; // the first register
        bool is_write = false;
    };

    bool is_equal(unsigned a, unsigned b) const { return sent_[a].sum == sent_[b].sum; }
    traced_frame& newest() { return frames_[(next_ + frames_.size() - 1) % frames_.size()]; }

    std::array<sent, 1000> sent_{};
    unsigned known_ = 0;
    unsigned writes_ = 0;
    std::array<traced_frame, 40> frames_{};
    std::array<traced_frame, 40> ordered_{};
    std::size_t next_ = 0;
    std::size_t kept_ = 0;
};

} // namespace servobus::sim
