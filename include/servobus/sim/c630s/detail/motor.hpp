// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the motor of the simulated C630S: position and speed of a shaft with a fixed tick, in integers,
// so that a run gives the same values on every machine. Inertia and friction are assumed but plausible: rated
// torque accelerates the unloaded motor to 3000 r/min in 0.1 s.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::sim::detail {

/// A position in encoder counts and a speed in 10^-6 r/min.
class c630s_shaft {
  public:
    static constexpr duration tick = milliseconds(1);
    static constexpr std::int64_t r_per_min = 1'000'000;
    static constexpr std::int64_t counts_per_turn = 131'072; ///< 17 bits

    static constexpr std::int64_t size(std::int64_t v) { return v < 0 ? -v : v; }
    static constexpr std::int64_t lesser(std::int64_t a, std::int64_t b) { return a < b ? a : b; }
    static constexpr std::int64_t greater(std::int64_t a, std::int64_t b) { return a < b ? b : a; }
    static constexpr std::int64_t between(std::int64_t low, std::int64_t v, std::int64_t high) {
        return v < low ? low : v > high ? high : v;
    }

    constexpr std::int64_t position() const { return counts_; }
    constexpr std::int64_t speed() const { return speed_; }
    constexpr bool stands() const { return speed_ == 0; }

    /// Sets the position, at standstill.
    constexpr void place(std::int64_t counts) {
        counts_ = counts;
        part_ = 0;
        speed_ = 0;
    }
    constexpr void stop() { speed_ = 0; }

    /// The change of speed in a tick if `ms` milliseconds lead from 0 to 1000 r/min; a time of 0 is a step.
    static constexpr std::int64_t change_of(std::int64_t ms) {
        return ms == 0 ? 20'000 * r_per_min : greater(1, 1000 * r_per_min / ms);
    }

    /// One tick, at the end of which the speed is `speed`.
    constexpr void run_at(std::int64_t speed) {
        travel(speed_ + speed);
        speed_ = speed;
    }
    /// One tick of a ramp to a speed, by at most `faster` or `slower`.
    constexpr void ramp_to(std::int64_t wanted, std::int64_t faster, std::int64_t slower) {
        const bool turns = (speed_ < 0 && wanted > 0) || (speed_ > 0 && wanted < 0);
        const bool slows = turns || size(wanted) < size(speed_);
        const std::int64_t goal = turns ? 0 : wanted;
        const std::int64_t step = slows ? slower : faster;
        run_at(speed_ + between(-step, goal - speed_, step));
    }
    /// One tick of the way to a target, with ramps of `ms` milliseconds for 1000 r/min. True when it has
    /// arrived, exactly on the target.
    constexpr bool approach(std::int64_t target, std::int64_t fastest, std::int64_t ms) {
        const std::int64_t ahead = target - counts_;
        if (ahead == 0 && part_ == 0 && speed_ == 0) return true;
        const std::int64_t direction = ahead > 0 ? 1 : -1; // between two counts the target has been passed
        const std::int64_t change = change_of(ms);
        const std::int64_t slowest = lesser(fastest, r_per_min / 2);
        const std::int64_t allowed = greater(slowest, braking_speed(size(ahead), fastest, ms));
        const std::int64_t before = greater(0, speed_ * direction);
        std::int64_t along = speed_ * direction;
        if (along < 0) {
            along = lesser(0, along + change);
        } else if (along > allowed) {
            along = greater(allowed, along - change - change / 4);
        } else {
            along = lesser(allowed, greater(along + change, slowest));
        }
        const bool is_slow = along <= 4 * change + 2 * slowest;
        if (along > 0 && is_slow && size(ahead) < counts_per_turn * 4 &&
            (before + along) * counts_per_turn >= size(ahead * parts_of_count - part_)) {
            place(target);
            return true;
        }
        run_at(along * direction);
        return false;
    }

  private:
    // The sum of two speeds times the counts of a turn: this many make a count in a tick.
    static constexpr std::int64_t parts_of_count = 120'000'000'000;

    constexpr void travel(std::int64_t sum) {
        part_ += sum * counts_per_turn;
        std::int64_t whole = part_ / parts_of_count;
        if (part_ % parts_of_count < 0) --whole;
        counts_ += whole;
        part_ -= whole * parts_of_count;
    }

