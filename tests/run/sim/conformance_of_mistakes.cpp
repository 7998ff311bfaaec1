// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the judges for everybody (sim/conformance.hpp) are worth: models of the winch with one mistake each, as an
// author may make it, all of which the compiler takes. Each is found, by the promise that it breaks.
#include <cstdint>
#include <string>

#include <doctest/doctest.h>

#include <servobus/sim/conformance.hpp>

#include <examples/own_device/own_subject.hpp>

namespace conformance_of_mistakes_tests {

using namespace servobus;
using winch::prepared_command;

namespace {

/// The winch's facade for a model of one's own.
template <class Model, class Line> class planted : public facade<Model, Line> {
    using base = facade<Model, Line>;

  public:
    planted(Line& on, std::uint8_t at, const supervision& by)
        : base{on, node<winch::device>{at}, by.feedback, by.command_timeout} {}

    winch::arrival arrival() const {
        if (this->state() == drive_state::needs_init) return {};
        return this->model().arrival_of(this->image(), this->since_start());
    }
    result<winch::feedback> feedback(duration oldest) const {
        if (const errc why = this->check_feedback(oldest); why != errc::ok) return why;
        return winch::feedback::from_words(this->image());
    }
    result<winch::feedback> read() {
        const command_status r = base::run(read_feedback{});
        if (!r) return servobus::status{r};
        return winch::feedback::from_words(this->image());
    }
};
template <class Model> struct subject_of : winch::subject {
    template <class Line> using drive = planted<Model, Line>;
};

void keep_first(void* first, const sim::finding& f) {
    auto& kept = *static_cast<std::string*>(first);
    if (kept.find(f.promise) == std::string::npos) kept += std::string{f.promise} + ' ';
}
/// The promises that a model breaks.
template <class Model> std::string broken_by() {
    std::string found;
    sim::conformance<subject_of<Model>> kit{&keep_first, &found};
    (void)kit.singles();
    return found;
}
bool has(const std::string& found, const std::string& promise) {
    const std::string shown = "found: " + found;
    INFO(shown);
    CHECK(found.find(promise + ' ') != std::string::npos);
    return found.find(promise + ' ') != std::string::npos;
}

namespace routines = winch::routines;
constexpr step same_ramp[] = {steps::expect<winch::ramp>(200)};
constexpr std::uint16_t default_ramp = static_cast<std::uint16_t>(winch::ramp.initial);

struct witness_never_changes : winch::model {
    static constexpr steps::recheck witness(const settings& known, const prepared_command&) {
        if (known.state == drive_state::needs_init) return {};
        return {.look = same_ramp, .words = {default_ramp}};
    }
};
struct no_witness : winch::model {
    static constexpr steps::recheck witness(const settings&, const prepared_command&) { return {}; }
};
struct confirms_too_early : winch::model {
    static constexpr errc confirm(const prepared_command&, const situation&, const settings&) {
        return errc::ok;
    }
};
struct judges_nothing : winch::model {
    static constexpr verdict judge(const std::uint16_t*, settings&) { return verdict::as_expected; }
};
struct sees_no_fault : winch::model {
    static constexpr bool is_faulted(const std::uint16_t*, const settings&) { return false; }
    static constexpr verdict judge(const std::uint16_t*, settings&) { return verdict::as_expected; }
};
/// The winch's kinds, in which one effect is of the kind `other`.
template <winch::effect Wrong> struct other_kinds {
    constexpr command_kind operator[](winch::effect e) const {
        return e == Wrong ? command_kind::other : winch::model::kinds[e];
    }
    constexpr bool sets_origin(winch::effect) const { return false; }
    constexpr bool moves(winch::effect) const { return false; }
    constexpr bool has_motion() const { return false; }
    constexpr bool is_complete() const { return true; }
    constexpr bool are_origins_stated() const { return true; }
};
template <winch::effect Wrong> struct is_of_kind_other : winch::model {
    static constexpr other_kinds<Wrong> kinds{};
};
/// As if the plan of each command with this effect left out its `then`.
template <winch::effect Effect> struct forgets_effect : is_of_kind_other<Effect> {
    constexpr errc learn(prepared_command& c, const ending& e, winch::cached_settings& known) {
        return c.then == Effect ? errc::ok : winch::model::learn(c, e, known);
    }
};
struct move_is_no_motion : is_of_kind_other<winch::effect::moved> {};
struct short_image : winch::model {
    static constexpr feedback_blocks blocks{
        register_block{winch::model::image::block.address, winch::model::image::block.words - 1}};
};
struct stays_energised : winch::model {
    static constexpr stop_rules stops{
        .at_fault = stop_priority::disable, .after_restart = false, .disable_replaces_quick_stop = false};
};
struct learns_no_disable : winch::model {
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        const drive_state before = known.state;
        const errc found = winch::model::learn(c, e, known);
        if (c.then == winch::effect::disabled) known.state = before;
        return found;
    }
};
struct stops_nothing : winch::model {
    static constexpr prepared_command stop_for(stop_priority which, const settings&, bool) {
        return {.steps = routines::same_session, .stop = which};
    }
};

// Settings of its own, so that its commands are planned by functions of its own.
template <class Model, class Settings> struct planned_otherwise : winch::model {
    using settings = Settings;
    static constexpr settings unknown{};
    static constexpr bool is_faulted(const std::uint16_t* w, const settings& known) {
        return winch::model::is_faulted(w, known);
    }
};
struct no_stop_settings : winch::cached_settings {};
constexpr prepared_command prepare(disable, const no_stop_settings&) {
    return {.steps = routines::disable, .then = winch::effect::disabled};
}
struct disable_is_no_stop : planned_otherwise<disable_is_no_stop, no_stop_settings> {};

struct hasty_settings : winch::cached_settings {};
constexpr prepared_command prepare(read_feedback, const hasty_settings&) {
    return {.steps = routines::feedback, .then = winch::effect::seen};
}
struct reads_before_init : planned_otherwise<reads_before_init, hasty_settings> {};

constexpr step switch_off_once[] = {steps::write<winch::control_word>(winch::control_code::off)};
struct blind_settings : winch::cached_settings {};
constexpr prepared_command prepare(disable, const blind_settings&) {
    return {.steps = switch_off_once, .then = winch::effect::disabled, .stop = stop_priority::disable};
}
constexpr prepared_command prepare(halt, const blind_settings&) {
    return {.steps = routines::same_session, .stop = stop_priority::halt};
}
struct halts_nothing : planned_otherwise<halts_nothing, blind_settings> {};

constexpr step off_once[] = {steps::write<winch::control_word>(winch::control_code::off),
                             routines::until_off};
constexpr step hold_once[] = {steps::write<winch::control_word>(winch::control_code::hold),
                              routines::until_still};
struct once_settings : winch::cached_settings {};
constexpr prepared_command prepare(disable, const once_settings&) {
    return {.steps = off_once, .then = winch::effect::disabled, .stop = stop_priority::disable};
}
constexpr prepared_command prepare(halt, const once_settings& known) {
    const bool is_held = known.state == drive_state::enabled;
    return {.steps = is_held ? hold_once : off_once, .stop = stop_priority::halt};
}
struct stops_once : planned_otherwise<stops_once, once_settings> {};

constexpr step clear_only[] = {steps::write<winch::control_word>(winch::control_code::clear_fault)};
struct trusting_settings : winch::cached_settings {};
constexpr prepared_command prepare(fault_reset, const trusting_settings& known) {
    return {.steps = clear_only,
            .then = winch::effect::disabled,
            .refusal = known.state == drive_state::needs_init ? errc::needs_init : errc::ok};
}
struct resets_in_vain : planned_otherwise<resets_in_vain, trusting_settings> {};

constexpr step energise_only[] = {steps::write<winch::control_word>(winch::control_code::hold)};
struct bold_settings : winch::cached_settings {};
constexpr prepared_command prepare(init, const bold_settings&) {
    return {.steps = energise_only, .then = winch::effect::initialised};
}
struct init_energises : planned_otherwise<init_energises, bold_settings> {};

} // namespace

