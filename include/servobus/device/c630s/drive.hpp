// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the facade of a drive. Commands (commands.hpp, moves.hpp, parameters.hpp) are run to
// their end, or begun and stepped in a loop that never waits. The facade caches the settings of the drive
// and invalidates them when they may have changed; it is not a safety function. servobus/device/c630s.hpp
// includes it.
//
//     c630s::drive servo{wire, 1};
//     if (!servo.run(c630s::init{})) return 1;
//     if (servo.state() == c630s::drive_state::needs_set_up && !servo.run(c630s::set_up{})) return 1;
//     if (servo.needs_power_cycle()) std::puts("switch the drive off and on");
//     const result<std::int64_t> place = servo.read(c630s::wide_position::mechanical); // encoder counts
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/drive.hpp>
#include <servobus/device/c630s/commands.hpp>
#include <servobus/device/c630s/feedback.hpp>
#include <servobus/device/c630s/moves.hpp>
#include <servobus/device/c630s/parameters.hpp>

namespace servobus::c630s {

/// One C630S on a line.
///
///     c630s::drive servo{wire, 1};
///     if (!servo.run(init{})) ...
///     if (servo.state() == drive_state::needs_set_up && !servo.run(set_up{})) ...
///     if (servo.needs_power_cycle()) ... // switch the drive off and on, then init again
///     if (!servo.run(enable{control_mode::speed})) ...
///     if (!servo.run(velocity{300 * r_per_min})) ...
///
/// In a superloop `begin(command)` instead of `run`, and `step()` once a turn. After an unknown outcome, or a
/// restart that shows in P31-00 or P0C-13 (looked at twice a second, and before every input that is set), the
/// state is `needs_init`, and no motion is ordered until `init` has run: motion never resumes by itself.
///
/// **The drive has no documented watchdog.** When the line or this program is lost, it goes on with its last
/// command: a speed, a torque or a jog without end. `watch_commands` covers an application that falls silent
/// in a loop that still steps; for the rest a wired stop is needed.
template <class Line> class drive : public drive_base<drive<Line>, Line, prepared_command> {
    using base = drive_base<drive<Line>, Line, prepared_command>;
    friend base;

  public:
    constexpr explicit drive(Line& on, std::uint8_t at = 1) : drive{on, servobus::node<device>{at}} {}
    /// With limits and silences of its own.
    constexpr drive(Line& on, const servobus::node<device>& at)
        : base{on, at}, response_{at.limits.response} {}

    constexpr drive_state state() const { return cached_.state; }
    constexpr const cached_settings& cached() const { return cached_; }
    /// The order of the words of 32-bit values; `unknown` before `init` too, and while a command may change
    /// it.
    constexpr word_order current_word_order() const {
        const bool is_open = !this->runner().is_idle() && this->current().then == effect::forgotten;
        return is_open || !cached_.is_initialised() ? word_order::unknown : cached_.word_order;
    }
    /// However long P0C-25 is: a bus grants what its plan reckons with.
    constexpr void grant_at_most(duration response) {
        most_granted_ = response;
        this->runner().set_response_limit(shorter_of(granted_, response));
    }
    /// True from a `set_up` or `keep` that changed something until `init` finds that the drive has been off.
    constexpr bool needs_power_cycle() const { return cached_.state == drive_state::needs_power_cycle; }
    /// The feedback read last.
    constexpr const feedback& seen() const { return seen_; }
    /// After a move ended `unknown`: whether the motor was found running, or more than 20 reference units
    /// from its place.
    constexpr motion_check motion() const { return motion_; }

    /// After `already_assigned`: the register that holds the function, such as `"P03-14"_p` for DI7, whose
    /// name is `c630s::catalogue.find(address)->name`; else 0.
    constexpr std::uint16_t conflicting_terminal() const { return conflict_; }

    /// Reads status, speed, torque, position, deviation and alarm. A fault while the drive is enabled
    /// switches the servo off before this returns.
    result<feedback> read() { return read_by(read_feedback{}, seen_); }
    /// Reads a position of 64 bits, both halves from one frame.
    result<std::int64_t> read(wide_position which) { return read_by(read_wide_position{which}, wide_); }
    /// Reads entry 0 (the present one) to 9 of the fault history. If it fails on entry 9 half-way, the next
    /// `init` asks for a power cycle that is not needed.
    result<fault_entry> fault(unsigned entry) { return read_by(read_fault{entry}, fault_); }

  private:
    template <class Wanted, class Value> result<Value> read_by(const Wanted& wanted, const Value& value) {
        const routine_status r = this->run(wanted);
        if (!r) return r.status;
        return value;
    }

    template <class Wanted> constexpr prepared_command plan(const Wanted& wanted) const {
        return wanted.plan(cached_);
    }

    constexpr errc admit(prepared_command& o) {
        if (o.then == effect::block_seen) begin_set_up(true);
        conflict_ = 0;
        if (is_powered()) check_drive_now_and_then(o);
        motion_ = motion_check::not_asked;
        return errc::ok;
    }

    constexpr void forget() { cached_ = {}; }

    static constexpr bool takes_over(const prepared_command& o) { return o.then == effect::initialised; }
    static constexpr bool is_command(const prepared_command& o) {
        const bool is_jog = o.then == effect::inputs_changed && o.stop == stop_priority::no_stop;
        return o.then == effect::motion || o.then == effect::moved || is_jog ||
               (o.then == effect::enabled && o.steps.data() == routines::enable_speed_segments.data());
    }
    static constexpr bool leaves_doubt(const prepared_command& o) {
        switch (o.then) {
        case effect::none:
        case effect::seen:
        case effect::position_read:
        case effect::motion:
        case effect::halted:
        case effect::waited:
        case effect::waited_off:
        case effect::quick_stopped: // only a servo-off takes its place, which is confirmed by itself
        case effect::home_looked_at:
        case effect::rivals_seen: return false;
        default: return true;
        }
    }
    constexpr bool is_powered() const { return cached_.state == drive_state::enabled; }

    /// A halt, or a quick stop where there is none.
    constexpr prepared_command watch_stop() const {
        const prepared_command o = halt{}.plan(cached_);
        return o.refusal == errc::ok ? o : quick_stop{}.plan(cached_);
    }
    // The drive has no watchdog to feed.
    static constexpr duration keep_alive_interval() { return {}; }
    static constexpr bool restarts_on_traffic = false;
    constexpr prepared_command keep_alive() const { return read_feedback{}.plan(cached_); }

    // A restart clears P31-00 and may bring back P0C-13 = 1, after which every target would wear the EEPROM.
    constexpr void check_drive_now_and_then(prepared_command& o) {
        const instant now = this->runner().line().now();
        if (since(drive_checked_, now) < milliseconds(500)) return;
        if (o.then == effect::seen) {
            o.steps = routines::feedback_of_same_drive;
        } else if (o.then == effect::motion) {
            o.steps = o.steps.data() == routines::velocity ? routine{routines::velocity_of_same_drive}
                                                           : routine{routines::torque_of_same_drive};
        } else {
            return;
        }
        drive_checked_ = now;
    }

    constexpr void fail(const prepared_command& o, const routine_status& r) {
        // Between the restart and the look that finds it, this command or one before may have set P31-00.
        const bool is_restart = is_powered() && r.error() == errc::needs_init;
        switch (o.then) {
        case effect::positions_compared: return;
        case effect::stopped_after_fault:
        case effect::block_seen:
        case effect::keeping:
        case effect::block_set:
        case effect::set_up:
        case effect::alarm_chosen:
        case effect::waited_off:
            report_behind(o, r);
            if (leaves_keeping(o, r)) this->follow({.steps = routines::give_up_keeping});
            return forget();
        case effect::moved:
            if (r.outcome() != outcome::unknown || r.step < routines::start_step) break;
            motion_ = motion_check::unknown;
            if (is_restart) break;
            word_order_of_move_ = cached_.word_order;
            this->follow({.steps = routines::post_check, .then = effect::positions_compared});
            break;
        case effect::reset: report_behind(o, r); break;
        case effect::rivals_seen:
        case effect::assigned: this->report_as(r); break;
        case effect::waited: report_behind(o, r); [[fallthrough]];
        case effect::enabled:
            // The line works, but the drive did not do what it was told: it must not stay as it is.
            if ((o.then == effect::waited || writes_inputs(o, r)) && is_drive_s_answer(r.error()))
                stop_behind();
            break;
        case effect::homed:
            this->report_as(r);
            if (r.step >= routines::home_step && is_drive_s_answer(r.error())) stop_behind();
            break;
        default: break;
        }
        if (is_restart || (is_powered() && r.error() == errc::faulted)) stop_behind();
        if (leaves_keeping(o, r)) this->follow({.steps = routines::give_up_keeping});
        if (base::is_in_doubt(r) || o.then == effect::forgotten) forget();
    }

    // What fails behind a command's own steps does so behind what they wrote, though it wrote nothing itself.
    constexpr void report_behind(const prepared_command& o, const routine_status& r) {
        const bool is_of_set_up =
            o.then == effect::block_seen || o.then == effect::keeping || o.then == effect::alarm_chosen;
        if (is_of_set_up && may_write_ && !is_keeping_) return this->report_as(r);
        this->report_as({r.status.with_sent(true), r.step, true});
    }
    static constexpr bool is_drive_s_answer(errc e) {
        return e != errc::port_lost && e != errc::clock_stopped && e != errc::faulted;
    }
    // The drive refused something while P0C-13 is 1: whoever writes next would wear the EEPROM.
    constexpr bool leaves_keeping(const prepared_command& o, const routine_status& r) const {
        const bool is_refusal = r.error() == errc::exception || r.error() == errc::unexpected_value;
        const bool is_in_set_up =
            is_keeping_ && (o.then == effect::block_seen || o.then == effect::block_set);
        return is_refusal && o.then != effect::none &&
               (is_in_set_up || detail::may_have_written<eeprom_update>(o, r));
    }
    static constexpr bool writes_inputs(const prepared_command& o, const routine_status& r) {
        return detail::may_have_written<virtual_input_levels>(o, r);
    }
    constexpr void stop_behind() {
        this->follow({.steps = routines::stop_all,
                      .then = effect::stopped_after_fault,
                      .stop = stop_priority::disable});
    }

    constexpr void apply(const prepared_command& o) {
        const auto words = this->runner().words();
        switch (o.then) {
        case effect::initialised: take_over(); break;
        case effect::block_seen: judge_block(); break;
        case effect::rivals_seen: judge_rivals(o); break;
        case effect::keeping:
            is_keeping_ = true;
            look_at_block();
            break;
        case effect::block_set: go_to_next_block(); break;
        case effect::set_up:
        case effect::needs_power_cycle: cached_.state = drive_state::needs_power_cycle; break;
        case effect::limits_set: detail::note_limits(o, cached_); break;
        case effect::enabled:
            cached_.state = drive_state::enabled;
            cached_.mode = o.mode;
            cached_.inputs = o.arguments[4];
            cached_.source = static_cast<position_source>(o.arguments[3]);
            cached_.runs_speed_segments = o.steps.data() == routines::enable_speed_segments.data();
            cached_.chooses_speed_segments =
                cached_.runs_speed_segments && o.arguments[2] == detail::as_word(segment_mode::by_input);
            cached_.runs_by_itself =
                cached_.runs_speed_segments || o.arguments[1] != detail::as_word(segment_mode::by_input);
            enabled_at_ = this->runner().line().now();
            drive_checked_ = enabled_at_;
            if (!cached_.runs_speed_segments) this->await_first_command();
            wait_for_brake();
            break;
        case effect::waited: wait_for_brake(); break;
        case effect::disabled:
        case effect::disabled_for_reset:
        case effect::stopped_after_fault:
            resets_when_off_ = o.then == effect::disabled_for_reset;
            note_servo_off();
            wait_for_power_off();
            break;
        case effect::waited_off: wait_for_power_off(); break;
        case effect::quick_stopped:
            if (is_powered()) cached_.state = drive_state::quick_stopped;
            break;
        case effect::inputs_changed:
        case effect::moved: cached_.inputs = o.arguments[1]; break;
        case effect::forgotten: forget(); break;
        case effect::seen:
            seen_ = feedback::from_words(words, cached_.word_order);
            react();
            break;
        case effect::position_read: wide_ = read_wide_position::from_words(words, cached_.word_order); break;
        case effect::record_read: fault_ = fault_entry::from_words(words, cached_.word_order); break;
        case effect::positions_compared: judge_motion(); break;
        case effect::home_looked_at: begin_homing(o); break;
        case effect::alarm_chosen: wait_for_power_off(); break;
        case effect::none:
        case effect::assigned:
        case effect::reset:
        case effect::halted:
        case effect::homed:
        case effect::motion: break;
        }
    }

    // Taking over and setting up

    constexpr void take_over() {
        const auto w = this->runner().words();
        const std::uint16_t words = w[routines::pair_word_order_word];
        forget();
        if (words > 1) return this->report_as({status::sent(errc::unexpected_value)});
        granted_ = response_ + milliseconds(w[routines::response_delay_word]);
        this->runner().set_response_limit(shorter_of(granted_, most_granted_));
        cached_ = {.state = drive_state::needs_set_up,
                   .mode = static_cast<control_mode>(w[routines::mode_word]),
                   .word_order = words == 0 ? word_order::high_first : word_order::low_first,
                   .max_speed = w[routines::max_speed_word],
                   .max_forward = w[routines::max_forward_word],
                   .max_reverse = w[routines::max_reverse_word],
                   .positive_torque = w[routines::positive_torque_word],
                   .negative_torque = w[routines::negative_torque_word],
                   .brake_delay_ms = w[routines::brake_delay_word],
                   .power_off_delay_ms = w[routines::power_off_delay_word]};
        is_marked_ = w[routines::record_word] == detail::as_word(fault_record::ninth_last);
        off_at_ = this->runner().line().now();
        resets_when_off_ = false;
        begin_set_up(false);
        look_at_block();
    }

    constexpr void begin_set_up(bool may_write) {
        may_write_ = may_write;
        is_keeping_ = false;
        block_ = 0;
    }
    constexpr std::uint16_t shift_to_block() const {
        return detail::as_word(detail::set_up_blocks[block_] - routines::first_of_blocks);
    }
    constexpr void look_at_block() {
        this->follow(
            {.steps = routines::look_at_block, .then = effect::block_seen, .shift = shift_to_block()});
    }
    constexpr void judge_block() {
        const auto held = this->runner().words().first(detail::block_size);
        steps::arguments wanted{};
        bool is_right = true;
        for (std::size_t i = 0; i < detail::block_size; ++i) {
            const auto address = static_cast<std::uint16_t>(detail::set_up_blocks[block_] + i);
            wanted[i] = detail::set_up_word(address, held[i]);
            is_right = is_right && held[i] == wanted[i];
        }
        if (is_right) return go_to_next_block();
        if (!may_write_) return end_look(drive_state::needs_set_up);
        if (!is_keeping_) return this->follow({.steps = routines::begin_keeping, .then = effect::keeping});
        this->follow({.steps = routines::set_block,
                      .arguments = wanted,
                      .then = effect::block_set,
                      .shift = shift_to_block()});
    }
    constexpr void go_to_next_block() {
        if (++block_ < detail::set_up_block_count) return look_at_block();
        if (is_keeping_) return this->follow({.steps = routines::end_keeping, .then = effect::set_up});
        if (cached_.state == drive_state::needs_set_up)
            end_look(is_marked_ ? drive_state::needs_power_cycle : drive_state::disabled);
    }
    constexpr void end_look(drive_state found) {
        cached_.state = found;
        if (is_marked_) return wait_for_power_off();
        this->follow({.steps = routines::choose_present_alarm, .then = effect::alarm_chosen});
    }

    // A terminal's function: the others are read before it is written.
    constexpr void judge_rivals(prepared_command next) {
        const auto held = this->runner().words();
        const auto block = static_cast<std::uint16_t>(next.shift + routines::first_of_blocks);
        for (std::uint16_t i = 0; i < detail::block_size; i += 2) {
            const auto address = static_cast<std::uint16_t>(block + i);
            if (held[i] != next.arguments[0] || address == next.arguments[1]) continue;
            conflict_ = address;
            return this->report_as(routine_status{errc::already_assigned});
        }
        const std::uint16_t other = detail::next_rivals(block);
        next.shift = detail::as_word(other - routines::first_of_blocks);
        if (other == 0) { // none has it
            next.steps = next.arguments[2] != 0 ? routine{routines::keep_one} : routine{routines::set_one};
            next.then = effect::assigned;
            next.shift = detail::as_word(next.arguments[1] - target_speed.address);
        }
        this->follow(next);
    }

    // What follows a command

    // A drive may leave the output of an earlier homing as it is: then that is no sign of this one.
    constexpr void begin_homing(const prepared_command& o) {
        const bool is_electrical = o.arguments[1] == detail::as_word(homing::start_electrical);
        const std::uint16_t sign = is_electrical ? status_flags::electrical_bit : status_flags::homed_bit;
        const bool is_old = (this->runner().words()[0] & sign) != 0;
        const routine steps =
            is_electrical
                ? (is_old ? routine{routines::home_electrically_again} : routine{routines::home_electrically})
                : (is_old ? routine{routines::home_again} : routine{routines::home});
        this->follow({.steps = steps, .arguments = o.arguments, .then = effect::homed, .limit = o.limit});
    }

    // P02-09: before it is over, a command is not obeyed and an edge is lost.
    constexpr void wait_for_brake() {
        const duration delay = milliseconds(cached_.brake_delay_ms + 10u);
        if (since(enabled_at_, this->runner().line().now()) < delay)
            this->follow({.steps = routines::look_at_brake, .then = effect::waited});
    }

    constexpr void note_servo_off() {
        cached_.inputs = 0;
        cached_.runs_speed_segments = false;
        cached_.chooses_speed_segments = false;
        cached_.runs_by_itself = false;
        off_at_ = this->runner().line().now();
        if (is_powered() || cached_.state == drive_state::quick_stopped)
            cached_.state = drive_state::disabled;
    }

    // P02-10: before it is over, the brake closes and the motor holds; what wants a stopped drive is refused.
    constexpr void wait_for_power_off() {
        const duration delay = milliseconds(cached_.power_off_delay_ms + 10u);
        if (!cached_.is_initialised()) return;
        if (since(off_at_, this->runner().line().now()) < delay)
            return this->follow({.steps = routines::look_at_inputs, .then = effect::waited_off});
        if (!resets_when_off_) return;
        const bool is_set_up = cached_.state == drive_state::disabled;
        this->follow({.steps = is_set_up ? routine{routines::fault_reset}
                                         : routine{routines::fault_reset_before_set_up},
                      .then = effect::reset});
        resets_when_off_ = false;
    }

    // A fault switches the servo off for good; so does a brake that is applied although the servo was on.
    constexpr void react() {
        if (!is_powered()) return;
        if (seen_.has_fault()) return stop_behind();
        if (seen_.state.is_brake_released()) return;
        forget();
        stop_behind();
    }

    // A standing servo trembles by a few counts.
    static constexpr std::int32_t stillness = 20;

    constexpr void judge_motion() {
        const auto w = this->runner().words();
        const auto place = [&](std::size_t i) { return join_words(w[i], w[i + 1u], word_order_of_move_); };
        const auto way =
            static_cast<std::int32_t>(place(routines::after_word) - place(routines::before_word));
        const std::int32_t pace = static_cast<std::int16_t>(w[routines::speed_word]);
        const bool is_running = pace > routines::stillness || pace < -std::int32_t{routines::stillness};
        const bool is_away = way > stillness || way < -stillness;
        motion_ = is_running || is_away ? motion_check::seen : motion_check::not_seen;
    }

    cached_settings cached_{};
    feedback seen_{};
    fault_entry fault_{};
    std::int64_t wide_ = 0;
    instant drive_checked_{};
    instant enabled_at_{};
    instant off_at_{};
    duration response_; // the node's
    duration granted_{response_};
    duration most_granted_{0xFFFF'FFFF};
    motion_check motion_ = motion_check::not_asked;
    word_order word_order_of_move_ = word_order::low_first;
    std::uint16_t conflict_ = 0; // the register that holds a function which another terminal was to get
    std::uint8_t block_ = 0;
    bool may_write_ = false;
    bool is_keeping_ = false;
    bool is_marked_ = false;
    bool resets_when_off_ = false;
};

} // namespace servobus::c630s
