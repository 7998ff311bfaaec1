// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D facade: every command with an event at each of its frames: the program crashes, the line is
// lost, the drive restarts, or a disable is commanded. A scene is played with its event at frame 0, 1, 2 .. until the
// command ends before the event.
#include <doctest/doctest.h>

#include <tests/support/zlac8015d_scenes.hpp>

namespace safety_zlac8015d_tests {

using namespace zlac8015d_scenes;

TEST_CASE(
    "S1, G37: after a program has crashed at any frame of any command, init of the next program first stops "
    "the drive" *
    doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (const std::uint32_t rest : {5u, 1500u}) {
            scenes += at_every_frame(of, [rest, &of](const row& o, std::size_t n) {
                scene s{o, false, of};
                while (!s.drive.is_idle() && s.frames() <= n) s.turn();
                if (s.frames() <= n) return s.is_over();
                s.wire.pass(milliseconds(rest));
                s.log.frames.clear();
                servobus::line restarted{s.wire, modbus::timing_at(115200)};
                zlac8015d::drive successor{restarted, 1, unsupervised};
                REQUIRE(successor.run(init{}));
                CHECK(rests(s));
                CHECK(same_bytes(s.log.frames[0], zero_targets));
                for (const auto& f : s.log.frames) CHECK((!is_write(f) || is_stop(f)));
                const std::int64_t place = s.model.left().position;
                s.wire.pass(milliseconds(300));
                const std::int64_t rolled = s.model.left().position - place;
                CHECK((rolled == 0 || (of.bit != options::running::turns && rolled * rolled <= 9)));
                return true;
            });
        }
        return scenes;
    });
}

TEST_CASE("G15, G29: if the line is lost for good at any frame of any command, the command fails in time and "
          "nothing but stops is sent twice") {
    for (const bool is_response : {false, true}) {
        at_every_frame([is_response](const row& o, std::size_t n) {
            scene s{o};
            std::uint64_t lost_at = 0;
            s.play([&] {
                const bool is_lost = is_response ? s.frames() > n : s.begun() > n;
                if (is_lost && lost_at == 0) lost_at = s.wire.time_us();
                if (is_response) s.wire.faults().lost_response = is_lost ? 1000 : 0;
                if (!is_response) s.wire.set_connected(0, !is_lost);
            });
            if (s.frames() <= n) return s.is_over();
            CHECK_FALSE(s.drive.last());
            CHECK(s.wire.time_us() - lost_at < s.longest_end_us());
            s.check_failure();
            s.check_once();
            s.reconnect();
            REQUIRE(s.drive.run(disable{}));
            CHECK(rests(s));
            REQUIRE(s.drive.run(init{}));
            CHECK(rests(s));
            s.check_motion();
            return true;
        });
    }
}

TEST_CASE("G15, G16, G21: if one transaction of any command is hurt, the reported outcome is correct") {
    for (const simulated::transaction_fault what : simulated::transaction_faults) {
        CAPTURE(static_cast<int>(what));
        at_every_frame([what](const row& o, std::size_t n) {
            CAPTURE(n);
            scene s{o};
            simulated::fault_injection fault{s, what, n};
            s.play([&] {
                if (what == simulated::transaction_fault::request_damaged)
                    s.log.open.clear(); // its length may be damaged
                fault();
            });
            if (s.begun() <= n) return s.is_over();
            fault.end();
            CHECK(fault.has_struck());
            s.check_once();
            s.check_cache();
            if (s.drive.last()) {
                CHECK(o.is_done(s));
            } else {
                s.check_failure();
                s.check_motion();
                if (what == simulated::transaction_fault::refused) CHECK(s.drive.last().exception() == 4);
            }
            s.wire.pass(milliseconds(300));
            for (const sim::wheel_view& w : {s.model.left(), s.model.right()})
                if (o.is_done == has_started) CHECK((w.position == 0 || w.position == 60));
            REQUIRE(s.drive.run(init{}));
            CHECK(rests(s));
            return true;
        });
    }
}

