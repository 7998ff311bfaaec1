// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Keeps how far the commands after an enable are, and whether the next consent must begin them. One copy of code for
// all lists. It sends nothing.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/control/command_status.hpp>
#include <servobus/control/loop_report.hpp>

namespace servobus::detail {

///     due --begin--> under way --the last command has ended well--> done
///     under way --withdraw--> due
///     done --anything but a halt has stopped the motor, or may have--> due
class after_enable_progress {
  public:
    /// True from the enable to the end of the last command, while the consent lasts.
    constexpr bool is_under_way() const { return is_under_way_; }
    /// False if the next consent must begin the list although the drive is energised.
    constexpr bool is_done() const { return is_done_; }
    /// The place of the command that is due, or under way.
    constexpr std::size_t index() const { return index_; }
    /// The end of that command, with its number.
    constexpr command_status numbered(const command_status& how) const {
        return how.in_part(take_over_part::setting, index_ + 1u);
    }

    constexpr void begin() {
        index_ = 0;
        is_under_way_ = true;
    }
    /// The command that was due has ended well. True if it was the last one of `size`.
    constexpr bool advance(std::size_t size) {
        ++index_;
        is_done_ = index_ == size;
        is_under_way_ = !is_done_;
        return is_done_;
    }
    /// True before a list that is done is left out: a reading must show first that the drive is as it was.
    constexpr bool is_check_due() const { return is_done_ && !is_checked_; }
    constexpr void begin_check() { is_checking_ = true; }
    constexpr bool is_checking() const { return is_checking_; }
    constexpr void end_check(bool is_read) {
        is_checked_ = is_read;
        is_checking_ = false;
    }
    /// Ends what is under way. What is done stays done.
    constexpr void withdraw() { is_under_way_ = is_checked_ = false; }
    constexpr void invalidate() { is_under_way_ = is_done_ = false; }

    /// The program has begun a command.
    constexpr void note_command(bool may_move, bool changes_power) {
        is_moving_ = may_move;
        if (changes_power) invalidate();
    }
    /// A command, a setpoint or a stop of the loop has ended. `shows_stop`: by an error that may come of a wired stop.
    constexpr void note_end(loop_part ended, const command_status& how, bool shows_stop) {
        if (how) return;
        const bool has_failed_in_motion =
            ended == loop_part::command && is_moving_ && how.outcome() != outcome::not_sent;
        if (shows_stop || has_failed_in_motion || ended == loop_part::stop) invalidate();
    }
    /// A stop is begun. `replaced`: what was under way.
    constexpr void note_stop(bool is_halt, loop_part replaced) {
        if (!is_halt || (replaced == loop_part::command && is_moving_)) invalidate();
    }

  private:
    std::uint8_t index_ = 0;
    bool is_under_way_ = false;
    bool is_done_ = false;
    bool is_checking_ = false;
    bool is_checked_ = false;
    bool is_moving_ = false; // the program's last command, which may be a homing
};

/// In a loop without commands after the enable, so that these cost it nothing.
struct nothing_after_enable {
    static constexpr bool is_under_way() { return false; }
    static constexpr bool is_done() { return true; }
    static constexpr void withdraw() {}
};

} // namespace servobus::detail
