// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive of your own: routines, commands, a model and a facade for the winch of own_device.hpp. Public headers
// of the library only; device/README.md explains each part. With a `line`:
//
//     winch::drive drum{line, 5, {.command_timeout = servobus::milliseconds(300)}};
//     if (!drum.run(servobus::init{}) || !drum.run(servobus::enable{})) return;
//     const winch::arrival there = drum.run(servobus::move_to{20'000 * winch::pulse}, servobus::wait_reached{});
//     if (there.how != servobus::arrival_state::reached) show(there.missing.count());
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/arguments.hpp>
#include <servobus/control/command.hpp>
#include <servobus/control/command_kinds.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/control/image_of.hpp>
#include <servobus/control/motion_commands.hpp>
#include <servobus/control/steps.hpp>

#include "own_device.hpp"

// The control word also starts the winch: only these words of it may be sent again.
template <>
inline constexpr auto servobus::stop_words<winch::control_word> =
    servobus::words_that_stop(winch::control_code::off, winch::control_code::hold);

namespace winch {

using servobus::drive_state, servobus::duration, servobus::errc, servobus::milliseconds, servobus::routine,
    servobus::step;
namespace steps = servobus::steps;
namespace commands = servobus::commands;

using rate = servobus::quantity<servobus::units::r_per_min / 10, std::int32_t>;
using distance = servobus::quantity<servobus::units::pulse, std::int32_t>;

// --- What is known of the drive, and what a command is

/// What the program has cached of the drive. One with parameters that commands need has them here too.
struct cached_settings {
    drive_state state = drive_state::needs_init;
};

enum class effect : std::uint8_t { none, initialised, enabled, disabled, turned, moved, arrived, seen, end };

/// A command made ready: a routine with its arguments, or why it is refused.
struct prepared_command {
    routine steps;
    steps::arguments arguments{};
    effect then = effect::none;
    errc refusal = errc::ok;
    servobus::stop_priority stop = servobus::stop_priority::no_stop;
    duration limit{};
};

// --- Routines: tables of steps. Those that read feedback registers are served by the process image.

namespace routines {
inline constexpr std::uint16_t session = 0x5E55; // a winch that was restarted has 0 in its place

inline constexpr step switch_off = steps::repeatable(steps::write<control_word>(control_code::off));
inline constexpr step hold = steps::repeatable(steps::write<control_word>(control_code::hold));
inline constexpr step until_off =
    steps::until_bits<status_word>(status_bits::energised | status_bits::turning, 0, 10'000);
inline constexpr step until_still = steps::until_bits<status_word>(status_bits::turning, 0, 10'000);
inline constexpr step until_energised =
    steps::until_bits<status_word>(status_bits::energised, status_bits::energised, 1'000);
inline constexpr step must_be_healthy = steps::expect_zero<fault>(errc::faulted);
inline constexpr step must_stand = steps::expect_zero<status_word>(errc::busy, status_bits::turning);

/// The winch may still turn from a program that crashed: the first frame switches it off.
inline constexpr step init[] = {
    switch_off,
    until_off,
    steps::write<host_word>(session),
    steps::expect<host_word>(session),
};
/// The target that an earlier program left must not act.
inline constexpr step enable[] = {
    must_be_healthy,
    steps::write_zero<speed>(),
    steps::expect_zero<speed>(),
    steps::same_drive(),
    steps::write<control_word>(control_code::hold),
    until_energised,
};
inline constexpr step disable[] = {switch_off, until_off};
inline constexpr step halt[] = {hold, until_still};
inline constexpr step clear_fault[] = {
    must_stand,
    steps::write<control_word>(control_code::clear_fault),
    steps::until_bits<fault>(0xFFFF, 0, 1'000, errc::faulted),
};
/// A speed may be written twice: without a response it is read back.
inline constexpr step turn[] = {steps::set_arguments<speed>(),
                                steps::write<control_word>(control_code::turn)};
/// The start is written once. After it the witness once more: a drive that has restarted ignores it.
inline constexpr step move[] = {
    must_stand,
    steps::write_arguments<target>(),
    steps::expect_arguments<target>(),
    steps::same_drive(),
    steps::write<control_word>(control_code::move),
    steps::same_drive(),
};
inline constexpr step wait_standstill[] = {
    steps::until_bits<status_word>(status_bits::turning, 0, step::commanded_limit), steps::same_drive()};
inline constexpr step wait_reached[] = {steps::confirm()};
inline constexpr step feedback[] = {steps::fetch<load, position, status_word, fault>()};
inline constexpr step same_session[] = {steps::expect<host_word>(session)};
} // namespace routines

// --- Commands: each checks its arguments against what is known, and becomes a routine

constexpr errc needs(const cached_settings& known, drive_state state) {
    if (known.state == drive_state::needs_init) return errc::needs_init;
    return known.state == state ? errc::ok : errc::wrong_state;
}

constexpr errc needs_init_done(const cached_settings& known) {
    return known.state == drive_state::needs_init ? errc::needs_init : errc::ok;
}

// The commands that every drive has

/// Switches the winch off, whatever it does, and takes it over.
constexpr prepared_command prepare(servobus::init, const cached_settings&) {
    return {.steps = routines::init, .then = effect::initialised};
}
/// Energises the winch, at standstill.
constexpr prepared_command prepare(servobus::enable, const cached_settings& known) {
    return {
        .steps = routines::enable, .then = effect::enabled, .refusal = needs(known, drive_state::disabled)};
}
/// Switches it off.
constexpr prepared_command prepare(servobus::disable, const cached_settings&) {
    return {.steps = routines::disable, .then = effect::disabled, .stop = servobus::stop_priority::disable};
}
/// Stops it; it stays energised. Where nothing is known of it, it is switched off.
constexpr prepared_command prepare(servobus::halt, const cached_settings& known) {
    const bool is_held = known.state == drive_state::enabled;
    return {.steps = is_held ? routine{routines::halt} : routine{routines::disable},
            .stop = servobus::stop_priority::halt};
}
/// Switches it off: its brake is the fastest stop.
constexpr prepared_command prepare(servobus::quick_stop, const cached_settings&) {
    return {
        .steps = routines::disable, .then = effect::disabled, .stop = servobus::stop_priority::quick_stop};
}
/// Clears a fault; the winch stays off.
constexpr prepared_command prepare(servobus::fault_reset, const cached_settings& known) {
    return {.steps = routines::clear_fault, .refusal = needs(known, drive_state::disabled)};
}
constexpr prepared_command prepare(const servobus::wait_standstill& wanted, const cached_settings& known) {
    return {.steps = routines::wait_standstill, .refusal = needs_init_done(known), .limit = wanted.limit};
}
constexpr prepared_command prepare(const servobus::wait_reached& wanted, const cached_settings& known) {
    return {.steps = routines::wait_reached,
            .then = effect::arrived,
            .refusal = needs_init_done(known),
            .limit = wanted.limit};
}
constexpr prepared_command prepare(servobus::read_feedback, const cached_settings& known) {
    return {.steps = routines::feedback, .then = effect::seen, .refusal = needs_init_done(known)};
}

// The commands with arguments of its own

/// Turns without end; the sign is the direction.
struct turn {
    rate at;
    constexpr prepared_command prepare(const cached_settings& known) const {
        const auto c = commands::count_in<speed>(at);
        return {.steps = routines::turn,
                .arguments = {{commands::as_word(c.count)}},
                .then = effect::turned,
                .refusal = commands::first_error(needs(known, drive_state::enabled), c.error)};
    }
};
/// Winds to a place; refused while it turns (`busy`).
constexpr prepared_command prepare(const servobus::move_to<distance>& wanted, const cached_settings& known) {
    const auto words =
        servobus::split_words(static_cast<std::uint32_t>(wanted.place.count()), device::facts.word_order);
    return {.steps = routines::move,
            .arguments = {{words.first, words.second}},
            .then = effect::moved,
            .refusal = commands::first_error(needs(known, drive_state::enabled),
                                             commands::in_range<target>(wanted.place.count()))};
}

// --- The registers of the arguments, by which `servobus::why` explains a refusal

constexpr auto arguments(const turn& c, const cached_settings&) {
    return servobus::argument_list{commands::argument<speed>(c.at)};
}
constexpr auto arguments(const servobus::move_to<distance>& c, const cached_settings&) {
    return servobus::argument_list{commands::argument<target>(c.place)};
}

// --- The model: what the facade must know of this drive

struct [[nodiscard]] arrival {
    servobus::arrival_state how = servobus::arrival_state::none;
    servobus::stop_cause cause = servobus::stop_cause::unknown;
    distance missing{};

    /// At rest at its target.
    constexpr explicit operator bool() const { return how == servobus::arrival_state::reached; }
};

class model {
  public:
    using prepared_command = winch::prepared_command;
    using settings = cached_settings;

    // The constants

    static constexpr servobus::drive_traits traits{.stops_without_line = false,
                                                   .halts_in_position = true,
                                                   .changes_speed_on_the_run = true,
                                                   .has_homing = false,
                                                   .keeps_single_parameters = false};
    /// The feedback, in one frame.
    using image = servobus::image_of<load, position, status_word, fault>;
    static constexpr servobus::feedback_blocks blocks{image::block};
    static constexpr settings unknown{};
    static constexpr servobus::stop_rules stops{
        .at_fault = servobus::stop_priority::disable,
        .after_restart = true, // a halt writes `hold`, which energises a winch that has restarted meanwhile
        .disable_replaces_quick_stop = false};
    static constexpr auto kinds = servobus::command_kinds<effect>{}
                                      .of(servobus::command_kind::take_over, effect::initialised)
                                      .of(servobus::command_kind::power, effect::enabled, effect::disabled)
                                      .of(servobus::command_kind::endless_motion, effect::turned)
                                      .of(servobus::command_kind::move, effect::moved)
                                      .of(servobus::command_kind::refresh, effect::seen)
                                      .of(servobus::command_kind::other, effect::arrived, effect::none)
                                      .with_new_origin();
    /// A restart changes this register: it must hold the session.
    static constexpr steps::recheck witness(const settings& known, const prepared_command&) {
        if (known.state == drive_state::needs_init) return {};
        return {.look = routines::same_session, .words = {routines::session}};
    }
    /// The winch has no watchdog: it turns on when nothing is sent.
    static constexpr duration watchdog(const settings&) { return {}; }

    // May the command begin, or go on?

    constexpr errc admit(const prepared_command& c, duration) const {
        return c.then == effect::arrived && !has_goal_ ? errc::wrong_state : errc::ok; // a wait needs a move
    }
    static constexpr errc permit(const prepared_command&, const servobus::situation&, const settings&) {
        return errc::ok; // none of its commands asks
    }

    // What does the feedback say?

    static constexpr bool is_faulted(const std::uint16_t* w, const settings&) {
        return w[image::place_of<fault>] != 0;
    }
    /// A winch that should be energised and is not has restarted, or was switched off by something else.
    static constexpr servobus::verdict judge(const std::uint16_t* w, settings& known) {
        if (known.state != drive_state::enabled) return servobus::verdict::as_expected;
        if (is_faulted(w, known)) {
            known.state = drive_state::disabled;
            return servobus::verdict::faulted;
        }
        const bool is_energised = (w[image::place_of<status_word>] & status_bits::energised) != 0;
        return is_energised ? servobus::verdict::as_expected : servobus::verdict::disabled;
    }
    /// No restart of it shows by its position.
    static constexpr bool has_fallen(const servobus::block_feedback&, const settings&) { return false; }
    static constexpr void note(const servobus::block_feedback&, const settings&) {}
    /// Is the move at its end?
    constexpr errc confirm(const prepared_command&, const servobus::situation& now, const settings&) const {
        switch (arrival_of(now.image, now.waited).how) {
        case servobus::arrival_state::under_way: return errc::busy;
        case servobus::arrival_state::stopped_short: return errc::stopped_short;
        default: return errc::ok;
        }
    }

    // What has a command changed?

    constexpr errc learn(prepared_command& c, const servobus::ending& e, settings& known) {
        if (!e.is_done) return errc::ok;
        switch (c.then) {
        case effect::initialised:
            known.state = drive_state::disabled;
            has_goal_ = false;
            break;
        case effect::enabled: known.state = drive_state::enabled; break;
        case effect::disabled:
            if (known.state != drive_state::needs_init) known.state = drive_state::disabled;
            break;
        case effect::turned: has_goal_ = false; break;
        case effect::moved:
            has_goal_ = true;
            goal_ = place(c.arguments.words);
            break;
        case effect::end:
        case effect::none:
        case effect::arrived:
        case effect::seen: break;
        }
        return errc::ok;
    }

    /// A motion was replaced that may have started: where the winch goes is not known any more.
    constexpr void preempt(const prepared_command&) { has_goal_ = false; }

    // How is it stopped?

    static constexpr prepared_command stop_for(servobus::stop_priority which, const settings& known, bool) {
        return which == servobus::stop_priority::halt ? prepare(servobus::halt{}, known)
                                                      : prepare(servobus::disable{}, known);
    }

    // For this drive's own facade

    constexpr arrival arrival_of(const std::uint16_t* w, duration since_start) const {
        if (!has_goal_) return {};
        const distance missing = goal_ - place(w + image::place_of<position>);
        const bool is_there = missing.count() == 0;
        const bool is_turning = (w[image::place_of<status_word>] & status_bits::turning) != 0;
        if (is_turning || (!is_there && since_start < milliseconds(200))) // it may not have begun
            return {.how = servobus::arrival_state::under_way, .missing = missing};
        return {.how = is_there ? servobus::arrival_state::reached : servobus::arrival_state::stopped_short,
                .missing = missing};
    }
    static constexpr distance place(const std::uint16_t* w) {
        return distance{
            static_cast<std::int32_t>(servobus::join_words(w[0], w[1], device::facts.word_order))};
    }

  private:
    distance goal_{};
    bool has_goal_ = false;
};

/// By which the plan of a bus finds the model.
model model_of(const device&);

/// The winch's feedback, one frame.
struct feedback {
    std::uint16_t load = 0; ///< 0.1 A
    distance position{};
    std::uint16_t status = 0; ///< `status_bits`
    std::uint16_t fault_code = 0;

    constexpr bool has_fault() const { return fault_code != 0; }
    constexpr bool is_moving() const { return (status & status_bits::turning) != 0; }

    static constexpr feedback from_words(const std::uint16_t* w) {
        using image = model::image;
        return {w[image::place_of<winch::load>], model::place(w + image::place_of<winch::position>),
                w[image::place_of<status_word>], w[image::place_of<fault>]};
    }
};

// --- The facade

template <class Line> class drive : public servobus::facade<model, Line> {
    using base = servobus::facade<model, Line>;

  public:
    constexpr drive(Line& on, std::uint8_t at, const servobus::supervision& by = servobus::without_watchdog)
        : drive{on, servobus::node<device>{at}, by} {}
    /// With limits and gaps of its own.
    constexpr drive(Line& on, const servobus::node<device>& at,
                    const servobus::supervision& by = servobus::without_watchdog)
        : base{on, at, by.feedback, by.command_timeout} {}

    using base::run;
    /// Runs a move and waits for its end.
    winch::arrival run(const servobus::move_to<distance>& move, const servobus::wait_reached& end) {
        if (!base::run(move)) return {};
        (void)base::run(end);
        return arrival(end);
    }
    /// Where the last move has come to, by the last feedback; with `end`, for a bus.
    constexpr winch::arrival arrival(const servobus::wait_reached&) const { return arrival(); }
    constexpr winch::arrival arrival() const {
        if (this->state() == drive_state::needs_init || this->is_move_beginning()) return {};
        winch::arrival a = this->model().arrival_of(this->image(), this->since_start());
        if (a.how == servobus::arrival_state::stopped_short) a.cause = this->cause();
        return a;
    }
    /// Read at most `oldest` ago. Errors: `needs_init`; `timeout` if it is older.
    constexpr servobus::result<winch::feedback> feedback(duration oldest) const {
        if (const errc why = this->check_feedback(oldest); why != errc::ok) return why;
        return winch::feedback::from_words(this->image());
    }
    /// Reads it in one frame.
    servobus::result<winch::feedback> read() {
        const servobus::command_status r = base::run(servobus::read_feedback{});
        if (!r) return servobus::status{r};
        return winch::feedback::from_words(this->image());
    }
};

} // namespace winch
