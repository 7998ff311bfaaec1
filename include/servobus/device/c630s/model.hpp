// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: what the facade must know of the drive: where its feedback is, what it says, what a restart
// changes, which routine stops it, and what follows from a command. c630s/drive.hpp includes it. Source: manual
// V24.111, chapters 5 to 9.
//
//     static_assert(c630s::model::blocks.image().contains(c630s::virtual_output_levels.address, 1)); // one short frame
//     static_assert(c630s::model::watchdog({}) == duration{}); // none is documented: it goes on
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/command_kinds.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/control/image_of.hpp>
#include <servobus/control/slower_blocks.hpp>
#include <servobus/device/c630s/commands.hpp>
#include <servobus/device/c630s/feedback.hpp>
#include <servobus/device/c630s/known_settings.hpp>
#include <servobus/device/c630s/motion.hpp>
#include <servobus/device/c630s/moves.hpp>
#include <servobus/device/c630s/parameters.hpp>
#include <servobus/device/c630s/set_up_progress.hpp>
#include <servobus/device/c630s/terminal_rivals.hpp>

namespace servobus::c630s {

/// The model of the drive for `servobus::facade`.
class model {
  public:
    using prepared_command = c630s::prepared_command;
    using settings = cached_settings;

    static constexpr drive_traits traits{.stops_without_line = false,
                                         .halts_in_position = false,
                                         .changes_speed_on_the_run = true,
                                         .has_homing = true,
                                         .keeps_single_parameters = true};
    /// P17-32: the states of the drive, which `set_up` assigns to its virtual outputs.
    using states = image_of<virtual_output_levels>;
    using motions = image_of<actual_speed, speed_command, torque_command, input_state>;
    using position = image_of<absolute_position>;
    using deviation = image_of<following_error, fine_actual_speed>;
    using alarm = image_of<selected_fault_record, recorded_alarm>;
    static constexpr std::uint8_t position_block = 2;
    static constexpr feedback_blocks blocks =
        feedback_blocks{states::block, motions::block, position::block, deviation::block, alarm::block}
            .one_after(2)
            .positions_in(position_block);
    static constexpr settings unknown{};
    static constexpr stop_rules stops{
        .at_fault = stop_priority::disable,
        .after_restart = true, // until the refresh that finds it, a command may have switched the servo on
        // A quick stop may wait for a standstill that does not come, and a servo-off does not stop a motor whose
        // servo-on is wired.
        .disable_replaces_quick_stop = true};

    static constexpr auto kinds =
        command_kinds<effect>{}
            .of(command_kind::take_over, effect::initialised, effect::looked, effect::taken_over)
            .of(command_kind::power, effect::enabled, effect::runs_speed_segments, effect::stopped,
                effect::disabled, effect::disabled_for_reset, effect::reset, effect::quick_stopped)
            .of(command_kind::endless_motion, effect::driven, effect::jogged, effect::segment_selected,
                effect::runs_segments)
            .of(command_kind::move, effect::moved, effect::homed)
            .of(command_kind::refresh, effect::seen)
            .of(command_kind::setting, effect::keeping, effect::block_set, effect::set_up,
                effect::needs_power_cycle, effect::torque_limited, effect::speed_limited,
                effect::parameter_set, effect::pair_set, effect::forgotten, effect::record_read,
                effect::assigned)
            .of(command_kind::other, effect::none, effect::examined, effect::halted, effect::jog_halted,
                effect::home_looked_at, effect::home_set, effect::arrived, effect::stood,
                effect::position_read, effect::positions_compared, effect::rivals_seen)
            // A parameter of 32 bits may be a gear: a position is another number then.
            .with_new_origin(effect::homed, effect::home_set, effect::pair_set, effect::forgotten)
            .with_motion(effect::runs_speed_segments); // by that command itself