TEST_CASE("G15, G25: a disable that is commanded at any frame of any command is the next frame, and the "
          "drive is off "
          "after it") {
    std::size_t stops = 0;
    for (const row& o : command_rows) {
        CAPTURE(o.name);
        for (std::size_t n = 0;; ++n) {
            CAPTURE(n);
            scene s{o};
            std::size_t next = 0; // frame of the command
            s.play([&] {
                if (next == 0 && s.begun() > n && s.drive.begin(disable{}) == errc::ok) next = s.begun();
            });
            if (next == 0) { // it ended before, or is a stop of no lower priority
                (void)s.is_over();
                break;
            }
            ++stops;
            CHECK(s.drive.last());
            CHECK(rests(s));
            REQUIRE(s.frames() > next);
            for (std::size_t i = next; i < s.frames(); ++i) {
                const auto& f = s.log.frames[s.first + i];
                CHECK((is_stop(f) || (i != next && !is_write(f))));
            }
            s.check_once();
            const std::int64_t place = s.model.left().position;
            s.wire.pass(milliseconds(500));
            CHECK(s.model.left().position == place);
        }
    }
    CHECK(stops > 100);
}

static std::size_t restarts(const options& of, std::uint32_t boot) {
    std::size_t scenes = 0;
    for (const bool locks : {false, true}) {
        scenes += at_every_frame(of, [boot, locks, &of](const row& o, std::size_t n) {
            scene s{o, locks, of};
            const std::uint32_t starts = s.model.starts();
            std::uint64_t up_at = 0;
            s.play([&] {
                if (s.begun() == n + 1 && up_at == 0) {
                    s.model.power_cycle();
                    s.starts = s.model.starts();
                    s.enables = s.model.enables();
                    s.first = s.log.frames.size();
                    up_at = s.wire.time_us() + boot * 1000u;
                }
                if (up_at != 0) s.wire.set_connected(0, s.wire.time_us() >= up_at);
            });
            if (up_at == 0) return s.is_over();
            s.reconnect();
            const bool is_ok = static_cast<bool>(s.drive.last());
            if (is_ok) CHECK(o.is_done(s));
            if (!is_ok) CHECK(s.model.starts() == s.starts);
            if (s.model.starts() == starts) CHECK(s.drive.motion() != motion_check::seen);
            const bool was_enabled_now =
                s.model.enables() > s.enables; // and was stopped, if the enable cannot be confirmed
            CHECK((s.model.enabled() == was_enabled_now || (was_enabled_now && !ends_well(o, of))));
            if (s.model.enabled()) CHECK((is_ok || s.drive.state() == drive_state::needs_init));
            // Reads detect the restart within half a second.
            for (int i = 0; i < 12 && s.drive.read(); ++i) s.wire.pass(milliseconds(50));
            if (s.drive.state() == drive_state::enabled) CHECK(s.model.enabled());
            s.wire.pass(milliseconds(1500));
            const std::int64_t place = s.model.left().position;
            const bool was_enabled = s.model.enabled();
            const command_status next = s.drive.run(servobus::velocity{50 * r_per_min, 50 * r_per_min});
            if (next) CHECK(was_enabled);
            s.wire.pass(milliseconds(200));
            if (!next) CHECK(s.model.left().position == place);
            return true;
        });
    }
    return scenes;
}

TEST_CASE(
    "G21, S2: a restart at any frame of any command is detected, with or without a boot time, and with free "
    "or locked shafts") {
    for (const std::uint32_t boot : {0u, 300u}) CHECK(restarts({}, boot) > 0);
}

TEST_CASE(
    "G21, S2: a restart at any frame of any command is detected under each interpretation of the manual" *
    doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) { return restarts(of, 5); });
}

} // namespace safety_zlac8015d_tests
