// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades: every command of both variants with an event at each of its frames: the program crashes, the
// line is lost, the drive restarts, or a release is commanded. A scene is played with its event at frame 0, 1, 2 ..
// until the command ends before the event.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>

#include <tests/support/yako_scenes.hpp>

namespace safety_yako_tests {

using namespace yako_scenes;

TEST_CASE_TEMPLATE("S1, G37: after a program has crashed at any frame of any command, init of the next "
                   "program first stops the "
                   "axis" *
                       doctest::test_suite("interpretations"),
                   A, closed_axis, open_axis) {
    at_every_frame<A>([](const row<A>& o, std::size_t n, bool is_late, const sim::yako_options& by) {
        scene<A> s{o, by};
        while (!s.drive.is_idle() && s.frames() <= n) s.turn();
        if (s.frames() <= n) return s.is_over();
        s.run(is_late ? 400 : 5);
        s.requests.clear();
        const bool was_enabled = s.model.enabled();
        typename A::line_type restarted{s.wire, modbus::timing_at(115200)};
        decltype(s.drive) successor{restarted, 1};
        REQUIRE(successor.run(init{}));
        CHECK_FALSE(s.is_moving());
        CHECK(same_bytes(s.requests[0], stop_frame));
        for (const auto& f : s.requests) CHECK((!is_write(f) || is_stop(f) || simulated::is_marker(f)));
        CHECK((was_enabled || !s.model.enabled()));
        const std::int64_t place = s.model.view().shaft;
        s.run(120);
        CHECK(s.model.view().shaft == place);
        return true;
    });
}

TEST_CASE_TEMPLATE("G15, G29: if the line is lost for good at any frame of any command, the command fails in "
                   "time and nothing but stops is sent twice" *
                       doctest::test_suite("interpretations"),
                   A, closed_axis, open_axis) {
    at_every_frame<A>([](const row<A>& o, std::size_t n, bool is_response, const sim::yako_options& by) {
        scene<A> s{o, by};
        std::uint64_t lost_at = 0;
        s.play([&] {
            const bool is_lost = is_response ? s.frames() > n : s.begun() > n;
            if (is_lost && lost_at == 0) lost_at = s.wire.time_us();
            if (is_response) s.wire.faults().lost_response = is_lost ? 1000 : 0;
            if (!is_response) s.wire.set_connected(0, !is_lost);
        });
        if (s.frames() <= n) return s.is_over();
        CHECK_FALSE(s.is_ok());
        CHECK(s.wire.time_us() - lost_at < s.longest_end_us());
        s.check_failure();
        s.check_once();
        s.check_way();
        s.reconnect();
        REQUIRE(s.drive.run(halt{}));
        CHECK_FALSE(s.is_moving());
        REQUIRE(s.drive.run(init{}));
        CHECK_FALSE(s.is_moving());
        s.check_beliefs();
        return true;
    });
}

TEST_CASE_TEMPLATE(
    "G15, G16, G21: if one transaction of any command is hurt, the reported outcome is correct" *
        doctest::test_suite("interpretations"),
    A, closed_axis, open_axis) {
    at_every_frame<A>(std::size(simulated::transaction_faults),
                      [](const row<A>& o, std::size_t n, std::size_t variant, const sim::yako_options& by) {
                          const simulated::transaction_fault what = simulated::transaction_faults[variant];
                          scene<A> s{o, by};
                          simulated::fault_injection fault{s, what, n};
                          s.play([&] {
                              if (what == simulated::transaction_fault::request_damaged)
                                  s.forget_open_request();
                              fault();
                          });
                          if (s.begun() <= n) return s.is_over();
                          fault.end();
                          CHECK(fault.has_struck());
                          s.check_once();
                          s.check_beliefs();
                          if (s.is_ok()) {
                              s.check_done();
                          } else {
                              s.check_failure();
                              s.run(120);
                              if (o.way != any_way) CHECK((s.way() == 0 || s.way() == o.way));
                          }
                          REQUIRE(s.drive.run(init{}));
                          CHECK_FALSE(s.is_moving());
                          return true;
                      });
}

TEST_CASE_TEMPLATE(
    "G15, G25: a release that is commanded at any frame of any command is the next frame, and the "
    "motor is free after it",
    A, closed_axis, open_axis) {
    std::size_t stops = 0;
    for (const row<A>& o : commands_of(static_cast<const A*>(nullptr))) {
        CAPTURE(o.name);
        for (std::size_t n = 0;; ++n) {
            CAPTURE(n);
            scene<A> s{o};
            std::size_t next = 0; // frame of the command
            s.play([&] {
                if (next == 0 && s.begun() > n && s.drive.begin(disable{}) == errc::ok) next = s.begun();
            });
            if (next == 0) { // it ended before, or is a stop of no lower priority
                (void)s.is_over();
                break;
            }
            ++stops;
            CHECK(s.is_ok());
            CHECK(is_off<A>(s));
            REQUIRE(s.frames() > next);
            for (std::size_t i = next; i < s.frames(); ++i) {
                const auto& f = s.requests[s.first + i];
                CHECK((is_stop(f) || (i != next && !is_write(f))));
            }
            s.check_once();
        }
    }
    CHECK(stops > 100);
}

TEST_CASE_TEMPLATE("G21, S4, S6: if the drive restarts at any frame of any command, no wrong motion follows" *
                       doctest::test_suite("interpretations"),
                   A, closed_axis, open_axis) {
    at_every_frame<A>([](const row<A>& o, std::size_t n, bool boots_slowly, const sim::yako_options& by) {
        const std::uint64_t boot_us = boots_slowly ? 300'000 : 5'000; // no request is received meanwhile
        const bool is_energised = by.is_enabled_at_power_on;
        scene<A> s{o, by};
        std::uint64_t up_at = 0;
        s.play([&] {
            if (s.begun() == n + 1 && up_at == 0) {
                s.model.power_cycle();
                up_at = s.wire.time_us() + boot_us;
            }
            if (up_at != 0) s.wire.set_connected(0, s.wire.time_us() >= up_at);
        });
        if (up_at == 0) return s.is_over();
        s.reconnect();
        s.check_once();
        s.check_way();
        // Three restarts that no register shows [errata A55]: one during a move to zero, which reports that the
        // motion is unknown; one that loses the position while the drive still reports that it is homed, of
        // which the comment of move_to warns; and one after which only the witness is read.
        const bool is_like_zero = by.kept == sim::yako_kept::written && !by.restart_keeps_place &&
                                  s.of.way == -30 && s.drive.motion() == motion_check::unknown;
        const bool is_like_homed =
            by.restart_keeps_homed && !by.restart_keeps_place && s.of.name.rfind("move_to", 0) == 0;
        const bool is_like_before =
            by.kept == sim::yako_kept::written &&
            std::all_of(s.requests.begin() + static_cast<std::ptrdiff_t>(s.first + n), s.requests.end(),
                        [](const auto& f) { return f[1] == 0x03 && f[3] == 0xBA; });
        const bool may_be_restart = is_like_zero || is_like_homed || is_like_before;
        if (s.is_ok() && !may_be_restart) s.check_done();
        if (s.moves() && s.model.starts() == s.starts) CHECK(s.drive.motion() != motion_check::seen);
        if (!is_energised && o.is_done != is_on<A>) CHECK_FALSE(s.model.enabled());
        s.run(120);
        if (!s.is_ok()) CHECK_FALSE(s.is_moving());
        // The next command detects the restart if that is possible. If it moves, it moves as commanded.
        const std::int64_t before = s.model.view().shaft;
        const command_status next = s.drive.run(move_by{10 * pulse, brisk});
        s.check_beliefs();
        s.run(120);
        const std::int64_t moved = s.model.view().shaft - before;
        if (!s.is_moving()) CHECK(moved == (next ? 10 : 0));
        return true;
    });
}

} // namespace safety_yako_tests
