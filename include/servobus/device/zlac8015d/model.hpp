// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: what the facade must know of the drive: where its feedback is, what it says, what a
// restart would change, which routine stops it. zlac8015d/drive.hpp includes it.
//
//     const zlac8015d::arrival came = wheels.arrival(zlac8015d::wheels::left);
//     if (came.how != arrival_state::reached) std::printf("%d counts missing\n", int(came.left_missing.count()));
#pragma once

#include <cstdint>

#include <servobus/control/command_kinds.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/control/image_of.hpp>
#include <servobus/device/zlac8015d/commands.hpp>

namespace servobus::zlac8015d {

/// Where the last move of the wheels has come to.
struct [[nodiscard]] arrival {
    arrival_state how = arrival_state::none;
    stop_cause cause = stop_cause::unknown; ///< why it `stopped_short`
    distance left_missing{};                ///< from the left wheel's position to its target
    distance right_missing{};

    /// At rest at its target.
    constexpr explicit operator bool() const { return how == arrival_state::reached; }
};

/// The model of the drive for `servobus::facade`.
class model {
  public:
    using prepared_command = zlac8015d::prepared_command;
    using settings = cached_settings;

    static constexpr drive_traits traits{.stops_without_line = true,
                                         .halts_in_position = false,
                                         .changes_speed_on_the_run = true,
                                         .has_homing = false,
                                         .keeps_single_parameters = false};
    /// 20A2h..20ACh in one frame.
    using image =
        image_of<status_word, hall_state, motor_temperature, left_faults, right_faults, left_actual_position,
                 right_actual_position, left_actual_speed, right_actual_speed>;
    static constexpr feedback_blocks blocks{image::block};
    static constexpr settings unknown{};
    static constexpr stop_rules stops{.at_fault = stop_priority::disable, // a fault of one wheel stops both
                                      .after_restart = false,
                                      .disable_replaces_quick_stop = false};

    static constexpr auto kinds =
        command_kinds<effect>{}
            .of(command_kind::take_over, effect::initialised)
            .of(command_kind::power, effect::enabled, effect::disabled, effect::quick_stopped)
            .of(command_kind::setting, effect::timeout_set, effect::speeds_set, effect::rescaled,
                effect::forgotten)
            .of(command_kind::move, effect::moved)
            .of(command_kind::endless_motion, effect::motion)
            .of(command_kind::refresh, effect::seen)
            .of(command_kind::other, effect::none, effect::positions_compared, effect::positions_cleared,
                effect::arrived)
            .with_new_origin(effect::positions_cleared);