    /// Before the set-up the outputs have no meaning.
    static constexpr bool is_faulted(const std::uint16_t* w, const settings& known) {
        return known.state > drive_state::needs_power_cycle && status_flags::from_word(w[0]).has_fault();
    }
    /// A brake that is applied although the servo is on: the drive has restarted, or something else has switched
    /// it off.
    static constexpr verdict judge(const std::uint16_t* w, settings& known) {
        if (known.state != drive_state::enabled) return verdict::as_expected;
        if (is_faulted(w, known)) return verdict::faulted;
        return status_flags::from_word(w[0]).is_brake_released() ? verdict::as_expected : verdict::disabled;
    }
    /// Whether the position of a motor without power is nearer to zero than it was: a restart may have put it there.
    static constexpr bool has_fallen(const block_feedback& r, const settings& known) {
        if (r.block != position_block) return false;
        const auto magnitude = [&](const std::uint16_t* w) {
            const u32 p = join_words(w[0], w[1], known.word_order);
            return p >> 31 != 0 ? 0u - p : p;
        };
        constexpr u32 trembling = 20; // reference units
        const u32 then = magnitude(r.before), there = magnitude(r.words);
        return then > there && then - there > trembling;
    }
    /// Nothing here follows the positions.
    static constexpr void note(const block_feedback&, const settings&) {}
    /// P31-00, with the marker: a restart clears it. None while a routine changes it.
    static constexpr steps::recheck witness(const settings& known, const prepared_command& under_way) {
        if (!known.is_marked() || (!under_way.steps.empty() && changes_inputs(under_way))) return {};
        return {.look = routines::same_inputs, .words = {known.inputs}};
    }
    /// None is documented: a motor runs on when nothing is sent.
    static constexpr duration watchdog(const settings&) { return {}; }
    /// A halt, or a quick stop where there is none. A drive of which nothing is known may keep each write in its
    /// EEPROM.
    static constexpr prepared_command stop_for(stop_priority priority, const settings& known, bool) {
        if (!known.is_initialised()) return detail::stop_sparing();
        if (priority == stop_priority::disable) return detail::stop_by_all_means(known);
        const prepared_command c = prepare(halt{}, known);
        return priority == stop_priority::halt && c.refusal == errc::ok ? c : prepare(quick_stop{}, known);
    }

    /// A wait needs a move.
    constexpr errc admit(prepared_command& c, duration) {
        if (c.then == effect::initialised && is_init_unanswered_) c.steps = routines::init_again;
        if (c.then == effect::arrived && !motion_.has_goal()) return errc::wrong_state;
        rivals_.forget();
        motion_.ask();
        if (c.then == effect::examined) (void)set_up_.begin(true);
        return errc::ok;
    }
    /// Whether a move may start, by the words that it has read: not towards a limit switch that is active.
    static constexpr errc permit(const prepared_command&, const situation& now, const settings& known) {
        motion_under_way next{};
        begin_move(next, now.words, known);
        return next.is_towards_limit(now.words, known.word_order) ? errc::wrong_state : errc::ok;
    }
    /// Whether the drive has carried out the command.
    constexpr errc confirm(const prepared_command& c, const situation& now, const settings& known) {
        const duration waited = now.waited;
        const status_flags s = status_flags::from_word(now.image[0]);
        switch (c.then) {
        case effect::enabled:
        case effect::runs_speed_segments:
            if (s.has_fault()) return errc::faulted;
            if (!s.is_brake_released()) return errc::needs_init;
            return waited >= milliseconds(known.brake_delay_ms + 10u) ? errc::ok : errc::busy;
        case effect::arrived:
        case effect::stood:
            if (motion_.how() == arrival_state::stopped_short) return errc::stopped_short;
            return motion_.confirm(s, waited);
        default: return waited >= milliseconds(known.power_off_delay_ms + 10u) ? errc::ok : errc::busy;
        }
    }

