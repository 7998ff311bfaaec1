// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Whether the application still commands a drive whose motion does not end by itself.
//
//     off --an endless motion begins--> on --a stop is done, or the command timeout has passed--> off
#pragma once

#include <servobus/core/time.hpp>

namespace servobus::detail {

class command_watch {
  public:
    constexpr explicit command_watch(duration limit) : limit_{limit} {}

    constexpr duration limit() const { return limit_; }
    constexpr void set_limit(duration limit, instant now) {
        limit_ = limit;
        commanded_at_ = now;
    }
    constexpr bool is_on() const { return is_on_; }
    constexpr void begin(instant now) {
        is_on_ = true;
        commanded_at_ = now;
    }
    constexpr void end() { is_on_ = false; }
    /// The application commands or waits.
    constexpr void note_command(instant now) { commanded_at_ = now; }
    constexpr bool has_run_out(instant now) const {
        return is_on_ && limit_ != duration{} && since(commanded_at_, now) > limit_;
    }

  private:
    duration limit_; // 0: none
    instant commanded_at_{};
    bool is_on_ = false;
};

} // namespace servobus::detail