    // The speed from which braking ends at the target: v^2 = 2 a s, with v in 10^-3 r/min.
    static constexpr std::int64_t braking_speed(std::int64_t ahead, std::int64_t fastest, std::int64_t ms) {
        if (ms == 0) return fastest;
        const std::int64_t distance = lesser(lesser(ahead, 8'000'000'000) * 60'000'000 / counts_per_turn,
                                             4'000'000'000'000); // 10^-3 r/min * ms
        const std::int64_t square = 2 * distance * 1'000'000 / ms;
        std::int64_t low = 0;
        std::int64_t high = 20'000'000;
        while (low < high) {
            const std::int64_t middle = (low + high + 1) / 2;
            if (middle * middle <= square) {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        return lesser(fastest, 1000 * low);
    }

    std::int64_t counts_ = 0;
    std::int64_t part_ = 0; // of a count, 0 .. parts_of_count - 1
    std::int64_t speed_ = 0;
};

/// The motor: a shaft with torque. Torques are in 0.1 % of the rated torque.
class c630s_motor {
  public:
    using shaft = c630s_shaft;

    constexpr std::int64_t position() const { return shaft_.position(); }
    constexpr std::int64_t speed() const { return shaft_.speed(); }
    constexpr std::int64_t torque() const { return torque_; }
    constexpr bool stands() const { return shaft_.stands(); }
    constexpr void block(bool is_blocked) { is_blocked_ = is_blocked; }
    constexpr bool is_limited() const { return is_limited_; }
    /// Sets the torque limits of both directions; neither is below 0.
    constexpr void set_limits(std::int64_t forward, std::int64_t reverse) {
        forward_ = forward;
        reverse_ = reverse;
    }

    /// One tick without power; `drag` multiplies the friction.
    constexpr void coast(std::int64_t drag) {
        torque_ = 0;
        is_limited_ = false;
        const std::int64_t loss = shaft::lesser(shaft::size(speed()), drag * resistance(speed()) * gain);
        move(speed() + (speed() > 0 ? -loss : loss));
    }
    /// One tick of a ramp to a speed, by at most `faster` or `slower` and within the torque limits.
    constexpr void ramp_to(std::int64_t wanted, std::int64_t faster, std::int64_t slower) {
        shaft ideal = shaft_;
        ideal.ramp_to(wanted, faster, slower);
        take(ideal.speed());
    }
    /// One tick with a commanded torque, within the speed limits.
    constexpr void push(std::int64_t wanted, std::int64_t forward_limit, std::int64_t reverse_limit) {
        const std::int64_t drive = shaft::between(-reverse_, wanted, forward_);
        const std::int64_t before = speed();
        const std::int64_t friction = resistance(before);
        std::int64_t after = before;
        if (before == 0) {
            const std::int64_t surplus = shaft::greater(0, shaft::size(drive) - friction);
            after = (drive < 0 ? -surplus : surplus) * gain;
        } else {
            after += (drive + (before > 0 ? -friction : friction)) * gain;
            if ((before > 0 && after < 0) || (before < 0 && after > 0)) after = 0;
        }
        // Above a speed limit it slows down to the limit, with at most half the rated torque.
        const std::int64_t brake = 500 * gain;
        if (after > forward_limit) after = shaft::greater(forward_limit, before - brake);
        if (after < -reverse_limit) after = shaft::lesser(-reverse_limit, before + brake);
        move(after);
        torque_ = drive;
        is_limited_ = drive != wanted;
    }
    /// One tick in which it follows a commanded shaft, at most at the speed `fastest`.
    constexpr void follow(const shaft& commanded, std::int64_t fastest) {
        if (is_blocked_) {
            const bool pulls = commanded.position() != position();
            const bool forward = commanded.position() > position();
            torque_ = !pulls ? 0 : forward ? forward_ : -reverse_;
            is_limited_ = pulls;
            shaft_.stop();
            return;
        }
        const std::int64_t behind = commanded.position() - position();
        const std::int64_t reach = fastest * shaft::counts_per_turn / 60'000'000'000 + 1;
        const std::int64_t before = speed();
        if (shaft::size(behind) <= reach) {
            shaft_ = commanded;
        } else {
            shaft_.run_at(behind > 0 ? fastest : -fastest);
        }
        feel(before);
    }

  private:
    static constexpr std::int64_t gain = 30'000; // change of speed a tick for 0.1 % of torque

    // Friction torque: 2 %, and a part that grows with the speed, 6 % at 3000 r/min.
    static constexpr std::int64_t resistance(std::int64_t speed) {
        return 20 + shaft::size(speed) / (50 * shaft::r_per_min);
    }

    constexpr void move(std::int64_t speed) {
        if (is_blocked_) {
            shaft_.stop();
        } else {
            shaft_.run_at(speed);
        }
    }
    constexpr void feel(std::int64_t before) {
        const std::int64_t friction = speed() == 0  ? 0
                                      : speed() > 0 ? resistance(speed())
                                                    : -resistance(speed());
        torque_ = shaft::between(-reverse_, (speed() - before) / gain + friction, forward_);
        is_limited_ = false;
    }
    // One tick to the speed `wanted`, as far as the torque limits allow.
    constexpr void take(std::int64_t wanted) {
        const std::int64_t before = speed();
        const std::int64_t friction = before == 0 ? 0 : before > 0 ? resistance(before) : -resistance(before);
        const std::int64_t needed = (wanted - before) / gain + friction;
        const std::int64_t given = shaft::between(-reverse_, needed, forward_);
        is_limited_ = given != needed;
        if (is_blocked_) {
            torque_ = wanted == 0 ? 0 : wanted > 0 ? forward_ : -reverse_;
            is_limited_ = wanted != 0;
            shaft_.stop();
            return;
        }
        torque_ = given;
        std::int64_t after = is_limited_ ? before + (given - friction) * gain : wanted;
        if ((before > 0 && after < 0) || (before < 0 && after > 0)) after = 0;
        shaft_.run_at(after);
    }

    shaft shaft_{};
    std::int64_t torque_ = 0;
    std::int64_t forward_ = 3000;
    std::int64_t reverse_ = 3000;
    bool is_blocked_ = false;
    bool is_limited_ = false;
};

} // namespace servobus::sim::detail
