// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Each finding of the judges for everybody (sim/conformance.hpp) is made by a winch with the flaw that it names, and
// what is no broken promise makes none.
#include <cstdint>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include <tests/support/flawed_winch_subject.hpp>

namespace conformance_of_findings_tests {

using namespace servobus;
using flawed_winch::flaw;
using kit = sim::conformance<flawed_winch::subject>;
using sim::mishap;

namespace {

// The own commands of the subject follow those of every drive.
enum command : std::uint8_t {
    init,
    enable,
    disable,
    halt,
    wait_standstill = 8,
    read_it = 11,
    home = 13,
    blind_home,
    turn
};

void keep_all(void* to, const sim::finding& f) {
    auto& all = *static_cast<std::string*>(to);
    const std::string one = std::string{f.promise} + ": " + f.what + "\n";
    if (all.find(one) == std::string::npos) all += one;
}
/// All findings of a flaw: each command without a mishap and few with one.
std::string found(flaw f) {
    std::string all;
    flawed_winch::present = f;
    flawed_winch::takes_over = 0;
    kit judges{&keep_all, &all};
    CHECK(judges.singles(static_cast<unsigned>(f), {0, 1000}).runs + (all.empty() ? 0 : 1) > 0);
    return all;
}
std::uint8_t number_of(mishap m) {
    std::uint8_t n = 0;
    while (sim::all_mishaps[n] != m) ++n;
    return n;
}
/// The findings of one run with two mishaps; the second one comes as many requests after the first one.
std::string found(flaw f, command which, mishap first, std::uint8_t at, mishap second, std::uint8_t later) {
    std::string all;
    flawed_winch::present = f;
    kit judges{&keep_all, &all};
    const std::uint8_t chosen[]{which, static_cast<std::uint8_t>(f), number_of(first), at, number_of(second),
                                later};
    CHECK(judges.from(bytes{chosen}).runs == 1);
    return all;
}
/// One mishap.
std::string found(flaw f, command which, mishap only, std::uint8_t at) {
    return found(f, which, only, at, mishap::response_doubled, 31);
}
bool has(const std::string& all, std::string_view one) {
    INFO("found: " << all);
    CHECK(all.find(one) != std::string::npos);
    return all.find(one) != std::string::npos;
}
bool lacks(const std::string& all, std::string_view one) {
    INFO("found: " << all);
    CHECK(all.find(one) == std::string::npos);
    return all.find(one) == std::string::npos;
}
constexpr std::string_view foreign_on =
    "G35: the drive is energised, its feedback is read, and the state is disabled";
constexpr std::string_view turns_after_homing = "G20: a homing has ended, and the motor turns on";
constexpr std::string_view turns_after_stop =
    "G20: the motor turns on after the command timeout, or after a stop";

} // namespace

TEST_CASE("a winch without a flaw, and what its commands leave open, make no finding") {
    CHECK(found(flaw::none) == "");
    CHECK(found(flaw::waits_without_move) == ""); // no goal is known
    CHECK(found(flaw::long_routine) == "");       // more requests than are chosen
    CHECK(found(flaw::cannot_turn) == "");        // nothing is played while it turns
}
TEST_CASE("a rope that slips") {
    const std::string all = found(flaw::slips);
    has(all, "G34: a homing is reported done, and the motor is not at home");
    has(all, "G34: arrival() is reached, and the motor is not at the target of the newest move");
    has(all, "G34: the move is reported to have reached its target, and the motor is elsewhere");
    has(all, "G15: a move by a way went farther than its way");
}
TEST_CASE("a motor that moves when it is energised, ahead or back") {
    has(found(flaw::jerks_ahead), "S1: the motor has moved, which was not commanded");
    has(found(flaw::jerks_back), "S1: the motor has moved, which was not commanded");
}
TEST_CASE("a motor that does not turn, or is seen to turn at one of two requests") {
    constexpr std::string_view stands = "G35: a motion is reported done, and the motor stands";
    has(found(flaw::stands), stands);
    lacks(found(flaw::twitches_at_odd), stands);
    lacks(found(flaw::twitches_at_even), stands);
}
TEST_CASE("a motor that turns on after a move") {
    const std::string all = found(flaw::turns_on);
    has(all, "G34: a homing is reported done, and the motor turns");
    has(all, turns_after_homing);
    has(all, turns_after_stop);
    // Another client may have started it.
    const std::string foreign = found(flaw::turns_on, home, mishap::foreign_write, 0);
    lacks(foreign, turns_after_homing);
    lacks(foreign, turns_after_stop);
}
TEST_CASE("a motor that turns after a restart that cannot be seen, until another restart") {
    has(found(flaw::turns_if_restarted, home, mishap::restart_after, 3), turns_after_homing);
    CHECK(found(flaw::turns_if_restarted, blind_home, mishap::restart_after, 3) == "");
}
TEST_CASE("a motor that stood, or was at its target, two requests ago") {
    const std::string turns = found(flaw::turns_after_stop, wait_standstill, mishap::response_late, 30);
    lacks(turns, "G26: a stop, or a wait for standstill, is reported done, and the motor turns");
    has(turns, turns_after_stop);
    const std::string away = found(flaw::jumps_off);
    lacks(away, "G34: a homing");
    lacks(away, "G34: the move");
}
TEST_CASE("a motor that is energised and should not be") {
    has(found(flaw::wakes), "S1: the motor was energised, which was not commanded");
    const std::string on = found(flaw::never_off);
    has(on, "G26: disable is reported done, and the motor is energised");
    has(on, "G26: disable is done on a sound line, and the motor is energised");
    CHECK(found(flaw::off_late) == "");
    const std::string shortly = found(flaw::off_shortly);
    lacks(shortly, "G26: disable is reported done, and");
    has(shortly, "S1: the motor was energised, which was not commanded");
    has(found(flaw::energised_unseen), "G37: an enable that cannot be confirmed leaves the motor energised");
    for (std::uint8_t at = 0; at < 4; ++at)
        lacks(found(flaw::foreign_enable, disable, mishap::foreign_write, at), foreign_on);
}
TEST_CASE("a motor that is not energised and should be") {
    constexpr std::string_view done =
        "G35: enable is reported done, the state is enabled, and the motor is not energised";
    lacks(found(flaw::energised_late), done);
    CHECK(found(flaw::energised_if_seen) == "");
    const std::string shortly = found(flaw::energised_shortly);
    lacks(shortly, done);
    has(shortly, "G35: enable is done on an undisturbed line, and the state is another one");
    const std::string never = found(flaw::never_energised);
    has(never, "kit: a command that leads to the start of a run fails on an undisturbed line");
    has(never, "G28: enable fails on a sound line after init");
}
TEST_CASE("a drive that is not sound again when the line is") {
    has(found(flaw::off_once), "G28: disable fails on a sound line");
    constexpr std::string_view lost = "G28: the drive cannot be taken over again on a sound line";
    has(found(flaw::init_forgets), lost);
    has(found(flaw::init_forgets, init, mishap::restart_before, 31), lost); // which does not come
    has(found(flaw::keeps_fault, turn, mishap::fault, 2),
        "G28: a fault whose cause has ended cannot be reset");
}
TEST_CASE("a command that does not end") {
    has(found(flaw::still_turning), "G29: the command does not end");
    has(found(flaw::still_turning, turn, mishap::program_halts, 12),
        "G29: the command that the program began meanwhile does not end");
    sim::trial<flawed_winch::subject> t{static_cast<unsigned>(flaw::still_turning)};
    CHECK(t.run(servobus::init{}));
    CHECK(t.run(servobus::enable{}));
    CHECK(t.run(winch::turn{60 * units::r_per_min}));
    CHECK(t.run(servobus::halt{}).error() == errc::clock_stopped);
}
TEST_CASE("the reset of a fault whose cause has not ended") {
    constexpr std::string_view remains = "G35: a fault reset is reported done, and the fault remains";
    CHECK(found(flaw::resets_any_fault) == "");
    lacks(found(flaw::mute_after_reset), remains); // what became of it cannot be read
}
TEST_CASE("a model that does not see a restart, or reads feedback beyond its image") {
    has(found(flaw::sees_no_restart), "G21: a restart is not seen, and the subject says that it shows");
    CHECK(found(flaw::reads_beyond) ==
          "kit: read_feedback reads registers beyond the `image` of the model\n");
}
TEST_CASE("a facade that sends something for a command that it refuses") {
    has(found(flaw::refusal_sends), "G21: a refused command has sent something");
}
TEST_CASE("a disable that is refused: not held against it if another mishap came first") {
    constexpr std::string_view refused = "G25: a disable is refused while another command is under way";
    has(found(flaw::disable_is_no_stop, home, mishap::program_disables, 5), refused);
    lacks(found(flaw::disable_is_no_stop, home, mishap::response_late, 5, mishap::program_disables, 1),
          refused);
}
TEST_CASE("a subject that is wrong about its drive") {
    has(found(flaw::taken_over_once), "kit: take_over fails on an undisturbed line");
    has(found(flaw::enable_denied), "kit: enable is done, and the subject says that it cannot be");
    has(found(flaw::wrong_enable),
        "kit: a command that leads to the start of a run fails on an undisturbed line");
}
TEST_CASE("a single mishap that makes a finding is in no pair") {
    kit sound{nullptr}, faulty{nullptr};
    const std::uint64_t all = sound.count_pairs(static_cast<unsigned>(flaw::none), {0, 97});
    const std::uint64_t fewer = faulty.count_pairs(static_cast<unsigned>(flaw::sees_no_restart), {0, 97});
    CHECK(all > 1000);
    CHECK(fewer < all);
}
TEST_CASE("findings are counted without a report, and too few bytes choose nothing") {
    kit silent{nullptr};
    CHECK(silent.singles(static_cast<unsigned>(flaw::reads_beyond)).findings == 1);
    CHECK(silent.from(hex("03 00 08 00 08")).runs == 0);
    CHECK(silent.from(hex("03 00 08 00 08 00")).runs == 1);
}
TEST_CASE("before the first request only the present counts, and after the last one too") {
    sim::trial<flawed_winch::subject> t{static_cast<unsigned>(flaw::energised_if_seen)};
    CHECK(t.run(servobus::init{}));
    t.watch();
    CHECK_FALSE(t.was_energised());
    CHECK(t.run(servobus::enable{}));
    CHECK(t.was_energised());
    CHECK(t.run(servobus::move_to{4000 * units::pulse}));
    CHECK(t.run(wait_reached{}));
    t.watch();
    CHECK(t.was_at(4000));
    CHECK_FALSE(t.was_at(0));
}
TEST_CASE("a mishap meets a request once that is carried out in two parts") {
    sim::trial<flawed_winch::subject> t{0};
    CHECK(t.run(servobus::init{}));
    t.watch({mishap::restart_before, 0}, {mishap::busy, 100});
    CHECK(t.drive().begin(read_feedback{}) == errc::ok);
    while (t.requests() == 0) t.live(microseconds(1));
    CHECK(t.before() == 0);
    CHECK(t.machine().restarts == 1);
    CHECK(t.before() == 0);
    CHECK(t.machine().restarts == 1);
}

} // namespace conformance_of_findings_tests
