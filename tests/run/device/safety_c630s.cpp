// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every command of the C630S facade with a fault at each of its frames: the program crashes, the line is lost for good,
// the drive restarts, or a disable is commanded.
#include <doctest/doctest.h>

#include <tests/support/c630s_scenes.hpp>

namespace safety_c630s_tests {

using namespace c630s_scenes;

TEST_CASE(
    "S1, G37: after a program has crashed at any frame of any command, init of a new program first stops "
    "the drive" *
    doctest::test_suite("interpretations")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            CAPTURE(o.name);
            rig r{o.model()};
            ++scenes;
            if (!begins(o, r)) continue;
            std::vector<sim::c630s> history;
            r.port.history = &history;
            check_end(o, r, o.asked.run(r.drive));
            CHECK(!history.empty());
            for (std::size_t k = 0; k < history.size(); ++k) {
                if (!now_read->takes(k)) continue;
                CAPTURE(k);
                take_over(history[k]);
                ++scenes;
            }
        }
        return scenes;
    });
}

TEST_CASE("G15, G29: if the line is lost at any frame of any command, the command ends in time, and a stop "
          "works when the line returns" *
          doctest::test_suite("interpretations")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            const auto judge = [](rig& r, const command_status& got, const sim::c630s&, std::size_t behind) {
                CHECK_FALSE(got);
                CHECK(got.outcome() != outcome::done);
                CHECK(r.drive.state() == drive_state::needs_init);
                const std::size_t tries = r.port.requests.size() - behind + 1;
                const node<device> n{1};
                CHECK(tries <= 30);
                CHECK(r.port.time_us() - r.port.struck_at() <=
                      tries * r.line.bound(32, 32, n.limits, n.gaps).us);
                CHECK(r.drive.run(velocity{10 * r_per_min}).error() == errc::needs_init);
                CHECK(r.drive.run(start_segment{2}).error() == errc::needs_init);
                r.port.mend();
                if (r.model().address() == 1 && r.model().baud() == r.port.baud)
                    CHECK(r.drive.run(disable{}));
                take_over(r.model());
            };
            scenes += disturb_each_frame(o, mishap::no_more_requests, o.model(), judge);
            scenes += disturb_each_frame(o, mishap::no_more_responses, o.model(), judge);
        }
        return scenes;
    });
}

TEST_CASE("G15, G16, G21: if one frame of any command is hurt, a command that is reported as done was done" *
          doctest::test_suite("interpretations")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            const auto judge = [&o](rig& r, const command_status& got, const sim::c630s& before,
                                    std::size_t) {
                if (got) CHECK(o.is_done(r));
                const bool fails_anyway = (o.model == factory_drive && present().shows_last_alarm) ||
                                          !can_enable(present()); // [errata C17]
                if (!got && !fails_anyway && r.port.planned() == mishap::refused) CHECK(got.exception() == 4);
                CHECK((r.drive.state() != drive_state::enabled || r.model().enabled()));
                r.port.mend();
                if (o.is_done == makes_a_move || o.is_done == makes_a_segment) {
                    r.port.pass(milliseconds(800));
                    const std::int64_t way = r.model().position() - before.position();
                    const std::int64_t once = r.model().starts() == before.starts() ? 0 : 3932;
                    CHECK((way >= once - 2 && way <= once + 2));
                    if (got && o.is_done == makes_a_move) CHECK(once != 0);
                    if (got && o.is_done == makes_a_segment)
                        CHECK((once != 0) != present().segment_start_is_level);
                }
                take_over(r.model());
            };
            scenes += disturb_each_frame(o, mishap::request_lost, o.model(), judge);
            scenes += disturb_each_frame(o, mishap::response_lost, o.model(), judge);
            constexpr mishap others[] = {mishap::response_damaged, mishap::response_late, mishap::refused,
                                         mishap::port_lost_sending, mishap::port_lost_awaiting};
            // Under each other interpretation one of them; the whole product has enough scenes without them.
            for (std::size_t i = 0; i < std::size(others) && !now_read->is_of_whole_product; ++i) {
                if (now_read->number == 0 || now_read->number % std::size(others) == i)
                    scenes += disturb_each_frame(o, others[i], o.model(), judge);
            }
        }
        return scenes;
    });
}

