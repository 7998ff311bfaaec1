// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Judges for every drive: plays each command of a facade against its simulated drive on a hostile line, with every
// mishap at every request, and checks from outside what the library promises. The author of a drive writes a subject,
// which says what the simulated drive does and how it is seen; device/README.md has one of twenty lines.
//
//     sim::conformance<winch_subject> kit{&print};        // print(const sim::finding&)
//     const sim::played all = kit.singles();              // every mishap at every request of every command
//     if (all.findings != 0) return 1;
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/control/motor_drive.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/trial.hpp>

namespace servobus::sim {

namespace detail {
struct any_command_of_a_subject {
    template <class Enable, class Command>
    void operator()(const char*, const Enable&, const Command&, const expected&) const {}
};
} // namespace detail

/// What the author of a drive says to the kit. All of it is needed: what a drive cannot do is a function that does
/// nothing, and is said so by a constant.
template <class S>
concept conformance_subject = requires(typename S::machine& m, const typename S::machine& seen,
                                       detail::any_command_of_a_subject each) {
    { S::address } -> std::convertible_to<std::uint8_t>;
    { S::baud } -> std::convertible_to<std::uint32_t>;
    { S::readings } -> std::convertible_to<unsigned>;      // interpretations of the manual, at least 1
    { S::tolerance } -> std::convertible_to<std::int64_t>; // of a place, in its counts
    { S::restart_is_seen(0u) } -> std::same_as<restart_shows>;
    { S::energises_by_reset } -> std::convertible_to<bool>; // a fault reset may
    {
        S::energises_by_level
        } -> std::convertible_to<bool>; // so may a stop that meets a drive that has restarted
    {S::make(0u)};
    { S::is_energised(seen) } -> std::same_as<bool>;
    { S::is_turning(seen) } -> std::same_as<bool>;
    { S::place(seen) } -> std::convertible_to<std::int64_t>;
    { S::starts(seen) } -> std::convertible_to<std::uint32_t>; // moves that it has begun
    S::restart(m);
    S::have_fault(m);
    S::end_fault(m);
    S::press_stop(m);
    S::release_stop(m);
    S::write_by_another(m);
    S::commands(each); // each(name, how it is enabled, command, expected)
};

/// What was played.
struct played {
    std::uint32_t runs = 0;
    std::uint32_t findings = 0;
    std::uint32_t happened[sizeof all_mishaps / sizeof *all_mishaps + 1]{}; ///< by mishap
};

template <class Subject> class conformance {
    static_assert(conformance_subject<Subject>, "the subject lacks something: see sim::conformance_subject");
    using trial_type = trial<Subject>;
    using drive_type = typename trial_type::drive_type;
    static_assert(motor_drive<drive_type>, "the kit judges a motor_drive");

  public:
    using report = void (*)(void* context, const finding&);

    explicit conformance(report to, void* context = nullptr) : report_{to}, context_{context} {}

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

    template <class Visit> static void visit_own(Visit&& visit) {
        Subject::commands([&](const char* name, const auto& enabled_by, const auto& wanted,
                              const expected& does) { visit(name, enabled_by, wanted, does); });
    }
    static unsigned own() {
        unsigned count = 0;
        visit_own([&](const char*, const auto&, const auto&, const expected&) { ++count; });
        return count;
    }
    static unsigned cases() { return first_own + own(); }

    // Calls `use(name, enabled_by, command, expected)` for the first own command that `fits`.
    template <class Fits, class Use> static bool with_first(const Fits& fits, const Use& use) {
        bool is_done = false;
        visit_own([&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
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
        visit_own([&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
            if (is_done || !does.is_move()) return;
            if (++moves == 1 && does.what == expected::kind::moves_to) return;
            is_done = true;
            use(name, enabled_by, wanted, does);
        });
    }

    // --- One run

    unsigned play(unsigned which, unsigned reading, planned_mishap first, planned_mishap second) {
        trial_type t{reading};
        now_ = {.command = "", .reading = reading, .first = first, .second = second};
        trial_ = &t;
        reported_ = nullptr;
        ++played_.runs;
        goal_known_ = false;
        if (which == first_own && first.what == mishap::none) judge_unknown(t);
        if (!Subject::take_over(t.drive(), t.machine())) {
            broken("kit", "the drive cannot be taken over on an undisturbed line");
            return 0;
        }
        switch (which) {
        case init_while_turning:
            turn(t);
            play(t, "init", init{});
            break;
        case enable_it:
            must(t.run(disable{}));
            play(t, "enable", enable{});
            break;
        case disable_while_turning:
            turn(t);
            play(t, "disable, turning", disable{});
            break;
        case halt_while_turning:
            turn(t);
            play(t, "halt, turning", halt{});
            break;
        case quick_stop_while_turning:
            turn(t);
            play(t, "quick_stop, turning", quick_stop{});
            break;
        case disable_while_moving:
            move(t);
            play(t, "disable, moving", disable{});
            break;
        case quick_stop_while_moving:
            move(t);
            play(t, "quick_stop, moving", quick_stop{});
            break;
        case reset_fault:
            must(t.run(enable{}));
            Subject::have_fault(t.machine());
            t.live(milliseconds(300));
            Subject::end_fault(t.machine());
            play(t, "fault_reset", fault_reset{});
            break;
        case wait_for_standstill:
            move(t);
            play(t, "wait_standstill", wait_standstill{milliseconds(10'000)});
            break;
        case wait_for_target:
            move(t);
            play(t, "wait_reached", wait_reached{milliseconds(10'000)});
            break;
        case move_again:
            move(t);
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
        trial_ = nullptr;
        for (const mishap m : all_mishaps)
            played_.happened[static_cast<unsigned>(m)] += t.has_happened(m) ? 1u : 0u;
        return requests_;
    }
    void play_own(trial_type& t, unsigned which) {
        unsigned i = 0;
        visit_own([&](const char* name, const auto& enabled_by, const auto& wanted, const expected& does) {
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
        visit_own([&](const char* name, const auto& enabled_by, const auto& wanted, const expected&) {
            refuses(name, wanted);
            if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(enabled_by)>, disable>)
                refuses("enabling", enabled_by);
        });
        if (t.requests() != 0) broken("G21", "a refused command has sent something");
    }
    void must(const routine_status& r) {
        if (!r) broken("kit", "a command that leads to the start of a run fails on an undisturbed line");
    }
    void turn(trial_type& t) {
        with_first([](const expected& e) { return e.what == expected::kind::turns; },
                   [&](const char*, const auto& enabled_by, const auto& wanted, const expected&) {
                       must(t.run(disable{}));
                       must(t.run(enabled_by));
                       must(t.run(wanted));
                       t.live(milliseconds(100));
                   });
    }
    void move(trial_type& t) {
        with_first([](const expected& e) { return e.is_move(); },
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
        if (t.is_stop_refused() && !std::is_same_v<Command, disable> && !std::is_same_v<Command, quick_stop>)
            broken("G25", "a disable is refused while another command is under way");
        const routine_status& r = t.drive().last();
        const bool is_replaced = r.error() == errc::preempted || t.has_happened(mishap::program_halts) ||
                                 t.has_happened(mishap::program_disables);
        if (now_.first.what == mishap::none && !r) broken("G29", "the command fails on an undisturbed line");
        if (r && !is_replaced) judge_done(t, wanted, does);
        // A stop of the facade itself follows a fault, a restart and a stall.
        const bool is_followed =
            t.has_happened(mishap::fault) || t.has_restarted() || t.has_happened(mishap::program_stalls);
        if (r.outcome() == outcome::not_sent && !is_replaced && !is_followed && t.writes() != 0 && !is_stop)
            broken("G16", "the command ends as not sent, but a request that writes has left");
        if (does.is_move() && t.has_started()) {
            goal_ = goal;
            goal_known_ = true;
        }
        judge_later(t, wanted, does);
    }

    // The command has ended well: the drive was at some time since the last request as it says.
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
            const bool is_undisturbed = now_.first.what == mishap::none;
            for (int i = 0; i < 35 && is_undisturbed && !t.is_turning(); ++i) t.live(milliseconds(10));
            if (is_undisturbed && !t.turned())
                broken("G35", "a motion is reported done, and the motor stands");
        }
    }

    // A while afterwards, on a sound line, and once the drive is taken over again.
    template <class Command> void judge_later(trial_type& t, const Command&, const expected& does) {
        using named = std::remove_cvref_t<Command>;
        constexpr bool is_init = std::is_same_v<named, init>;
        constexpr bool is_enable = requires { typename std::enable_if_t<std::is_same_v<named, enable>>; };
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
        if (now_.first.what == mishap::none) {
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

    // The same is reported once in a run.
    void broken(const char* promise, const char* what) {
        if (reported_ == what) return;
        reported_ = what;
        ++played_.findings;
        finding f = now_;
        f.promise = promise;
        f.what = what;
        if (trial_ != nullptr) f.trace = trial_->trace();
        if (report_ != nullptr) report_(context_, f);
    }
    report report_;
    void* context_;
    played played_{};
    finding now_{};
    trial_type* trial_ = nullptr;
    expected does_{};
    std::int64_t goal_ = 0;
    bool goal_known_ = false;
    bool was_enabled_ = false;
    const char* reported_ = nullptr;
    unsigned requests_ = 0;            // of the command that was played last
    std::array<bool, 400> repeated_{}; // those of its requests that need no mishap of their own
};

} // namespace servobus::sim
