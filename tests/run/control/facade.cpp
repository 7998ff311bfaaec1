// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What all facades share, tested with one that knows next to nothing of its drive: which stop replaces which, how
// often a stop is tried, what is repeated automatically, and what happens when the application stops commanding.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>

#include <tests/support/bare_rig.hpp>

namespace facade_tests {

using namespace bare_rigs;

TEST_CASE("during the stop of the command timeout the application's stop is accepted and replaces it, unless "
          "it has a lower priority") {
    struct scene {
        bare::command watched;
        bare::command wanted;
        bool is_taken;
    };
    const scene all[] = {{halting, halting, true},
                         {halting, disabling, true},
                         {halting, quick_stopping, true},
                         {disabling, halting, false},
                         {disabling, disabling, true},
                         {disabling, quick_stopping, true},
                         {quick_stopping, halting, false},
                         {quick_stopping, disabling, false},
                         {quick_stopping, quick_stopping, true},
                         {halting, look, false},
                         {halting, move, false}};
    for (const scene& s : all) {
        CAPTURE(static_cast<int>(s.watched.stop));
        CAPTURE(static_cast<int>(s.wanted.stop));
        rig r;
        bare::model::stops_by = s.watched;
        r.watched_stop_begins();
        const command_status e = r.drive.begin(s.wanted);
        CHECK(e == (s.is_taken ? errc::ok : errc::busy));
        const std::size_t before = r.port.frames.size();
        r.loop(60);
        CHECK(r.drive.is_idle());
        if (s.is_taken) {
            CHECK(r.drive.last());
            CHECK(r.port.frames.size() == before + 2); // its write and its read-back, once
        }
    }
}

TEST_CASE("a command that has no steps and no reason for it is refused, and nothing is sent") {
    rig r;
    CHECK(r.drive.begin(bare::command{.steps = no_steps}) == errc::bad_argument);
    CHECK(r.drive.run(bare::command{.steps = no_steps, .refusal = errc::inexact}).error() == errc::inexact);
    CHECK(r.drive.is_idle());
    CHECK(r.port.frames.empty());
}

TEST_CASE("a stop of the application is replaced only by a stop of higher priority") {
    struct scene {
        bare::command first;
        bare::command second;
        bool is_taken;
    };
    const scene all[] = {{halting, halting, false},
                         {halting, disabling, true},
                         {halting, quick_stopping, true},
                         {disabling, halting, false},
                         {disabling, disabling, false},
                         {disabling, quick_stopping, true},
                         {quick_stopping, halting, false},
                         {quick_stopping, disabling, false},
                         {quick_stopping, quick_stopping, false},
                         {look, look, false},
                         {look, halting, true},
                         {move, quick_stopping, true}};
    for (const scene& s : all) {
        CAPTURE(static_cast<int>(s.first.stop));
        CAPTURE(static_cast<int>(s.second.stop));
        rig r;
        REQUIRE(r.drive.begin(s.first) == errc::ok);
        while (r.port.frames.empty()) r.turn();
        CHECK(r.drive.begin(s.second) == (s.is_taken ? errc::ok : errc::busy));
        r.loop(60);
        CHECK(r.drive.is_idle());
        CHECK(r.drive.last());
        CHECK(r.drive.done() == 2); // the take-over of the rig, and the command accepted last
    }
}

TEST_CASE("G26: a stop that does not read back is tried three times, and then reported") {
    for (unsigned ignored = 0; ignored <= 5; ++ignored) {
        for (const bool is_watched : {false, true}) {
            CAPTURE(ignored);
            CAPTURE(is_watched);
            rig r;
            if (is_watched) {
                r.drive.set_command_timeout(milliseconds(100));
                REQUIRE(r.drive.run(move));
                r.port.frames.clear();
                r.ignores = ignored;
                r.loop(180); // the next stop would come after another 100 ms
            } else {
                r.file.words[0x0100] = 100;
                r.ignores = ignored;
                const command_status stopped = r.drive.run(halting);
                CHECK(static_cast<bool>(stopped) == (ignored < 3));
                if (ignored >= 3) CHECK(stopped.error() == errc::unexpected_value);
                r.loop(50);
            }
            CHECK(r.halts() == (ignored < 3 ? ignored + 1 : 3));
            CHECK(r.port.frames.size() == 2 * r.halts());
        }
    }
    rig r; // a command that is no stop is tried once
    r.ignores = 1;
    CHECK(r.drive.run(set).error() == errc::unexpected_value);
    CHECK(r.port.count_of(0x06) == 1);
}

TEST_CASE("G26: each stop has its three tries, however many the previous one used") {
    rig r;
    for (int i = 0; i < 4; ++i) {
        r.file.words[0x0100] = 100;
        r.port.frames.clear();
        r.ignores = 2;
        CHECK(r.drive.run(halting));
        CHECK(r.halts() == 3);
    }
}

TEST_CASE("G26: each stop of the command timeout has its three tries, and stays separate from the "
          "application's commands") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    REQUIRE(r.drive.run(move));
    r.port.frames.clear();
    SUBCASE("three tries fail, and there are three more when the timeout has passed again") {
        r.ignores = 5;
        r.loop(180);
        CHECK(r.halts() == 3);
        r.loop(100);
        CHECK(r.halts() == 6);
        CHECK(r.file.words[0x0100] == 0);
        CHECK(r.drive.last()); // the move's
    }
    SUBCASE("the application's stop may replace it at the second try as at the first") {
        r.ignores = 1;
        const std::uint64_t end = r.port.time + 1'000'000;
        while (r.halts() < 2 && r.port.time < end) r.turn();
        REQUIRE(r.halts() == 2);
        CHECK(r.drive.begin(halting) == errc::ok);
        r.loop(40);
        CHECK(r.drive.last());
    }
}

