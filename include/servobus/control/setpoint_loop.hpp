// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The loop of a program around one drive. It takes the drive over, again after each loss, begins the latest setpoint
// every period, and reports each end once. It resets faults and energises only after a consent that the program gives
// each time. Programs that step a facade include it.
//
//     setpoint_loop loop{wheels, take_over{}, enable{}, setpoints<zlac8015d::wheel_velocities>{}};
//     loop.enable();                              // a consent: the operator has pressed the button
//     loop.set({30 * r_per_min, 30 * r_per_min}); // the latest setpoint, in each iteration
//     wire.sleep(loop.step());                    // on a bus: all.step(), then loop.command()
//     if (const loop_report ended = loop.take_report()) std::puts(text(ended.what));
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/control/after_enable.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/detail/after_enable_progress.hpp>
#include <servobus/control/detail/loop_reports.hpp>
#include <servobus/control/loop_report.hpp>
#include <servobus/control/motor_drive.hpp>
#include <servobus/control/moving_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// The setpoints of a loop: any command without constants that must be given, such as `zlac8015d::clamped_velocity`.
template <std::default_initializable Command> struct setpoints {
    using command = Command;
    duration every =
        milliseconds(20); ///< the latest one is begun again after so long; below the command timeout
    duration lasts =
        milliseconds(200); ///< a setpoint that is older is not begun: the program gives them no more
};

/// For a drive that is commanded by `begin` only, such as a lift by its moves.
struct no_setpoints {
    struct command {};
    duration every{};
    duration lasts{};
};

/// A drive in a loop that never waits. It refers to the drive; nothing else commands the drive meanwhile.
///
///     constexpr take_over set_up{zlac8015d::resolution{10}};
///     setpoint_loop loop{wheels, set_up, enable{}, setpoints<zlac8015d::wheel_velocities>{}};
///
/// **Motion never begins by itself.** The program's `enable()` allows it once the drive is enabled. It ends with a stop
/// through the loop, a fault, a wired stop or limit switch, or a setpoint that was not carried out. It also ends with a
/// loss: a restart, a lost port, an outcome that is not known. After each of them another `enable()` must follow. (A
/// YAKO's wired stop shows only by a setpoint that is not carried out. A wired stop that ends before the next setpoint
/// is not seen.) A setpoint that was given before `enable()` is never begun. A setpoint that has become old is not
/// begun again, so that the command timeout stops the drive. The next setpoint of the program moves it again. Like
/// every facade it is not a safety function.
///
/// The commands of an `after_enable`, such as a homing, run before motion is allowed. The consent to the enable covers
/// them: **the machine moves then**. Meanwhile `begin` returns `busy` and no setpoint is begun. A setpoint that is
/// given before their end is never begun. Whatever ends that motion is allowed ends these commands too, and so does
/// the first of them that fails. `loop_part::after_enable` is reported then, but not for a stop of the program.
///
///     setpoint_loop loop{lift, take_over{disable{}}, enable{}, after_enable{home{homing::home_24}}};
///
/// The list of the take-over runs again after each loss, and once in `retry` until it succeeds. Put no `save{}` in it,
/// which would wear the drive's EEPROM. Each attempt without a response doubles that time, up to 10 s.
template <motor_drive Drive, class TakeOver, class Enable = servobus::enable, class Setpoints = no_setpoints,
          detail::list_after_enable AfterEnable = after_enable<>>
class setpoint_loop {
    static_assert(!detail::list_after_enable<Enable> && !detail::list_after_enable<Setpoints>,
                  "after_enable{...} comes right after the enable: take_over{}, enable{}, after_enable{...}, "
                  "setpoints<>{}");
    static_assert(!TakeOver::resets_faults,
                  "a loop resets faults by consent: reset_faults(), not with_fault_reset{} in its take-over");
    static constexpr bool has_setpoints = !std::same_as<Setpoints, no_setpoints>;
    static constexpr bool has_list = AfterEnable::size != 0; // after the enable
    using setpoint = typename Setpoints::command;
    using list_progress =
        std::conditional_t<has_list, detail::after_enable_progress, detail::nothing_after_enable>;

  public:
    /// `retry`: from one attempt to take the drive over to the next, while the drive responds.
    constexpr explicit setpoint_loop(Drive& drive, const TakeOver& list, const Enable& how = {},
                                     const Setpoints& times = {}, duration retry = milliseconds(1000))
        : drive_{&drive}, list_{list}, enable_{how}, times_{times}, retry_{retry}, wait_{retry} {}
    /// `then`: after each enable, before motion is allowed.
    constexpr setpoint_loop(Drive& drive, const TakeOver& list, const Enable& how, const AfterEnable& then,
                            const Setpoints& times = {}, duration retry = milliseconds(1000))
        : drive_{&drive}, list_{list}, enable_{how}, then_{then}, times_{times}, retry_{retry}, wait_{retry} {
    }
    setpoint_loop(const setpoint_loop&) = delete; // a consent is used once
    setpoint_loop& operator=(const setpoint_loop&) = delete;

