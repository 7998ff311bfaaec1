// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A command must not see what the one before has left in its facade: tries that it has used, a target, its report.
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/bare_rig.hpp>
#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/loop_bound.hpp>

namespace left_behind_tests {

using namespace bare_rigs;
using namespace servobus::units;

namespace {

constexpr step with_witness[] = {steps::same_drive(), look_steps[0]};
constexpr steps::recheck same_target{.look = &halt_steps[1], .words = {0}};
constexpr bare::command take_over_witnessed{
    .steps = look_steps, .then = command_kind::take_over, .witness = same_target};

/// The drive responds to no read of a register but to the last try.
void lose_all_but_the_last(rig& r, unsigned address) {
    static constexpr unsigned tries = node<device>{1}.read_retries;
    r.port.device = [&r, address, lost = 0u](tests::scripted_port& p, const sent_frame& f) mutable {
        if (f.data[1] == 3 && f.data[2] * 256u + f.data[3] == address && lost++ < tries) return;
        r.file(p, f);
    };
}

/// Begins a command and steps it until so many of its requests have left. False if it has ended before.
template <class Drive, class Requests, class Wire, class Command>
bool begin_up_to(Drive& drive, const Requests& requests, Wire& wire, const Command& wanted, std::size_t n) {
    const std::size_t before = requests.size();
    REQUIRE(drive.begin(wanted) == errc::ok);
    for (tests::loop_bound left{"a command"}; !drive.is_idle() && requests.size() < before + n; left.use()) {
        const duration idle = drive.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    return !drive.is_idle();
}

/// A move that a stop replaces at each of its frames leaves no target, neither its own nor that of the move before.
template <class Rig, class Prepare, class Move, class Stop, class Log>
void check_replaced(Prepare prepare, const Move& move, const Stop& stop, Log requests) {
    std::size_t frames = 0;
    for (std::size_t n = 0;; ++n) {
        CAPTURE(n);
        Rig r;
        prepare(r);
        REQUIRE(r.drive.run(move));
        REQUIRE(r.drive.run(wait_reached{}));
        REQUIRE(r.drive.arrival(wait_reached{}).how == arrival_state::reached);
        if (!begin_up_to(r.drive, requests(r), r.wire, move, n)) break;
        REQUIRE(r.drive.run(stop));
        CHECK(r.drive.arrival(wait_reached{}).how == arrival_state::none);
        CHECK(r.drive.run(wait_reached{}).outcome() == outcome::not_sent);
        ++frames;
    }
    CHECK(frames > 4);
}
constexpr auto logged = [](auto& r) -> auto& { return r.requests; };

} // namespace

TEST_CASE("a command has its own tries, also where its first step is the witness") {
    for (const bool uses_tries : {false, true}) {
        CAPTURE(uses_tries);
        rig r;
        r.file.words[0x0100] = 0;
        REQUIRE(r.drive.run(take_over_witnessed));
        if (uses_tries) lose_all_but_the_last(r, 0x0110);
        REQUIRE(r.drive.run(look));
        lose_all_but_the_last(r, 0x0100);
        CHECK(r.drive.run(bare::command{.steps = with_witness}));
    }
}

TEST_CASE(
    "G20: the command timeout that stops an idle drive leaves the report of its last command, and one that "
    "cuts a command is its report") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    REQUIRE(r.drive.run(move));
    r.port.frames.clear();
    r.loop(200);
    CHECK(r.halts() == 1);
    CHECK(r.drive.last());
    REQUIRE(r.drive.run(move));
    r.port.frames.clear();
    r.is_mute = true;
    REQUIRE(r.drive.begin(look) == errc::ok);
    for (tests::loop_bound left{"the stop"}; r.halts() == 0; left.use()) r.turn();
    CHECK(r.drive.last().error() == errc::command_timeout);
    CHECK(r.drive.last().outcome() == outcome::unknown);
}

TEST_CASE("G34: a move that a stop replaces, after whichever of its frames, leaves no target") {
    SUBCASE("YAKO") {
        check_replaced<simulated::closed_axis>(
            [](auto& a) {
                REQUIRE(a.drive.run(init{}));
                REQUIRE(a.drive.run(enable{}));
            },
            move_by{100 * pulse}, halt{}, logged);
    }
    SUBCASE("C630S") {
        check_replaced<simulated::driven_c630s>(
            [](auto& r) {
                REQUIRE(r.make_ready());
                REQUIRE(r.drive.run(c630s::segment{1, 300 * c630s::reference_unit, 600 * r_per_min}));
                REQUIRE(r.drive.run(c630s::enable_in{c630s::control_mode::position}));
            },
            c630s::start_segment{1}, quick_stop{}, logged);
    }
}

} // namespace left_behind_tests
