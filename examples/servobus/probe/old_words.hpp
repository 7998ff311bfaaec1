// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Notes what registers hold before a probe changes them, and gives it back at the end.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bench.hpp"

namespace tool {

class old_words {
  public:
    explicit old_words(probe_bench& on) : on_{&on} {}

    /// Reads a register or a pair, unless it is noted already. What could not be read is not noted, and never written.
    void note(std::uint16_t address) {
        if (find(address) == nullptr) add({address, false, {on_->read(address), 0}});
    }
    void note_pair(std::uint16_t address) {
        if (find(address) == nullptr) add({address, true, on_->read_pair(address)});
    }
    /// 0 for a register that is not noted.
    std::uint16_t word(std::uint16_t address) const {
        const old* const o = find(address);
        return o != nullptr ? o->words[0] : std::uint16_t{0};
    }
    void put_back(std::uint16_t address) {
        if (const old* const o = find(address)) write(*o);
    }
    /// In the order in which they were noted.
    void restore() {
        for (const old& o : all_) write(o);
    }
    void restore_last_first() {
        for (auto o = all_.rbegin(); o != all_.rend(); ++o) write(*o);
    }
    void forget() { all_.clear(); }

  private:
    struct old {
        std::uint16_t address;
        bool is_pair;
        std::array<std::uint16_t, 2> words;
    };

    const old* find(std::uint16_t address) const {
        const auto at = std::ranges::find(all_, address, &old::address);
        return at != all_.end() ? &*at : nullptr;
    }
    void add(const old& read) {
        if (on_->has_failed()) return;
        all_.push_back(read);
        on_->note_old(read.address, std::span{read.words}.first(read.is_pair ? 2 : 1));
    }
    void write(const old& o) {
        if (o.is_pair)
            (void)on_->write_pair(o.address, o.words);
        else
            (void)on_->write(o.address, o.words[0]);
    }

    probe_bench* on_;
    std::vector<old> all_{};
};

} // namespace tool
