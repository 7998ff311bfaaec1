// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plays one command of a drive from its start state, with up to two mishaps, and has it judged. The commands are those
// that every drive has, from standstill and in motion, then the drive's own. sim/conformance.hpp says which are played.
//
//     // Each of its runs begins with a new simulated drive:
//     template <class Subject> using first_of_a_run = sim::trial<Subject>;
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/common_commands.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/control/routine_status.hpp>
#include <servobus/control/states.hpp>
#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/judge.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/trial.hpp>

namespace servobus::sim {

namespace detail {
// The model of a facade.
template <class Model, class Line> Model model_of_facade(const facade<Model, Line>&);
} // namespace detail

/// Counts the runs so far.
struct played {
    std::uint32_t runs = 0;
    std::uint32_t findings = 0;
    std::uint32_t happened[sizeof all_mishaps / sizeof *all_mishaps + 1]{}; ///< by mishap
};

template <class Subject> class conformance_player : protected conformance_judge<Subject> {
    using base = conformance_judge<Subject>;

  protected:
    using base::base;
    using base::broken;
    using base::goal_;
    using base::goal_known_;
    using base::now_;
    using base::was_enabled_;
    using typename base::trial_type;

    // The commands that every drive has, then the drive's own.
    enum common : unsigned {
        init_while_turning,
        enable_it,
        disable_while_turning,
        halt_while_turning,
        quick_stop_while_turning,
        disable_while_moving,
        quick_stop_while_moving,
        reset_fault,
        wait_for_standstill,
        wait_for_target,
        move_again,
        read_it,
        first_own
    };

    static unsigned own() {
        unsigned count = 0;
        Subject::commands([&](const char*, const auto&, const auto&, const expected&) { ++count; });
        return count;
    }
    static unsigned cases() { return first_own + own(); }

    // Calls `use(name, enabled_by, command, expected)` for the first own command that `fits`.
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

    // A move that may follow the first one: the same by a way, or the next to a place.
    template <class Use> static void with_second_move(const Use& use) {
        unsigned moves = 0;
        bool is_done = false;
        Subject::commands(
            [&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
                if (is_done || !does.is_move()) return;
                if (++moves == 1 && does.what == expected::kind::moves_to) return;
                is_done = true;
                use(name, enabled_by, wanted, does);
            });
    }

    // --- One run

    unsigned play(unsigned which, unsigned interpretation, planned_mishap first, planned_mishap second) {
        base::requests_ = 0;
        if (base::is_enough()) return 0;
        if (which == reset_fault && first.what == mishap::none) judge_reset_in_vain(interpretation);
        trial_type t{interpretation};
        base::begin(t, interpretation, first, second);
        ++played_.runs;
        if (which == first_own && first.what == mishap::none) judge_unknown(t);
        if (!take_over(t)) {
            played_.findings = base::findings();
            return 0;
        }
        if (which != enable_it && which < first_own && !can_be_done("enable")) return 0;
        switch (which) {
        case init_while_turning:
            if (turn(t)) play(t, "init", init{});
            break;
        case enable_it:
            this->must(t.run(disable{}));
            play(t, "enable", enable{});
            break;
        case disable_while_turning:
            if (turn(t)) play(t, "disable, turning", disable{});
            break;
        case halt_while_turning:
            if (turn(t)) play(t, "halt, turning", halt{});
            break;
        case quick_stop_while_turning:
            if (turn(t)) play(t, "quick_stop, turning", quick_stop{});
            break;
        case disable_while_moving:
            if (move(t)) play(t, "disable, moving", disable{});
            break;
        case quick_stop_while_moving:
            if (move(t)) play(t, "quick_stop, moving", quick_stop{});
            break;
        case reset_fault:
            this->must(t.run(enable{}));
            Subject::have_fault(t.machine());
            t.live(milliseconds(300));
            (void)t.finish(); // the stop that answers the fault
            Subject::end_fault(t.machine());
            play(t, "fault_reset", fault_reset{});
            break;
        case wait_for_standstill:
            if (move(t)) play(t, "wait_standstill", wait_standstill{milliseconds(10'000)});
            break;
        case wait_for_target:
            if (move(t)) play(t, "wait_reached", wait_reached{milliseconds(10'000)});
            break;
        case move_again:
            if (!move(t)) break;
            this->must(t.run(wait_reached{}));
            with_second_move([&](const char*, const auto&, const auto& wanted, const expected& does) {
                does_ = does;
                play(t, "a second move", wanted);
            });
            break;
        case read_it:
            this->must(t.run(enable{}));
            play(t, "read_feedback", read_feedback{});
            break;
        default: play_own(t, which - first_own);
        }
        played_.findings = base::findings();
        for (const mishap m : all_mishaps)
            played_.happened[static_cast<unsigned>(m)] += t.has_happened(m) ? 1u : 0u;
        return base::requests_;
    }
    bool take_over(trial_type& t) {
        if (Subject::take_over(t.drive(), t.machine())) return true;
        if (t.wire().responses() == 0) {
            broken(
                "kit",
                "the simulated drive has not responded: see address and baud of the subject, and take_over");
        } else if (t.drive().last().error() == errc::exception) {
            broken("kit", "the simulated drive refuses a request of take_over: it does not know the "
                          "register, or the value");
        } else {
            broken("kit", "take_over fails on an undisturbed line");
        }
        return false;
    }
    void play_own(trial_type& t, unsigned which) {
        unsigned i = 0;
        Subject::commands(
            [&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
                if (i++ != which) return;
                if constexpr (std::is_same_v<std::remove_cvref_t<decltype(enabled_by)>, disable>) {
                    this->must(t.run(disable{}));
                } else {
                    if (!can_be_done("enable")) return;
                    this->must(t.run(disable{}));
                    const routine_status enabled = t.run(enabled_by);
                    if (can_be_done(name)) this->must(enabled);
                }
                does_ = does;
                play(t, name, wanted);
            });
    }
    // Nothing is known of the drive: each command but `init` and stops is refused, and nothing is sent.
    void judge_unknown(trial_type& t) {
        const auto refuses = [&](const char* name, const auto& wanted) {
            now_.command = name;
            t.watch();
            if (t.drive().begin(wanted) != errc::ok) {
                if (t.requests() != 0) broken("G21", "a refused command has sent something");
                return;
            }
            broken("G21", "a command is accepted although nothing is known of the drive");
            (void)t.finish();
        };
        refuses("enable", enable{});
        refuses("fault_reset", fault_reset{});
        refuses("wait_standstill", wait_standstill{});
        refuses("wait_reached", wait_reached{});
        refuses("read_feedback", read_feedback{});
        Subject::commands([&](const char* name, const auto& enabled_by, const auto& wanted, const expected&) {
            refuses(name, wanted);
            if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(enabled_by)>, disable>)
                refuses("enabling", enabled_by);
        });
    }
    // A fault whose cause has not ended: its reset must not be reported done while the feedback shows the fault.
    void judge_reset_in_vain(unsigned interpretation) {
        trial_type t{interpretation};
        base::begin(t, interpretation, {}, {});
        now_.command = "fault_reset";
        if (!Subject::take_over(t.drive(), t.machine()) || !t.run(enable{})) return;
        Subject::have_fault(t.machine());
        t.live(milliseconds(300));
        (void)t.finish(); // the stop that answers the fault
        if (!t.run(fault_reset{}) || !t.run(read_feedback{})) return;
        if (t.drive().state() == drive_state::faulted)
            broken("G35", "a fault reset is reported done, and the fault remains");
    }
    // Without a kind of motion the command is neither supervised, nor is `preempt` called when it is replaced.
    template <class Command> void judge_kind(trial_type& t, const Command& wanted) {
        if constexpr (requires {
                          detail::model_of_facade(t.drive());
                          wanted.plan(t.drive().cached());
                      }) {
            using model = decltype(detail::model_of_facade(t.drive()));
            const command_kind kind = model::kinds[wanted.plan(t.drive().cached()).then];
            if (kind != command_kind::endless_motion && kind != command_kind::move)
                broken("kit", "the command moves the motor, and its effect is of no kind of motion");
        }
    }
    bool can_be_done(const char* command) const { return Subject::can_be_done(now_.interpretation, command); }
    // False if the drive has no such command: what is played from there is left out.
    bool turn(trial_type& t) {
        return with_first(
            [&](const char* name, const expected& e) {
                return e.what == expected::kind::turns && can_be_done(name);
            },
            [&](const char*, const auto& enabled_by, const auto& wanted, const expected&) {
                this->must(t.run(disable{}));
                this->must(t.run(enabled_by));
                this->must(t.run(wanted));
                t.live(milliseconds(100));
                for (int i = 0; i < 40 && !t.is_turning(); ++i)
                    t.live(milliseconds(10)); // its ramp begins slowly
            });
    }
    bool move(trial_type& t) {
        return with_first(
            [&](const char* name, const expected& e) { return e.is_move() && can_be_done(name); },
            [&](const char*, const auto& enabled_by, const auto& wanted, const expected& does) {
                this->must(t.run(disable{}));
                this->must(t.run(enabled_by));
                goal_ = does.goal_from(t.place());
                goal_known_ = true;
                this->must(t.run(wanted));
            });
    }

    template <class Command> void play(trial_type& t, const char* name, const Command& wanted) {
        constexpr bool is_stop = std::is_same_v<Command, disable> || std::is_same_v<Command, halt> ||
                                 std::is_same_v<Command, quick_stop>;
        now_.command = name;
        const expected does = does_;
        does_ = {};
        t.watch(now_.first, now_.second);
        was_enabled_ = t.drive().state() == drive_state::enabled;
        const std::int64_t goal = does.goal_from(t.place());
        const bool begins_itself = does.is_motion() && !does.ends_at_goal(); // a homing may be a follow-up
        if (begins_itself && base::is_undisturbed() && can_be_done(name)) judge_kind(t, wanted);
        const errc refused = t.drive().begin(wanted);
        if (refused != errc::ok) {
            if (!can_be_done(name)) return;
            broken("kit", "a command is refused in the state in which it is to be played");
            return;
        }
        const bool has_ended = t.finish();
        base::note_requests(t);
        if (!has_ended) {
            broken("G29", "the command does not end");
            return;
        }
        // A stop of the facade may be under way after another mishap, or after a command that cannot be confirmed.
        if (t.is_stop_refused() && can_be_done(name) && now_.first.what == mishap::program_disables &&
            !std::is_same_v<Command, disable> && !std::is_same_v<Command, quick_stop>)
            broken("G25", "a disable is refused while another command is under way");
        const routine_status& r = t.drive().last();
        const bool is_replaced =
            t.has_happened(mishap::program_halts) || t.has_happened(mishap::program_disables);
        if (base::is_undisturbed() && !r && can_be_done(name)) {
            if (r.error() == errc::exception) {
                broken("kit", "the simulated drive refuses a request of the command: it does not know the "
                              "register, or the value");
            } else {
                broken("G29", "the command fails on an undisturbed line");
            }
        }
        if (is_stop && base::is_one_frame_lost() && !r && can_be_done(name))
            broken("G26", "a stop ends without success after one frame was lost: it is not repeated");
        if (r && !is_replaced) base::judge_done(t, wanted, does);
        // A stop of the facade itself follows a fault, a restart and a stall.
        const bool is_followed =
            t.has_happened(mishap::fault) || t.has_restarted() || t.has_happened(mishap::program_stalls);
        if (r.outcome() == outcome::not_sent && !is_replaced && !is_followed && t.writes() != 0 && !is_stop)
            broken("G16", "the command ends as not sent, but a request that writes has left");
        if (does.has_goal() && t.has_started()) {
            goal_ = goal;
            goal_known_ = true;
        }
        base::judge_later(t, wanted, does);
    }

    played played_{};
    expected does_{}; // the command that is played next
};

} // namespace servobus::sim
