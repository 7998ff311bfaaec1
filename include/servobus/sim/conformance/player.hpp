// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plays one command of a drive from its start state, with up to two mishaps, and has it judged. The commands are those
// that every drive has, from standstill and in motion, then the drive's own. Which are played is up to
// sim/conformance.hpp.
//
//     template <class Subject> bool is_init_sound(void (*print)(void*, const sim::finding&)) {
//         sim::conformance_player<Subject> player{print};
//         (void)player.play(0, 0); // the first command, under the first interpretation, without a mishap
//         return player.so_far().findings == 0;
//     }
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/command_status.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/control/states.hpp>
#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/judge.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/start.hpp>
#include <servobus/sim/conformance/trial.hpp>
#include <servobus/sim/conformance/wire_log.hpp>

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

template <class Subject> class conformance_player {
  public:
    using judge_type = conformance_judge<Subject>;
    using trial_type = trial<Subject>;
    using start_type = conformance_start<Subject>;

    explicit conformance_player(typename judge_type::report to, void* context = nullptr)
        : judge_{to, context} {}

    /// Counts the commands.
    static unsigned cases() {
        unsigned count = first_own;
        Subject::commands([&](const char*, const auto&, const auto&, const expected&) { ++count; });
        return count;
    }
    /// The runs, and what the judge has found in them.
    played so_far() const {
        played all = played_;
        all.findings = judge_.findings();
        return all;
    }
    judge_type& judge() { return judge_; }

    /// Plays the command with this number, 0 .. cases() - 1. Returns its requests at which another mishap may happen.
    chosen_requests play(unsigned which, unsigned interpretation, planned_mishap first = {},
                         planned_mishap second = {}) {
        if (judge_.is_enough()) return {};
        if (which == reset_fault && first.what == mishap::none) judge_reset_in_vain(interpretation);
        trial_type t{interpretation};
        judge_.begin(t, interpretation, first, second);
        ++played_.runs;
        if (which == first_own && first.what == mishap::none) judge_unknown(t);
        const start_type start{judge_, t};
        if (!start.take_over()) return {};
        if (which != enable_it && which < first_own && !judge_.can_be_done("enable")) return {};
        switch (which) {
        case init_while_turning:
            if (start.turn()) play_command(t, "init", init{});
            break;
        case enable_it:
            start.run(disable{});
            play_command(t, "enable", enable{});
            break;
        case disable_while_turning:
            if (start.turn()) play_command(t, "disable, turning", disable{});
            break;
        case halt_while_turning:
            if (start.turn()) play_command(t, "halt, turning", halt{});
            break;
        case quick_stop_while_turning:
            if (start.turn()) play_command(t, "quick_stop, turning", quick_stop{});
            break;
        case disable_while_moving:
            if (start.move()) play_command(t, "disable, moving", disable{});
            break;
        case quick_stop_while_moving:
            if (start.move()) play_command(t, "quick_stop, moving", quick_stop{});
            break;
        case reset_fault:
            start.run(enable{});
            start.have_fault();
            Subject::end_fault(t.machine());
            play_command(t, "fault_reset", fault_reset{});
            break;
        case wait_for_standstill:
            if (start.move()) play_command(t, "wait_standstill", wait_standstill{milliseconds(10'000)});
            break;
        case wait_for_target:
            if (start.move()) play_command(t, "wait_reached", wait_reached{milliseconds(10'000)});
            break;
        case move_again:
            if (!start.move()) break;
            start.run(wait_reached{});
            play_second_move(t);
            break;
        case read_it:
            start.run(enable{});
            play_command(t, "read_feedback", read_feedback{});
            break;
        default: play_own(start, t, which - first_own);
        }
        for (const mishap m : all_mishaps)
            played_.happened[static_cast<unsigned>(m)] += t.has_happened(m) ? 1u : 0u;
        return judge_.chosen();
    }

  private:
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

    void play_own(const start_type& start, trial_type& t, unsigned which) {
        unsigned i = 0;
        (void)start_type::with_first(
            [&](const char*, const expected&) { return i++ == which; },
            [&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
                if constexpr (std::is_same_v<std::remove_cvref_t<decltype(enabled_by)>, disable>) {
                    start.run(disable{});
                } else {
                    if (!judge_.can_be_done("enable")) return;
                    start.run(disable{});
                    const command_status enabled = t.run(enabled_by);
                    if (judge_.can_be_done(name)) judge_.must(enabled);
                }
                play_command(t, name, wanted, does);
            });
    }
    // A move that may follow the first one: the same by a way, or the next to a place.
    void play_second_move(trial_type& t) {
        unsigned moves = 0;
        (void)start_type::with_first(
            [&](const char*, const expected& e) {
                return e.is_move() && (++moves != 1 || e.what != expected::kind::moves_to);
            },
            [&](const char*, const auto&, const auto& wanted, const expected& does) {
                play_command(t, "a second move", wanted, does);
            });
    }
    // Nothing is known of the drive: each command but `init` and stops is refused, and nothing is sent.
    void judge_unknown(trial_type& t) {
        const auto refuses = [&](const char* name, const auto& wanted) {
            judge_.name(name);
            t.watch();
            if (t.drive().begin(wanted) != errc::ok) {
                if (t.requests() != 0) judge_.broken("G21", "a refused command has sent something");
                return;
            }
            judge_.broken("G21", "a command is accepted although nothing is known of the drive");
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
        judge_.begin(t, interpretation);
        judge_.name("fault_reset");
        if (!Subject::take_over(t.drive(), t.machine()) || !t.run(enable{})) return;
        start_type{judge_, t}.have_fault();
        if (!t.run(fault_reset{}) || !t.run(read_feedback{})) return;
        if (t.drive().state() == drive_state::faulted)
            judge_.broken("G35", "a fault reset is reported done, and the fault remains");
    }
    // Without a kind of motion the command is neither supervised, nor is `preempt` called when it is replaced.
    template <class Command> void judge_kind(trial_type& t, const Command& wanted) {
        // A command in the machine's units is made ready by its facade only.
        if constexpr (requires {
                          detail::model_of_facade(t.drive());
                          requires commands::is_preparable<Command, decltype(t.drive().cached())>;
                      }) {
            using model = decltype(detail::model_of_facade(t.drive()));
            const command_kind kind = model::kinds[commands::prepared(wanted, t.drive().cached()).then];
            if (kind != command_kind::endless_motion && kind != command_kind::move)
                judge_.broken("kit", "the command moves the motor, and its effect is of no kind of motion");
        }
    }

    template <class Command>
    void play_command(trial_type& t, const char* name, const Command& wanted, const expected& does = {}) {
        constexpr bool is_stop = std::is_same_v<Command, disable> || std::is_same_v<Command, halt> ||
                                 std::is_same_v<Command, quick_stop>;
        const finding& now = judge_.now();
        judge_.begin_command(name);
        t.watch(now.first, now.second);
        const std::int64_t goal = does.goal_from(t.place());
        const bool begins_itself = does.is_motion() && !does.ends_at_goal(); // a homing may be a follow-up
        if (begins_itself && judge_.is_undisturbed() && judge_.can_be_done(name)) judge_kind(t, wanted);
        if (!t.drive().begin(wanted)) {
            if (!judge_.can_be_done(name)) return;
            judge_.broken("kit", "a command is refused in the state in which it is to be played");
            return;
        }
        const bool has_ended = t.finish();
        judge_.note_requests();
        if (!has_ended) {
            judge_.broken("G29", "the command does not end");
            return;
        }
        // A stop of the facade may be under way after another mishap, or after a command that cannot be confirmed.
        if (t.is_stop_refused() && judge_.can_be_done(name) && now.first.what == mishap::program_disables &&
            !std::is_same_v<Command, disable> && !std::is_same_v<Command, quick_stop>)
            judge_.broken("G25", "a disable is refused while another command is under way");
        const command_status& r = t.drive().last();
        const bool is_replaced =
            t.has_happened(mishap::program_halts) || t.has_happened(mishap::program_disables);
        if (judge_.is_undisturbed() && !r && judge_.can_be_done(name)) {
            if (r.error() == errc::exception) {
                judge_.broken("kit",
                              "the simulated drive refuses a request of the command: it does not know the "
                              "register, or the value");
            } else {
                judge_.broken("G29", "the command fails on an undisturbed line");
            }
        }
        if (is_stop && judge_.is_one_frame_lost() && !r && judge_.can_be_done(name))
            judge_.broken("G26", "a stop ends without success after one frame was lost: it is not repeated");
        if (r && !is_replaced) judge_.at_end(wanted, does);
        // A stop of the facade itself follows a fault, a restart and a stall.
        const bool is_followed =
            t.has_happened(mishap::fault) || t.has_restarted() || t.has_happened(mishap::program_stalls);
        if (r.outcome() == outcome::not_sent && !is_replaced && !is_followed && t.writes() != 0 && !is_stop)
            judge_.broken("G16", "the command ends as not sent, but a request that writes has left");
        if (does.has_goal() && t.has_started()) judge_.aim_at(goal);
        judge_.afterwards(wanted, does);
    }

    judge_type judge_;
    played played_{}; // the judge counts the findings
};

} // namespace servobus::sim
