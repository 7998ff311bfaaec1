// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the motor of the simulated ZLAC8015D and of the simulated steppers. It computes position, speed
// and current with a fixed tick, in integers, so that a run gives the same values on every machine. Ramps are
// linear where the drive has S-shaped ones. Inertia and friction are those of an unloaded hub motor, assumed
// but plausible.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::sim::detail {

/// The largest r with r * r <= n.
constexpr std::uint64_t square_root(std::uint64_t n) {
    std::uint64_t root = 0;
    for (std::uint64_t bit = std::uint64_t{1} << 62; bit != 0; bit >>= 2) {
        const bool fits = n >= root + bit;
        if (fits) n -= root + bit;
        root = fits ? (root >> 1) + bit : root >> 1;
    }
    return root;
}

constexpr std::int64_t magnitude(std::int64_t v) { return v < 0 ? -v : v; }
constexpr std::int64_t smaller_of(std::int64_t a, std::int64_t b) { return a < b ? a : b; }
constexpr std::int64_t larger_of(std::int64_t a, std::int64_t b) { return a < b ? b : a; }
constexpr std::int64_t within(std::int64_t v, std::int64_t limit) {
    return v > limit ? limit : v < -limit ? -limit : v;
}

/// A motor. Speeds are in 10^-6 r/min, times in us, currents in uA.
class wheel {
  public:
    /// The period of the control loop; a command takes effect in the next tick.
    static constexpr duration tick = microseconds(250);
    static constexpr std::int64_t r_per_min = 1'000'000;

    constexpr std::int64_t position() const { return counts_; }
    constexpr std::int64_t speed() const { return speed_; }
    constexpr std::int64_t current() const { return current_ / 1000; }
    constexpr std::int64_t target() const { return target_; }
    constexpr bool is_moving_to_target() const { return is_moving_to_target_; }
    constexpr bool stands() const { return speed_ == 0; }

    /// Encoder counts per turn, 4 for each encoder line; above 0.
    constexpr void set_counts_per_turn(std::int64_t counts) { counts_per_turn_ = counts; }
    constexpr void set_current_limit(std::int64_t microamperes) { limit_ = 1000 * microamperes; }

    constexpr void move_to(std::int64_t target) {
        target_ = target;
        is_moving_to_target_ = true;
    }
    constexpr void forget_target() {
        target_ = counts_;
        is_moving_to_target_ = false;
    }
    /// Stops the motor at this position.
    constexpr void place(std::int64_t position) {
        target_ = position;
        arrive();
    }
    /// Stops the motor: the shaft is blocked.
    constexpr void block() {
        speed_ = 0;
        current_ = 0;
        is_on_curve_ = false;
    }

    /// One tick without power. `drag` multiplies the friction: 1 for a free shaft, more for shorted phases.
    constexpr void roll(std::int64_t drag) {
        current_ = 0;
        const std::int64_t before = speed_;
        const std::int64_t loss = smaller_of(magnitude(speed_), drag * friction(speed_) / inertia);
        speed_ += speed_ > 0 ? -loss : loss;
        is_slowing_ = is_on_curve_ = false;
        travel(before);
    }

    /// One tick of a ramp to a speed. The acceleration time leads from 0 to the target speed, the
    /// deceleration time from the speed at which slowing began to 0; a time of 0 is a step.
    constexpr void ramp_to(std::int64_t wanted, std::uint32_t acceleration_ms,
                           std::uint32_t deceleration_ms) {
        const std::int64_t before = speed_;
        const bool turns = (speed_ < 0 && wanted > 0) || (speed_ > 0 && wanted < 0);
        const bool slows = turns || magnitude(wanted) < magnitude(speed_);
        if (slows) {
            if (!is_slowing_) slowing_from_ = magnitude(speed_);
            approach_speed(turns ? 0 : wanted, ramp_step(slowing_from_, deceleration_ms));
        } else if (speed_ != wanted) {
            approach_speed(wanted, ramp_step(magnitude(wanted), acceleration_ms));
        }
        is_slowing_ = slows && speed_ != 0 && speed_ != wanted;
        travel(before);
        feel(before);
    }

