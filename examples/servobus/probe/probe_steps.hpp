// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Serves the steps of every drive's probe: waits for a reading, reads and writes numbers, notes what was found.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/core/time.hpp>
#include <servobus/registers/wire.hpp>

#include "../interpretations/findings.hpp"
#include "bench.hpp"
#include "old_words.hpp"

namespace tool {

class probe_steps {
  public:
    probe_steps(const probe_steps&) = delete;
    probe_steps& operator=(const probe_steps&) = delete;

  protected:
    using u16 = std::uint16_t;

    /// `a_while`: between two readings that wait for a change.
    probe_steps(probe_bench& on, findings& found, servobus::duration a_while)
        : on_{&on}, found_{&found}, old_{on}, a_while_{a_while} {}
    ~probe_steps() = default;

    /// Waits while the drive is asked. False: it was not so after this many readings.
    template <class Condition> bool until(Condition is_so, int readings) {
        for (int i = 0; i < readings && !on_->has_failed(); ++i) {
            if (is_so()) return true;
            wait();
        }
        return false;
    }
    void wait() { on_->wait(a_while_); }

    /// A number of 32 bits in two registers, in the order that the drive is set to.
    std::int32_t read_number(u16 address) {
        const std::array<u16, 2> words = on_->read_pair(address);
        return static_cast<std::int32_t>(servobus::join_words(words[0], words[1], order_));
    }
    bool write_number(u16 address, std::int32_t value) {
        const servobus::word_pair words = servobus::split_words(static_cast<std::uint32_t>(value), order_);
        return on_->write_pair(address, {words.first, words.second});
    }
    /// Reads the register that is 1 for the low word first.
    void note_order(u16 address) {
        on_->set_low_first(on_->read(address) != 0);
        order_ = on_->is_low_first() ? servobus::word_order::low_first : servobus::word_order::high_first;
    }

    /// Nothing that was read after a failure counts.
    void found(const char* name, const char* way) {
        if (!on_->has_failed()) found_->set(name, way);
    }
    void found(const char* name, bool is_so) { found(name, is_so ? "yes" : "no"); }
    void found(const char* name, seen is_so) {
        if (is_so != seen::unknown) found(name, is_so == seen::yes);
    }

    probe_bench* on_;
    findings* found_;
    old_words old_;

  private:
    servobus::duration a_while_;
    servobus::word_order order_ = servobus::word_order::high_first;
};

} // namespace tool