    /// Steps the drive and then commands it. Returns what the drive's `step` does.
    constexpr duration step() {
        const duration idle = drive_->step();
        command();
        return idle;
    }
    /// Commands the drive, which the program or its bus has stepped: the end of what is under way, then what is next.
    constexpr void command() {
        watch();
        if (!drive_->is_idle() || conclude()) return; // an end is reported before the next one can come
        begin_next();
    }

    // --- What the program wants

    /// Consents once to energise the drive and to move it then. It waits for a take-over that is under way. A loss, a
    /// fault, a stop, or a take-over that fails withdraws it. Without effect while motion is allowed already, and while
    /// the commands of `after_enable` run.
    constexpr void enable() {
        if (may_move_ || progress_.is_under_way()) return;
        may_enable_ = true;
        is_set_ = false;
    }
    /// Consents once to a fault reset. False, and without effect, if the drive has no fault. It stays disabled after
    /// it.
    constexpr bool reset_faults() {
        may_reset_ = drive_->state() == drive_state::faulted;
        return may_reset_;
    }
    /// The latest setpoint, which replaces the one before. It is begun at the next period in which motion is allowed.
    constexpr void set(const setpoint& wanted) requires has_setpoints {
        setpoint_ = wanted;
        set_at_ = now();
        is_set_ = true;
    }
    /// Begins another command of the drive: a move, a setting. `last()` of the drive, and a report, say how it ends.
    /// Errors: the command's own; `busy` if something is under way; `needs_init` until the drive is taken over;
    /// `wrong_state` for a command that moves or energises while motion is not allowed.
    template <class Wanted> constexpr command_status begin(const Wanted& wanted) {
        if (asked_ != loop_part::none || !drive_->is_idle()) return errc::busy;
        if (!is_taken_over_) return errc::needs_init;
        if (may_move<detail::model_of_drive<Drive>, Wanted> && !may_move_) return errc::wrong_state;
        const command_status refusal = drive_->begin(wanted);
        if (refusal) asked_ = loop_part::command;
        if constexpr (has_list) {
            using model = detail::model_of_drive<Drive>;
            if (refusal)
                progress_.note_command(may_move<model, Wanted>, detail::changes_power<model, Wanted>());
        }
        return refusal;
    }

    // --- Stops, which go before everything else. Each ends that motion is allowed, also if the drive refuses it.

    /// Begins `halt{}`. Errors: the command's own.
    constexpr command_status halt() { return stop_by(servobus::halt{}); }
    /// Begins `quick_stop{}`. Errors: the command's own.
    constexpr command_status quick_stop() { return stop_by(servobus::quick_stop{}); }
    /// Begins `disable{}`. Errors: the command's own.
    constexpr command_status disable() { return stop_by(servobus::disable{}); }

    // --- What the program is told

    /// The last end that was not taken yet; one that is not taken is replaced by the next. Setpoints that succeed are
    /// not reported. Where the drive itself has ended the permission to move, that is reported, or that what was under
    /// way has failed. A failure that is repeated is reported once, until it succeeds or something else has ended.
    constexpr loop_report take_report() { return reports_.take(); }
    constexpr bool is_taken_over() const { return is_taken_over_; }
    /// True while setpoints are begun, and moves can be.
    constexpr bool is_motion_allowed() const { return may_move_; }
    constexpr Drive& drive() const { return *drive_; }

  private:
    constexpr instant now() const { return drive_->line().now(); }