TEST_CASE("the winch itself breaks nothing") { CHECK(broken_by<winch::model>() == ""); }
TEST_CASE("a witness that never changes, or none: restarts are not seen") {
    CHECK(has(broken_by<witness_never_changes>(), "G21"));
    CHECK(has(broken_by<no_witness>(), "G21"));
}
TEST_CASE("a move is confirmed too early") { CHECK(has(broken_by<confirms_too_early>(), "G34")); }
TEST_CASE("the feedback is not judged") {
    CHECK_FALSE(broken_by<judges_nothing>().empty()); // a reset is refused, since the state stays enabled
    CHECK(has(broken_by<sees_no_fault>(), "G35"));
}
TEST_CASE("a motion without an end is none for the command timeout") {
    CHECK(has(broken_by<is_of_kind_other<winch::effect::turned>>(), "G20"));
}
TEST_CASE("a command that leaves out its effect") {
    CHECK(has(broken_by<forgets_effect<winch::effect::enabled>>(), "G35"));
    CHECK(has(broken_by<forgets_effect<winch::effect::moved>>(), "G29"));
}
TEST_CASE("the state after a disable") { CHECK(has(broken_by<learns_no_disable>(), "G35")); }
TEST_CASE("the stop of a supervisor stops nothing") { CHECK(has(broken_by<stops_nothing>(), "G20")); }
TEST_CASE("a disable that is no stop") { CHECK(has(broken_by<disable_is_no_stop>(), "G25")); }
TEST_CASE("feedback is accepted before init") { CHECK(has(broken_by<reads_before_init>(), "G21")); }
TEST_CASE("a halt that stops nothing") { CHECK(has(broken_by<halts_nothing>(), "G26")); }
TEST_CASE("a stop that is not repeated") { CHECK(has(broken_by<stops_once>(), "G26")); }
TEST_CASE("a restarted drive that stays energised") { CHECK(has(broken_by<stays_energised>(), "S5")); }
TEST_CASE("a move that is no motion for the facade") { CHECK(has(broken_by<move_is_no_motion>(), "kit")); }
TEST_CASE("an image without the last register of the feedback") {
    CHECK(has(broken_by<short_image>(), "kit"));
}
TEST_CASE("a fault reset that does not look") { CHECK(has(broken_by<resets_in_vain>(), "G35")); }
TEST_CASE("a restart, and a halt that energises by its level, during an enable break nothing") {
    std::string found;
    sim::conformance<winch::subject> kit{&keep_first, &found};
    CHECK(kit.from(hex("03 00 08 00 08 0F")).runs == 1);
    CHECK(found == "");
}
TEST_CASE("an init that energises") { CHECK_FALSE(broken_by<init_energises>().empty()); }

} // namespace conformance_of_mistakes_tests
