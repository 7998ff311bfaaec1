// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: a wheel's way from one feedback to the next, and the speeds that both show. Together they bound how
// far the wheel was from a steady way, and show that the drive may have restarted.
// zlac8015d/robot_model.hpp includes it.
//
//     constexpr zlac8015d::wheel_image before{.position = 640, .speed = 600}; // 60 r/min
//     constexpr zlac8015d::wheel_step even{before, {722, 600}, milliseconds(20), 4096};
//     constexpr zlac8015d::wheel_step restarted{before, {70, 600}, milliseconds(20), 4096};
//     static_assert(even.excess() == 0 && even.bow() == 0);
//     static_assert(restarted.excess() > 80 && restarted.may_come_from_zero(0));
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::zlac8015d {

/// A wheel in a feedback: its counts, 20A7h or 20A9h, and its speed in 0.1 r/min, 20ABh or 20ACh.
struct wheel_image {
    std::uint32_t position = 0;
    std::int16_t speed = 0;
};

/// A wheel's way between two feedbacks, in counts, and the ways in that time at both speeds. A servo trembles by
/// 5 counts.
class wheel_step {
  public:
    constexpr wheel_step(const wheel_image& before, const wheel_image& now, duration between,
                         std::uint32_t counts_per_turn)
        : moved_{static_cast<std::int32_t>(now.position - before.position)}, there_{static_cast<std::int32_t>(
                                                                                 now.position)},
          from_{way(before.speed, between, counts_per_turn)}, to_{way(now.speed, between, counts_per_turn)} {}

    /// True if the wheel was at rest in both, where it was.
    constexpr bool is_at_rest() const { return farthest() <= 5; }
    /// Bounds how far the wheel was from a steady way, as a mean over the time: by its change from one speed to the
    /// other at any moment, and by what its way has more or less than both speeds allow.
    constexpr std::int32_t bow() const { return (magnitude(to_ - from_) >> 3) + ((excess() + 1) >> 1); }
    /// How much more or less the way is than both speeds allow.
    constexpr std::int32_t excess() const {
        const std::int32_t low = from_ < to_ ? from_ : to_, high = from_ < to_ ? to_ : from_;
        return moved_ < low ? low - moved_ : moved_ > high ? moved_ - high : 0;
    }
    /// The longest of the way and of those by both speeds.
    constexpr std::int32_t farthest() const {
        const std::int32_t moved = magnitude(moved_), by_speed = fastest();
        return moved < by_speed ? by_speed : moved;
    }
    /// True if the wheel may have been at zero between the two. `swing`: that of this time.
    constexpr bool may_come_from_zero(std::int32_t swing) const {
        const std::int32_t most = fastest() + (fastest() >> 2) + 5 + 16 * swing;
        return there_ <= most && there_ >= -most;
    }

    /// Bounds the bow of a wheel that changes its speed by at most `tenths` of 0.1 r/min in a millisecond. At the end
    /// it has its speed again: for a quarter of the time it is faster, for half of it slower, and a quarter faster.
    /// The first setpoint may change the speed for the time of a `step` before.
    static constexpr std::int32_t swing(std::uint8_t tenths, duration in, std::uint32_t counts_per_turn,
                                        duration step = {}) {
        const std::uint32_t change = tenths * (at_most_4_s(in + step) * 67 >> 16); // ms, 2 % too many
        const auto faster = static_cast<std::int16_t>(change < 32'767 ? change : 32'767);
        return (way(faster, in, counts_per_turn) + 31) >> 5;
    }

  private:
    static constexpr std::int32_t magnitude(std::int32_t v) { return v < 0 ? -v : v; }
    constexpr std::int32_t fastest() const {
        const std::int32_t a = magnitude(from_), b = magnitude(to_);
        return a < b ? b : a;
    }
    static constexpr std::uint32_t at_most_4_s(duration d) {
        return d.us >> 22 != 0 ? std::uint32_t{1} << 22 : d.us;
    }
    // The counts in a time at a speed: tenths * us * counts / 600 000 000. 2^12 / 600 000 000 is 58 641 / 2^33.
    static constexpr std::int32_t way(std::int16_t tenths, duration in, std::uint32_t counts_per_turn) {
        const std::int64_t parts = std::int64_t{tenths} * at_most_4_s(in) * counts_per_turn >> 12;
        return static_cast<std::int32_t>((parts * 58'641 + (std::int64_t{1} << 32)) >> 33);
    }

    std::int32_t moved_;
    std::int32_t there_;
    std::int32_t from_; ///< by the speed before
    std::int32_t to_;   ///< by the speed now
};

} // namespace servobus::zlac8015d
