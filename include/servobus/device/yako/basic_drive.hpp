// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: what the facades of both variants share. Commands (commands.hpp,
// parameters.hpp) are run to their end, or begun and stepped in a loop that never waits. The facade reads
// the drive's state before it sends a command and again afterwards, since it may acknowledge a command
// that it does not execute. It caches the settings of the drive and invalidates them when they may have
// changed; it is not a safety function. yako/drive.hpp includes it; code for both variants takes a
// `basic_drive`:
//
//     template <class Device, class Line> bool advance(yako::basic_drive<Device, Line>& axis) {
//         return axis.run(yako::move_by{5000 * pulse}) && axis.run(yako::wait_standstill{});
//     }
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/control/drive.hpp>
#include <servobus/device/yako/feedback.hpp>
#include <servobus/device/yako/parameters.hpp>

namespace servobus::yako {

/// One drive on a line; `closed_loop::drive` or `open_loop::drive`.
///
///     yako::closed_loop::drive axis{wire, 1};
///     if (!axis.run(init{})) ...
///     if (!axis.run(enable{})) ...
///     if (!axis.run(home{homing::home_24})) ...
///     if (!axis.run(move_to{5000 * pulse})) ...
///
/// In a superloop `begin(command)` instead of `run`, and `step()` once a turn. After an unknown outcome or a
/// restart of the drive the state is `needs_init`, and no motion is ordered until `init` has run. A restart
/// shows in a homing that is lost, or in registers that hold something else: software limits, word order,
/// speed resolution, the stored profile of a move and the speeds of a homing, where these are used.
///
/// `watch_commands` also counts while the axis homes: its limit must be longer than that takes.
template <class Device, class Line>
class basic_drive : public drive_base<basic_drive<Device, Line>, Line, prepared_command> {
    using base = drive_base<basic_drive<Device, Line>, Line, prepared_command>;
    friend base;

  public:
    using feedback = basic_feedback<Device>;

    constexpr basic_drive(Line& on, const servobus::node<Device>& at) : base{on, at} {}

    constexpr drive_state state() const { return cached_.state; }
    constexpr const cached_settings& cached() const { return cached_; }
    /// The order of the words of 32-bit values; `unknown` before `init` too, and while a command may change
    /// it.
    constexpr word_order current_word_order() const {
        const effect due = this->runner().is_idle() ? effect{} : this->current().then;
        const bool is_open =
            due == effect::word_order_set || due == effect::forgotten || due == effect::reset;
        const bool is_known = !is_open && !this->runner().is_doubted();
        return is_known && cached_.state != drive_state::needs_init ? cached_.word_order
                                                                    : word_order::unknown;
    }
    /// The feedback read last.
    constexpr const feedback& seen() const { return seen_; }
    /// Whether the last motion that was ordered was seen to begin; after a start that ended `unknown`,
    /// whether the motor was found running or away from its place. `unknown` for a move that interrupts
    /// another: which of the two runs cannot be seen; and for one to zero that is over when it is looked at,
    /// since a drive that keeps its registers over a restart may look the same [errata A55].
    constexpr motion_check motion() const { return motion_; }

    /// Reads error, status, terminals, position and speed in one frame.
    result<feedback> read() {
        const routine_status r = this->run(read_feedback{});
        if (!r) return r.status;
        return seen_;
    }

  private:
    static constexpr bool is_closed_loop = detail::is_closed_loop<Device>;
    static constexpr duration start_limit = milliseconds(200);
    static constexpr duration steady_time = milliseconds(50);         // a stand between two legs is shorter
    static constexpr duration lost_time = milliseconds(500);          // standing without a home this long
    static constexpr std::int32_t stillness = is_closed_loop ? 5 : 0; // pulses by which a motor trembles

    template <class Wanted> constexpr prepared_command plan(const Wanted& wanted) const {
        if constexpr (requires { typename Wanted::device; }) {
            static_assert(std::is_same_v<typename Wanted::device, Device>,
                          "this command belongs to the other variant of the drive");
        }
        prepared_command o = wanted.plan(cached_);
        if (!o.body.empty()) {
            o.at = phase::prechecking;
            o.steps = next_look(o);
        }
        return o;
    }

