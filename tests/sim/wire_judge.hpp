// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Counts the triggers on the wire, whatever the library reports (G15, G33). It decodes the bytes that the
// port took, with its own framing, its own CRC and its own list of the triggers in the manuals. It assumes
// that a frame whose rest is not taken is followed by the beginning of another one, in a call of its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "judge.hpp"
#include "scene.hpp"

namespace trial {

class wire_judge {
  public:
    explicit wire_judge(scene& on) : on_{&on} {}

    /// The application has begun a new command of this node.
    void commanded(std::uint8_t node_address) {
        triggers_[node_address].clear();
        count_[node_address] = 0;
    }
    /// Triggers that were sent since then.
    unsigned triggers(std::uint8_t node_address) const { return count_[node_address]; }
    std::uint64_t frames() const { return frames_; }

    /// The port has taken these bytes, of one call.
    void taken(servobus::bytes what) {
        chunks_.push_back(pending_.size());
        pending_.insert(pending_.end(), what.begin(), what.end());
        while (take_frame()) {}
    }

  private:
    // Takes one complete frame from the beginning of the bytes. Drops the beginning of a frame that was cut
    // off: it is followed by a valid one, or has become as long as a frame and is none.
    bool take_frame() {
        for (std::size_t k = 1; k < chunks_.size(); ++k) {
            if (begins_with_frame(pending_) ||
                !begins_with_frame(servobus::bytes{pending_}.subspan(chunks_[k])))
                continue;
            drop(chunks_[k]);
            return true;
        }
        const std::size_t size = length(pending_);
        if (size == 0 || pending_.size() < size) return false;
        const servobus::bytes frame = servobus::bytes{pending_}.first(size);
        if (plain_crc(frame) != 0) {
            if (chunks_.size() < 2)
                throw broken{"G33: the bytes on the wire are neither a frame nor the rest of one"};
            drop(chunks_[1]);
            return true;
        }
        ++frames_;
        look_at(frame);
        drop(size);
        return true;
    }
    void drop(std::size_t size) {
        pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(size));
        std::vector<std::size_t> left;
        for (const std::size_t at : chunks_) {
            if (at >= size && at - size < pending_.size()) left.push_back(at - size);
        }
        chunks_ = left;
        if (!pending_.empty() && (chunks_.empty() || chunks_.front() != 0))
            chunks_.insert(chunks_.begin(), 0);
    }
    static bool begins_with_frame(servobus::bytes b) {
        const std::size_t size = length(b);
        return size != 0 && size <= b.size() && plain_crc(b.first(size)) == 0;
    }
    static std::size_t length(servobus::bytes b) {
        if (b.size() < 7) return 0;
        return b[1] == 0x10 ? b[6] + std::size_t{9} : 8;
    }

    void look_at(servobus::bytes f) {
        if (f[1] != 0x06 && f[1] != 0x10) return;
        const unsigned first = word(f, 2);
        const unsigned count = f[1] == 0x06 ? 1u : word(f, 4);
        for (unsigned i = 0; i < count; ++i) {
            const unsigned value = f[1] == 0x06 ? word(f, 4) : word(f, 7 + 2 * i);
            const unsigned sets_going = what_it_triggers(f[0], first + i, value);
            if (sets_going != 0) note(f[0], first + i, sets_going);
        }
    }
    // The triggers by the manuals; 0 for none.
    unsigned what_it_triggers(std::uint8_t node_address, unsigned address, unsigned value) {
        switch (on_->kinds[node_address]) {
        case drive_kind::zlac8015d: // 200Eh: 06h fault reset, 08h enable, 10h..12h start
            return address == 0x200E && (value == 0x06 || value == 0x08 || (value >= 0x10 && value <= 0x12))
                       ? value
                       : 0;
        case drive_kind::yako: // 0027h: bits 0, 1 and 4 start; 002Dh: all but 0011h, which releases
            if (address == 0x0027) return value & 0x0013u;
            return address == 0x002D && value != 0x0011 ? value : 0;
        case drive_kind::c630s: { // P31-00: the rising edges of the virtual inputs; P0D-01: alarm reset
            if (address == 0x0D01) return value;
            if (address != 0x3100) return 0;
            const unsigned risen = value & ~inputs_[node_address];
            inputs_[node_address] = value;
            return risen;
        }
        default: return 0;
        }
    }
    void note(std::uint8_t node_address, unsigned address, unsigned what) {
        ++count_[node_address];
        if (++triggers_[node_address][{address, what}] == 1) return;
        throw broken{"G15: one command has sent a trigger to node " + std::to_string(node_address) +
                     " twice, register " + std::to_string(address) + " = " + std::to_string(what)};
    }

    static unsigned word(servobus::bytes f, std::size_t at) { return f[at] * 256u + f[at + 1]; }

    scene* on_;
    byte_list pending_;
    std::vector<std::size_t> chunks_; ///< where the bytes of each call begin in `pending_`
    std::array<std::map<std::pair<unsigned, unsigned>, unsigned>, 256> triggers_;
    std::array<unsigned, 256> count_{};
    std::array<unsigned, 256> inputs_{};
    std::uint64_t frames_ = 0;
};

} // namespace trial
