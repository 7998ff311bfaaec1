// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Judges for every drive: plays each command of a facade against its simulated drive on a hostile line, with every
// mishap at every request, and checks from outside what the library promises. The author of a drive writes a subject,
// which says what the simulated drive does and how it is seen; device/README.md has one of twenty lines.
//
//     template <class Subject> bool is_right(void (*print)(void*, const sim::finding&)) {
//         sim::conformance<Subject> kit{print};
//         return kit.singles().findings == 0; // every mishap at every request of every command
//     }
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/control/motor_drive.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/judge.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/subject.hpp>
#include <servobus/sim/conformance/trial.hpp>

namespace servobus::sim {

/// What was played.
struct played {
    std::uint32_t runs = 0;
    std::uint32_t findings = 0;
    std::uint32_t happened[sizeof all_mishaps / sizeof *all_mishaps + 1]{}; ///< by mishap
};

template <class Subject> class conformance : conformance_judge<Subject> {
    static_assert(conformance_subject<Subject>, "the subject lacks something: see sim::conformance_subject");
    using base = conformance_judge<Subject>;
    using base::broken;
    using base::goal_;
    using base::goal_known_;
    using base::now_;
    using base::was_enabled_;
    using typename base::trial_type;
    static_assert(motor_drive<typename base::drive_type>, "the judges are for a motor_drive");
    static_assert(
        requires(typename base::drive_type & d, typename Subject::machine& m) {
            { Subject::take_over(d, m) } -> std::same_as<bool>;
        },
        "the subject says by take_over(drive, machine) how the drive is made ready");

  public:
    /// Each broken promise is reported to it.
    using typename base::report;

    explicit conformance(report to, void* context = nullptr) : base{to, context} {}

    /// Every mishap at every request of every command, each interpretation of the manual alone. Of equal requests in a
    /// row, as in a wait, the first, the second and the last.
    played singles() {
        for (unsigned reading = 0; reading < Subject::readings; ++reading) singles(reading);
        return played_;
    }
    /// The same for one interpretation.
    played singles(unsigned reading) {
        for (unsigned c = 0; c < cases(); ++c) {
            const unsigned requests = play(c, reading, {}, {});
            const auto is_repeated = repeated_;
            for (unsigned r = 0; r < requests; ++r) {
                if (r < is_repeated.size() && is_repeated[r]) continue;
                for (const mishap m : all_mishaps) (void)play(c, reading, {m, r}, {});
            }
        }
        return played_;
    }
    /// Random pairs of mishaps, as many as `runs`; the same seed plays the same.
    played pairs(std::uint64_t seed, std::uint32_t runs) {
        dice random{seed};
        for (std::uint32_t i = 0; i < runs; ++i) {
            const unsigned c = random.below(cases());
            const unsigned reading = random.below(Subject::readings);
            const auto any = [&](unsigned from) {
                return planned_mishap{all_mishaps[random.below(sizeof all_mishaps / sizeof *all_mishaps)],
                                      from + random.below(12)};
            };
            const planned_mishap first = any(0);
            (void)play(c, reading, first, any(first.request));
        }
        return played_;
    }

    /// One run, whose command and mishaps are taken from bytes: for a fuzzer. Fewer than six bytes play nothing.
    played from(bytes chosen) {
        if (chosen.size() < 6) return played_;
        constexpr std::size_t mishaps = sizeof all_mishaps / sizeof *all_mishaps;
        const planned_mishap first{all_mishaps[chosen[2] % mishaps], chosen[3] % 32u};
        const planned_mishap second{all_mishaps[chosen[4] % mishaps], first.request + chosen[5] % 32u};
        (void)play(chosen[0] % cases(), chosen[1] % Subject::readings, first, second);
        return played_;
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
                if (is_done || !fits(does)) return;
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

    unsigned play(unsigned which, unsigned reading, planned_mishap first, planned_mishap second) {
        trial_type t{reading};
        base::begin(t, reading, first, second);
        requests_ = 0;
        ++played_.runs;
        if (which == first_own && first.what == mishap::none) judge_unknown(t);
        if (!Subject::take_over(t.drive(), t.machine())) {
            broken("kit", "the drive cannot be taken over on an undisturbed line");
            played_.findings = base::findings();
            return 0;
        }
        switch (which) {
        case init_while_turning:
            if (turn(t)) play(t, "init", init{});
            break;
        case enable_it:
            must(t.run(disable{}));
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
            must(t.run(enable{}));
            Subject::have_fault(t.machine());
            t.live(milliseconds(300));
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
            must(t.run(wait_reached{}));
            with_second_move([&](const char*, const auto&, const auto& wanted, const expected& does) {
                does_ = does;
                play(t, "a second move", wanted);
            });
            break;
        case read_it:
            must(t.run(enable{}));
            play(t, "read_feedback", read_feedback{});
            break;
        default: play_own(t, which - first_own);
        }
        played_.findings = base::findings();
        for (const mishap m : all_mishaps)
            played_.happened[static_cast<unsigned>(m)] += t.has_happened(m) ? 1u : 0u;
        return requests_;
    }
    void play_own(trial_type& t, unsigned which) {
        unsigned i = 0;
        Subject::commands(
            [&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
                if (i++ != which) return;
                if constexpr (std::is_same_v<std::remove_cvref_t<decltype(enabled_by)>, disable>) {
                    must(t.run(disable{}));
                } else {
                    must(t.run(disable{}));
                    must(t.run(enabled_by));
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
            const errc refused = t.drive().begin(wanted);
            if (refused != errc::ok) return;
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
        if (t.requests() != 0) broken("G21", "a refused command has sent something");
    }
    void must(const routine_status& r) {
        if (!r) broken("kit", "a command that leads to the start of a run fails on an undisturbed line");
    }
    // False if the drive has no such command: what is played from there is left out.
    bool turn(trial_type& t) {
        return with_first([](const expected& e) { return e.what == expected::kind::turns; },
                          [&](const char*, const auto& enabled_by, const auto& wanted, const expected&) {
                              must(t.run(disable{}));
                              must(t.run(enabled_by));
                              must(t.run(wanted));
                              t.live(milliseconds(100));
                          });
    }
    bool move(trial_type& t) {
        return with_first([](const expected& e) { return e.is_move(); },
                          [&](const char*, const auto& enabled_by, const auto& wanted, const expected& does) {
                              must(t.run(disable{}));
                              must(t.run(enabled_by));
                              goal_ = does.goal_from(t.place());
                              goal_known_ = true;
                              must(t.run(wanted));
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
        const errc refused = t.drive().begin(wanted);
        if (refused != errc::ok) {
            broken("kit", "a command is refused in the state in which it is to be played");
            return;
        }
        const bool has_ended = t.finish();
        requests_ = t.requests();
        for (unsigned i = 0; i < repeated_.size(); ++i) repeated_[i] = t.is_repeated(i);
        if (!has_ended) {
            broken("G29", "the command does not end");
            return;
        }
        // After another mishap a stop of the facade may be under way.
        if (t.is_stop_refused() && now_.first.what == mishap::program_disables &&
            !std::is_same_v<Command, disable> && !std::is_same_v<Command, quick_stop>)
            broken("G25", "a disable is refused while another command is under way");
        const routine_status& r = t.drive().last();
        const bool is_replaced = r.error() == errc::preempted || t.has_happened(mishap::program_halts) ||
                                 t.has_happened(mishap::program_disables);
        if (base::is_undisturbed() && !r) broken("G29", "the command fails on an undisturbed line");
        if (is_stop && base::is_one_frame_lost() && !r)
            broken("G26", "a stop ends without success after one frame was lost: it is not repeated");
        if (r && !is_replaced) base::judge_done(t, wanted, does);
        // A stop of the facade itself follows a fault, a restart and a stall.
        const bool is_followed =
            t.has_happened(mishap::fault) || t.has_restarted() || t.has_happened(mishap::program_stalls);
        if (r.outcome() == outcome::not_sent && !is_replaced && !is_followed && t.writes() != 0 && !is_stop)
            broken("G16", "the command ends as not sent, but a request that writes has left");
        if (does.is_move() && t.has_started()) {
            goal_ = goal;
            goal_known_ = true;
        }
        base::judge_later(t, wanted, does);
    }

    played played_{};
    expected does_{};                  // the command that is played next
    unsigned requests_ = 0;            // of the command that was played last
    std::array<bool, 400> repeated_{}; // those of its requests that need no mishap of their own
};

} // namespace servobus::sim
