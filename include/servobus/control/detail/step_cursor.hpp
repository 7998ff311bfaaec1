// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The place in a routine: which step is due, and what that asks for. control/detail/routine_run.hpp moves it.
#pragma once

#include <cstdint>

#include <servobus/control/image.hpp>
#include <servobus/control/step.hpp>

namespace servobus::detail {

class step_cursor {
  public:
    constexpr bool is_over() const { return size_ == 0; }
    /// Returns the step that is due, until the routine is over.
    constexpr const step& current() const { return *current_; }
    constexpr bool is_at_stop() const { return current().is_repeatable; }
    constexpr bool is_at_witness() const { return !is_over() && current().what == step::kind::witness; }
    /// True if the drive's model decides on the step, by the process image.
    constexpr bool asks_model() const { return !is_over() && current().asks_model(); }
    /// True if the step needs registers of `of`.
    constexpr bool reads(const register_block& of) const {
        if (is_over() || current().what == step::kind::write || current().what == step::kind::witness)
            return false;
        return current().asks_model() ||
               (!current().is_element && of.contains(current().address, current().count));
    }

  protected:
    constexpr void start(routine table, std::uint16_t shift) {
        current_ = table.data();
        size_ = static_cast<std::uint8_t>(table.size());
        shift_ = shift;
        at_ = 0;
    }
    constexpr void leave() { size_ = 0; }
    constexpr void go_to(std::uint8_t step) {
        current_ += step - at_;
        at_ = step;
    }
    constexpr bool is_last() const { return at_ + 1u == size_; }
    /// True if the step before has read what this one overwrites: that holds for one frame only.
    constexpr bool was_looked_at() const {
        return at_ != 0 && current_[-1].what == step::kind::expect &&
               current_[-1].address == current().address;
    }
    /// Returns the address of the step's register. In an array of registers `shift` chooses the element.
    constexpr std::uint16_t address() const {
        return static_cast<std::uint16_t>(current().address + (current().is_element ? shift_ : 0));
    }

    std::uint8_t at_ = 0;
    std::uint8_t size_ = 0; // steps; 0 when it is over
    std::uint16_t shift_ = 0;
    const step* current_ = nullptr;
};

} // namespace servobus::detail