TEST_CASE(
    "G26: an unconfirmed stop is repeated only if the program asked for it, and only until it is confirmed") {
    for (const bool repeats : {false, true}) {
        CAPTURE(repeats);
        rig r;
        if (repeats) r.drive.repeat_stops(milliseconds(300));
        r.is_mute = true;
        CHECK(r.drive.run(halting).outcome() == outcome::unknown);
        const std::size_t tried = r.halts();
        CHECK(tried == 3); // those of a stop without a response
        r.loop(3000);
        CHECK((r.halts() > tried) == repeats);
        r.is_mute = false;
        r.loop(2000);
        const std::size_t confirmed = r.halts();
        r.loop(2000);
        CHECK(r.halts() == confirmed);
        CHECK((r.file.words[0x0100] == 0) == repeats);
        CHECK(r.drive.last().outcome() == outcome::unknown); // the application's command, as it ended
    }
}

TEST_CASE("G19: three frames of a stop go before all others, and its repetitions wait like any other frame") {
    constexpr std::size_t behind_the_first = 2;
    rig r;
    SUBCASE("the application's stop") {
        r.drive.repeat_stops(milliseconds(100));
        r.is_mute = true;
        CHECK_FALSE(r.drive.run(halting));
        CHECK(r.hasty_frames() == behind_the_first);
        r.loop(5000);
        CHECK(r.halts() > 9);
        CHECK(r.hasty_frames() == behind_the_first);
        SUBCASE("commanded again") {
            r.port.frames.clear();
            CHECK_FALSE(r.drive.run(halting));
            CHECK(r.hasty_frames() >= behind_the_first);
        }
    }
    SUBCASE("the stop of the command timeout") {
        r.drive.set_command_timeout(milliseconds(100));
        REQUIRE(r.drive.run(move));
        r.is_mute = true;
        r.port.frames.clear();
        r.loop(5000);
        CHECK(r.halts() > 9);
        CHECK(r.hasty_frames() == behind_the_first);
        SUBCASE("after another command") {
            r.is_mute = false;
            r.loop(1000);
            REQUIRE(r.drive.run(move));
            r.is_mute = true;
            r.port.frames.clear();
            r.loop(5000);
            CHECK(r.hasty_frames() == behind_the_first);
        }
    }
}

