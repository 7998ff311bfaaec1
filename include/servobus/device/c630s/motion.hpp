// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the move under way: where it is to end, how it has ended, and whether one began whose start
// got no response. c630s/model.hpp includes it; programs get an `arrival` from a drive.
//
//     const c630s::arrival there = servo.run(c630s::start_segment{3}, wait_reached{});
//     if (there.how == arrival_state::stopped_short && there.cause == stop_cause::blocked)
//         std::printf("pressed %ld units before its target\n", long{there.missing.count()});
#pragma once

#include <cstdint>

#include <servobus/control/states.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

/// Where the last move has come to.
struct [[nodiscard]] arrival {
    arrival_state how = arrival_state::none;
    stop_cause cause = stop_cause::unknown; ///< why it `stopped_short`
    distance missing{};                     ///< from the motor's position, as read last, to its target

    /// At rest at its target.
    constexpr explicit operator bool() const { return how == arrival_state::reached; }
};

/// `words`: what a routine read.
class motion_under_way {
  public:
    constexpr bool has_goal() const { return how_ != arrival_state::none; }
    constexpr arrival_state how() const { return how_; }
    constexpr stop_cause cause() const { return cause_; }
    constexpr motion_check seen() const { return seen_; }
    /// From a position to the target.
    constexpr distance missing_at(std::int32_t position) const {
        return distance{difference(goal_, position)};
    }

    constexpr void forget() { how_ = arrival_state::none; }
    constexpr void ask() { seen_ = motion_check::not_asked; }
    constexpr void note(motion_check seen) { seen_ = seen; }
    /// A stop was commanded, or followed a fault.
    constexpr void stop() {
        if (how_ == arrival_state::under_way) how_ = arrival_state::stopped_short;
    }

    /// The start was acknowledged. Relative ways count from the end of the command before.
    constexpr void begin(std::int32_t way, bool is_absolute, slice<const std::uint16_t> words,
                         word_order order) {
        using namespace routines;
        goal_ = is_absolute ? way
                            : sum(sum(number_at(words, before_word, order),
                                      number_at(words, deviation_before_word, order)),
                                  way);
        const std::int32_t size = way < 0 ? difference(0, way) : way;
        tolerance_ = size > 2 * trembling ? trembling : size / 2 + rounding;
        resume();
        is_blocked_ = false;
        blocked_since_ = {};
    }

    /// By the alarm that was read before the start, a limit switch is active where the move goes (Er.950: positive,
    /// Er.952: negative).
    constexpr bool is_towards_limit(slice<const std::uint16_t> words, word_order order) const {
        using namespace routines;
        if (words[alarm_before_word] != commands::as_word(fault_record::current)) return false;
        const std::uint16_t alarm = words[alarm_before_word + 1u];
        const std::int32_t way = difference(goal_, number_at(words, before_word, order));
        return (alarm == 0x950 && way > 0) || (alarm == 0x952 && way < 0);
    }

    /// Whether the drive says that the motion has ended, by its word of outputs. `since_start`: of this, after the
    /// start was acknowledged; it may go back from two minutes to one.
    constexpr errc confirm(status_flags s, duration since_start) {
        confirmed_ = since_start;
        const bool presses = s.is_torque_limited() && !s.is_rotating();
        if (!presses || since_start < blocked_since_) blocked_since_ = since_start;
        is_blocked_ = presses && since_start.us - blocked_since_.us >= blocked_time.us;
        const bool is_over = s.is_completed() && since_start >= start_time;
        return is_over || is_blocked_ ? errc::ok : errc::busy;
    }
    /// COIN soon after a start may be that of the move before: the place decides then.
    constexpr bool may_have_hardly_begun() const { return !is_blocked_ && confirmed_ < begin_time; }
    /// Such a move is still under way, whatever `conclude` has found.
    constexpr void resume() {
        how_ = arrival_state::under_way;
        cause_ = stop_cause::unknown;
    }

    /// The position was read after that, at standstill. The move has reached its target if the position and its
    /// deviation, which COIN limits, add up to it.
    constexpr bool conclude(slice<const std::uint16_t> words, word_order order) {
        using namespace routines;
        const std::int32_t place = number_at(words, place_word, order);
        const std::int32_t command =
            is_blocked_ ? place : sum(place, number_at(words, deviation_word, order));
        const std::int32_t missing = difference(goal_, command);
        const bool is_there = missing <= tolerance_ && missing >= -tolerance_;
        how_ = is_there ? arrival_state::reached : arrival_state::stopped_short;
        if (!is_there) cause_ = is_blocked_ ? stop_cause::blocked : cause_by(words);
        return is_there;
    }

    /// After a start that got no response: the place before it is known.
    constexpr motion_check compared(slice<const std::uint16_t> words, word_order order) const {
        using namespace routines;
        if ((words[inputs_word] & terminal::marker) == 0) return motion_check::unknown; // restarted
        const std::int32_t way =
            difference(number_at(words, after_word, order), number_at(words, before_word, order));
        const std::int32_t pace = static_cast<std::int16_t>(words[speed_word]);
        const bool is_running = pace > stillness || pace < -std::int32_t{stillness};
        return is_running || way > trembling || way < -trembling ? motion_check::seen
                                                                 : motion_check::not_seen;
    }

    /// A number of 32 bits among the words.
    static constexpr std::int32_t number_at(slice<const std::uint16_t> words, std::size_t place,
                                            word_order order) {
        return from_bits<i32>(join_words(words[place], words[place + 1u], order));
    }

  private:
    static constexpr std::int32_t trembling = 20; // reference units
    static constexpr std::int32_t rounding = 2;   // of encoder counts
    static constexpr duration start_time = milliseconds(50);
    static constexpr duration begin_time = milliseconds(500);
    // Er.630 comes after P0A-32, 200 ms from the factory.
    static constexpr duration blocked_time = milliseconds(100);

    // Positions wrap.
    static constexpr std::int32_t sum(std::int32_t a, std::int32_t b) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
    }
    static constexpr std::int32_t difference(std::int32_t a, std::int32_t b) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
    }
    // Er.900 is FunIN.34, Er.950 and Er.952 are limit switches.
    static constexpr stop_cause cause_by(slice<const std::uint16_t> words) {
        using namespace routines;
        if (words[cause_word] != commands::as_word(fault_record::current)) return stop_cause::unknown;
        const std::uint16_t alarm = words[cause_word + 1u];
        return alarm == 0x900 || alarm == 0x950 || alarm == 0x952 ? stop_cause::input : stop_cause::unknown;
    }

    std::int32_t goal_ = 0;
    std::int32_t tolerance_ = 0;
    duration confirmed_{};     // when the drive said so, since the start
    duration blocked_since_{}; // likewise
    arrival_state how_ = arrival_state::none;
    stop_cause cause_ = stop_cause::unknown;
    motion_check seen_ = motion_check::not_asked;
    bool is_blocked_ = false;
};

} // namespace servobus::c630s