    static constexpr bool is_faulted(const std::uint16_t* w, const settings&) {
        return w[image::place_of<left_faults>] != 0 || w[image::place_of<right_faults>] != 0 ||
               is_either(w[image::place_of<status_word>], shaft_state::alarm);
    }
    /// A shaft that is free at standstill, although the drive was enabled, shows a restart; one that is driven
    /// may read as free, and then the mode shows it [errata B30].
    static constexpr verdict judge(const std::uint16_t* w, settings& known) {
        if (known.state != drive_state::enabled) return verdict::as_expected;
        if (is_faulted(w, known)) {
            known.state = drive_state::disabled;
            return verdict::faulted;
        }
        const std::uint16_t status = w[image::place_of<status_word>];
        if (is_either(status, shaft_state::emergency_stop)) {
            known.state = drive_state::quick_stopped;
            return verdict::held;
        }
        if (!is_either(status, shaft_state::released)) return verdict::as_expected;
        const bool is_running = (status & status_flags::running_bits) != 0;
        return known.mode == operating_mode::torque || is_running ? verdict::uncertain : verdict::disabled;
    }
    /// Whether a position is nearer to zero than the speeds and the time between two images allow. A speed counts
    /// 0.1 r/min, and a turn has at most 16384 counts (2030h, 2060h).
    static constexpr bool has_fallen(const block_feedback& r, const settings&) {
        const std::uint16_t* const before = r.before;
        const std::uint16_t* const now = r.words;
        constexpr std::size_t speeds = image::place_of<left_actual_speed>;
        constexpr std::size_t places = image::place_of<left_actual_position>;
        // Of 128 us, at most 4 s.
        const std::uint32_t parts = r.between.us >> 22 != 0 ? 32'768u : r.between.us >> 7;
        for (std::size_t wheel = 0; wheel < 2; ++wheel) {
            const std::uint32_t then_speed = magnitude(static_cast<std::int16_t>(before[speeds + wheel]));
            const std::uint32_t now_speed = magnitude(static_cast<std::int16_t>(now[speeds + wheel]));
            const std::uint32_t faster = then_speed < now_speed ? now_speed : then_speed;
            const std::uint32_t then =
                magnitude(static_cast<std::int32_t>(pair(before + places + 2 * wheel)));
            const std::uint32_t there = magnitude(static_cast<std::int32_t>(pair(now + places + 2 * wheel)));
            // 16384 / 600 000, rounded up. Where a restart puts it, all but a trembling raises a suspicion.
            const std::uint32_t allowed = there <= 64u ? 10u : (faster * parts >> 8) + 64u;
            if (then > there && then - there > allowed) return true;
        }
        return false;
    }
    /// Nothing here follows the positions.
    static constexpr void note(const block_feedback&, const settings&) {}
    /// A restart loses the mode.
    static constexpr steps::recheck witness(const settings& known, const prepared_command&) {
        const bool has_mode = known.state >= drive_state::enabled; // or it was stopped quickly
        return {.look = has_mode ? routines::same_mode : nullptr,
                .words = {static_cast<std::uint16_t>(known.mode)}};
    }
    /// A little shorter than the drive's own, 2000h, which counts from the last request that it received. A
    /// drive that was stored with 0 is taken to have the factory's second.
    static constexpr duration watchdog(const settings& known) { return watchdog(known.host_timeout); }
    static constexpr duration watchdog(std::uint16_t host_timeout_ms) {
        const std::uint32_t ms = host_timeout_ms == 0 ? 1000u : host_timeout_ms;
        return milliseconds(ms - ms / 16);
    }
    /// The routine for a stop of a supervisor. `has_watchdog_expired`: the drive's watchdog may have stopped it, so
    /// that its first frame is one that stops it in every mode. A halt is a quick stop in the position modes, which
    /// have no halt.
    static constexpr prepared_command stop_for(stop_priority priority, const settings& known,
                                               bool has_watchdog_expired) {
        prepared_command c{.steps = routines::stop_both, .stop = priority};
        if (has_watchdog_expired) {
            c.steps = routines::stop_after_silence;
        } else if (priority == stop_priority::disable) {
            c.then = effect::disabled;
        } else if (priority == stop_priority::quick_stop || !detail::plan_halt(c, known)) {
            detail::plan_quick_stop(c, known);
        }
        return c;
    }

