// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Positions that do not wrap: a drive's position register of 32 bits is unwrapped into 64 bits of counts, or into
// micrometres that do not drift. Programs that read positions for longer than a register lasts include it.
//
//     constexpr unwrapped across = [] { unwrapped p; p.start(0xFFFF'FFF0u); (void)p.update(0x10); return p; }();
//     static_assert(across.counts() == 32);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/lengths.hpp>
#include <servobus/axis/scale.hpp>
#include <servobus/core/status.hpp>

namespace servobus {

/// A position of 32 bits, unwrapped into 64 bits. Two readings in a row must be less than 2^31 counts apart.
class unwrapped {
  public:
    constexpr unwrapped() = default;
    constexpr explicit unwrapped(count_direction direction) : direction_{direction} {}

    /// Takes `raw` as the register's value of the present position, at first and after the drive has changed it. The
    /// counts so far are kept.
    constexpr void start(std::uint32_t raw) { last_ = raw; }

    /// The forward counts from the last reading to `raw`. They are not added.
    constexpr std::int32_t step_to(std::uint32_t raw) const {
        return static_cast<std::int32_t>(direction_ == count_direction::forward ? raw - last_ : last_ - raw);
    }

    /// Adds the counts from the last reading to `raw`, and returns them.
    constexpr std::int32_t update(std::uint32_t raw) {
        const std::int32_t step = step_to(raw);
        last_ = raw;
        counts_ += step;
        return step;
    }

    /// The forward counts of all steps.
    constexpr std::int64_t counts() const { return counts_; }

  private:
    std::int64_t counts_ = 0;
    std::uint32_t last_ = 0;
    count_direction direction_ = count_direction::forward;
};

/// The same position in micrometres. The rest of each step is carried, so the sum is at most 0.5 um off, whatever the
/// number of steps.
class unwrapped_length {
  public:
    constexpr explicit unwrapped_length(const scale& um_of_count,
                                        count_direction direction = count_direction::forward)
        : um_of_count_{um_of_count}, position_{direction} {}

    /// Takes `raw` as the register's value of the present position. The length so far is kept.
    constexpr void start(std::uint32_t raw) { position_.start(raw); }

    /// Adds the way from the last reading to `raw`.
    /// Errors: out_of_range (a step beyond `most()` of the scale, about 2147 m: nothing is added, `start` again).
    constexpr status update(std::uint32_t raw) {
        const result<std::int32_t> step = um_of_count_.convert(position_.step_to(raw), carry_);
        if (!step) return step.error();
        (void)position_.update(raw);
        um_ += *step;
        return {};
    }

    constexpr micrometres length() const { return micrometres{um_}; }
    constexpr std::int64_t counts() const { return position_.counts(); }

  private:
    scale um_of_count_;
    std::int32_t carry_ = 0;
    unwrapped position_;
    std::int64_t um_ = 0;
};

} // namespace servobus