TEST_CASE("G25: a stop that could not be sent keeps its priority until it can") {
    for (const bool is_watched : {false, true}) {
        CAPTURE(is_watched);
        rig r;
        if (is_watched) {
            r.drive.set_command_timeout(milliseconds(100));
            REQUIRE(r.drive.run(move));
        } else {
            r.drive.repeat_stops(milliseconds(100));
        }
        r.port.lost_from_call = r.port.calls + 1;
        r.port.frames.clear();
        if (!is_watched) CHECK(r.drive.run(halting).outcome() == outcome::not_sent);
        r.loop(1000);
        r.port.lost_from_call = 0;
        bool was_urgent = false;
        const std::uint64_t end = r.port.time + 1'000'000;
        while (r.port.frames.empty() && r.port.time < end) {
            r.turn();
            was_urgent = was_urgent || r.drive.machine().wants_stop();
        }
        CHECK(was_urgent);
        CHECK(r.halts() == 1);
    }
}

TEST_CASE("G25: a stop that does not read back is tried again with the priority that it has left") {
    rig r;
    r.ignores = 3;
    REQUIRE(r.drive.begin(halting) == errc::ok);
    bool was_urgent = false;
    unsigned urgent_halts = 0;
    while (!r.drive.is_idle()) {
        const std::size_t before = r.halts();
        was_urgent = was_urgent || r.drive.machine().wants_stop();
        r.turn();
        if (r.halts() != before) {
            urgent_halts += was_urgent ? 1u : 0u;
            was_urgent = false;
        }
    }
    CHECK(r.halts() == 3);
    CHECK(urgent_halts == 3);
}

TEST_CASE("G26: the application's next motion ends the repetition of its stop once it is done") {
    rig r;
    r.drive.repeat_stops(milliseconds(300));
    r.is_mute = true;
    CHECK_FALSE(r.drive.run(halting));
    r.is_mute = false;
    REQUIRE(r.drive.run(look)); // after that the response to the move is no echo
    CHECK(r.drive.run(move));
    r.port.frames.clear();
    r.loop(2000);
    CHECK(r.port.frames.empty());
    CHECK(r.file.words[0x0100] == 100);
}

TEST_CASE("G26: a motion that fails, or a command that is no motion, leaves the stop open") {
    rig r;
    r.drive.repeat_stops(milliseconds(300));
    r.is_mute = true;
    CHECK_FALSE(r.drive.run(halting));
    SUBCASE("a motion without a response") { CHECK_FALSE(r.drive.run(move)); }
    r.is_mute = false;
    SUBCASE("a read") { CHECK(r.drive.run(look)); }
    const std::size_t before = r.halts();
    r.loop(2000);
    CHECK(r.halts() == before + 1);
    CHECK(r.file.words[0x0100] == 0);
}

TEST_CASE("G20: while a stop of the application is in progress the command timeout sends none") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    REQUIRE(r.drive.run(move));
    r.is_mute = true;
    r.port.frames.clear();
    const command_status stopped = r.drive.run(quick_stopping); // 3 tries of 100 ms and more
    CHECK(stopped.outcome() == outcome::unknown);
    CHECK(stopped.error() == errc::timeout);
    CHECK(r.writes_to(0x0101, 5) == 3);
    CHECK(r.halts() == 0);
    r.loop(150);
    CHECK(r.halts() > 0); // it was not confirmed: now the command timeout sends its own
}

TEST_CASE("a stop that interrupts a change of settings invalidates the drive state, one that interrupts a "
          "motion does not") {
    rig r;
    REQUIRE(r.drive.begin(move) == errc::ok);
    while (r.port.frames.empty()) r.turn();
    CHECK(r.drive.begin(halting) == errc::ok);
    r.loop(50);
    CHECK(r.drive.last());
    CHECK(r.drive.state() == drive_state::enabled);
    r.port.frames.clear();
    REQUIRE(r.drive.begin(set) == errc::ok);
    while (r.port.frames.empty()) r.turn();
    CHECK(r.drive.begin(halting) == errc::ok);
    CHECK(r.drive.state() == drive_state::needs_init);
    r.loop(50);
    CHECK(r.drive.last());
}

TEST_CASE("what a command may have changed decides whether the state is known after its failure") {
    static constexpr step read_only[] = {look_steps[0]};
    static constexpr step write_and_check[] = {set_steps[0], set_steps[1]};
    struct scene {
        bare::command what;
        bool is_mute;
        bool is_ignored;
        bool is_known;
    };
    const scene all[] = {
        {{.steps = write_and_check}, false, true, false},                        // not as written
        {{.steps = write_and_check}, true, false, false},                        // no response
        {{.steps = read_only}, true, false, false},                              // nor to a read
        {{.steps = write_and_check, .refusal = errc::busy}, false, false, true}, // nothing was sent
    };
    for (const scene& s : all) {
        rig r;
        r.is_mute = s.is_mute;
        r.ignores = s.is_ignored ? 1 : 0;
        CHECK_FALSE(r.drive.run(s.what));
        CHECK((r.drive.state() == drive_state::enabled) == s.is_known);
        CHECK(r.drive.failed() == (s.is_known ? 0u : 1u));
    }
}

