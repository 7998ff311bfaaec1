// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: homing of a simulated YAKOTEC stepper as a sequence of legs: the direction and speed of the
// motor, and what ends each leg. From appendix 1 of the manual V2.6.0: its steps for methods 1..14 and 17..30
// follow from five properties of each method; which legs are fast or slow is the vendor's.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/device/yako/homing.hpp>

namespace servobus::sim::detail {

/// What a homing method searches for.
struct yako_homing_plan {
    enum class signal : std::uint8_t { none, negative_limit, positive_limit, home, collision };

    signal from = signal::none; ///< what ends the search
    int first = 0;              ///< direction of the search
    int last = 0;               ///< direction of the approach to home
    bool is_rising = false;     ///< home is the edge where the switch becomes active
    bool reverses = false;      ///< the search reverses at a limit
    bool has_index = false;     ///< home is the first index pulse after the edge
};

constexpr yako_homing_plan plan_of(servobus::yako::homing method) {
    using enum yako_homing_plan::signal;
    constexpr std::array<yako_homing_plan, 15> edges{{
        {},
        {negative_limit, -1, 1, false, false}, // 1, 17
        {positive_limit, 1, -1, false, false},
        {home, 1, -1, false, false},
        {home, 1, 1, true, false},
        {home, -1, 1, false, false},
        {home, -1, -1, true, false},
        {home, 1, -1, false, true}, // 7, 23
        {home, 1, 1, true, true},
        {home, 1, -1, true, true},
        {home, 1, 1, false, true},
        {home, -1, 1, false, true}, // 11, 27
        {home, -1, -1, true, true},
        {home, -1, 1, true, true},
        {home, -1, -1, false, true},
    }};
    const int n = number_of(method);
    if (n >= 1 && n <= 14) {
        yako_homing_plan plan = edges[static_cast<std::size_t>(n)];
        plan.has_index = true;
        return plan;
    }
    if (n >= 17 && n <= 30) return edges[static_cast<std::size_t>(n - 16)];
    switch (n) {
    case 33: return {none, -1, -1, false, false, true};
    case 34: return {none, 1, 1, false, false, true};
    case -1: return {collision, -1, 1, false, false, true};
    case -2: return {collision, 1, -1, false, false, true};
    case -3: return {collision, -1, -1, false, false, false};
    case -4: return {collision, 1, 1, false, false, false};
    default: return {};
    }
}

/// A homing in progress. The drive turns the motor by `direction` and reports each pulse that it passes.
class yako_homing {
  public:
    using signal = yako_homing_plan::signal;

    constexpr void begin(servobus::yako::homing method, bool is_active) {
        plan_ = plan_of(method);
        was_active_ = is_active;
        is_stopping_ = has_reversed_ = false;
        if (plan_.from == signal::collision) return enter(leg::search, plan_.first, true);
        if (plan_.from == signal::none) return enter(leg::index, plan_.first, false);
        if (is_active && plan_.is_rising) return enter(leg::leave, -plan_.last, is_direct());
        if (is_active || is_direct()) return enter(leg::last, plan_.last, false);
        enter(leg::search, plan_.first, true);
    }

    /// True for the method that takes the current position as home.
    constexpr bool is_at_home() const { return plan_.first == 0; }
    constexpr signal from() const { return plan_.from; }
    /// The direction to turn in, 1 or -1; 0 means slow down to standstill.
    constexpr int direction() const { return is_stopping_ ? 0 : direction_; }
    /// The direction in which the motor ran last.
    constexpr int heading() const { return direction_; }
    constexpr bool is_fast() const { return is_fast_; }
    constexpr bool is_colliding() const { return plan_.from == signal::collision && leg_ == leg::search; }
    /// True if the limit in this direction is the signal of the search, or if a leg is stopping: then the
    /// limit does not stop the homing.
    constexpr bool expects_limit(int direction) const {
        if (is_stopping_) return true;
        return (direction < 0 && plan_.from == signal::negative_limit) ||
               (direction > 0 && plan_.from == signal::positive_limit);
    }
    constexpr bool turns_at_limit() const { return plan_.reverses && leg_ == leg::search && !has_reversed_; }

    constexpr void turn() {
        has_reversed_ = true;
        stop_for(leg::search, -direction_, true);
    }
    /// Begins the next leg: the motor is at rest.
    constexpr void stood() {
        is_stopping_ = false;
        enter(next_leg_, next_direction_, next_is_fast_);
    }
    /// Reports that the shaft is at the hard stop. True if that is home.
    constexpr bool collide() {
        if (!plan_.has_index) return true;
        enter(leg::index, plan_.last, false);
        return false;
    }
    /// Reports a pulse that was passed, and the state of the switch there. True if it is home.
    constexpr bool pass(bool is_active, bool is_index) {
        const bool rose = is_active && !was_active_;
        const bool fell = !is_active && was_active_;
        was_active_ = is_active;
        if (is_stopping_) return false;
        switch (leg_) {
        case leg::search:
            if (rose) end_search();
            return false;
        case leg::leave:
            if (fell) stop_for(leg::last, plan_.last, false);
            return false;
        case leg::last:
            if (!(plan_.is_rising ? rose : fell)) return false;
            leg_ = leg::index;
            return !plan_.has_index;
        case leg::index: return is_index;
        }
        return false;
    }

  private:
    enum class leg : std::uint8_t { search, leave, last, index };

    // Methods 4, 6, 20 and 22 search for their edge at the slow speed all the way.
    constexpr bool is_direct() const { return plan_.is_rising && !plan_.reverses; }
    constexpr void end_search() {
        const bool is_on_the_way = direction_ == plan_.last;
        if (plan_.is_rising) {
            is_on_the_way ? stop_for(leg::leave, -plan_.last, false) : enter(leg::leave, direction_, false);
        } else {
            is_on_the_way ? enter(leg::last, direction_, false) : stop_for(leg::last, plan_.last, false);
        }
    }
    constexpr void enter(leg l, int direction, bool is_fast) {
        leg_ = l;
        direction_ = direction;
        is_fast_ = is_fast;
    }
    constexpr void stop_for(leg l, int direction, bool is_fast) {
        is_stopping_ = true;
        next_leg_ = l;
        next_direction_ = direction;
        next_is_fast_ = is_fast;
    }

    yako_homing_plan plan_{};
    int direction_ = 0;
    int next_direction_ = 0;
    leg leg_ = leg::search;
    leg next_leg_ = leg::search;
    bool is_fast_ = false;
    bool next_is_fast_ = false;
    bool is_stopping_ = false;
    bool has_reversed_ = false;
    bool was_active_ = false;
};

} // namespace servobus::sim::detail