    // A body that begins with a check has it before the look, and its own writes right behind the look.
    static constexpr bool has_check(const prepared_command& o) {
        return o.body[0].what == step::kind::expect;
    }
    static constexpr routine next_look(const prepared_command& o) {
        const routine look =
            is_closed_loop ? routine{routines::look_closed_loop} : routine{routines::look_open_loop};
        const std::size_t done = o.looked;
        if (!has_check(o)) return look.only(done);
        return done == 0 ? o.body.only(0) : look.only(done - 1);
    }

    constexpr errc admit(prepared_command& o) {
        if (is_motion(o.then)) motion_ = motion_check::not_asked;
        return errc::ok;
    }

    static constexpr cached_settings nothing() { return {.is_closed_loop = is_closed_loop}; }
    constexpr void forget() {
        cached_ = nothing();
        is_creeping_ = false;
    }

    static constexpr bool is_motion(effect e) {
        return e == effect::moved || e == effect::crept || e == effect::jogged || e == effect::homed;
    }
    static constexpr bool takes_over(const prepared_command& o) { return o.then == effect::initialised; }
    static constexpr bool is_command(const prepared_command& o) { return is_motion(o.then); }
    static constexpr bool leaves_doubt(const prepared_command& o) {
        return o.at != phase::prechecking && o.then != effect::none && o.then != effect::seen &&
               !is_command(o);
    }
    // No watchdog of the drive's own stops a motor that was lost sight of: it counts as powered until `init`,
    // whose first frame is a stop.
    constexpr bool is_powered() const {
        if (cached_.state != drive_state::needs_init) return cached_.state == drive_state::enabled;
        return this->current().then != effect::initialised;
    }
    constexpr prepared_command watch_stop() const { return yako::stop{}.plan(cached_); }
    static constexpr duration keep_alive_interval() { return {}; }
    static constexpr bool restarts_on_traffic = false;
    constexpr prepared_command keep_alive() const { return read_feedback{}.plan(cached_); }
    // Neither is kept but by a save.
    constexpr steps::recheck recheck() const {
        if (cached_.state == drive_state::needs_init) return {};
        return {.look =
                    is_closed_loop ? &routines::still_as_in_closed_loop : &routines::still_as_in_open_loop,
                .words = {static_cast<std::uint16_t>(cached_.word_order == word_order::high_first ? 0 : 1),
                          static_cast<std::uint16_t>(cached_.resolution)}};
    }

    constexpr void apply(const prepared_command& o) {
        if (o.stop != stop_priority::no_stop) is_creeping_ = false;
        if (o.at == phase::prechecking) return look_on(o);
        if (o.at == phase::verifying) return pursue(o);
        switch (o.then) {
        case effect::initialised: return take_over();
        case effect::enabled:
            cached_.state = drive_state::enabled;
            this->await_first_command();
            break;
        case effect::released:
            if (cached_.state != drive_state::needs_init) cached_.state = drive_state::released;
            if (!is_closed_loop) lose_home();
            break;
        case effect::quick_stopped: lose_home(); break;
        case effect::profile_set: keep_profile(o); break;
        case effect::homing_profile_set:
            cached_.has_homing_profile = true;
            cached_.homing_speeds[0] = o.arguments[0];
            cached_.homing_speeds[1] = o.arguments[1];
            break;
        case effect::limited: cached_.limits = limit_enable::after_homing; break;
        case effect::unlimited: cached_.limits = limit_enable::disabled; break;
        case effect::word_order_set: cached_.word_order = word_order_of(o.arguments[0]); break;
        case effect::resolution_set:
            cached_.resolution = static_cast<speed_count>(o.arguments[0]);
            cached_.has_scale = true;
            cached_.has_profile = false;
            cached_.has_homing_profile = false;
            break;
        case effect::forgotten: forget(); break;
        case effect::seen:
            look();
            if (!still_stands()) forget();
            break;
        case effect::trusted:
            look();
            cached_.is_homed = cached_.was_homed && seen_.state.is_homed();
            if (!cached_.is_homed) this->report_as(routine_status{errc::needs_homing});
            break;
        case effect::positions_compared: motion_ = compared(); break;
        case effect::moved:
        case effect::crept:
        case effect::jogged:
        case effect::homed:
        case effect::kept:
        case effect::position_cleared:
        case effect::reset: start_pursuit(o); break;
        case effect::none: break;
        }
    }

