// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Judges one run: compares what the facade reports with what is seen of the drive from outside. It does so when the
// command has ended, a while later, and once the drive is taken over again. The runs are made by sim/conformance.hpp.
//
//     template <class Subject> void complain(sim::conformance_judge<Subject>& judge, sim::trial<Subject>& t) {
//         judge.begin(t, 0);
//         if (t.is_energised()) judge.broken("S1", "the motor is energised before its first command");
//     }
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/command_status.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/subject.hpp>
#include <servobus/sim/conformance/trial.hpp>
#include <servobus/sim/conformance/wire_log.hpp>

namespace servobus::sim {

template <class Subject> class conformance_judge {
  public:
    using trial_type = trial<Subject>;
    using drive_type = typename trial_type::drive_type;
    using report = void (*)(void* context, const finding&);

    conformance_judge(report to, void* context) : report_{to}, context_{context} {}

    /// Begins the judgement of another run, which `t` outlives.
    void begin(trial_type& t, unsigned interpretation, planned_mishap first = {},
               planned_mishap second = {}) {
        now_ = {.interpretation = interpretation, .first = first, .second = second};
        trial_ = &t;
        reported_ = nullptr;
        goal_known_ = false;
        chosen_ = {};
    }
    /// Names in the findings what is played.
    void name(const char* command) { now_.command = command; }
    /// Begins the command that is judged, in the state that the drive has.
    void begin_command(const char* command) {
        name(command);
        was_enabled_ = trial_->drive().state() == drive_state::enabled;
    }
    /// Sets the target of the newest move that has started.
    void aim_at(std::int64_t goal) {
        goal_ = goal;
        goal_known_ = true;
    }
    /// Keeps which requests have been sent, without those that are like others.
    void note_requests() { chosen_ = trial_->log().chosen(); }

    /// The run that is judged: its command, interpretation and mishaps.
    const finding& now() const { return now_; }
    /// The requests that were kept last.
    const chosen_requests& chosen() const { return chosen_; }
    std::uint32_t findings() const { return findings_; }
    /// True after so many findings that others would hide what to mend first.
    bool is_enough() const { return findings_ >= 100; }
    bool can_be_done(const char* command) const { return Subject::can_be_done(now_.interpretation, command); }
    bool is_undisturbed() const { return now_.first.what == mishap::none; }
    bool is_one_frame_lost() const {
        return now_.first.what >= mishap::request_lost && now_.first.what <= mishap::response_damaged &&
               now_.second.what == mishap::none;
    }

    /// Reports a broken promise, the same one once in a run.
    void broken(const char* promise, const char* what) {
        if (reported_ == what) return;
        reported_ = what;
        if (is_enough()) return;
        ++findings_;
        send(promise, what);
        if (!is_enough()) return;
        ++findings_;
        send("kit", "so many findings are enough: nothing else is played");
    }
    /// Reports a failed command that leads to the start of the one that is judged.
    void must(const command_status& r) {
        if (!r) broken("kit", "a command that leads to the start of a run fails on an undisturbed line");
    }

    /// Judges a command that has ended well: the drive was at some time since the last request as it says.
    template <class Command> void at_end(const Command&, const expected& does) {
        trial_type& t = *trial_;
        constexpr bool is_init = std::is_same_v<Command, init>;
        if constexpr (std::is_same_v<Command, enable>) {
            const bool is_hidden_stop =
                !Subject::shows(now_.interpretation).wired_stop && t.has_happened(mishap::stop_input);
            const bool is_wrong = !t.was_energised() && !is_hidden_stop;
            if (is_wrong) t.live(milliseconds(200)); // its end does not wait for the next feedback
            if (is_wrong && t.drive().state() == drive_state::enabled && !t.is_energised())
                broken("G35",
                       "enable is reported done, the state is enabled, and the motor is not energised");
        }
        if constexpr (std::is_same_v<Command, disable>) {
            if (!t.was_off()) broken("G26", "disable is reported done, and the motor is energised");
        }
        if constexpr (is_init || std::is_same_v<Command, disable> || std::is_same_v<Command, halt> ||
                      std::is_same_v<Command, quick_stop> || std::is_same_v<Command, wait_standstill>) {
            if (!t.stood())
                broken("G26", "a stop, or a wait for standstill, is reported done, and the motor turns");
        }
        if constexpr (std::is_same_v<Command, wait_reached>) {
            if (goal_known_ && !t.was_at(goal_))
                broken("G34", "the move is reported to have reached its target, and the motor is elsewhere");
        }
        if (does.ends_at_goal()) {
            if (!t.stood()) broken("G34", "a homing is reported done, and the motor turns");
            if (!t.was_at(does.where))
                broken("G34", "a homing is reported done, and the motor is not at home");
        }
        if (does.what == expected::kind::turns) {
            // A motor takes time to turn.
            for (int i = 0; i < 35 && is_undisturbed() && !t.is_turning(); ++i) t.live(milliseconds(10));
            if (is_undisturbed() && !t.turned() && can_be_done(now_.command))
                broken("G35", "a motion is reported done, and the motor stands");
        }
    }

    /// Judges a while afterwards, on a sound line, and once the drive is taken over again.
    template <class Command> void afterwards(const Command&, const expected& does) {
        trial_type& t = *trial_;
        using named = std::remove_cvref_t<Command>;
        constexpr bool is_init = std::is_same_v<named, init>;
        constexpr bool is_enable = std::is_same_v<named, enable>;
        constexpr bool may_energise_by_reset =
            std::is_same_v<named, fault_reset> && Subject::energises_by_reset;
        drive_type& d = t.drive();
        for (unsigned ms = 0; ms < 1'500; ms += 50) {
            t.live(milliseconds(50));
            judge_arrival(t);
            // A second mishap may meet what follows the first one.
            if (ms == 450 && !is_undisturbed()) note_requests();
        }
        const what_shows shows = Subject::shows(now_.interpretation);
        const bool is_hidden_stop = !shows.wired_stop && t.has_happened(mishap::stop_input);
        const bool is_foreign = t.has_happened(mishap::foreign_write);
        const bool is_blind = (does.hides_restart && t.has_restarted()) ||
                              (!shows.restart_in_a_change && t.has_restarted_in_a_change());
        if (!is_foreign) {
            const bool by_level = Subject::energises_by_level && t.has_restarted();
            const bool by_command = is_enable || may_energise_by_reset;
            // After each restart a halt may energise as well, also after an enable.
            const unsigned allowed = (by_command ? 1u : 0u) + (by_level ? planned_restarts() : 0u);
            if (t.energised() > allowed) broken("S1", "the motor was energised, which was not commanded");
            if (by_level && !is_enable && !is_blind && t.energised() != 0 && t.is_energised())
                broken("S5", "a stop has energised a drive that had restarted, and it stays energised");
        }
        if (!does.is_motion() && !is_foreign && !is_blind && !t.was_turning() &&
            (t.most() - t.begun_at() > Subject::tolerance || t.begun_at() - t.least() > Subject::tolerance))
            broken("S1", "the motor has moved, which was not commanded");
        // Without power a motor rolls on, and a halt near the target has a ramp of its own.
        const bool has_power = !t.has_happened(mishap::program_halts) && !t.has_happened(mishap::fault) &&
                               !t.has_restarted() && !t.has_happened(mishap::stop_input) &&
                               !t.has_happened(mishap::program_disables) &&
                               !t.has_happened(mishap::program_stalls);
        if (does.what == expected::kind::moves_by && has_power) {
            const std::int64_t low = does.where < 0 ? t.begun_at() + does.where : t.begun_at();
            const std::int64_t high = does.where < 0 ? t.begun_at() : t.begun_at() + does.where;
            if (t.least() < low - Subject::tolerance || t.most() > high + Subject::tolerance)
                broken("G15", "a move by a way went farther than its way");
        }
        if (is_undisturbed()) {
            const bool can_enable = can_be_done("enable");
            if (is_enable && can_enable && d.state() != drive_state::enabled)
                broken("G35", "enable is done on an undisturbed line, and the state is another one");
            if (std::is_same_v<named, disable> && d.state() != drive_state::disabled)
                broken("G35", "disable is done on an undisturbed line, and the state is another one");
        }
        if (d.state() == drive_state::enabled && !t.is_energised() && !is_hidden_stop)
            broken("G35", "the drive is not energised, its feedback is read, and the state is enabled");
        if (d.state() == drive_state::disabled && t.is_energised() && !is_foreign)
            broken("G35", "the drive is energised, its feedback is read, and the state is disabled");
        if (t.has_happened(mishap::fault) && d.state() == drive_state::enabled)
            broken("G35", "the drive has a fault, its feedback is read, and the state is enabled");
        const bool can_be_seen =
            shows.restart == restart_shows::always ||
            (shows.restart == restart_shows::while_enabled && was_enabled_ && !is_enable);
        if (can_be_seen && !is_blind && t.has_restarted() && !is_init && d.state() == drive_state::enabled)
            broken("G21", "the drive has restarted, and the state is enabled as before");
        if (does.ends_at_goal() && t.is_turning() && !is_foreign && !is_blind)
            broken("G20", "a homing has ended, and the motor turns on");
        for (int i = 0; i < 200 && t.is_turning(); ++i) t.live(milliseconds(100));
        if (is_blind && !shows.every_stop && t.is_turning()) {
            Subject::restart(t.machine());
        } else if (t.is_turning() && !is_foreign && !does.is_move()) {
            broken("G20", "the motor turns on after the command timeout, or after a stop");
        }
        recover(t);
    }

  private:
    unsigned planned_restarts() const {
        const auto is_restart = [](mishap m) {
            return m == mishap::restart_before || m == mishap::restart_after;
        };
        return (is_restart(now_.first.what) ? 1u : 0u) + (is_restart(now_.second.what) ? 1u : 0u);
    }
    void judge_arrival(trial_type& t) {
        if (t.drive().arrival().how != arrival_state::reached) return;
        if (!goal_known_) return;
        if (!t.was_at(goal_))
            broken("G34", "arrival() is reached, and the motor is not at the target of the newest move");
    }

    void recover(trial_type& t) {
        t.heal();
        if (!t.finish()) {
            broken("G29", "the command that the program began meanwhile does not end");
            return;
        }
        command_status ready = t.run(init{});
        // An init during which the restart of before is found ends with that.
        if (ready == errc::needs_init && t.has_restarted()) ready = t.run(init{});
        if (!ready) {
            broken("G28", "init fails on a sound line");
            return;
        }
        // A register that a cut command has left otherwise may want what take_over does.
        if (t.drive().state() != drive_state::disabled && t.drive().state() != drive_state::faulted &&
            !Subject::take_over(t.drive(), t.machine()))
            broken("G28", "the drive cannot be taken over again on a sound line");
        if (t.drive().state() == drive_state::faulted) {
            const bool is_reset = static_cast<bool>(t.run(fault_reset{}));
            if (!is_reset && !can_be_done("fault_reset")) {
                Subject::restart(t.machine());
                must(t.run(init{}));
            } else if (!is_reset) {
                broken("G28", "a fault whose cause has ended cannot be reset");
            }
        }
        if (t.is_turning()) broken("S1", "init is done, and the motor turns");
        if (!t.run(disable{})) broken("G28", "disable fails on a sound line");
        if (t.is_energised()) broken("G26", "disable is done on a sound line, and the motor is energised");
        const bool is_enabled = static_cast<bool>(t.run(enable{}));
        if (!can_be_done("enable")) {
            if (is_enabled) broken("kit", "enable is done, and the subject says that it cannot be");
            if (t.is_energised())
                broken("G37", "an enable that cannot be confirmed leaves the motor energised");
            return;
        }
        if (!is_enabled) {
            broken("G28", "enable fails on a sound line after init");
            return;
        }
        if (!t.is_energised())
            broken("G35", "enable is done on a sound line, and the motor is not energised");
    }

    void send(const char* promise, const char* what) {
        finding f = now_;
        f.promise = promise;
        f.what = what;
        f.trace = trial_->trace();
        if (report_ != nullptr) report_(context_, f);
    }

    report report_;
    void* context_;
    trial_type* trial_ = nullptr;
    const char* reported_ = nullptr;
    std::uint32_t findings_ = 0;
    finding now_{};
    chosen_requests chosen_{};
    std::int64_t goal_ = 0;
    bool goal_known_ = false;
    bool was_enabled_ = false; // before the command
};

} // namespace servobus::sim
