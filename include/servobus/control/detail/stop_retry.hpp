// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stops that stand side by side in a routine: each goes out once before any goes out again, since the second
// may do what the first could not. One that must not be the first frame a drive hears waits for another's
// answer.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/step.hpp>

namespace servobus::detail {

/// Which of up to eight stops is to go out next.
class stop_retry {
  public:
    static constexpr std::uint8_t rounds = 3;

    /// Takes the stop that is step `at` of a routine of `size` steps, and those right behind it.
    constexpr void begin(const step* stop, std::uint8_t at, std::uint8_t size) {
        first_ = last_ = at_ = at;
        behind_ = 0;
        while (last_ + 1u < size && (++stop)->is_repeatable && last_ - at < 7) {
            ++last_;
            if (stop->is_behind) behind_ = static_cast<std::uint8_t>(behind_ | mask_of(last_));
        }
        due_ = 0xFF;
        missed_ = 0;
        round_ = 1;
        has_answer_ = false;
    }

    /// The stop that was due has had its response, or none. False if there is none to go out any more.
    constexpr bool conclude(bool has_response) {
        if (has_response) {
            has_answer_ = true;
        } else {
            miss();
        }
        for (;;) {
            while (at_ != last_) {
                if ((due_ & mask_of(++at_)) == 0) continue;
                if (has_answer_ || (behind_ & mask_of(at_)) == 0) return true;
                miss();
            }
            if (missed_ == 0 || round_ == rounds) return false;
            ++round_;
            due_ = missed_;
            missed_ = 0;
            at_ = first_;
            if ((due_ & mask_of(at_)) != 0) return true;
        }
    }

    /// The step that is due.
    constexpr std::uint8_t at() const { return at_; }
    constexpr std::uint8_t last() const { return last_; }
    /// At the end: one of them was never answered, or one was.
    constexpr bool is_any_missed() const { return missed_ != 0; }
    constexpr bool is_any_answered() const { return has_answer_; }

  private:
    constexpr unsigned mask_of(unsigned step) const { return 1u << (step - first_); }
    constexpr void miss() { missed_ = static_cast<std::uint8_t>(missed_ | mask_of(at_)); }

    std::uint8_t first_ = 0;
    std::uint8_t last_ = 0;
    std::uint8_t at_ = 0;
    std::uint8_t due_ = 0;    // bits, counted from the first: to go out in this round
    std::uint8_t missed_ = 0; // to go out in the next
    std::uint8_t behind_ = 0; // not to go out before another was answered
    std::uint8_t round_ = 1;
    bool has_answer_ = false;
};

} // namespace servobus::detail