TEST_CASE("G26: of several stops that were not confirmed the one of the highest priority is repeated") {
    rig r;
    const auto open = [&r] { return r.drive.machine().slot().supervisors().open_priority(); };
    r.is_mute = true;
    REQUIRE_FALSE(r.drive.run(halting));
    CHECK(open() == stop_priority::halt);
    REQUIRE_FALSE(r.drive.run(disabling));
    CHECK(open() == stop_priority::disable);
    REQUIRE_FALSE(r.drive.run(quick_stopping));
    CHECK(open() == stop_priority::quick_stop);
    REQUIRE_FALSE(r.drive.run(halting));
    CHECK(open() == stop_priority::quick_stop);
    r.is_mute = false;
    REQUIRE(r.drive.run(halting));
    CHECK(open() == stop_priority::no_stop);
}

TEST_CASE("G26: an init that fails in place of the command timeout's halt leaves a disable open") {
    rig r;
    r.drive.set_command_timeout(milliseconds(300));
    r.drive.repeat_stops({});
    REQUIRE(r.drive.run(move));
    r.is_mute = true;
    REQUIRE_FALSE(r.drive.run(disabling));
    r.port.frames.clear();
    for (int i = 0; r.halts() == 0 && i < 100'000; ++i) r.turn();
    REQUIRE(r.halts() == 1);
    REQUIRE_FALSE(r.drive.is_idle());
    REQUIRE_FALSE(r.drive.run(taking_over));
    CHECK(r.drive.machine().slot().supervisors().open_priority() == stop_priority::disable);
}

TEST_CASE("G20: a disable that was not confirmed leaves the command timeout running") {
    rig r;
    r.drive.set_command_timeout(milliseconds(300));
    r.drive.repeat_stops({});
    REQUIRE(r.drive.run(move));
    r.is_mute = true;
    REQUIRE_FALSE(r.drive.run(disabling));
    r.is_mute = false;
    r.port.frames.clear();
    r.loop(400);
    CHECK(r.halts() == 1);
}

TEST_CASE("G26: another command timeout leaves the period of repeated stops that the program has set") {
    for (const bool is_set : {false, true}) {
        CAPTURE(is_set);
        rig r;
        if (is_set) r.drive.repeat_stops(milliseconds(200));
        r.drive.set_command_timeout(milliseconds(5000));
        r.drive.set_command_timeout(no_command_timeout);
        r.is_mute = true;
        CHECK_FALSE(r.drive.run(halting));
        const std::size_t tried = r.halts();
        r.loop(2000);
        CHECK((r.halts() > tried) == is_set);
    }
}

TEST_CASE("last() of a command that is refused by run() is its refusal, but not while another is under way") {
    rig r;
    REQUIRE(r.drive.run(look));
    CHECK(r.drive.run(bare::command{.steps = look_steps, .refusal = errc::out_of_range}).error() ==
          errc::out_of_range);
    CHECK(r.drive.last().error() == errc::out_of_range);
    REQUIRE(r.drive.begin(move) == errc::ok);
    CHECK(r.drive.run(look).error() == errc::busy);
    r.loop(50);
    CHECK(r.drive.last());
}

TEST_CASE(
    "G26: a stop of the command timeout has its three tries, however many the program's stop has used") {
    rig r;
    r.drive.repeat_stops(milliseconds(10'000));
    r.drive.set_command_timeout(milliseconds(100));
    REQUIRE(r.drive.run(move));
    r.ignores = 5;
    CHECK(r.drive.run(halting).error() == errc::unexpected_value); // after three tries
    r.file.words[0x0100] = 100;
    r.port.frames.clear();
    r.loop(150);
    CHECK(r.halts() == 3);
    CHECK(r.file.words[0x0100] == 0);
}

} // namespace facade_tests