    /// A wait needs a move, and one lost frame must not use up the time of the drive's watchdog. Another 2022h may be
    /// written from here on, also if the command is replaced: until its mark is set no restart shows by it.
    constexpr errc admit(prepared_command& c, duration lost) {
        if (c.then == effect::initialised)
            c.steps = c.steps.first(routines::init_size + std::size_t{to_power_cycle_});
        if (c.then == effect::rescaled) to_power_cycle_ = routines::to_set_mark;
        if (c.then == effect::arrived && goals_of(c.arguments[0]) == 0) return errc::wrong_state;
        motion_ = motion_check::not_asked;
        if (c.then != effect::timeout_set || c.arguments[0] == 0) return errc::ok;
        return c.arguments[0] * 1000u < lost.us + 50'000 ? errc::out_of_range : errc::ok;
    }
    /// What a command has changed. Steps that are put into `c` follow as a part of it. Returns the error that is
    /// reported in place of its success.
    // Inline in its one caller: less flash.
    [[gnu::always_inline]] constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        if (!e.is_done) {
            fail(c, e, known);
            return errc::ok;
        }
        const slice<const std::uint16_t> words = e.words;
        const bool is_known = known.state >= drive_state::disabled;
        switch (c.then) {
        case effect::initialised:
            goals_ = 0; // a restart may have changed the positions
            known = {.state = drive_state::disabled,
                     .resolution = words[routines::resolution_word],
                     .max_speed = words[routines::max_speed_word],
                     .host_timeout = words[routines::host_timeout_word]};
            if (!speed_resolution.limits.contains(known.resolution)) {
                known.state = drive_state::needs_init;
                return errc::unexpected_value;
            }
            if (to_power_cycle_ == routines::to_ask_mark && words[routines::mode_word] == 0)
                to_power_cycle_ = 0;
            if (to_power_cycle_ == 0) break;
            [[fallthrough]];
        case effect::rescaled: // the drive has its mark now
            to_power_cycle_ = routines::to_ask_mark;
            known.state = drive_state::needs_power_cycle;
            break;
        case effect::enabled:
            known.state = drive_state::enabled;
            known.mode = c.mode;
            known.starts = static_cast<synchronisation>(c.arguments[2]);
            goals_ = 0;
            break;
        case effect::disabled:
            if (is_known) known.state = drive_state::disabled;
            break;
        case effect::quick_stopped:
            if (is_known) known.state = drive_state::quick_stopped;
            break;
        case effect::timeout_set: known.host_timeout = c.arguments[0]; break;
        case effect::speeds_set:
            known.resolution = c.arguments[0];
            known.max_speed = c.arguments[1];
            break;
        case effect::forgotten: known.state = drive_state::needs_init; break;
        case effect::positions_compared: motion_ = compared(words); break;
        case effect::positions_cleared: goals_ = 0; break;
        case effect::moved: keep_goals(c, words, known); break;
        case effect::end:
        case effect::none:
        case effect::motion:
        case effect::seen:
        case effect::arrived: break;
        }
        return errc::ok;
    }
    /// A motion was replaced that may have started.
    constexpr void preempt(const prepared_command& c) {
        failed_ = static_cast<std::uint8_t>(failed_ | static_cast<unsigned>(c.which));
    }
    /// None of its commands asks.
    static constexpr errc permit(const prepared_command&, const situation&, const settings&) {
        return errc::ok;
    }
    /// Whether the move that a command waits for has ended at its target.
    constexpr errc confirm(const prepared_command& c, const situation& now, const settings&) const {
        switch (arrival_of(static_cast<wheels>(c.arguments[0]), now.image, now.waited).how) {
        case arrival_state::under_way: return errc::busy;
        case arrival_state::stopped_short: return errc::stopped_short;
        case arrival_state::none:
        case arrival_state::reached: break;
        }
        return errc::ok;
    }

    constexpr motion_check motion() const { return motion_; }
    /// `w`: the image, which was read `since_start` after the last start.
    constexpr arrival arrival_of(wheels which, const std::uint16_t* w, duration since_start) const {
        arrival a{};
        const unsigned asked = goals_of(static_cast<unsigned>(which));
        if (asked == 0) return a;
        if ((asked & left_bit) != 0) a.left_missing = missing(0, w);
        if ((asked & right_bit) != 0) a.right_missing = missing(1, w);
        const unsigned running = ((w[0] & status_flags::left_running_bit) != 0 ? left_bit : 0u) |
                                 ((w[0] & status_flags::right_running_bit) != 0 ? right_bit : 0u);
        const bool is_there = is_still(a.left_missing) && is_still(a.right_missing);
        if ((running & asked) != 0 || (!is_there && since_start < start_limit)) {
            a.how = arrival_state::under_way;
        } else {
            a.how = is_there ? arrival_state::reached : arrival_state::stopped_short;
        }
        return a;
    }

