// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: what the facade must know of a drive: where its feedback is, what it says, whether
// a command may begin and has been carried out, what a restart would change, which routine stops it. Both
// variants share it. yako/basic_drive.hpp includes it. A drive may acknowledge a command that it does not
// carry out (manual V2.6.0, sections 4.1 and 5.1), so each is confirmed by the feedback.
//
//     static_assert(yako::model<yako::closed_loop::device>::blocks.image().contains(yako::actual_position.address, 2));
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/control/command_kinds.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/control/image_of.hpp>
#include <servobus/device/yako/motion.hpp>
#include <servobus/device/yako/parameters.hpp>

namespace servobus::yako {

/// The model of a drive for `servobus::facade`.
template <class Device> class model {
  public:
    using prepared_command = yako::prepared_command;
    using settings = cached_settings;
    using feedback = basic_feedback<Device>;

    static constexpr drive_traits traits{.stops_without_line = false,
                                         .halts_in_position = true,
                                         .changes_speed_on_the_run = false,
                                         .has_homing = true,
                                         .keeps_single_parameters = false};
    static constexpr bool is_closed_loop = detail::is_closed_loop<Device>;
    /// 0006h..000Ch in one frame. Both variants have these registers at the same addresses.
    using image = image_of<error_code, status_word, closed_loop::input_state, closed_loop::output_state,
                           actual_position, closed_loop::actual_speed>;
    static constexpr feedback_blocks blocks{image::block};
    static constexpr settings unknown{.is_closed_loop = is_closed_loop};
    static constexpr stop_rules stops{
        .at_fault = stop_priority::halt, // the shaft stays held: a release would let a load fall
        .after_restart =
            true, // it is energised, and obeys a start that was sent before the restart was found
        .disable_replaces_quick_stop = false};

    static constexpr auto kinds =
        command_kinds<effect>{}
            .of(command_kind::take_over, effect::initialised, effect::marked)
            .of(command_kind::power, effect::enabled, effect::disabled, effect::quick_stopped,
                effect::alarm_cleared)
            .of(command_kind::move, effect::moved, effect::crept, effect::homed)
            .of(command_kind::endless_motion, effect::jogged)
            .of(command_kind::refresh, effect::seen)
            .of(command_kind::setting, effect::kept, effect::profile_set, effect::homing_profile_set,
                effect::limited, effect::unlimited, effect::word_order_set, effect::resolution_set,
                effect::forgotten, effect::reset, effect::position_cleared, effect::segment_set)
            .of(command_kind::other, effect::none, effect::trusted, effect::positions_compared,
                effect::arrived, effect::stop_examined)
            // A position in the other word order is another number too.
            .with_new_origin(effect::homed, effect::position_cleared, effect::word_order_set);

    static constexpr bool is_faulted(const std::uint16_t* w, const settings&) {
        return status_of(w).has_alarm();
    }
    /// A homing that is lost shows a restart. The drive's own bit says whether the motor has power: an input can
    /// take it away.
    static constexpr verdict judge(const std::uint16_t* w, settings& known) {
        const motion_status s = status_of(w);
        if (!follow(s, known)) return verdict::disabled;
        if (!s.has_alarm()) return verdict::as_expected;
        return s.is_enabled() ? verdict::faulted : verdict::tripped;
    }
    /// Whether the position is nearer to zero than the speed and the time between two images allow.
    static constexpr bool has_fallen(const block_feedback& r, const settings& known) {
        return motion_type::is_fall(r.before, r.words, r.between, known);
    }
    constexpr void note(const block_feedback& r, const settings&) {
        if (!status_of(r.words).is_moving()) motion_.end_creep();
    }
    /// The marker; without one, what else a restart may change.
    static constexpr steps::recheck witness(const settings& known, const prepared_command&) {
        if (known.is_marked)
            return {.look = routines::same_marker, .words = {known.marker[0], known.marker[1]}};
        return {.look = is_closed_loop ? routines::same_in_closed_loop : routines::same_in_open_loop,
                .words = {static_cast<std::uint16_t>(known.word_order == word_order::high_first ? 0 : 1),
                          static_cast<std::uint16_t>(known.resolution)}};
    }
    /// The drive has no watchdog: a motor runs on when nothing is sent.
    static constexpr duration watchdog(const settings&) { return {}; }
    static constexpr prepared_command stop_for(stop_priority priority, const settings& known, bool) {
        if (priority == stop_priority::quick_stop) return prepare(quick_stop{}, known);
        if (priority == stop_priority::disable) return prepare(disable{}, known);
        return prepare(halt{}, known);
    }

    /// A wait needs a move.
    constexpr errc admit(const prepared_command& c, duration) {
        if (c.then == effect::arrived && !motion_.has_goal()) return errc::wrong_state;
        if (is_motion(c.then)) motion_.ask();
        if (c.stop != stop_priority::no_stop) motion_.end_creep();
        return errc::ok;
    }
    /// Whether the drive is as the command requires. A bounded jog that is still under way is done when this returns.
    constexpr errc permit(prepared_command& c, const situation& now, settings& known) {
        const motion_status s = status_of(now.image);
        if (!follow(s, known)) return errc::needs_init;
        const bool goes_on = motion_.goes_on(c, now.image);
        if (has(c.needs, requirement::healthy) && s.has_alarm()) return errc::faulted;
        if (has(c.needs, requirement::enabled) && !s.is_enabled()) return errc::wrong_state;
        if (has(c.needs, requirement::released) && s.is_enabled()) return errc::wrong_state;
        if (has(c.needs, requirement::standing) && s.is_moving() && !goes_on) return errc::busy;
        // Bit 3 acts in positioning only (section 4.1): a jog or a homing would run on.
        if (c.then == effect::moved && s.is_moving() && !motion_.is_positioning()) return errc::busy;
        if (has(c.needs, requirement::homed) && !known.is_homed) return errc::needs_homing;
        if (goes_on && c.aim == nullptr) {
            motion_.note(motion_check::seen);
            c.steps = no_steps;
        } else if (is_motion(c.then)) {
            if (c.aim != nullptr) {
                if (const errc why = c.aim(c, now.image, known); why != errc::ok) return why;
            }
            motion_.begin(c, now.image, known);
            if (c.then == effect::homed) lose_home(known);
        }
        return errc::ok;
    }
    /// Whether a command that was acknowledged is carried out; or whether a move has arrived. An alarm that comes
    /// meanwhile has ended the command by then: each image is judged first.
    constexpr errc confirm(const prepared_command& c, const situation& now, settings& known) {
        const std::uint16_t* const w = now.image;
        const duration since_start = now.waited;
        const motion_status s = status_of(w);
        switch (c.then) {
        case effect::kept:
        case effect::reset: return s.is_moving() ? errc::not_executed : errc::ok;
        case effect::position_cleared:
            if (!s.is_homed()) lose_home(known); // whether it stays homed is not stated [errata A54]
            return motion_type::is_at_zero(w, known) ? errc::ok : errc::not_executed;
        case effect::moved:
        case effect::crept:
        case effect::jogged: return motion_.confirm_start(c, w, since_start, known);
        case effect::homed: return motion_.confirm_home(c, w, since_start, known);
        default: break;
        }
        switch (arrival_of(w, since_start, known).how) {
        case arrival_state::under_way: return errc::busy;
        case arrival_state::stopped_short: return s.has_alarm() ? errc::faulted : errc::stopped_short;
        case arrival_state::none: return motion_.has_goal() ? errc::unexpected_value : errc::ok;
        default: return errc::ok;
        }
    }

    /// What a command has changed. Steps that are put into `c` follow as a part of it. Returns the error that is
    /// reported in place of its success.
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        if (!e.is_done) {
            fail(c, e.status, known);
            return errc::ok;
        }
        const slice<const std::uint16_t> words = e.words;
        note_profile(c, known);
        switch (c.then) {
        case effect::initialised: return take_over(c, words, known);
        case effect::enabled: known.state = drive_state::enabled; break;
        case effect::disabled:
            if (known.state != drive_state::needs_init) known.state = drive_state::disabled;
            if (!is_closed_loop) lose_home(known);
            break;
        case effect::quick_stopped: lose_home(known); break;
        case effect::alarm_cleared: (void)follow(status_of(words.data()), known); break;
        case effect::trusted:
            known.is_homed = known.was_homed && status_of(words.data()).is_homed();
            if (!known.is_homed) return errc::needs_homing;
            break;
        case effect::homing_profile_set:
            known.has_homing_profile = true;
            known.homing_speeds[0] = c.arguments[0];
            known.homing_speeds[1] = c.arguments[1];
            break;
        case effect::limited: known.limits = limit_enable::after_homing; break;
        case effect::unlimited: known.limits = limit_enable::disabled; break;
        case effect::word_order_set: change_word_order(word_order_of(c.arguments[0]), known); break;
        case effect::resolution_set:
            known.resolution = static_cast<speed_count>(c.arguments[0]);
            known.has_scale = true;
            known.has_profile = false;
            known.has_homing_profile = false;
            break;
        case effect::forgotten:
        case effect::reset: known = unknown; break;
        case effect::segment_set: known.is_marked = false; break;
        case effect::kept: mark(c, 0, known); break;
        case effect::marked:
            known.state = marked_state_;
            known.is_marked = true;
            known.marker[0] = c.arguments[0];
            known.marker[1] = c.arguments[1];
            break;
        case effect::moved:
        case effect::crept: motion_.keep_goal(c); break;
        case effect::homed: known.is_homed = true; break;
        case effect::positions_compared: motion_.note(motion_.compared(words)); break;
        case effect::stop_examined: motion_.examine(words); break;
        default: break;
        }
        return errc::ok;
    }
    /// A motion was replaced that may have started, or a move has failed. A bounded jog that is under way may continue.
    constexpr void preempt(const prepared_command& c) {
        if (c.then == effect::crept)
            motion_.drop_goal();
        else
            motion_.forget();
    }