    // A stop by the drive's wiring, whose end must not let it move again. After a fault or a restart it is not enabled.
    constexpr bool is_held() const { return drive_->cause() == stop_cause::input; }
    // A setpoint that was not carried out: a wired stop that only shows by that may keep the motor at rest.
    static constexpr bool shows_stop(errc e) {
        return e == errc::not_executed || e == errc::not_reached || e == errc::stopped_short;
    }
    constexpr bool is_unable() const { return seen_ != drive_state::enabled || is_held(); }
    constexpr errc why_unable() const {
        return seen_ == drive_state::needs_init ? errc::needs_init
               : seen_ == drive_state::faulted  ? errc::faulted
                                                : errc::wrong_state;
    }
    constexpr void watch() {
        const drive_state before = seen_;
        seen_ = drive_->state();
        const bool is_lost = is_taken_over_ && seen_ == drive_state::needs_init;
        if (is_lost) is_taken_over_ = false;
        if constexpr (has_list) {
            if ((may_move_ || progress_.is_under_way() || progress_.is_done()) && is_unable()) end_list();
        } else {
            if (may_move_ && (seen_ != drive_state::enabled || is_held())) end_motion();
        }
        if (is_lost || (seen_ == drive_state::faulted && before != drive_state::faulted)) withdraw();
    }
    constexpr void end_motion() {
        withdraw();
        (void)reports_.note({.what = loop_part::permission, .how = why_unable()});
    }
    constexpr void withdraw() {
        may_enable_ = may_reset_ = may_move_ = is_set_ = false;
        progress_.withdraw();
    }
    constexpr void allow_motion() { may_move_ = is_due_ = true; }
    // The drive is energised by a consent.
    constexpr void go_on() {
        if constexpr (has_list) {
            if (!progress_.is_done()) return progress_.begin();
        }
        allow_motion();
    }
    // The drive is not as the list needs it or has left it. The end of a command that is under way is reported later.
    constexpr void end_list() {
        const bool is_between = progress_.is_under_way() && asked_ != loop_part::after_enable;
        progress_.invalidate();
        if (may_move_) return end_motion();
        if (is_between) (void)fail_list(why_unable());
    }
    // A newer consent is withdrawn too: it was given before the failure was known.
    constexpr bool fail_list(const command_status& how) {
        withdraw();
        return reports_.note({loop_part::after_enable, progress_.numbered(how)});
    }

    template <class Stop> constexpr command_status stop_by(const Stop& wanted) {
        if constexpr (has_list) progress_.note_stop(std::same_as<Stop, servobus::halt>, asked_);
        withdraw();
        const command_status refusal = drive_->begin(wanted);
        if (refusal) asked_ = loop_part::stop;
        if constexpr (has_list) {
            if (!refusal) progress_.invalidate();
        }
        return refusal;
    }

