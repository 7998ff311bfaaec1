// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the axis of a simulated YAKOTEC stepper: the commanded position, the shaft that follows it unless
// it is blocked, and the drive's position count. Positions of the machine are pulses, positive as 0010h = 0
// turns the motor; positions of the program count from the program's zero and in its direction.
#pragma once

#include <cstdint>

#include <servobus/sim/detail/wheel.hpp>
#include <servobus/sim/yako/machine.hpp>

namespace servobus::sim::detail {

class yako_axis {
  public:
    constexpr explicit yako_axis(bool has_encoder) : has_encoder_{has_encoder} {}

    // The machine

    constexpr void attach(const yako_machine& m) { machine_ = m; }
    constexpr yako_geometry geometry() const { return {machine_, pulses_per_turn_}; }
    constexpr std::int64_t shaft() const { return shaft_; }
    constexpr std::int64_t shaft_before() const { return shaft_before_; }
    /// The commanded position minus the actual one.
    constexpr std::int64_t following_error() const { return motor_.position() - shaft_; }
    constexpr void block(bool is_blocked) { is_blocked_ = is_blocked; }
    /// Turns the shaft by external force.
    constexpr void push(std::int64_t pulses) { shaft_ = shaft_before_ = geometry().allowed(shaft_ + pulses); }

    // The program's view

    constexpr std::int64_t position() const { return sign_ * (counted() - zero_); }
    constexpr void set_position(std::int64_t value) { zero_ = counted() - sign_ * value; }
    /// Converts a position of the program to one of the machine.
    constexpr std::int64_t place_of(std::int64_t position) const { return zero_ + sign_ * position; }
    constexpr std::int64_t commanded() const { return motor_.position(); }
    constexpr int sign() const { return sign_; }
    /// The speed in 10^-6 r/min in the program's direction: the actual one with an encoder, otherwise the
    /// commanded one.
    constexpr std::int64_t speed() const {
        if (has_encoder_) return is_stuck_ ? 0 : sign_ * motor_.speed();
        return is_rolling_ ? 0 : sign_ * motor_.speed();
    }
    constexpr bool stands() const { return motor_.stands(); }

    /// Applies the settings; the program's position keeps its value.
    constexpr void adopt(bool is_reversed, std::int64_t pulses_per_turn) {
        const std::int64_t shown = position();
        if (pulses_per_turn != pulses_per_turn_) {
            const std::int64_t error = following_error();
            shaft_ = shaft_before_ = shaft_ * pulses_per_turn / pulses_per_turn_;
            motor_.place(shaft_ + error * pulses_per_turn / pulses_per_turn_);
            motor_.set_counts_per_turn(pulses_per_turn);
            pulses_per_turn_ = pulses_per_turn;
        }
        sign_ = is_reversed ? -1 : 1;
        set_position(shown);
    }
    constexpr bool agrees(bool is_reversed, std::int64_t pulses_per_turn) const {
        return is_reversed == (sign_ < 0) && pulses_per_turn == pulses_per_turn_;
    }

    /// Powers the motor: with an encoder its position becomes the commanded position.
    constexpr void energise() {
        motor_.place(has_encoder_ ? shaft_ : motor_.position());
        is_rolling_ = false;
    }
    constexpr void switch_on(bool keeps_place) {
        const std::int64_t shown = keeps_place ? position() : 0;
        motor_.place(shaft_);
        set_position(shown);
        is_rolling_ = is_stuck_ = false;
    }

    // Motion, one tick each

    constexpr void halt() { motor_.place(motor_.position()); }
    /// Stops the shaft at this position of the machine.
    constexpr void halt_at(std::int64_t place) {
        motor_.place(has_encoder_ ? place : place + following_error());
        shaft_ = shaft_before_ = place;
    }
    constexpr void aim(std::int64_t place) { motor_.move_to(place); }
    constexpr bool has_arrived() const { return !motor_.is_moving_to_target(); }
    constexpr std::int64_t way_to_go() const { return sign_ * (motor_.target() - motor_.position()); }
    constexpr void forget_target() { motor_.forget_target(); }

    constexpr void approach(std::int64_t fastest, std::int64_t slowest, std::uint32_t acceleration_ms,
                            std::uint32_t deceleration_ms) {
        const std::int64_t before = motor_.position();
        motor_.approach_target(fastest, slowest, acceleration_ms, deceleration_ms);
        follow(before);
    }
    constexpr void ramp_to(std::int64_t speed, std::uint32_t acceleration_ms, std::uint32_t deceleration_ms) {
        const std::int64_t before = motor_.position();
        motor_.ramp_to(sign_ * speed, acceleration_ms, deceleration_ms);
        follow(before);
    }
    constexpr void hold() { follow(motor_.position()); }
    /// One tick without power. An open loop does not count this motion.
    constexpr void roll() {
        const std::int64_t before = motor_.position();
        motor_.roll(1);
        const std::int64_t wanted = shaft_ + motor_.position() - before;
        shaft_before_ = shaft_;
        shaft_ = is_blocked_ ? shaft_ : geometry().allowed(wanted);
        if (shaft_ != wanted) motor_.block();
        if (!has_encoder_) zero_ += motor_.position() - before;
        is_rolling_ = true;
    }

  private:
    constexpr std::int64_t counted() const { return has_encoder_ ? shaft_ : motor_.position(); }

    constexpr void follow(std::int64_t before) {
        const std::int64_t commanded = motor_.position() - before;
        const std::int64_t most = larger_of(magnitude(commanded), fastest_return());
        const std::int64_t step = has_encoder_ ? within(following_error(), most) : commanded;
        shaft_before_ = shaft_;
        const std::int64_t place = geometry().allowed(shaft_ + step);
        if (!is_blocked_) shaft_ = place;
        is_stuck_ = step != 0 && shaft_ == shaft_before_;
        is_rolling_ = false;
    }
    // Pulses in a tick at 3000 r/min.
    constexpr std::int64_t fastest_return() const { return 1 + pulses_per_turn_ / 80; }

    wheel motor_ = [] {
        wheel w;
        w.set_counts_per_turn(1000);
        return w;
    }();
    yako_machine machine_ = yako_machine::none();
    std::int64_t shaft_ = 0;
    std::int64_t shaft_before_ = 0; // one tick before
    std::int64_t zero_ = 0;
    std::int64_t pulses_per_turn_ = 1000;
    int sign_ = 1;
    bool has_encoder_;
    bool is_blocked_ = false;
    bool is_stuck_ = false;
    bool is_rolling_ = false;
};

} // namespace servobus::sim::detail
