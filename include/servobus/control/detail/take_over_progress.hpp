// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Chooses the part of a take-over that is due, from how the one before it ended and the state of the drive. One copy of
// code for all lists. It sends nothing.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/control/command_status.hpp>
#include <servobus/control/states.hpp>

namespace servobus::detail {

/// What a take-over has done and found.
class take_over_progress {
  public:
    /// `size`: of the list of settings.
    constexpr take_over_progress(bool resets, std::size_t size)
        : resets_{resets}, size_{static_cast<std::uint8_t>(size)} {}

    constexpr bool is_over() const { return is_over_; }
    /// The part that is due: its command is the next one.
    constexpr take_over_part due() const { return part_; }
    /// The place of the setting that is due in the list.
    constexpr std::size_t index() const { return index_; }
    /// How it ended.
    constexpr command_status status() const {
        const unsigned number = part_ == take_over_part::setting ? index_ + 1u : 0u;
        return how_.in_part(part_, number);
    }

    /// The part that was due has ended so, and the drive is in the state `found`.
    constexpr void conclude(const command_status& how, drive_state found) {
        using enum take_over_part;
        how_ = how;
        if (!how) return end();
        if (found == drive_state::needs_power_cycle) return fail(power_cycle, errc::wrong_state);
        if (part_ == reading && !looks_for_fault_) return end_in(found);
        if (part_ == init && resets_) {
            looks_for_fault_ = true;
            part_ = reading;
            return;
        }
        if (looks_for_fault_) {
            looks_for_fault_ = false;
            if (found == drive_state::faulted) {
                part_ = fault_reset;
                return;
            }
        }
        if (part_ == setting) ++index_;
        part_ = index_ == size_ ? reading : setting;
    }

  private:
    constexpr void end_in(drive_state found) {
        if (found == drive_state::needs_init) return fail(take_over_part::reading, errc::needs_init);
        if (found == drive_state::needs_set_up) return fail(take_over_part::set_up, errc::wrong_state);
        if (found == drive_state::faulted && resets_) return fail(take_over_part::reading, errc::faulted);
        end();
    }
    constexpr void fail(take_over_part at, errc why) {
        part_ = at;
        how_ = why;
        end();
    }
    constexpr void end() { is_over_ = true; }

    command_status how_{};
    take_over_part part_ = take_over_part::init;
    bool resets_;
    bool looks_for_fault_ = false; // by a reading before the settings
    bool is_over_ = false;
    std::uint8_t size_;
    std::uint8_t index_ = 0;
};

} // namespace servobus::detail