    constexpr motion_check motion() const { return motion_.seen(); }
    constexpr stop_cause cause() const { return motion_.cause(); }
    constexpr arrival arrival_of(const std::uint16_t* w, duration since_start, const settings& known) const {
        return motion_.arrival_of(w, since_start, known);
    }

  private:
    using motion_type = motion_under_way<Device>;

    static constexpr motion_status status_of(const std::uint16_t* w) { return motion_type::status_of(w); }
    static constexpr std::int32_t last_mark = 15;

    static constexpr bool is_motion(effect e) {
        return e == effect::moved || e == effect::crept || e == effect::jogged || e == effect::homed;
    }
    static constexpr word_order word_order_of(std::uint16_t word) {
        return word == 0 ? word_order::high_first : word_order::low_first;
    }
    static constexpr std::uint8_t start_step_of(const prepared_command& c) {
        if (c.then == effect::homed) return routines::home_start_step;
        return c.then == effect::jogged || c.has_profile ? routines::start_step : routines::stored_start_step;
    }

    constexpr void fail(prepared_command& c, const command_status& r, settings& known) {
        if (c.then == effect::kept && r.error() == errc::not_executed) return mark(c, 0, known);
        if (r.error() == errc::stopped_short && known.state != drive_state::needs_init) {
            c = {.steps = is_closed_loop ? routine{routines::examine_stop_in_closed_loop}
                                         : routine{routines::examine_stop_in_open_loop},
                 .then = effect::stop_examined};
            return;
        }
        if (!is_motion(c.then) || r.step() < start_step_of(c)) return;
        // After a refused read a homing goes on; other motions are supervised by their own feedback.
        const bool is_after_start = r.step() > start_step_of(c);
        const bool is_unseen_homing =
            c.then == effect::homed && is_after_start && r.outcome() == outcome::refused;
        if (r.outcome() != outcome::unknown && !is_unseen_homing) return;
        if (r.error() == errc::not_executed) return note_profile(c, known);
        motion_.note(motion_check::unknown);
        if (c.then == effect::homed) {
            if (r.error() != errc::faulted) c = prepare(halt{}, known);
            return;
        }
        if (is_after_start) return;
        c.steps = known.is_marked ? routine{routines::after_start} : routine{routines::after_start_unmarked};
        c.arguments = {{known.marker[0], known.marker[1]}};
        c.then = effect::positions_compared;
    }
    // Where the axis is, is not known any more: nor is what an earlier program found.
    static constexpr void lose_home(settings& known) {
        known.is_homed = false;
        known.was_homed = false;
    }
    // False for a drive that was restarted since. An open loop loses its position with its current.
    static constexpr bool follow(motion_status s, settings& known) {
        if (known.is_homed && !s.is_homed()) return false;
        known.state = s.is_enabled() ? drive_state::enabled : drive_state::disabled;
        if (!is_closed_loop && !s.is_enabled()) lose_home(known);
        return true;
    }

