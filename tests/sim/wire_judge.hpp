// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Counts what sets a machine going, on the wire, whatever the library says of it (G15, G33): from the bytes
// that the port took, with frames, CRC and the triggers of the manuals of its own. It assumes that a frame
// whose rest is not taken is followed by the beginning of another one.
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
    /// Each whole frame with the word that it writes, where it is a trigger.
    explicit wire_judge(scene& on) : on_{&on} {}

    /// The application has commanded this unit anew.
    void commanded(std::uint8_t unit) {
        triggers_[unit].clear();
        count_[unit] = 0;
    }
    /// Frames since then that set something going.
    unsigned triggers(std::uint8_t unit) const { return count_[unit]; }
    std::uint64_t frames() const { return frames_; }

    /// The port has taken these bytes, of one call.
    void taken(servobus::bytes what) {
        chunks_.push_back(pending_.size());
        pending_.insert(pending_.end(), what.begin(), what.end());
        while (take_frame()) {}
    }

  private:
    // A whole frame, from the first byte that the port took of it; what was cut before it is dropped.
    bool take_frame() {
        const std::size_t size = length();
        if (size == 0 || pending_.size() < size) return false;
        const servobus::bytes frame = servobus::bytes{pending_}.first(size);
        if (plain_crc(frame) != 0) {
            if (chunks_.size() < 2) throw broken{"G33: what is on the wire is no frame, nor the rest of one"};
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
    std::size_t length() const {
        if (pending_.size() < 7) return 0;
        return pending_[1] == 0x10 ? pending_[6] + std::size_t{9} : 8;
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
    // By the manuals; 0 for nothing.
    unsigned what_it_triggers(std::uint8_t unit, unsigned address, unsigned value) {
        switch (on_->kinds[unit]) {
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
            const unsigned risen = value & ~inputs_[unit];
            inputs_[unit] = value;
            return risen;
        }
        default: return 0;
        }
    }
    void note(std::uint8_t unit, unsigned address, unsigned what) {
        ++count_[unit];
        if (++triggers_[unit][{address, what}] == 1) return;
        throw broken{"G15: on the wire, unit " + std::to_string(unit) +
                     " is set going twice by one command, register " + std::to_string(address) + " = " +
                     std::to_string(what)};
    }

    static unsigned word(servobus::bytes f, std::size_t at) { return f[at] * 256u + f[at + 1]; }

    scene* on_;
    byte_list pending_;
    std::vector<std::size_t> chunks_; ///< where what one call took begins, in `pending_`
    std::array<std::map<std::pair<unsigned, unsigned>, unsigned>, 256> triggers_;
    std::array<unsigned, 256> count_{};
    std::array<unsigned, 256> inputs_{};
    std::uint64_t frames_ = 0;
};

} // namespace trial
