// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the last motion that was commanded, by the feedback before and after its start: has
// it begun, where has it come to, has a homing found home. A drive may acknowledge a start that it does not
// carry out (manual V2.6.0, section 4.1). yako/model.hpp includes it.
//
//     const yako::arrival came = axis.arrival();
//     if (came.how != arrival_state::reached) std::printf("%d pulses missing\n", int(came.missing.count()));
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/image.hpp>
#include <servobus/control/states.hpp>
#include <servobus/device/yako/feedback.hpp>

namespace servobus::yako {

/// Where the last move has come to.
struct [[nodiscard]] arrival {
    arrival_state how = arrival_state::none;
    stop_cause cause = stop_cause::unknown; ///< why it `stopped_short`
    distance missing{};                     ///< from the motor's position to its target

    /// At rest at its target.
    constexpr explicit operator bool() const { return how == arrival_state::reached; }
};

/// `w`: the words of the feedback. `since_start`: of these, after the start was acknowledged; it may go back from two
/// minutes to one.
template <class Device> class motion_under_way {
    using feedback = basic_feedback<Device>;
    using settings = cached_settings;
    static constexpr std::int32_t stillness = detail::is_closed_loop<Device> ? 5 : 0;

  public:
    static constexpr motion_status status_of(const std::uint16_t* w) {
        return motion_status::from_word(w[routines::status_at]);
    }
    static constexpr distance position_in(const std::uint16_t* w, const cached_settings& known) {
        return feedback::position_in({w, 7}, known.word_order);
    }
    static constexpr bool is_at_zero(const std::uint16_t* w, const cached_settings& known) {
        return is_within(position_in(w, known));
    }
    /// Whether the position is nearer to zero than the speed of either image and the time `between` them allow. The
    /// speed counts 1 or 0.1 r/min, and 0011h the pulses of a turn.
    static constexpr bool is_fall(const std::uint16_t* before, const std::uint16_t* now, duration between,
                                  const cached_settings& known) {
        const std::uint32_t counted =
            largest(static_cast<std::int16_t>(before[6]), static_cast<std::int16_t>(now[6]));
        const std::uint32_t turns =
            known.resolution == speed_count::tenth_r_per_min ? (counted * 13u >> 7) + 1u : counted;
        // Of 256 us, at most 4 s.
        const std::uint32_t parts = between.us >> 22 != 0 ? 16'384u : between.us >> 8;
        const std::uint32_t way =
            (turns * known.microsteps >> 10) * parts >> 8; // 60000 for 65536, and 1000 for 1024:
        const std::uint32_t then = magnitude(position_in(before, known).count());
        const std::uint32_t there = magnitude(position_in(now, known).count());
        // A quarter more is enough. Where a restart puts it, all but a trembling raises a suspicion.
        const std::uint32_t allowed = there <= 32u ? 5u : way + (way >> 2) + 32u;
        return then > there && then - there > allowed;
    }

    constexpr motion_check seen() const { return seen_; }
    /// Why the last move has stopped short, as far as its inputs and its software limits say.
    constexpr stop_cause cause() const { return cause_; }
    constexpr bool has_goal() const { return has_goal_; }
    /// A move to a place, and no jog and no homing.
    constexpr bool is_positioning() const { return is_positioning_; }

    /// Another one is commanded.
    constexpr void ask() { seen_ = motion_check::not_asked; }
    constexpr void note(motion_check what) { seen_ = what; }
    /// No bounded jog or hold is under way any more.
    constexpr void end_creep() { is_creeping_ = false; }
    constexpr void drop_goal() {
        has_goal_ = false;
        cause_ = stop_cause::unknown;
    }
    constexpr void forget() {
        is_creeping_ = false;
        drop_goal();
    }
    /// The move has stopped short. `words`: the feedback, and the functions of the inputs. An input that is active no
    /// more leaves the cause unknown.
    constexpr void examine(slice<const std::uint16_t> words) {
        const motion_status s = status_of(words.data());
        if (s.is_beyond_positive_limit() || s.is_beyond_negative_limit()) cause_ = stop_cause::software_limit;
        for (std::size_t i = 0; i < input_count; ++i) {
            const auto f = static_cast<input_function>(words[routines::functions_word + i]);
            const bool stops = (f >= input_function::positive_limit && f <= input_function::emergency_stop);
            if (stops && (words[routines::inputs_at] >> i & 1u) != 0) cause_ = stop_cause::input;
        }
    }
    constexpr void begin(const prepared_command& c, const std::uint16_t* w, const settings& known) {
        const motion_status s = status_of(w);
        forget();
        has_begun_ = false;
        moving_until_ = {};
        before_ = position_in(w, known);
        pair_word_order_ = known.word_order;
        was_homed_ = s.is_homed();
        was_moving_ = s.is_moving() && c.then != effect::crept; // a hold has a target all the same
        is_positioning_ = c.then == effect::moved || c.then == effect::crept;
    }
    /// True for a bounded jog or a hold under way in the same direction. The first image that shows it at rest has
    /// ended it.
    constexpr bool goes_on(const prepared_command& c, const std::uint16_t* w) const {
        const auto pace = static_cast<std::int16_t>(w[6]);
        const bool is_opposite = (pace > 0 && c.target < 0) || (pace < 0 && c.target > 0);
        return c.then == effect::crept && is_creeping_ && !is_opposite;
    }

    /// The motion was seen to begin.
    constexpr void keep_goal(const prepared_command& c) {
        // What an interrupting way is counted from is not stated [errata A59].
        has_goal_ = c.has_target && c.aim == nullptr && (c.is_absolute || !was_moving_);
        goal_ = goal_of(c);
        const bool is_up = c.target > 0;
        is_beyond_range_ = !c.is_absolute && (is_up ? goal_ < before_ : before_ < goal_);
    }
    constexpr arrival arrival_of(const std::uint16_t* w, duration since_start, const settings& known) const {
        if (!has_goal_ || known.state == drive_state::needs_init) return {};
        const distance place = position_in(w, known);
        const distance missing = way(place, goal_);
        const bool is_there = is_within(missing);
        // Whether the counter wraps or stops at its end is not stated [errata A61]: the end tells nothing then.
        if (is_beyond_range_ && is_at_end_of_range(place) && !status_of(w).is_moving())
            return {.missing = missing};
        if (status_of(w).is_moving() || (!is_there && since_start < start_limit))
            return {.how = arrival_state::under_way, .missing = missing};
        return {.how = is_there ? arrival_state::reached : arrival_state::stopped_short, .missing = missing};
    }

    constexpr errc confirm_start(const prepared_command& c, const std::uint16_t* w, duration since_start,
                                 settings& known) {
        const distance place = position_in(w, known);
        const bool is_moving = status_of(w).is_moving();
        const bool is_there = is_at_goal(c, place);
        if (!is_moving && is_near(place, before_) && !is_there) {
            if (since_start < start_limit) return errc::busy;
            seen_ = motion_check::not_seen;
            return errc::not_executed;
        }
        // A motion that interrupts another ends at an unknown place.
        if (!is_moving && !was_moving_ && !is_there) {
            if (since_start < start_limit) return errc::busy; // a shaft that still comes to rest
            seen_ = motion_check::unknown;
            if (may_have_restarted(place)) known = {.is_closed_loop = detail::is_closed_loop<Device>};
            return errc::not_reached;
        }
        const bool is_certain = !was_moving_ && (is_moving || !may_have_restarted(place));
        seen_ = is_certain ? motion_check::seen : motion_check::unknown;
        is_creeping_ = c.then == effect::crept && is_moving;
        return errc::ok;
    }

    /// The drive may still say "homed" from the time before, and may rest for a moment between two legs.
    constexpr errc confirm_home(const prepared_command& c, const std::uint16_t* w, duration since_start,
                                const settings& known) {
        const motion_status s = status_of(w);
        const distance place = position_in(w, known);
        if (s.is_moving() || !is_near(place, before_)) has_begun_ = true;
        if (!s.is_homed()) was_homed_ = false;
        if (s.is_moving() || since_start < moving_until_) moving_until_ = since_start;
        const duration at_rest{since_start.us - moving_until_.us};
        const bool is_motionless = c.arguments[1] == static_cast<std::uint16_t>(homing::current_position);
        const bool is_new = !was_homed_ || is_motionless || (has_begun_ && is_at_home(c, place));
        const bool is_found = s.is_homed() && is_new;
        seen_ = has_begun_ ? motion_check::seen : motion_check::not_seen;
        const bool is_there = !c.has_target || is_near(place, goal_of(c));
        const bool may_yet_begin = !is_there && since_start < start_limit;
        if (is_found && at_rest >= steady_time && !may_yet_begin)
            return is_there ? errc::ok : errc::not_executed;
        if (!is_found && !has_begun_ && since_start >= start_limit) return errc::not_executed;
        if (!is_found && has_begun_ && at_rest >= lost_time) return errc::not_reached;
        return errc::busy;
    }
    /// After a start that got no response no setting is valid any more, but the place before it is known.
    constexpr motion_check compared(slice<const std::uint16_t> words) const {
        const distance place = feedback::position_in(words, pair_word_order_);
        if (status_of(words.data()).is_moving()) return motion_check::seen;
        if (may_have_restarted(place)) return motion_check::unknown;
        return is_near(place, before_) ? motion_check::not_seen : motion_check::seen;
    }

  private:
    /// Pulses by which a motor trembles.
    static constexpr bool is_within(distance d) { return d.count() <= stillness && d.count() >= -stillness; }
    static constexpr bool is_near(distance a, distance b) { return is_within(way(a, b)); }
    // Positions are counted modulo 2^32, as by a counter that wraps.
    static constexpr std::uint32_t bits(distance d) { return static_cast<std::uint32_t>(d.count()); }
    static constexpr distance wrapped(std::uint32_t d) { return distance{static_cast<std::int32_t>(d)}; }
    static constexpr distance way(distance from, distance to) { return wrapped(bits(to) - bits(from)); }
    static constexpr bool is_at_end_of_range(distance d) {
        return magnitude(d.count()) >= 0x7FFF'FFFFu - static_cast<std::uint32_t>(stillness);
    }
    static constexpr std::uint32_t magnitude(std::int32_t d) {
        return d < 0 ? 0u - static_cast<std::uint32_t>(d) : static_cast<std::uint32_t>(d);
    }
    static constexpr std::uint32_t largest(std::int16_t a, std::int16_t b) {
        return magnitude(a) < magnitude(b) ? magnitude(b) : magnitude(a);
    }

    static constexpr std::size_t input_count = detail::is_closed_loop<Device> ? 4 : 7;
    static constexpr duration start_limit = milliseconds(200);
    static constexpr duration steady_time = milliseconds(50); // between two legs a motor rests for less
    static constexpr duration lost_time = milliseconds(500);  // at rest without a home this long

    constexpr distance goal_of(const prepared_command& c) const {
        return c.is_absolute ? distance{c.target}
                             : wrapped(bits(before_) + static_cast<std::uint32_t>(c.target));
    }
    // At a goal so near that a motor which trembles may seem to have reached it, it must have come exactly.
    constexpr bool is_at_goal(const prepared_command& c, distance place) const {
        if (!c.has_target) return false;
        return is_within(goal_of(c) - before_) ? place == goal_of(c) : is_near(place, goal_of(c));
    }
    // A restart may put the position to zero, and keep every register that would show it [errata A55].
    constexpr bool may_have_restarted(distance now) const { return is_within(now) && !is_within(before_); }

    // Where "homed" has not fallen, as it need not [errata A54], the place alone tells that home was found;
    // not where it says the actual value.
    constexpr bool is_at_home(const prepared_command& c, distance place) const {
        const unsigned rule = c.arguments[0] < 6 ? c.arguments[0] : c.arguments[0] - 6u; // it moves, or stays
        const distance offset{from_bits<i32>(join_words(c.arguments[2], c.arguments[3], pair_word_order_))};
        const distance places[] = {offset, distance{0}, distance{0} - offset};
        return rule < 3 && is_near(place, places[rule]);
    }

    distance before_{};       // where the last motion began
    distance goal_{};         // of the last move
    duration moving_until_{}; // since the start of a homing
    word_order pair_word_order_ = word_order::unknown;
    motion_check seen_ = motion_check::not_asked;
    stop_cause cause_ = stop_cause::unknown;
    bool has_goal_ = false;
    bool is_beyond_range_ = false; // the goal is on the other side of the end of the counter's range
    bool was_homed_ = false;
    bool was_moving_ = false;
    bool is_positioning_ = false; // the last motion was a move to a place
    bool has_begun_ = false;
    bool is_creeping_ = false; // a bounded jog or a hold is under way
};

} // namespace servobus::yako
