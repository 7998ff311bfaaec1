// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The states in which sim/conformance/player.hpp begins a command: the drive is ready, the motor turns or moves, or
// there is a fault. Commands that lead there must succeed, since nothing disturbs them.
//
//     template <class Subject> bool is_ready(sim::conformance_judge<Subject>& judge, sim::trial<Subject>& t) {
//         return sim::conformance_start{judge, t}.take_over(); // if not, the judge has reported why
//     }
#pragma once

#include <servobus/control/common_commands.hpp>
#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/judge.hpp>
#include <servobus/sim/conformance/trial.hpp>

namespace servobus::sim {

template <class Subject> class conformance_start {
  public:
    conformance_start(conformance_judge<Subject>& judge, trial<Subject>& t) : judge_{judge}, trial_{t} {}

    /// Makes the drive ready, as its author says. Returns false, after a finding, if that fails.
    bool take_over() const {
        if (Subject::take_over(trial_.drive(), trial_.machine())) return true;
        if (trial_.wire().responses() == 0) {
            judge_.broken("kit", "the simulated drive has not responded: see address and baud of the "
                                 "subject, and take_over");
        } else if (trial_.drive().last().error() == errc::exception) {
            judge_.broken("kit", "the simulated drive refuses a request of take_over: it does not know the "
                                 "register, or the value");
        } else {
            judge_.broken("kit", "take_over fails on an undisturbed line");
        }
        return false;
    }
    /// Lets the motor turn. Returns false if the drive has no command for that.
    bool turn() const {
        return with_first(
            [this](const char* name, const expected& e) {
                return e.what == expected::kind::turns && judge_.can_be_done(name);
            },
            [this](const char*, const auto& enabled_by, const auto& wanted, const expected&) {
                enable_by(enabled_by);
                run(wanted);
                trial_.live(milliseconds(100));
                for (int i = 0; i < 40 && !trial_.is_turning(); ++i)
                    trial_.live(milliseconds(10)); // its ramp begins slowly
            });
    }
    /// Begins a move. Returns false if the drive has none.
    bool move() const {
        return with_first(
            [this](const char* name, const expected& e) { return e.is_move() && judge_.can_be_done(name); },
            [this](const char*, const auto& enabled_by, const auto& wanted, const expected& does) {
                enable_by(enabled_by);
                judge_.aim_at(does.goal_from(trial_.place()));
                run(wanted);
            });
    }
    /// Lets the drive have a fault, and the facade answer it by a stop.
    void have_fault() const {
        Subject::have_fault(trial_.machine());
        trial_.live(milliseconds(300));
        (void)trial_.finish();
    }
    /// Runs a command that must succeed.
    template <class Command> void run(const Command& wanted) const { judge_.must(trial_.run(wanted)); }

    /// Calls `use(name, enabled_by, command, expected)` for the first own command that `fits(name, expected)`.
    template <class Fits, class Use> static bool with_first(const Fits& fits, const Use& use) {
        bool is_done = false;
        Subject::commands(
            [&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
                if (is_done || !fits(name, does)) return;
                is_done = true;
                use(name, enabled_by, wanted, does);
            });
        return is_done;
    }

  private:
    template <class Enable> void enable_by(const Enable& enabled_by) const {
        run(disable{});
        run(enabled_by);
    }

    conformance_judge<Subject>& judge_;
    trial<Subject>& trial_;
};

} // namespace servobus::sim