TEST_CASE(
    "G15, G25: a disable that is commanded at any frame of any command is the next frame, and the motor is "
    "off after it") {
    std::size_t stops = 0;
    for (const row& o : command_rows) {
        CAPTURE(o.name);
        for (std::size_t k = 0;; ++k) {
            CAPTURE(k);
            rig r{o.model()};
            REQUIRE(begins(o, r));
            const std::size_t first = r.port.requests.size();
            REQUIRE(o.asked.begin(r.drive) == errc::ok);
            std::size_t next = 0; // number of the frame after the disable was commanded
            while (!r.drive.is_idle()) {
                const bool is_due = next == 0 && r.port.requests.size() > first + k;
                if (is_due && r.drive.begin(disable{}) == errc::ok) next = r.port.requests.size();
                r.port.wait(r.drive.step());
            }
            if (next == 0) { // it ended before, or is a stop of no lower priority
                check_end(o, r, r.drive.last());
                break;
            }
            ++stops;
            REQUIRE(r.port.requests.size() > next);
            CHECK(modbus::is_write(r.port.requests[next][1]));
            CHECK(only_stop(r.port.requests, next));
            for (const auto& t : triggers) CHECK(c630s_scenes::times(r.port.requests, first, t) <= 1);
            if (r.model().address() != 1 || r.model().baud() != r.port.baud) continue; // it was sent there
            CHECK(r.drive.last());
            CHECK(is_off(r));
            const std::int64_t place = r.model().position();
            r.port.pass(milliseconds(500));
            CHECK(r.model().position() == place);
        }
    }
    CHECK(stops > 100);
}

TEST_CASE("S5: if the drive restarts after any frame of any command, no cached word energises it again" *
          doctest::test_suite("interpretations")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            bool may_be_on = false; // an enable may be sent completely after a blink
            const auto judge = [&](rig& r, const command_status& got, const sim::c630s& before,
                                   std::size_t behind) {
                const bool was_last = r.port.requests.size() == behind;
                const u16 looked_at = load_word(r.port.requests[behind - 1], 2);
                const bool is_believed = r.drive.state() == drive_state::enabled;
                r.port.pass(milliseconds(600));
                (void)r.drive.read();
                const bool is_found = is_believed && r.drive.state() == drive_state::needs_init;
                if (got && !was_last) CHECK((o.is_done(r) || is_found));
                r.port.pass(milliseconds(600));
                CHECK(r.model().enabled() == (r.drive.state() == drive_state::enabled));
                if (may_be_on && r.model().enabled()) {
                    CHECK((got && o.is_done(r)));
                } else {
                    CHECK(is_off(r));
                    CHECK(r.drive.run(start_segment{2}).outcome() == outcome::not_sent);
                }
                // No program can detect a restart between a read of P31-00 and its write.
                if (!may_be_on || (before.enabled() && looked_at != p31))
                    CHECK_FALSE(r.port.has_been_energised());
                stays_off_at_power_on(r.model());
                take_over(r.model());
            };
            scenes += disturb_each_frame(o, mishap::restart, o.model(), judge);
            if (o.model == ready_drive)
                scenes += disturb_each_frame(o, mishap::restart, keeping_drive(), judge);
            may_be_on = true;
            scenes += disturb_each_frame(o, mishap::blink, o.model(), judge);
        }
        return scenes;
    });
}

// The drive does not store P0C-13 = 0. So P0C-13 shows a restart, and the drive stores what is written after
// it.
TEST_CASE("S5: a drive that a halt has enabled again after a restart is switched off when the restart is "
          "found") {
    static c630s_interpretation forgets;
    forgets.options.stores_eeprom_off = false;
    now_read = &forgets;
    const auto judge = [](rig& r, const command_status&, const sim::c630s&, std::size_t) {
        r.port.pass(milliseconds(600));
        (void)r.drive.read();
        const bool is_found = r.drive.state() == drive_state::needs_init;
        r.port.pass(milliseconds(600));
        if (is_found) CHECK_FALSE(r.model().enabled());
        CHECK((r.drive.state() == drive_state::enabled || (r.model().stored(p31) & functions) == 0));
    };
    for (const row& o : command_rows) {
        if (std::string{o.name} == "halt, jog") disturb_each_frame(o, mishap::blink, o.model(), judge);
    }
    now_read = &c630s_interpretations::all().front();
}

} // namespace safety_c630s_tests
