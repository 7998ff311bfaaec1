// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facades of all drives derive from this one. A facade keeps the drive's feedback as a process image and runs one
// command at a time. It checks that the drive has not restarted, and stops it where the application or the line fails.
// Its machine decides (control/drive_machine.hpp); the facade moves the machine's frames over a line. The `drive.hpp`
// of each device derives from it and describes the drive by a model.
//
//     if (!wheels.begin(velocity{30 * r_per_min, 30 * r_per_min})) return 1;
//     while (!wheels.is_idle()) wheels.step(); // in your loop, between your other work
//     if (!wheels.last()) std::puts(text(wheels.last().error()));
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/drive_machine.hpp>
#include <servobus/control/drive_model.hpp>
#include <servobus/control/drive_traits.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

/// A facade of one drive on `Line`; nothing else sends to the drive. `Model` describes it (device/README.md).
template <class Model, class Line> class facade {
    static_assert(Model::kinds.is_complete(),
                  "an effect has no kind: each is listed in the `kinds` of the model");
    static_assert(Model::kinds.are_origins_stated(),
                  "which commands have a new origin is stated: `with_new_origin()` of `kinds`, for none too");
    static_assert(image_block<Model>.words != 0, "the feedback of a model is at least one register");
    static_assert(image_block<Model>.words <= steps::longest,
                  "the feedback of a model is at most 11 registers");
    static_assert(Model::traits.stops_without_line == (Model::watchdog(Model::unknown) != duration{}),
                  "a drive that stops without its line has a watchdog, also while its settings are unknown");
    static_assert(drive_model<Model>,
                  "a model has each part of device/README.md, in the form that it has there");

  public:
    using model_type = Model;
    using prepared_command = typename Model::prepared_command;
    using settings = typename Model::settings;
    using machine_type = drive_machine<Model, typename Line::exchange>;
    /// In which respects the drive differs from others.
    static constexpr drive_traits traits = Model::traits;

    /// True if no command is under way, nor a stop of a supervisor.
    constexpr bool is_idle() const { return machine_.slot().is_idle(); }
    /// The end of the application's last command; meaningful when idle. A copy, since the next command has another.
    constexpr command_status last() const { return machine_.slot().report(); }
    /// `faulted` if the last feedback shows a fault.
    constexpr drive_state state() const { return machine_.known().state(); }
    /// Returns the settings as far as they are known now.
    constexpr settings cached() const { return machine_.known().cached(); }
    /// Why the drive stopped following its last motion command; `unknown` while it follows.
    constexpr stop_cause cause() const { return machine_.known().motion().cause(); }
    /// The drive does not respond. A drive with a watchdog is absent after the watchdog's time without a response. Any
    /// other is absent after three refreshes in a row without one. It is then read once a second, on a bus once in the
    /// plan's retry period.
    constexpr bool is_absent() const { return machine_.known().is_absent(); }

    constexpr std::uint8_t address() const { return machine_.address(); }
    constexpr Line& line() const { return *line_; }
    /// Gives a bus, or a test, the machine: what is to be sent, and since when it waits.
    constexpr machine_type& machine() { return machine_; }
    constexpr const machine_type& machine() const { return machine_; }

    // --- Its commands

    /// Runs a command to its end. Waits; bounded by the routine's limits. The command timeout begins again
    /// meanwhile. Errors: the command's own; `preempted` if a stop replaced it.
    template <class Wanted> [[gnu::always_inline]] command_status run(const Wanted& wanted) {
        return run_own(commands::in_units_of_drive<settings>(wanted));
    }
    /// Runs a command that is made of others, such as `take_over`. Waits. Returns which of them failed, and how.
    template <commands::made_of_commands Wanted> command_status run(const Wanted& wanted) {
        return wanted.run_by(*this, [this](const auto& part) { return this->run(part); });
    }

    /// Starts a command; `step` moves it on. A stop replaces a command of lower priority and is sent right after the
    /// frame in flight. Nothing is sent if it is refused. Errors: the command's own; `busy` if another command is under
    /// way; `needs_init`; `faulted`; `bad_argument`. The last is for a node address that the device cannot have, and
    /// for a feedback period shorter than its frames. It is also for a drive that its bus refuses, and for a plan with
    /// neither steps nor a refusal. A command that only the command timeout ends (`needs_command_timeout`) gets it
    /// where there is none.
    template <class Wanted> [[gnu::always_inline]] constexpr command_status begin(const Wanted& wanted) {
        return begin_own(commands::in_units_of_drive<settings>(wanted));
    }
    /// Does not compile, and the error is the command's own: it is several commands.
    template <commands::made_of_commands Wanted> constexpr command_status begin(const Wanted& wanted) {
        (void)commands::prepared(wanted, valid_settings());
        return {};
    }

    /// Moves on without waiting: the command under way, the feedback that is due, the checks of the
    /// supervisors. Returns a time during which no further step is needed unless a byte arrives.
    constexpr duration step() {
        const instant now = line_->now();
        if (machine_.pass(now, *line_)) machine_.notify(*line_);
        if (!machine_.is_on_the_wire()) {
            const flight next = machine_.next(now, *line_);
            if (next != machine_.purpose()) {
                if (machine_.purpose() != flight::none) line_->abandon(machine_.exchange());
                machine_.load(next, now, *line_);
            }
            if (next == flight::none) return milliseconds(1);
        }
        const duration idle = line_->step(machine_.exchange(), machine_.terms().gaps());
        if (!machine_.exchange().done()) return idle;
        machine_.conclude(line_->now(), line_->began_at(), !line_->is_echo_ruled_out(address()));
        if (machine_.announces_stop()) line_->announce_stop();
        return {};
    }

    /// After `limit` without a motion command or a blocking call a motion without an end is stopped. A speed, torque or
    /// jog that awaits its response counts until it ends. So a motor whose program hangs after `begin` is stopped at
    /// the latest `limit` and `longest_setpoint()` later. A stop that is not confirmed is repeated as often, unless
    /// `repeat_stops` has set another period.
    constexpr void set_command_timeout(command_timeout limit) {
        machine_.supervisors().set_limit(limit.limit(), line_->now());
    }
    /// `step` repeats a stop that was not confirmed, `every` so often, until it is, or until a command that
    /// succeeds replaces it. 0: it does not. The default is the command timeout.
    constexpr void repeat_stops(duration every) { machine_.supervisors().repeat_stops(every); }

    /// The longest time of a speed or torque that gets no response and is read back. Each frame takes as long as its
    /// bound.
    constexpr duration longest_setpoint() const {
        const response_limits& limits = machine_.terms().limits();
        const duration lost = line_->bound(longest_write, 8, limits, machine_.terms().gaps());
        return lost + line_->bound(8, 5 + 2 * steps::longest, limits, machine_.terms().gaps()) * 2;
    }
    /// True if one lost response takes longer than the command timeout. The drive is not stopped for that (G40). But a
    /// program that waits for each command's end may command less often than its command timeout asks.
    constexpr bool is_command_timeout_short() const {
        const modbus::rtu_timing& timing = line_->timing();
        const duration frames = timing.wire_time(longest_write + 2 * (8 + 5 + 2 * steps::longest));
        const duration quarantine = longer_of(timing.visible_gap(), machine_.terms().gaps().quarantine);
        return machine_.slot().supervisors().is_shorter_than(machine_.terms().limits().response + quarantine +
                                                             frames);
    }

  protected:
    template <class Node>
    constexpr facade(Line& on, const Node& at, duration feedback, command_timeout limit)
        : line_{&on}, machine_{at, feedback, limit} {}
    ~facade() = default;

    // --- What it shows its drive's own facade

    constexpr const Model& model() const { return machine_.known().model(); }
    constexpr Model& model() { return machine_.model(); }
    constexpr const std::uint16_t* image() const { return machine_.known().feedback().image(); }
    /// Errors of feedback that may be at most so old: `needs_init` where nothing is known of the drive, `busy` while a
    /// command changes settings, `timeout` if it is older or none was read since.
    constexpr errc check_feedback(duration oldest) const {
        if (!machine_.known().is_known()) return errc::needs_init;
        // The command under way may change what values mean.
        const auto& slot = machine_.slot();
        if (slot.is_at(command_kind::setting) || slot.is_at(command_kind::take_over)) return errc::busy;
        return machine_.known().feedback().is_young(oldest, line_->now()) ? errc::ok : errc::timeout;
    }
    /// Returns what the last routine fetched.
    constexpr slice<const std::uint16_t> words() const { return machine_.slot().run().words(); }
    /// From the start of the last motion to the image; zero for an image that is older. It goes back from two minutes
    /// to one: times are not compared over a wrap of the clock.
    constexpr duration since_start() const { return machine_.known().since_start(); }
    /// True while a move begins: the one before has no arrival any more.
    constexpr bool is_move_beginning() const { return machine_.slot().is_at(command_kind::move); }
    /// A move that seems to be under way has been cut by a fault: its stop may be under way.
    constexpr bool is_ended_by_fault(arrival_state how) const {
        return how == arrival_state::under_way && cause() == stop_cause::fault;
    }
    /// The settings are those of the drive as it is now: no request without a response since the last check.
    constexpr bool is_verified() const { return machine_.known().is_verified(line_->epoch(address())); }
    constexpr const prepared_command& current() const { return machine_.slot().command(); }
    constexpr bool is_faulted() const { return machine_.known().is_faulted(); }
    /// The blocks of the feedback that are read less often.
    constexpr const slower_blocks<Model>& slower() const { return machine_.known().polling().slower(); }

  private:
    template <class Wanted>
    static constexpr bool changes_cached_settings = [] {
        if constexpr (requires { Wanted::changes_cached_settings; })
            return Wanted::changes_cached_settings;
        else
            return false;
    }();
    // A command in the units of the drive.
    template <class Wanted> command_status run_own(const Wanted& wanted) {
        prepared_command next = planned(wanted);
        if constexpr (changes_cached_settings<Wanted>) {
            const command_status how = run_planned(next);
            if (how.outcome() != outcome::not_sent) note_change();
            return how;
        } else {
            return run_planned(next);
        }
    }
    template <class Wanted> constexpr command_status begin_own(const Wanted& wanted) {
        prepared_command next = planned(wanted);
        const errc refusal = accept(next);
        if constexpr (changes_cached_settings<Wanted>) {
            if (refusal == errc::ok) note_change();
        }
        return refusal;
    }
    // Another facade of the drive has stale settings from now on.
    constexpr void note_change() {
        line_->note_change(address());
        machine_.note_own_change();
    }
    // The cached settings, if they are still valid now.
    constexpr const settings& valid_settings() { return machine_.valid_settings(line_->now(), *line_); }
    template <class Wanted> constexpr prepared_command planned(const Wanted& wanted) {
        prepared_command next = commands::prepared(wanted, valid_settings());
        if constexpr (requires { Wanted::needs_command_timeout; }) {
            if (next.refusal == errc::ok && !machine_.slot().supervisors().has_limit())
                next.refusal = errc::bad_argument;
        }
        return next;
    }
    // The request for the feedback and its response take longer on the wire than the period.
    constexpr bool is_period_too_short() const {
        const auto& polling = machine_.known().polling();
        const duration every = polling.period();
        return polling.is_on() && every != default_feedback &&
               every < line_->timing().wire_time(13 + 2 * image_block<Model>.words);
    }
    constexpr errc accept(prepared_command& next) {
        if (is_period_too_short()) return errc::bad_argument;
        const errc refusal = machine_.accept(next, line_->now());
        machine_.notify(*line_);
        return refusal;
    }
    // Runs a prepared command: one copy of code for all commands.
    command_status run_planned(prepared_command& next) {
        if (const errc refusal = machine_.note_refusal(accept(next)); refusal != errc::ok) return refusal;
        const std::uint8_t mine = machine_.slot().number();
        auto guard = line_->new_stall_detector();
        while (!is_idle()) {
            machine_.supervisors().note_command(line_->now());
            const duration idle = step();
            if (guard.has_failed(line_->now())) {
                give_up(errc::clock_stopped);
                break;
            }
            line_->sleep(idle);
        }
        return machine_.slot().number() == mine ? last() : command_status{status::sent(errc::preempted)};
    }
    constexpr void give_up(errc why) {
        machine_.give_up(why, line_->now());
        machine_.notify(*line_);
    }

    static constexpr std::size_t longest_write = 9 + 2 * steps::max_arguments; // bytes

    Line* line_;
    machine_type machine_;
};

} // namespace servobus
