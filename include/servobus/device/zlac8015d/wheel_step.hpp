// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: tells whether a wheel's way from one feedback to the next is what its speeds say, which shows a restart of
// the drive, and a steady way through lost responses. zlac8015d/robot.hpp includes it.
//
//     constexpr zlac8015d::wheel_image before{.position = 640, .speed = 600}; // 60 r/min
//     constexpr zlac8015d::wheel_step slow{before, {722, 600}, milliseconds(20), 4096};
//     constexpr zlac8015d::wheel_step restarted{before, {80, 600}, milliseconds(20), 4096};
//     static_assert(slow.is_steady() && restarted.is_odd() && restarted.may_come_from_zero());
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::zlac8015d {

/// A wheel in a feedback: its counts, 20A7h or 20A9h, and its speed in 0.1 r/min, 20ABh or 20ACh.
struct wheel_image {
    std::uint32_t position = 0;
    std::int16_t speed = 0;
};

/// A wheel's way between two feedbacks, beside what its speeds in both of them allow. A servo trembles by 5 counts.
class wheel_step {
  public:
    constexpr wheel_step(const wheel_image& before, const wheel_image& now, duration between,
                         std::uint32_t counts_per_turn)
        : moved_{static_cast<std::int32_t>(now.position - before.position)},
          there_{static_cast<std::int32_t>(now.position)}, from_{way(before.speed, between, counts_per_turn)},
          to_{way(now.speed, between, counts_per_turn)}, change_{now.speed - before.speed} {}

    /// Less or more than by the lower or the higher of its speeds, and a quarter.
    constexpr bool is_odd() const {
        const std::int32_t slack = (farthest() >> 2) + 5;
        return moved_ < (from_ < to_ ? from_ : to_) - slack || moved_ > (from_ < to_ ? to_ : from_) + slack;
    }
    /// By its speed, which is the same in both, within 2 r/min and a sixteenth of the way.
    constexpr bool is_steady() const {
        const std::int32_t off = 2 * moved_ - from_ - to_;
        const std::int32_t slack = (farthest() >> 3) + 10;
        return change_ <= 20 && change_ >= -20 && off <= slack && off >= -slack;
    }
    /// It may have been at zero between the two.
    constexpr bool may_come_from_zero() const {
        const std::int32_t most = farthest() + (farthest() >> 2) + 5;
        return there_ <= most && there_ >= -most;
    }

  private:
    constexpr std::int32_t farthest() const {
        const std::int32_t a = from_ < 0 ? -from_ : from_, b = to_ < 0 ? -to_ : to_;
        return a < b ? b : a;
    }
    // The counts in a time at a speed: at most 4 s, as 1024 us; 1 / 600 000 is 7 / 2^22.
    static constexpr std::int32_t way(std::int16_t tenths, duration in, std::uint32_t counts_per_turn) {
        const auto ms = static_cast<std::int32_t>(in.us >> 22 != 0 ? 4096u : in.us >> 10);
        const std::int64_t turns = tenths * ms >> 6;
        return static_cast<std::int32_t>(turns * counts_per_turn * 7 >> 16);
    }

    std::int32_t moved_;
    std::int32_t there_;
    std::int32_t from_; ///< by the speed before
    std::int32_t to_;   ///< by the speed now
    std::int32_t change_;
};

} // namespace servobus::zlac8015d