    /// What a command has changed. Steps that are put into `c` follow as a part of it. Returns the error that is
    /// reported in place of its success.
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        if (c.then == effect::initialised)
            is_init_unanswered_ = !e.is_done && e.status.outcome() == outcome::unknown;
        if (!e.is_done) {
            fail(c, e.steps, e.status, known);
            return errc::ok;
        }
        const errc found = conclude(c, e.words, known);
        // The drive's own delay, P0C-25, counts on top of the node's response limit.
        if (response_ == duration{}) response_ = e.limits.response;
        e.limits.response = response_ + milliseconds(response_delay_ms_);
        return found;
    }

    /// A motion was replaced that may have started.
    constexpr void preempt(const prepared_command&) { motion_.forget(); }

    constexpr std::uint16_t conflict() const { return rivals_.conflict(); }
    constexpr const motion_under_way& motion() const { return motion_; }
    /// Where a move ends, by the words that it reads before its start.
    static constexpr std::int32_t target_of(slice<const std::uint16_t> words, const settings& known) {
        motion_under_way next{};
        begin_move(next, words, known);
        return next.missing_at(0).count();
    }

  private:
    constexpr errc conclude(prepared_command& c, slice<const std::uint16_t> words, settings& known) {
        switch (c.then) {
        case effect::initialised: return take_over(c, words, known);
        case effect::looked: set_up_.look(c, words, known); break;
        case effect::taken_over:
            known.inputs = c.arguments[1];
            known.state = set_up_.found();
            break;
        case effect::examined: {
            bool is_right = false;
            c = set_up_.judge(words, is_right);
            // Nothing is left to do, though a block differed at `init`: another program has set the drive up.
            if (c.steps.empty() && known.state == drive_state::needs_set_up) known = unknown;
            break;
        }
        case effect::keeping:
            known.state = drive_state::needs_init; // until the drive keeps its writes no more
            c = set_up_.keep();
            break;
        case effect::block_set: c = set_up_.next(); break;
        case effect::set_up:
        case effect::needs_power_cycle:
            known.state = drive_state::needs_power_cycle;
            set_up_.note_kept();
            break;
        case effect::torque_limited:
            known.positive_torque = c.arguments[0];
            known.negative_torque = c.arguments[1];
            break;
        case effect::speed_limited:
            known.max_speed = c.arguments[0];
            known.max_forward = c.arguments[1];
            known.max_reverse = c.arguments[2];
            break;
        case effect::parameter_set: detail::note_parameter(c, known); break;
        case effect::enabled:
        case effect::runs_speed_segments:
            motion_.forget();
            detail::note_enabled(c, words, known);
            break;
        case effect::stopped:
        case effect::disabled:
        case effect::disabled_for_reset:
            motion_.stop();
            detail::note_servo_off(c, known);
            break;
        case effect::reset: known.inputs = c.arguments[1]; break;
        case effect::quick_stopped:
            motion_.stop();
            if (known.state == drive_state::enabled) known.state = drive_state::quick_stopped;
            break;
        case effect::moved:
            known.inputs = c.arguments[1];
            begin_move(motion_, words, known);
            break;
        case effect::runs_segments:
        case effect::jogged:
        case effect::jog_halted:
        case effect::segment_selected: known.inputs = c.arguments[1]; break;
        case effect::homed:
        case effect::home_set:
        case effect::pair_set: motion_.forget(); break;
        case effect::arrived:
        case effect::stood: return end_move(c, words, known);
        case effect::forgotten: known = unknown; break;
        case effect::positions_compared: motion_.note(motion_.compared(words, word_order_of_move_)); break;
        case effect::home_looked_at: detail::begin_homing(c, words); break;
        case effect::rivals_seen: return rivals_.judge(c, words);
        default: break;
        }
        return errc::ok;
    }
    // A command has failed at a step of the table `failed`.
    constexpr void fail(prepared_command& c, routine failed, const command_status& r, settings& known) {
        const effect was = c.then;
        const bool is_answer = r.error() != errc::port_lost && r.error() != errc::clock_stopped;
        const bool is_restart = known.state == drive_state::enabled && r.error() == errc::needs_init;
        const bool is_energised =
            kinds[c.then] == command_kind::power && detail::may_have_written<virtual_input_levels>(failed, r);
        const bool is_homing = was == effect::homed && r.step() >= routines::home_step;
        // The drive has restarted, or may have: what the stop does up to its servo-off got no response.
        const bool is_cut = switches_off(was) && known.is_marked() &&
                            (!detail::may_have_written<virtual_input_levels>(failed, r) ||
                             failed[r.step()].what == step::kind::write);
        c.then = effect::none;
        if (was == effect::moved && is_started(failed, r)) {
            motion_.forget(); // the target is that of the move before
            if (r.outcome() == outcome::unknown) {
                motion_.note(motion_check::unknown);
                word_order_of_move_ = known.word_order;
                if (!is_restart) c = {.steps = routines::post_check, .then = effect::positions_compared};
            }
        }
        // The line works, but the drive did not do what it was told, or has restarted: it must not stay as it is.
        const bool must_stop =
            is_restart || is_cut || (is_energised && c.stop == stop_priority::no_stop) || is_homing;
        const bool is_unknown = is_cut || r.error() == errc::needs_init;
        if (must_stop && is_answer)
            c = is_unknown ? detail::stop_sparing() : detail::stop_by_all_means(known);
        if (set_up_.leaves_keeping(was, failed, r)) c = {.steps = routines::give_up_keeping};
        if (set_up_.is_part(was) || was == effect::forgotten) known = unknown;
    }
    static constexpr bool changes_inputs(const prepared_command& c) {
        const command_kind kind = kinds[c.then];
        if (kind == command_kind::take_over || kind == command_kind::power) return true;
        if (kind == command_kind::endless_motion) return c.then != effect::driven;
        return c.then == effect::moved || c.then == effect::jog_halted;
    }
    static constexpr bool switches_off(effect e) {
        return e == effect::stopped || e == effect::disabled || e == effect::disabled_for_reset;
    }
    static constexpr bool is_started(routine failed, const command_status& r) {
        return r.step() + routines::steps_from_start >= failed.size();
    }
    // Taking over and setting up: the drive needs an init until the blocks of the set-up were read too.
    constexpr errc take_over(prepared_command& c, slice<const std::uint16_t> w, settings& known) {
        using namespace routines;
        motion_.forget();
        known = unknown;
        if (w[pair_word_order_word] > 1) return errc::unexpected_value;
        response_delay_ms_ = w[response_delay_word];
        known = detail::settings_in(w);
        c = set_up_.take_over(w[record_word] == detail::as_word(fault_record::ninth_last));
        return errc::ok;
    }

    static constexpr void begin_move(motion_under_way& motion, slice<const std::uint16_t> words,
                                     const settings& known) {
        using namespace routines;
        if (known.source == position_source::step) {
            motion.begin(static_cast<std::int16_t>(words[way_word]), false, words, known.word_order);
        } else {
            motion.begin(motion_under_way::number_at(words, way_word, known.word_order),
                         known.ways == displacement_type::absolute, words, known.word_order);
        }
    }
    constexpr errc end_move(prepared_command& c, slice<const std::uint16_t> words, const settings& known) {
        if (!motion_.has_goal() || motion_.conclude(words, known.word_order)) return errc::ok;
        if (!motion_.may_have_hardly_begun()) return errc::stopped_short;
        motion_.resume();
        c.steps = routines::wait_reached;
        return errc::ok;
    }

    motion_under_way motion_{};
    duration response_{}; // the node's, once a command has succeeded
    set_up_progress set_up_{};
    word_order word_order_of_move_ = word_order::low_first;
    std::uint16_t response_delay_ms_ = 0;
    terminal_rivals rivals_{};
    bool is_init_unanswered_ = false;
};

/// By which a plan finds the model of a node's device.
model model_of(const device&);

} // namespace servobus::c630s
