// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What passed on the wire: a hash that is equal for two runs only if every byte and every time was the
// same, and the last frames with the events between them, for the report of a failed run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

namespace trial {

class record {
  public:
    /// Consecutive bytes, or a remark.
    struct note {
        std::uint64_t begin_us = 0;
        std::uint64_t end_us = 0;
        bool is_from_client = false;
        std::vector<std::uint8_t> data;
        std::string remark;
    };

    /// `gap_us`: bytes closer than this belong to one frame. `longest`: how many notes are kept; with 0
    /// only the hash is computed.
    record(std::uint64_t gap_us, std::size_t longest) : gap_us_{gap_us}, longest_{longest} {}

    void byte(std::uint64_t at_us, std::uint8_t value, bool is_from_client) {
        mix(at_us);
        mix(value + (is_from_client ? 256u : 0u));
        if (longest_ == 0) return;
        const bool goes_on = !notes_.empty() && notes_.back().remark.empty() &&
                             notes_.back().is_from_client == is_from_client &&
                             at_us - notes_.back().end_us < gap_us_ && notes_.back().data.size() < 300;
        if (!goes_on) add({at_us, at_us, is_from_client, {}, {}});
        notes_.back().data.push_back(value);
        notes_.back().end_us = at_us;
    }
    void remark(std::uint64_t at_us, std::string words) {
        if (longest_ != 0) add({at_us, at_us, false, {}, std::move(words)});
    }
    void mix(std::uint64_t value) {
        for (int i = 0; i < 8; ++i) hash_ = (hash_ ^ ((value >> (8 * i)) & 0xFFu)) * 1099511628211u;
    }

    std::uint64_t hash() const { return hash_; }
    const std::deque<note>& notes() const { return notes_; }

  private:
    void add(note n) {
        notes_.push_back(std::move(n));
        if (notes_.size() > longest_) notes_.pop_front();
    }

    std::deque<note> notes_;
    std::uint64_t gap_us_;
    std::size_t longest_;
    std::uint64_t hash_ = 14695981039346656037u;
};

} // namespace trial