    /// Follows, for a tick, a ramp that begins anew with each changed speed, at no acceleration. It lasts for its whole
    /// time, to speed up or to slow down, whatever the change is.
    constexpr void curve_to(std::int64_t wanted, std::uint32_t acceleration_ms,
                            std::uint32_t deceleration_ms) {
        const std::int64_t before = speed_;
        const bool turns = (speed_ < 0 && wanted > 0) || (speed_ > 0 && wanted < 0);
        const bool slows = turns || magnitude(wanted) < magnitude(speed_);
        if (!is_on_curve_ || wanted != curve_to_) {
            is_on_curve_ = true;
            curve_from_ = speed_;
            curve_to_ = wanted;
            curve_us_ = 0;
            curve_length_us_ = 1000 * std::int64_t{slows ? deceleration_ms : acceleration_ms};
        }
        curve_us_ = smaller_of(curve_us_ + tick.us, curve_length_us_ + reaction_us);
        speed_ = curve_from_ + part_of_curve(curve_to_ - curve_from_);
        travel(before);
        feel(before);
    }
    /// One tick of the way to the target. The motor accelerates to `fastest` in the acceleration time, slows
    /// down from it in the deceleration time, starts and arrives with `slowest`, and stops exactly on the
    /// target.
    constexpr void approach_target(std::int64_t fastest, std::int64_t slowest, std::uint32_t acceleration_ms,
                                   std::uint32_t deceleration_ms) {
        const std::int64_t before = speed_;
        const std::int64_t ahead = target_ - counts_;
        if (ahead == 0 && part_ == 0 && speed_ == 0) {
            is_moving_to_target_ = false;
            return;
        }
        const std::int64_t direction = ahead > 0 ? 1 : -1; // between two counts the target has been passed
        const std::int64_t left = parts_to(ahead);
        slowest = smaller_of(slowest, fastest);
        const std::int64_t faster = larger_of(1, step_of(fastest, acceleration_ms));
        const std::int64_t slower = larger_of(1, step_of(fastest, deceleration_ms));
        const std::int64_t allowed = larger_of(slowest, allowed_speed(fastest, ahead, deceleration_ms));
        std::int64_t along = speed_ * direction;
        if (along < 0) {
            along = smaller_of(0, along + slower);
        } else if (along > allowed) {
            along = larger_of(allowed, along - slower - slower / 4);
        } else {
            along = smaller_of(allowed, larger_of(along + faster, slowest));
        }
        speed_ = along * direction;
        const bool is_slow = along <= 4 * slower + 2 * slowest;
        if (along > 0 && is_slow && tick_travel(larger_of(0, before * direction) + along) >= left) {
            arrive();
        } else {
            travel(before);
        }
        is_slowing_ = is_on_curve_ = false;
        feel(before);
    }

    /// One tick with a commanded current that changes by `slope` mA/s. 0.3 A balances the friction at
    /// standstill; the current above it accelerates the wheel by 200 r/min a second for each ampere, less the
    /// friction that grows with the speed.
    constexpr void push(std::int64_t wanted, std::uint16_t slope, std::int64_t fastest) {
        const std::int64_t before = speed_;
        const std::int64_t change = std::int64_t{slope} * tick.us; // mA/s * us = nA
        const std::int64_t goal = within(wanted * 1000, limit_);
        current_ += within(goal - current_, change);
        const std::int64_t resistance = friction(speed_);
        const std::int64_t pull = current_ / 1000;
        if (speed_ == 0) {
            const std::int64_t surplus = larger_of(0, magnitude(pull) - resistance);
            speed_ = (pull < 0 ? -surplus : surplus) / inertia;
        } else {
            const std::int64_t net = pull + (speed_ > 0 ? -resistance : resistance);
            speed_ += net / inertia;
            if ((before > 0 && speed_ < 0) || (before < 0 && speed_ > 0)) speed_ = 0;
        }
        speed_ = within(speed_, fastest);
        is_slowing_ = is_on_curve_ = false;
        travel(before);
    }

  private:
    // (10^-6 r/min) * us * counts a turn: this many make a count.
    static constexpr std::int64_t parts_of_count = 60'000'000'000'000;
    static constexpr std::int64_t inertia = 20; // uA that accelerate by 10^-6 r/min in a tick

