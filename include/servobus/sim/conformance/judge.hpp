// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The judgement on one run: what the facade reports against what is seen of the drive from outside, when the command has
// ended, a while later, and once the drive is taken over again. sim/conformance.hpp makes the runs.
//
//     void report(void*, const sim::finding& f) { std::puts(f.what); } // of any judge
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/common_commands.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/subject.hpp>
#include <servobus/sim/conformance/trial.hpp>

namespace servobus::sim {

template <class Subject> class conformance_judge {
  protected:
    using trial_type = trial<Subject>;
    using drive_type = typename trial_type::drive_type;
    using report = void (*)(void* context, const finding&);

    conformance_judge(report to, void* context) : report_{to}, context_{context} {}

    /// Another run begins.
    void begin(trial_type& t, unsigned reading, planned_mishap first, planned_mishap second) {
        now_ = {.reading = reading, .first = first, .second = second};
        trial_ = &t;
        reported_ = nullptr;
        goal_known_ = false;
    }
    std::uint32_t findings() const { return findings_; }
    bool is_undisturbed() const { return now_.first.what == mishap::none; }
    bool is_one_frame_lost() const {
        return now_.first.what >= mishap::request_lost && now_.first.what <= mishap::response_damaged &&
               now_.second.what == mishap::none;
    }

    // Judges a command that has ended well: the drive was at some time since the last request as it says.
    template <class Command> void judge_done(trial_type& t, const Command&, const expected& does) {
        constexpr bool is_init = std::is_same_v<Command, init>;
        if constexpr (std::is_same_v<Command, enable>) {
            if (!t.was_energised()) broken("G35", "enable is reported done, and the motor is not energised");
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
        if (does.what == expected::kind::turns) {
            // A motor takes time to turn.
            for (int i = 0; i < 35 && is_undisturbed() && !t.is_turning(); ++i) t.live(milliseconds(10));
            if (is_undisturbed() && !t.turned())
                broken("G35", "a motion is reported done, and the motor stands");
        }
    }

    // Judges a while afterwards, on a sound line, and once the drive is taken over again.
    template <class Command> void judge_later(trial_type& t, const Command&, const expected& does) {
        using named = std::remove_cvref_t<Command>;
        constexpr bool is_init = std::is_same_v<named, init>;
        constexpr bool is_enable = std::is_same_v<named, enable>;
        constexpr bool may_energise_by_reset =
            std::is_same_v<named, fault_reset> && Subject::energises_by_reset;
        drive_type& d = t.drive();
        for (unsigned ms = 0; ms < 1'500; ms += 50) {
            t.live(milliseconds(50));
            judge_arrival(t);
        }
        const bool is_foreign = t.has_happened(mishap::foreign_write);
        if (!is_foreign) {
            const bool by_level = Subject::energises_by_level && t.has_restarted();
            const unsigned allowed = is_enable || may_energise_by_reset || by_level ? 1u : 0u;
            if (t.energised() > allowed) broken("S1", "the motor was energised, which was not commanded");
            if (by_level && !is_enable && t.energised() != 0 && t.is_energised())
                broken("S5", "a stop has energised a drive that had restarted, and it stays energised");
        }
        const bool is_blind = does.hides_restart && t.has_restarted();
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
            if (is_enable && d.state() != drive_state::enabled)
                broken("G35", "enable is done on an undisturbed line, and the state is another one");
            if (std::is_same_v<named, disable> && d.state() != drive_state::disabled)
                broken("G35", "disable is done on an undisturbed line, and the state is another one");
        }
        if (d.state() == drive_state::enabled && !t.is_energised())
            broken("G35", "the drive is not energised, its feedback is read, and the state is enabled");
        if (d.state() == drive_state::disabled && t.is_energised() && !is_foreign)
            broken("G35", "the drive is energised, its feedback is read, and the state is disabled");
        if (t.has_happened(mishap::fault) && d.state() == drive_state::enabled)
            broken("G35", "the drive has a fault, its feedback is read, and the state is enabled");
        const restart_shows shows = Subject::restart_is_seen(now_.reading);
        const bool can_be_seen = shows == restart_shows::always ||
                                 (shows == restart_shows::while_enabled && was_enabled_ && !is_enable);
        if (can_be_seen && !is_blind && t.has_restarted() && !is_init && d.state() == drive_state::enabled)
            broken("G21", "the drive has restarted, and the state is enabled as before");
        for (int i = 0; i < 200 && t.is_turning(); ++i) t.live(milliseconds(100));
        if (t.is_turning() && !is_foreign && !does.is_move())
            broken("G20", "the motor turns on after the command timeout, or after a stop");
        recover(t);
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
        if (!t.run(init{})) {
            broken("G28", "init fails on a sound line");
            return;
        }
        if (t.drive().state() == drive_state::faulted) {
            if (!t.run(fault_reset{})) broken("G28", "a fault whose cause has ended cannot be reset");
        }
        if (t.is_turning()) broken("S1", "init is done, and the motor turns");
        if (!t.run(disable{})) broken("G28", "disable fails on a sound line");
        if (t.is_energised()) broken("G26", "disable is done on a sound line, and the motor is energised");
        if (!t.run(enable{})) {
            broken("G28", "enable fails on a sound line after init");
            return;
        }
        if (!t.is_energised())
            broken("G35", "enable is done on a sound line, and the motor is not energised");
    }

    // Reports a broken promise, the same one once in a run.
    void broken(const char* promise, const char* what) {
        if (reported_ == what) return;
        reported_ = what;
        ++findings_;
        finding f = now_;
        f.promise = promise;
        f.what = what;
        if (trial_ != nullptr) f.trace = trial_->trace();
        if (report_ != nullptr) report_(context_, f);
    }

    finding now_{};
    std::int64_t goal_ = 0; // of the newest move that has started
    bool goal_known_ = false;
    bool was_enabled_ = false; // before the command

  private:
    report report_;
    void* context_;
    trial_type* trial_ = nullptr;
    const char* reported_ = nullptr;
    std::uint32_t findings_ = 0;
};

} // namespace servobus::sim