    // The drive is idle: what the loop has begun has ended. True if that is reported.
    constexpr bool conclude() {
        const loop_part ended = asked_;
        if (ended == loop_part::none) return false;
        const command_status how = drive_->last();
        if (ended == loop_part::take_over) {
            parts_.conclude(how, seen_);
            return parts_.is_over() && end_take_over();
        }
        asked_ = loop_part::none;
        if (ended == loop_part::setpoint && how) {
            reports_.note_success(ended);
            return false;
        }
        if (ended == loop_part::setpoint && shows_stop(how.error())) withdraw();
        if constexpr (has_list) {
            if (ended == loop_part::enable && progress_.is_checking()) return conclude_check(how);
        }
        if (ended == loop_part::enable) conclude_enable(static_cast<bool>(how));
        if constexpr (has_list) {
            if (ended == loop_part::after_enable) return conclude_listed(how);
            progress_.note_end(ended, how, shows_stop(how.error()));
        }
        return reports_.note({.what = ended, .how = how});
    }
    constexpr bool conclude_check(const command_status& how) {
        progress_.end_check(static_cast<bool>(how));
        if (how && (may_enable_ || !is_unable())) return false; // it is enabled next, if the consent lasts
        may_enable_ = false;
        return reports_.note({.what = loop_part::enable, .how = how ? command_status{why_unable()} : how});
    }
    constexpr bool conclude_listed(const command_status& how) {
        if (!how) return fail_list(how);
        if (!progress_.is_under_way()) // it was withdrawn meanwhile, and a newer consent begins the list anew
            return reports_.note({loop_part::after_enable, progress_.numbered(why_unable())});
        if (!progress_.advance(AfterEnable::size)) return false;
        is_set_ = false;
        allow_motion();
        return reports_.note({.what = loop_part::after_enable});
    }
    // A stop that the drive refused meanwhile has withdrawn the consent all the same.
    constexpr void conclude_enable(bool is_done) {
        if (may_enable_ && is_done && seen_ == drive_state::enabled) go_on();
        may_enable_ = false;
    }
    // The line worked, and the drive sent nothing.
    static constexpr bool is_unanswered(const command_status& how) {
        return how.outcome() == outcome::unknown && how.error() >= errc::no_echo &&
               how.error() <= errc::bad_gap;
    }
    constexpr duration longer_wait() const {
        constexpr duration longest = milliseconds(10'000);
        if (wait_ >= longest) return wait_;
        return wait_ * 2 < longest ? wait_ * 2 : longest;
    }
    constexpr bool end_take_over() {
        const command_status done = parts_.status();
        asked_ = loop_part::none;
        is_taken_over_ = static_cast<bool>(done);
        wait_ = is_unanswered(done) ? longer_wait() : retry_;
        if (!done) withdraw();
        return reports_.note({loop_part::take_over, done});
    }

    constexpr void begin_next() {
        const instant at = now();
        if (asked_ == loop_part::take_over) return begin_part();
        if (!is_taken_over_) {
            if (has_tried_ && since(tried_, at) < wait_) return;
            has_tried_ = true;
            tried_ = at;
            asked_ = loop_part::take_over;
            parts_ = list_.begin();
            return begin_part();
        }
        if (seen_ == drive_state::faulted) {
            if (may_reset_) start(fault_reset{}, loop_part::fault_reset);
            may_reset_ = false;
            return;
        }
        if constexpr (has_list) {
            if (progress_.is_under_way()) return begin_listed();
        }
        if (may_enable_) return begin_enable();
        if constexpr (has_setpoints) {
            if (may_move_ && is_set_) begin_setpoint(at);
        }
    }
    constexpr void begin_part() {
        const command_status refusal =
            list_.template apply<Drive>(parts_, [this](const auto& part) { return drive_->begin(part); });
        if (refusal) return;
        parts_.conclude(refusal, seen_);
        (void)end_take_over();
    }
    constexpr void begin_enable() {
        if (seen_ != drive_state::enabled || is_held()) {
            start(enable_, loop_part::enable);
            may_enable_ = asked_ == loop_part::enable; // until it has ended
            return;
        }
        if constexpr (has_list) {
            if (progress_.is_check_due()) return begin_check();
        }
        may_enable_ = false;
        go_on(); // it is energised, as after a halt
        (void)reports_.note({.what = loop_part::enable});
    }
    // The list is left out only for a drive whose feedback shows no fault and no restart now, also if nothing polls it.
    constexpr void begin_check() {
        start(read_feedback{}, loop_part::enable);
        may_enable_ = asked_ == loop_part::enable;
        if (may_enable_) progress_.begin_check();
    }
    constexpr void begin_listed() {
        const command_status refusal = then_.template apply<Drive>(
            progress_.index(), [this](const auto& listed) { return drive_->begin(listed); });
        if (refusal)
            asked_ = loop_part::after_enable;
        else
            (void)fail_list(refusal);
    }
    constexpr void begin_setpoint(instant at) {
        if (since(set_at_, at) > times_.lasts) {
            is_set_ = false;
            return;
        }
        const duration gone = since(begun_, at);
        if (!is_due_ && gone < times_.every) return;
        const bool keeps_rhythm = !is_due_ && gone < times_.every * 2;
        begun_ = keeps_rhythm ? begun_ + times_.every : at;
        is_due_ = false;
        start(setpoint_, loop_part::setpoint);
    }
    template <class Wanted> constexpr void start(const Wanted& wanted, loop_part what) {
        const command_status refusal = drive_->begin(wanted);
        if (refusal)
            asked_ = what;
        else
            (void)reports_.note({.what = what, .how = refusal});
    }

    Drive* drive_;
    [[no_unique_address]] TakeOver list_;
    [[no_unique_address]] Enable enable_;
    [[no_unique_address]] AfterEnable then_{};
    Setpoints times_;
    [[no_unique_address]] setpoint setpoint_{};
    duration retry_;
    duration wait_;   // until the next attempt
    instant tried_{}; // the last attempt to take the drive over
    instant begun_{}; // the last setpoint
    instant set_at_{};
    detail::take_over_progress parts_ = list_.begin();
    detail::loop_reports reports_{};
    loop_part asked_ = loop_part::none; // under way, or its end is not concluded
    drive_state seen_ = drive_state::needs_init;
    [[no_unique_address]] list_progress progress_{};
    bool has_tried_ = false;
    bool is_taken_over_ = false;
    bool may_enable_ = false; // a consent that is not used up, or whose enable is under way
    bool may_reset_ = false;
    bool may_move_ = false;
    bool is_set_ = false; // since the last consent, and not too old
    bool is_due_ = false; // the first setpoint, which waits for no period
};
template <class Drive, class TakeOver, class Enable, class... Commands, class Setpoints = no_setpoints>
setpoint_loop(Drive&, const TakeOver&, const Enable&, const after_enable<Commands...>&, const Setpoints& = {},
              duration = {}) -> setpoint_loop<Drive, TakeOver, Enable, Setpoints, after_enable<Commands...>>;
// In the wrong order, for the error above.
template <class Drive, class TakeOver, class Enable, class Setpoints, class... Commands>
setpoint_loop(Drive&, const TakeOver&, const Enable&, const Setpoints&, const after_enable<Commands...>&)
    -> setpoint_loop<Drive, TakeOver, Enable, after_enable<Commands...>>;

} // namespace servobus
