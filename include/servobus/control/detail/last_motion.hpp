// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The last motion of a drive: since when it is under way, and why the drive stopped following it.
#pragma once

#include <servobus/control/states.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

class last_motion {
  public:
    constexpr stop_cause cause() const { return cause_; }
    constexpr void set_cause(stop_cause c) { cause_ = c; }
    /// The first cause counts.
    constexpr void note_cause(stop_cause c) {
        if (cause_ == stop_cause::unknown) cause_ = c;
    }
    /// Its command ends, or has sent its start.
    constexpr void note_motion(instant now) {
        moved_at_ = now;
        is_image_of_motion_ = false;
    }
    /// An image has come, of the motion or of after it.
    constexpr void note_image(instant now) {
        is_image_of_motion_ = true;
        if (since(moved_at_, now) > long_ago + long_ago) moved_at_ = instant{now.us - long_ago.us};
    }
    /// From the start of the last motion to the image that was `taken` then; zero for an image that is older. It goes
    /// back from two minutes to one: times are not compared over a wrap of the clock.
    constexpr duration since_start(instant taken) const {
        return is_image_of_motion_ && !went_back(moved_at_, taken) ? since(moved_at_, taken) : duration{};
    }

  private:
    static constexpr duration long_ago = milliseconds(60'000);

    instant moved_at_{}; // when the last motion command ended
    stop_cause cause_ = stop_cause::unknown;
    bool is_image_of_motion_ = false; // the image was read after the last motion command
};

} // namespace servobus::detail
