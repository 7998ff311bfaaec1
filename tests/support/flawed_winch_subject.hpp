// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The model, the facade and the subject of the winch with one flaw (flawed_winch.hpp). The judges of
// sim/conformance.hpp see each flaw as an interpretation of the manual.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <servobus/sim/conformance.hpp>

#include <examples/own_device/own_subject.hpp>
#include <tests/support/flawed_winch.hpp>

namespace flawed_winch {

using winch::prepared_command;

// --- The model, with settings of its own: its commands are planned by functions of its own

struct settings : winch::cached_settings {};

namespace routines {
inline constexpr winch::ro<u16> beyond_image{0x18, full<u16>, no_unit, 0};
inline constexpr winch::ro<i32> into_image{0x0F, full<i32>, no_unit, 0}; // two registers
inline constexpr step reads_beyond[] = {steps::expect<winch::host_word>(winch::routines::session),
                                        steps::fetch<winch::host_word>(14), steps::fetch<beyond_image>(15),
                                        steps::fetch<into_image>(12), winch::routines::feedback[0]};
inline constexpr step clear_only[] = {steps::write<winch::control_word>(winch::control_code::clear_fault)};
inline constexpr step halts_for_long[] = {
    winch::routines::hold,
    steps::until_bits<winch::status_word>(winch::status_bits::turning, 0, step::commanded_limit)};
inline constexpr step home[] = {steps::write_arguments<winch::target>(),
                                steps::write<winch::control_word>(winch::control_code::move),
                                winch::routines::until_still, steps::same_drive()};
inline constexpr auto many_writes = [] {
    constexpr step one = steps::write<winch::ramp>(500);
    std::array<step, 230> all{};
    for (step& s : all) s = one;
    return all;
}();
} // namespace routines

inline prepared_command prepare(halt, const settings& known) {
    if (present != flaw::still_turning) return winch::prepare(halt{}, known);
    return {.steps = routines::halts_for_long, .stop = stop_priority::halt, .limit = milliseconds(200'000)};
}
inline prepared_command prepare(disable, const settings& known) {
    prepared_command c = winch::prepare(disable{}, known);
    if (present == flaw::disable_is_no_stop) c.stop = stop_priority::no_stop;
    return c;
}
inline prepared_command prepare(fault_reset, const settings& known) {
    prepared_command c = winch::prepare(fault_reset{}, known);
    if (present == flaw::mute_after_reset) c.steps = routines::clear_only;
    return c;
}
inline prepared_command prepare(read_feedback, const settings& known) {
    prepared_command c = winch::prepare(read_feedback{}, known);
    if (present == flaw::reads_beyond) c.steps = routines::reads_beyond;
    return c;
}
/// The motor searches home, three seconds away.
struct home {
    static constexpr std::int32_t place = 30'000;
    constexpr prepared_command prepare(const winch::cached_settings& known) const {
        prepared_command c = winch::prepare(servobus::move_to{place * units::pulse}, known);
        c.steps = routines::home;
        return c;
    }
};
struct write_often {
    constexpr prepared_command prepare(const winch::cached_settings& known) const {
        return {.steps = routines::many_writes, .refusal = winch::needs_init_done(known)};
    }
};

class model : public winch::model {
    using base = winch::model;

  public:
    using settings = flawed_winch::settings;
    static constexpr settings unknown{};
    static constexpr bool is_faulted(const std::uint16_t* w, const settings& known) {
        return base::is_faulted(w, known);
    }
    static steps::recheck witness(const settings& known, const prepared_command& c) {
        return present == flaw::sees_no_restart ? steps::recheck{} : base::witness(known, c);
    }
    static verdict judge(const std::uint16_t* w, settings& known) {
        return present == flaw::sees_no_restart ? verdict::as_expected : base::judge(w, known);
    }
    errc admit(const prepared_command& c, duration waited) const {
        return present == flaw::waits_without_move ? errc::ok : base::admit(c, waited);
    }
    errc learn(prepared_command& c, const ending& e, settings& known) {
        const errc found = base::learn(c, e, known);
        const bool is_init = e.is_done && c.then == winch::effect::initialised;
        if (is_init && ++inits_ > 1 && present == flaw::init_forgets) known.state = drive_state::needs_init;
        return found;
    }

  private:
    unsigned inits_ = 0;
};

template <class Line> class drive : public facade<model, Line> {
    using base = facade<model, Line>;

  public:
    drive(Line& on, std::uint8_t at, const supervision& by)
        : base{on, node<winch::device>{at}, by.feedback, by.command_timeout} {}

    template <class Wanted> command_status begin(const Wanted& wanted) {
        const command_status begun = base::begin(wanted);
        if (present == flaw::refusal_sends && begun == errc::needs_init) (void)base::run(disable{});
        return begun;
    }
    winch::arrival arrival() const {
        if (this->state() == drive_state::needs_init) return {};
        return this->model().arrival_of(this->image(), this->since_start());
    }
    result<winch::feedback> feedback(duration oldest) const {
        if (const errc why = this->check_feedback(oldest); why != errc::ok) return why;
        return winch::feedback::from_words(this->image());
    }
    result<winch::feedback> read() { return servobus::status{base::run(read_feedback{})}; }
};

// --- The subject

struct subject : winch::subject {
    using machine = simulated;
    template <class Line> using drive = flawed_winch::drive<Line>;

    static constexpr unsigned interpretations = static_cast<unsigned>(flaw::end);
    static sim::what_shows shows(unsigned) {
        return {.restart_in_a_change = present != flaw::init_forgets,
                .every_stop = present != flaw::turns_if_restarted};
    }
    static bool can_be_done(unsigned, std::string_view command) {
        if (present == flaw::enable_denied || present == flaw::energised_unseen) return command != "enable";
        if (present == flaw::cannot_turn) return command != "turn";
        return command != "never";
    }
    static machine make(unsigned interpretation) {
        present = static_cast<flaw>(interpretation);
        return machine{};
    }
    template <class Drive> static bool take_over(Drive& drum, machine&) {
        if (!drum.run(init{}) || drum.state() == drive_state::needs_init) return false;
        return present != flaw::taken_over_once || takes_over++ == 0;
    }
    static bool is_energised(const machine& m) { return m.is_energised(); }
    static bool is_turning(const machine& m) { return m.is_turning(); }
    static std::int64_t place(const machine& m) { return m.place(); }
    static std::uint32_t starts(const machine& m) { return m.starts(); }
    static void restart(machine& m) { m.power_cycle(); }
    static void have_fault(machine& m) { m.raise_fault(3); }
    static void end_fault(machine& m) { m.end_fault_cause(); }
    static void press_stop(machine& m) { m.interrupt(); }
    static void release_stop(machine&) {}
    static void write_by_another(machine& m) {
        if (present == flaw::foreign_enable) m.control(winch::control_code::hold);
    }
    template <class Each> static void commands(const Each& each) {
        using servobus::move_to, winch::turn, units::r_per_min, units::pulse;
        sim::expected homes_blindly = sim::homes_at(home::place);
        homes_blindly.hides_restart = true;
        each("stay", enable{}, move_to{0 * pulse}, sim::changes_nothing());
        each("home", enable{}, home{}, sim::homes_at(home::place));
        each("home, blind", enable{}, home{}, homes_blindly);
        each("turn", enable{}, turn{60 * r_per_min}, sim::turns());
        each("move_to", enable{}, move_to{4000 * pulse}, sim::moves_to(4000));
        each("move_to, back", enable{}, move_to{-2000 * pulse}, sim::moves_to(-2000));
        each("move_by", enable{}, move_to{4000 * pulse}, sim::moves_by(4000)); // from 0
        each("move_by, back", enable{}, move_to{-2000 * pulse}, sim::moves_by(-2000));
        if (present == flaw::waits_without_move)
            each("wait", enable{}, wait_reached{}, sim::changes_nothing());
        if (present == flaw::long_routine) each("write", enable{}, write_often{}, sim::changes_nothing());
        if (present == flaw::wrong_enable) {
            each("turn, too fast before", turn{1000 * r_per_min}, turn{60 * r_per_min}, sim::turns());
            each("never", turn{1000 * r_per_min}, turn{60 * r_per_min}, sim::turns());
        }
    }
};

} // namespace flawed_winch