    constexpr void fail(const prepared_command& o, const routine_status& r) {
        if (o.then == effect::positions_compared) return;
        if (o.at == phase::verifying) {
            motion_ = motion_check::unknown;
            end(r.status);
            forget();
            if (o.then == effect::homed) this->follow(watch_stop()); // it would home on unseen
            return;
        }
        if (o.at == phase::prechecking) this->report_as(r);
        if (o.at == phase::acting) {
            this->report_as(r);
            if (r.outcome() == outcome::unknown && is_start(o.steps[r.step])) {
                motion_ = motion_check::unknown;
                this->follow(
                    {.steps = post_check(o), .arguments = o.arguments, .then = effect::positions_compared});
            }
        }
        if (base::is_in_doubt(r)) forget();
    }

    static constexpr bool is_start(const step& s) {
        return s.what == step::kind::write && s.address == motion_command.address &&
               motion_code::from_word(s.value).is_start();
    }
    static constexpr word_order word_order_of(std::uint16_t word) {
        return word == 0 ? word_order::high_first : word_order::low_first;
    }

    constexpr void take_over() {
        this->await_first_command();
        const auto w = this->runner().words();
        const std::uint16_t count = is_closed_loop ? w[routines::resolution_word] : std::uint16_t{0};
        if (w[routines::limits_word] > 1 || w[routines::word_order_word] > 1 || count > 1) {
            forget();
            return end({errc::unexpected_value});
        }
        const bool is_certain = count == 0;
        const auto status = motion_status::from_word(w[routines::status_word_at]);
        cached_ = {.state = status.is_enabled() ? drive_state::enabled : drive_state::released,
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
            cached_.profile[i] = w[routines::profile_at + i];
        cached_.homing_speeds[0] = w[routines::homing_speeds_at];
        cached_.homing_speeds[1] = w[routines::homing_speeds_at + 1u];
        is_creeping_ = false;
        this->await_first_command();
    }

    constexpr void keep_profile(const prepared_command& o) {
        cached_.has_profile = true;
        for (std::size_t i = 0; i < cached_settings::profile_words; ++i) cached_.profile[i] = o.arguments[i];
    }

    constexpr void look() {
        seen_ = feedback::from_words(this->runner().words(), cached_.word_order, cached_.resolution);
    }

    // False for a drive that was restarted since. An open loop loses its position with its current.
    constexpr bool still_stands() {
        if (cached_.is_homed && !seen_.state.is_homed()) return false;
        const bool is_enabled = seen_.state.is_enabled();
        cached_.state = is_enabled ? drive_state::enabled : drive_state::released;
        if (!is_closed_loop && !is_enabled) lose_home();
        if (!seen_.state.is_moving()) is_creeping_ = false;
        return true;
    }

    // Where the axis is, is not known any more: nor is what an earlier program found.
    constexpr void lose_home() {
        cached_.is_homed = false;
        cached_.was_homed = false;
    }

    // A creep under way, in the same direction.
    constexpr bool goes_on(const prepared_command& o) const {
        const std::int32_t pace = seen_.velocity.count();
        const bool is_opposite = (pace > 0 && o.target < 0) || (pace < 0 && o.target > 0);
        return o.then == effect::crept && is_creeping_ && !is_opposite;
    }

    constexpr errc judge(const prepared_command& o) {
        const auto w = this->runner().words();
        const bool has_word_order = w[routines::word_order_at] <= 1 &&
                                    word_order_of(w[routines::word_order_at]) == cached_.word_order;
        const auto count = static_cast<std::uint16_t>(cached_.resolution);
        const bool has_limits = w[routines::limits_at] == static_cast<std::uint16_t>(cached_.limits);
        const bool has_count = !is_closed_loop || w[routines::resolution_at] == count;
        if (!has_limits || !has_word_order || !has_count) return errc::needs_init;
        look();
        if (!still_stands()) return errc::needs_init;
        const motion_status s = seen_.state;
        if (has(o.needs, requirement::healthy) && s.has_alarm()) return errc::faulted;
        if (has(o.needs, requirement::enabled) && !s.is_enabled()) return errc::wrong_state;
        if (has(o.needs, requirement::released) && s.is_enabled()) return errc::wrong_state;
        if (has(o.needs, requirement::standing) && s.is_moving() && !goes_on(o)) return errc::busy;
        // Bit 3 acts in positioning only (section 4.1): a jog or a homing would run on.
        if (o.then == effect::moved && s.is_moving() && !is_positioning_) return errc::busy;
        if (has(o.needs, requirement::homed) && !cached_.is_homed) return errc::needs_homing;
        return errc::ok;
    }

    // The frames of a look belong together only if the drive was not restarted between them, which costs at
    // least one frame. A program that steps rarely looks the same: so it is not asked for ever.
    constexpr void look_on(prepared_command o) {
        const instant heard = this->runner().last_heard();
        const duration gap = since(heard_, heard);
        const duration loss = this->runner().limits().response + this->runner().gaps().quarantine;
        const bool is_torn = o.looked != 0 && gap > loss && o.looks < 2;
        heard_ = heard;
        if (is_torn) ++o.looks;
        o.looked = is_torn ? std::uint8_t{0} : static_cast<std::uint8_t>(o.looked + 1);
        if (o.looked == (has_check(o) ? 3 : 2)) return act(o);
        o.steps = next_look(o);
        this->follow(o);
    }

    // The drive was looked at: now the command itself, if it may be.
    constexpr void act(prepared_command o) {
        if (const errc refusal = judge(o); refusal != errc::ok) {
            this->report_as(routine_status{refusal});
            if (refusal == errc::needs_init) forget();
            return;
        }
        if (goes_on(o)) {
            motion_ = motion_check::seen;
            return;
        }
        if (is_motion(o.then)) {
            is_creeping_ = false;
            before_ = seen_.position;
            pair_word_order_ = cached_.word_order;
            was_homed_ = seen_.state.is_homed();
            was_moving_ = seen_.state.is_moving();
            is_positioning_ = o.then == effect::moved || o.then == effect::crept;
            if (o.then == effect::homed) lose_home();
        }
        o.at = phase::acting;
        o.steps = o.body.behind(has_check(o) ? 1 : 0);
        this->follow(o);
    }

    constexpr void start_pursuit(prepared_command o) {
        if (o.steps[0].count == routines::write_move.count) keep_profile(o);
        has_begun_ = false;
        sent_ = this->runner().line().now();
        stood_since_ = sent_;
        o.at = phase::verifying;
        o.steps = routines::feedback;
        this->follow(o);
    }

    // It was acknowledged: is it carried out?
    constexpr void pursue(const prepared_command& o) {
        look();
        if (o.then == effect::kept || o.then == effect::reset) {
            if (seen_.state.is_moving()) return end({errc::not_executed});
            if (o.then == effect::reset) forget();
            return;
        }
        if (o.then == effect::position_cleared) {
            if (!seen_.state.is_homed()) lose_home(); // whether it stays homed is not stated [errata A54]
            if (!is_near(distance{0})) end({errc::not_executed});
            return;
        }
        if (seen_.state.has_alarm()) return end({errc::faulted});
        if (o.then == effect::homed) return pursue_home(o);
        if (has_moved() || (o.has_target && is_at_goal(o))) {
            if (!seen_.state.is_moving() && o.steps.size() == 1) { // a short move, or a restart: at zero
                prepared_command closer = o;
                closer.steps = post_check(o);
                return this->follow(closer);
            }
            const bool is_over = !seen_.state.is_moving();
            if (is_over && !may_be_over(o)) { // a shaft that still comes to rest gets as long as a start
                if (since(sent_, this->runner().line().now()) < start_limit) return this->follow(o);
                motion_ = motion_check::unknown;
                if (may_have_restarted(seen_.position)) forget();
                return end({errc::not_reached});
            }
            // One that interrupts another cannot be told from it.
            const bool is_certain = !was_moving_ && !(is_over && may_have_restarted(seen_.position));
            motion_ = is_certain ? motion_check::seen : motion_check::unknown;
            is_creeping_ = o.then == effect::crept;
        } else if (since(sent_, this->runner().line().now()) < start_limit) {
            this->follow(o);
        } else {
            motion_ = motion_check::not_seen;
            end({errc::not_executed});
        }
    }

    static constexpr routine post_check(const prepared_command& o) {
        if (o.then == effect::homed) return routines::after_home;
        if (o.then == effect::jogged) return routines::after_jog;
        return has_check(o) ? routine{routines::after_stored_move} : routine{routines::after_move};
    }

    // The drive may still say "homed" from the time before, and may stand for a moment between two legs.
    constexpr void pursue_home(const prepared_command& o) {
        const instant now = this->runner().line().now();
        const duration taken = since(sent_, now);
        if (has_moved()) has_begun_ = true;
        if (!seen_.state.is_homed()) was_homed_ = false;
        if (seen_.state.is_moving()) stood_since_ = now;
        const duration stood = since(stood_since_, now);
        const bool is_motionless = o.arguments[1] == static_cast<std::uint16_t>(homing::current_position);
        const bool is_new = !was_homed_ || is_motionless || (has_begun_ && is_at_home(o));
        const bool is_found = seen_.state.is_homed() && is_new;
        motion_ = has_begun_ ? motion_check::seen : motion_check::not_seen;
        const bool is_there = !o.has_target || is_near(goal_of(o));
        const bool may_yet_begin = !is_there && taken < start_limit;
        if (is_found && stood >= steady_time && !may_yet_begin) {
            if (!is_there) return end({errc::not_executed});
            cached_.is_homed = true;
        } else if (!is_found && !has_begun_ && taken >= start_limit) {
            end({errc::not_executed});
        } else if (!is_found && has_begun_ && stood >= lost_time) {
            end({errc::not_reached});
        } else if (taken > o.limit) {
            end({errc::not_reached});
            prepared_command halt = watch_stop();
            halt.at = phase::acting; // its failure is reported instead
            this->follow(halt);
        } else {
            this->follow(o);
        }
    }

    constexpr void end(status why) { this->report_as({why.with_sent(true)}); }

    // Where "homed" has not fallen, as it need not [errata A54], the place alone tells that home was found;
    // not where it says the actual value.
    constexpr bool is_at_home(const prepared_command& o) const {
        const unsigned rule = o.arguments[0] < 6 ? o.arguments[0] : o.arguments[0] - 6u; // it moves, or stays
        const distance offset{from_bits<i32>(join_words(o.arguments[2], o.arguments[3], pair_word_order_))};
        const distance places[] = {offset, distance{0}, distance{0} - offset};
        return rule < 3 && is_near(places[rule]);
    }
    constexpr distance goal_of(const prepared_command& o) const {
        return o.is_absolute ? distance{o.target} : before_ + distance{o.target};
    }
    constexpr bool is_near(distance place) const {
        const std::int32_t off = (seen_.position - place).count();
        return off <= stillness && off >= -stillness;
    }
    // At a goal so near that a motor which trembles may seem to have reached it, it must have come exactly.
    constexpr bool is_at_goal(const prepared_command& o) const {
        const std::int32_t way = (goal_of(o) - before_).count();
        const bool is_short = way <= stillness && way >= -stillness;
        return is_short ? seen_.position == goal_of(o) : is_near(goal_of(o));
    }
    // Whether a motion that was ordered may have ended already. An interrupting one ends at an unknown place.
    constexpr bool may_be_over(const prepared_command& o) const {
        return was_moving_ || (o.has_target && is_at_goal(o));
    }
    // A restart may put the position to zero, and keep every register that would show it [errata A55].
    constexpr bool may_have_restarted(distance now) const {
        const auto is_zero = [](distance d) { return d.count() <= stillness && d.count() >= -stillness; };
        return is_zero(now) && !is_zero(before_);
    }
    constexpr bool has_moved() const { return seen_.state.is_moving() || !is_near(before_); }

    // After a start that was not answered nothing is believed any more, but the place before it is known.
    constexpr motion_check compared() const {
        const auto w = this->runner().words();
        const distance place = feedback::position_in(w, pair_word_order_);
        const std::int32_t way = (place - before_).count();
        if (motion_status::from_word(w[routines::status_at]).is_moving()) return motion_check::seen;
        if (may_have_restarted(place)) return motion_check::unknown;
        return way > stillness || way < -stillness ? motion_check::seen : motion_check::not_seen;
    }

    cached_settings cached_ = nothing();
    feedback seen_{};
    distance before_{}; // where the last motion began
    instant sent_{};    // when its start was acknowledged
    instant stood_since_{};
    instant heard_{}; // when the last frame of a look left
    word_order pair_word_order_ = word_order::unknown;
    motion_check motion_ = motion_check::not_asked;
    bool was_homed_ = false;
    bool was_moving_ = false;
    bool is_positioning_ = false; // the last motion was a move to a place
    bool has_begun_ = false;
    bool is_creeping_ = false;
};

} // namespace servobus::yako