    // uA that keep the wheel at this speed.
    static constexpr std::int64_t friction(std::int64_t speed) { return 300'000 + magnitude(speed) / 500; }

    static constexpr std::int64_t step_of(std::int64_t change, std::uint32_t time_ms) {
        return time_ms == 0 ? change : change * tick.us / (1000 * std::int64_t{time_ms});
    }

    // From a changed speed to its first effect.
    static constexpr std::int64_t reaction_us = 2000;

    // 10 x^3 - 15 x^4 + 6 x^5: neither speed nor acceleration jumps at its ends.
    constexpr std::int64_t part_of_curve(std::int64_t change) const {
        constexpr std::int64_t one = std::int64_t{1} << 20;
        const std::int64_t gone = larger_of(0, curve_us_ - reaction_us);
        if (gone >= curve_length_us_) return change;
        const std::int64_t x = gone * one / curve_length_us_;
        const std::int64_t cube = x * x / one * x / one;
        const std::int64_t part = cube * (10 * one - 15 * x + 6 * (x * x / one)) / one;
        return change / one * part + change % one * part / one;
    }

    // Carries the remainder to the next tick, so that a ramp takes exactly its time.
    constexpr std::int64_t ramp_step(std::int64_t change, std::uint32_t time_ms) {
        if (time_ms == 0) return 2 * change;
        const std::int64_t whole = change * tick.us + carried_;
        const std::int64_t divisor = 1000 * std::int64_t{time_ms};
        carried_ = whole % divisor;
        return whole / divisor;
    }

    constexpr void approach_speed(std::int64_t wanted, std::int64_t step) {
        speed_ += within(wanted - speed_, step);
    }

    // The distance of a tick at the mean of two speeds, given by their sum, in parts of a count.
    constexpr std::int64_t tick_travel(std::int64_t sum) const {
        return sum * counts_per_turn_ / 2 * static_cast<std::int64_t>(tick.us);
    }

    constexpr void travel(std::int64_t before) {
        part_ += tick_travel(before + speed_);
        std::int64_t whole = part_ / parts_of_count;
        if (part_ % parts_of_count < 0) --whole;
        counts_ += whole;
        part_ -= whole * parts_of_count;
    }

    constexpr void arrive() {
        counts_ = target_;
        part_ = 0;
        speed_ = 0;
        is_moving_to_target_ = false;
    }

    // Above 100 000 counts the exact value does not matter: no tick covers as much.
    constexpr std::int64_t parts_to(std::int64_t ahead) const {
        if (magnitude(ahead) > 100'000) return 100'000 * parts_of_count;
        return magnitude(ahead * parts_of_count - part_);
    }

    // The speed from which the deceleration ends at the target: v^2 = 2 a s, with s in 10^-3 r/min * ms.
    constexpr std::int64_t allowed_speed(std::int64_t fastest, std::int64_t ahead,
                                         std::uint32_t time_ms) const {
        if (time_ms == 0) return fastest;
        const std::int64_t exact = parts_to(ahead) / counts_per_turn_ / 1'000'000;
        const std::int64_t rough =
            smaller_of(magnitude(ahead), 1'000'000'000) * 60'000'000 / counts_per_turn_;
        const std::int64_t distance =
            smaller_of(magnitude(ahead) > 100'000 ? rough : exact, 1'000'000'000'000);
        const std::int64_t square = 2 * (fastest / 1000) * distance / std::int64_t{time_ms};
        const auto root = static_cast<std::int64_t>(square_root(static_cast<std::uint64_t>(square)));
        return smaller_of(fastest, 1000 * root);
    }

    // Computes the current of a controlled change of speed.
    constexpr void feel(std::int64_t before) {
        const std::int64_t turning = speed_ == 0 ? 0 : speed_ > 0 ? friction(speed_) : -friction(speed_);
        current_ = within(1000 * ((speed_ - before) * inertia + turning), limit_);
    }

    std::int64_t counts_ = 0;
    std::int64_t part_ = 0; // of a count, 0 .. parts_of_count - 1
    std::int64_t speed_ = 0;
    std::int64_t current_ = 0; // nA
    std::int64_t limit_ = 30'000'000'000;
    std::int64_t target_ = 0;
    std::int64_t counts_per_turn_ = 4096;
    std::int64_t slowing_from_ = 0;
    std::int64_t carried_ = 0;
    std::int64_t curve_from_ = 0;
    std::int64_t curve_to_ = 0;
    std::int64_t curve_us_ = 0; // since its change
    std::int64_t curve_length_us_ = 0;
    bool is_on_curve_ = false;
    bool is_slowing_ = false;
    bool is_moving_to_target_ = false;
};

} // namespace servobus::sim::detail