  private:
    static constexpr bool is_either(std::uint16_t state, shaft_state s) {
        const auto code = static_cast<unsigned>(s);
        return state >> 14 == code || (state >> 6 & 3u) == code;
    }
    // The goals of these wheels; none if a move of theirs has failed since the last that began.
    constexpr unsigned goals_of(unsigned which) const { return (failed_ & which) != 0 ? 0u : goals_ & which; }
    // A servo at rest trembles by a few counts.
    static constexpr std::int32_t stillness = 20;
    // A wheel that does not run so long after its start will not.
    static constexpr duration start_limit = milliseconds(200);
    static constexpr unsigned left_bit = static_cast<unsigned>(wheels::left);
    static constexpr unsigned right_bit = static_cast<unsigned>(wheels::right);

    static constexpr std::uint32_t magnitude(std::int32_t d) {
        return d < 0 ? 0u - static_cast<std::uint32_t>(d) : static_cast<std::uint32_t>(d);
    }
    static constexpr bool is_still(distance d) { return d.count() <= stillness && d.count() >= -stillness; }
    static constexpr u32 pair(const std::uint16_t* w) {
        return join_words(w[0], w[1], device::facts.word_order);
    }
    constexpr distance missing(std::size_t wheel, const std::uint16_t* w) const {
        return distance{
            static_cast<std::int32_t>(goal_[wheel] - pair(w + routines::before_word + 2 * wheel))};
    }
    // A shorter time of the drive's watchdog may be set all the same.
    constexpr void fail(prepared_command& c, const ending& e, const settings& known) {
        if (e.status.outcome() != outcome::unknown) {
            if (c.then == effect::rescaled && !e.status.has_changed())
                to_power_cycle_ = 0; // it was not written
            return;
        }
        if (c.then == effect::timeout_set && watchdog(c.arguments[0]) < e.watchdog)
            e.watchdog = watchdog(c.arguments[0]);
        // Enabled perhaps, and its status does not show it [errata B30].
        if (c.then == effect::enabled && e.status.error() == errc::not_reached) {
            c.steps = routines::stop_both;
            c.then = effect::none;
            c.stop = stop_priority::disable;
        }
        if (c.then != effect::moved || e.status.step() < routines::start_step) return;
        goals_ = 0;
        motion_ = motion_check::unknown;
        if (known.state == drive_state::needs_init) return; // the positions are of before a restart
        c.steps = routines::post_check;
        c.arguments[0] = static_cast<std::uint16_t>(known.mode);
        c.then = effect::positions_compared;
    }
    // The targets as positions of the feedback: of a relative move, from where it began.
    constexpr void keep_goals(const prepared_command& c, slice<const std::uint16_t> words,
                              const settings& known) {
        const auto wheel = static_cast<unsigned>(c.which);
        const bool is_relative = known.mode == operating_mode::relative_position;
        const std::uint16_t* target = c.arguments.words; // the first wheel that moves
        for (std::size_t i = 0; i < 2; ++i) {
            if ((wheel & (1u << i)) == 0) continue;
            goal_[i] = pair(target) + (is_relative ? pair(words.data() + routines::before_word + 2 * i) : 0u);
            target += 2;
        }
        goals_ = static_cast<std::uint8_t>((goals_ & ~unsigned{failed_}) | wheel);
        failed_ = 0;
    }

    static constexpr motion_check compared(slice<const std::uint16_t> words) {
        const std::uint16_t* w = words.data();
        const auto has_moved = [&](std::size_t i) {
            const u32 way = pair(w + routines::after_word + i) - pair(w + routines::before_word + i);
            return !is_still(distance{static_cast<std::int32_t>(way)});
        };
        const bool is_running = (w[routines::running_word] & status_flags::running_bits) != 0;
        return is_running || has_moved(0) || has_moved(2) ? motion_check::seen : motion_check::not_seen;
    }

    u32 goal_[2]{};
    std::uint8_t goals_ = 0;  // the wheels that have one
    std::uint8_t failed_ = 0; // the wheels of moves that were replaced or failed since the last that began
    std::uint8_t to_power_cycle_ = 0; // the steps of an `init` that ask for a restart since 2022h was written
    motion_check motion_ = motion_check::not_asked;
};

/// By which a plan finds the model of a node's device.
model model_of(const device&);

} // namespace servobus::zlac8015d
