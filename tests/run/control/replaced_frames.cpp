// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stop meets a frame that is on the wire, a line that another drive wants, or a program that commands just in time.
// Judged by the frames.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>

#include <tests/support/bare_rig.hpp>

namespace replaced_frames_tests {

using namespace bare_rigs;

namespace {

/// The first command's frame gets no response, and the second one has replaced it meanwhile.
drive_state state_after(const bare::command& first, const bare::command& second) {
    rig r;
    r.is_mute = true;
    REQUIRE(r.drive.begin(first) == errc::ok);
    while (r.port.frames.empty()) r.turn();
    r.is_mute = false;
    REQUIRE(r.drive.begin(second) == errc::ok);
    r.loop(400);
    REQUIRE(r.drive.is_idle());
    CHECK(r.drive.last());
    CHECK(r.port.frames.size() == 3); // one, and the stop with its read-back
    return r.drive.state();
}

} // namespace

TEST_CASE(
    "G21: a replaced motion whose frame had no response leaves the state unknown, a replaced stop does not") {
    CHECK(state_after(move, halting) == drive_state::needs_init);
    CHECK(state_after(look, halting) == drive_state::enabled);
    CHECK(state_after(halting, disabling) == drive_state::enabled);
}

TEST_CASE("G25: a stop is the next frame, although the witness and the feedback are due") {
    rig r{milliseconds(20)};
    r.file.words[0x0100] = 0;
    REQUIRE(r.drive.run(bare::command{.steps = look_steps,
                                      .then = command_kind::take_over,
                                      .witness = {.look = &halt_steps[1], .words = {0}}}));
    r.is_mute = true;
    r.port.frames.clear();
    while (r.port.frames.size() < 2) r.turn(); // a read of the feedback got no response
    r.is_mute = false;
    r.port.frames.clear();
    REQUIRE(r.drive.begin(disabling) == errc::ok);
    r.loop(400);
    REQUIRE_FALSE(r.port.frames.empty());
    CHECK(modbus::is_write(r.port.frames.front().data[1]));
}

TEST_CASE("G19: a stop goes first on a line whose other drive is stepped before it") {
    rig r;
    bare::drive<rig::line_type> other{r.on, node<device>{2}};
    REQUIRE(other.begin(look) == errc::ok);
    REQUIRE(r.drive.begin(halting) == errc::ok);
    for (int i = 0; i < 10; ++i) {
        (void)other.step();
        r.port.wait(microseconds(500)); // the gap between frames passes
    }
    CHECK(r.port.frames.empty());
    r.turn();
    (void)other.step();
    r.loop(10);
    REQUIRE_FALSE(r.port.frames.empty());
    CHECK(r.port.frames.front().data[0] == 1);
}

TEST_CASE("a poll that waits when the settings become stale is taken back, and leaves the line to others") {
    rig r{milliseconds(20)};
    client other{r.on, node<device>{2}};
    CHECK(other.read<state>().error() == errc::timeout); // there is no node 2; a quarantine follows
    r.port.frames.clear();
    r.turn();
    REQUIRE_FALSE(r.on.is_free()); // the poll has the line, and waits for the quarantine
    REQUIRE(r.port.frames.empty());
    r.on.note_change(1);
    r.turn();
    REQUIRE(r.drive.state() == drive_state::needs_init);
    CHECK(r.on.is_free());
    CHECK(other.read<state>().error() == errc::timeout); // `busy` if the poll still had the line
    REQUIRE_FALSE(r.port.frames.empty());
    CHECK(r.port.frames.front().data[0] == 2);
}

TEST_CASE("G20: the command timeout counts from the end of a setpoint, however long that took") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    r.port.device = [](tests::scripted_port& p, const sent_frame& f) {
        p.say(20'000, tests::acknowledgement(f.data));
    };
    for (int i = 0; i < 10; ++i) {
        REQUIRE(r.drive.begin(move) == errc::ok);
        while (!r.drive.is_idle()) r.turn();
        REQUIRE(r.drive.last());
        r.loop(90);
    }
    CHECK(r.halts() == 0);
    r.loop(30);
    CHECK(r.halts() == 1);
}

} // namespace replaced_frames_tests