    constexpr errc take_over(prepared_command& c, slice<const std::uint16_t> w, settings& known) {
        motion_.forget();
        known = unknown;
        const std::uint16_t count = is_closed_loop ? w[routines::resolution_word] : std::uint16_t{0};
        if (w[routines::limits_word] > 1 || w[routines::word_order_word] > 1 || count > 1)
            return errc::unexpected_value;
        const bool is_certain = count == 0;
        const auto status = motion_status::from_word(w[routines::status_word_at]);
        known = {.state = status.is_enabled() ? drive_state::enabled : drive_state::disabled,
                 .is_closed_loop = is_closed_loop,
                 .limits = static_cast<limit_enable>(w[routines::limits_word]),
                 .word_order = word_order_of(w[routines::word_order_word]),
                 .resolution = static_cast<speed_count>(count),
                 .has_scale = is_certain,
                 .has_profile = is_certain,
                 .has_homing_profile = is_certain,
                 .was_homed = status.is_homed(),
                 .microsteps = w[routines::microsteps_word]};
        for (std::size_t i = 0; i < cached_settings::profile_words; ++i)
            known.profile[i] = w[routines::profile_at + i];
        known.homing_speeds[0] = w[routines::homing_speeds_at];
        known.homing_speeds[1] = w[routines::homing_speeds_at + 1u];
        const auto held = static_cast<std::int32_t>(
            join_words(w[routines::marker_at], w[routines::marker_at + 1u], known.word_order));
        constexpr std::int32_t from_the_factory = 5000;
        if ((held >= 0 && held <= last_mark) || held == from_the_factory) mark(c, held, known);
        return errc::ok;
    }
    // Writes a marker that differs from what the row holds. Until it is written, the drive needs an init.
    constexpr void mark(prepared_command& c, std::int32_t held, settings& known) {
        known.is_marked = false;
        marked_state_ = known.state;
        known.state = drive_state::needs_init;
        const word_pair words = detail::words_of(distance{held < last_mark ? held + 1 : 1}, known);
        c = {.steps = routines::mark, .arguments = {{words.first, words.second}}, .then = effect::marked};
    }
    static constexpr void change_word_order(word_order to, settings& known) {
        if (to == known.word_order) return;
        known.word_order = to;
        const std::uint16_t first = known.marker[0];
        known.marker[0] = known.marker[1];
        known.marker[1] = first;
    }
    // 0020h..0023h hold what the command has written.
    constexpr void note_profile(const prepared_command& c, settings& known) {
        if (!c.has_profile && c.then != effect::profile_set) return;
        if (c.then == effect::profile_set) motion_.end_creep(); // it has another profile
        known.has_profile = true;
        for (std::size_t i = 0; i < cached_settings::profile_words; ++i) known.profile[i] = c.arguments[i];
    }

    motion_type motion_{};
    drive_state marked_state_ = drive_state::needs_init; // once the marker is written
};

/// By which a plan finds the model of a node's device.
template <class Device>
requires std::is_base_of_v<device, Device> model<Device> model_of(const Device&);

} // namespace servobus::yako
