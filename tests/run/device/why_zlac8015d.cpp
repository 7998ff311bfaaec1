// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLAC8015D: every command with an argument, with random values around every limit, against the ranges of the manual's
// table (V1.07, chapter 4) as this test states them, and `why` against both.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/device/zlac8015d/arguments.hpp>

#include <tests/support/refusals.hpp>

namespace why_zlac8015d_tests {

using namespace servobus;
using namespace servobus::zlac8015d;
using refusal_tests::rule;
using zlac8015d::time; // and not that of the C library

namespace {

constexpr unsigned rounds = 3000;

struct bench {
    refusal_tests::near_limits pick{0x5EED'2AC8};
    refusal_tests::refusal_judge of{drive_states{drive_state::needs_init, drive_state::needs_power_cycle,
                                                 drive_state::disabled, drive_state::enabled,
                                                 drive_state::quick_stopped}};
    cached_settings known{};

    /// Three of four are in a state in which the command is possible.
    void draw(drive_state state, operating_mode mode,
              synchronisation starts = synchronisation::asynchronous) {
        known = {.state = state,
                 .mode = mode,
                 .starts = starts,
                 .resolution = static_cast<std::uint16_t>(1 + pick.below(10)),
                 .max_speed =
                     static_cast<std::uint16_t>(pick.one_in(8) ? pick.next() & 0xFFFF : pick.below(1001)),
                 .host_timeout = static_cast<std::uint16_t>(pick.below(0x8000))};
        if (!pick.one_in(4)) return;
        known.state = static_cast<drive_state>(pick.below(7));
        known.mode = static_cast<operating_mode>(pick.below(5));
        known.starts = static_cast<synchronisation>(pick.below(2));
    }
    void draw() { draw(drive_state::disabled, operating_mode::undefined); }

    speed speed_near() {
        const std::int64_t own = std::int64_t{known.max_speed} * 2520;
        const std::int64_t table = 3000 * 2520 / known.resolution;
        const std::int64_t most = own < table ? own : table;
        return speed{pick.value({-most, -table, -own, 0, own, table, most}, 2520 / known.resolution)};
    }
    distance place(std::int64_t most) { return distance{pick.value({-most, 0, most})}; }
};

// 2008h in r/min, then whole counts of 1/n r/min (2022h), then 2088h.
struct three_rules {
    rule r[3];
};
three_rules speed_rules(long address, speed v, const cached_settings& known) {
    const long double part = v.count();
    const long double n = known.resolution;
    return {{rule::range(address, part, 2520, -static_cast<long double>(known.max_speed), known.max_speed),
             rule::whole(address, part * n, 2520), rule::range(address, part * n, 2520, -3000, 3000)}};
}

} // namespace

TEST_CASE("ZLAC8015D: a speed is refused by 2008h, by its count, or by 2088h, and why says by which") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw(drive_state::enabled, operating_mode::velocity);
        const speed l = b.speed_near();
        const speed r = b.speed_near();
        const three_rules ls = speed_rules(0x2088, l, b.known);
        const three_rules rs = speed_rules(0x2089, r, b.known);
        b.of.judge(velocity{l, r}, b.known, {ls.r[0], ls.r[1], ls.r[2], rs.r[0], rs.r[1], rs.r[2]});
        b.of.judge(left_velocity{l}, b.known, {ls.r[0], ls.r[1], ls.r[2]});
        b.of.judge(right_velocity{r}, b.known, {rs.r[0], rs.r[1], rs.r[2]});
        if (b.pick.one_in(8)) b.known.host_timeout = 0;
        b.of.judge(hold{l, r}, b.known, {ls.r[0], ls.r[1], ls.r[2], rs.r[0], rs.r[1], rs.r[2]});
        // A clamped speed is never refused for its value.
        const errc clamped = clamped_velocity{l, r}.prepare(b.known).refusal;
        CHECK((clamped == errc::ok || clamped == errc::needs_init || clamped == errc::wrong_state));
        const refusal why_not = commands::refusal_of(left_velocity{l}, b.known);
        if (why_not.error == errc::out_of_range) {
            const bool is_beyond_own = ls.r[0].is_broken;
            const bool is_beyond_table =
                rule::range(0, l.count() * 1.0L * b.known.resolution, 2520, -3000, 3000).is_broken;
            CHECK((is_beyond_own || is_beyond_table));
            if (!is_beyond_table) CHECK(why_not.argument.limited_by == 0x2008);
            if (!is_beyond_own) CHECK(why_not.argument.limited_by == 0x2088);
        }
    }
    CHECK(b.of.seen() ==
          "5607 accepted, 2058 out of range, 1315 inexact, 0 bad argument, 3020 for the state, "
          "0 for other reasons");
}

TEST_CASE("ZLAC8015D: torques and positions keep 2090h, 208Ah, and half of it where they are absolute") {
    bench b;
    constexpr std::int64_t half = 0x3FFF'FFFF;
    constexpr std::int64_t whole = 0x7FFF'FFFF;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw(drive_state::enabled, operating_mode::torque);
        const current l{b.pick.value({-30'000, 0, 30'000})};
        const current r{b.pick.value({-30'000, 0, 30'000})};
        const rule lr = rule::range(0x2090, l.count(), -30'000, 30'000);
        const rule rr = rule::range(0x2091, r.count(), -30'000, 30'000);
        b.of.judge(torque{l, r}, b.known, {lr, rr});
        b.of.judge(left_torque{l}, b.known, lr);
        b.of.judge(right_torque{r}, b.known, rr);

        const distance way_l = b.place(whole);
        const distance way_r = b.place(whole);
        const rule wl = rule::range(0x208A, way_l.count(), -0x7FFF'FFFEl, 0x7FFF'FFFEl);
        const rule wr = rule::range(0x208C, way_r.count(), -0x7FFF'FFFEl, 0x7FFF'FFFEl);
        b.draw(drive_state::enabled, operating_mode::relative_position, synchronisation::synchronous);
        b.of.judge(move_by{way_l, way_r}, b.known, {wl, wr});
        b.draw(drive_state::enabled, operating_mode::relative_position);
        b.of.judge(move_left_by{way_l}, b.known, wl);
        b.of.judge(move_right_by{way_r}, b.known, wr);

        const distance at_l = b.place(half);
        const distance at_r = b.place(half);
        const rule al = rule::range(0x208A, at_l.count(), -0x3FFF'FFFFl, 0x3FFF'FFFFl);
        const rule ar = rule::range(0x208C, at_r.count(), -0x3FFF'FFFFl, 0x3FFF'FFFFl);
        b.draw(drive_state::enabled, operating_mode::absolute_position, synchronisation::synchronous);
        b.of.judge(move_to{at_l, at_r}, b.known, {al, ar});
        b.draw(drive_state::enabled, operating_mode::absolute_position);
        b.of.judge(move_left_to{at_l}, b.known, al);
        b.of.judge(move_right_to{at_r}, b.known, ar);
    }
    CHECK(b.of.seen() == "17011 accepted, 3415 out of range, 0 inexact, 0 bad argument, 6574 for the state, "
                         "0 for other reasons");
}

TEST_CASE("ZLAC8015D: parameters keep the ranges of the manual's table") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw();
        const time rise{b.pick.value({0, 32'767})};
        const time fall{b.pick.value({0, 32'767})};
        b.of.judge(
            ramps{rise, fall}, b.known,
            {rule::range(0x2080, rise.count(), 0, 32'767), rule::range(0x2082, fall.count(), 0, 32'767)});
        b.of.judge(quick_stop_ramp{fall}, b.known, rule::range(0x2084, fall.count(), 0, 32'767));
        b.of.judge(watchdog{rise}, b.known, rule::range(0x2000, rise.count(), 1, 32'767)); // 0 by name only
        b.of.judge(watchdog{undocumented_zero{}}, b.known, rule::range(0x2000, 0, 0, 32'767));
        const current_slope slope{b.pick.value({0, 65'535})};
        b.of.judge(torque_slope{slope}, b.known, rule::range(0x2086, slope.count(), 0, 65'535));

        const speed l{b.pick.value({2520, 2'520'000}, 2520)};
        const speed r{b.pick.value({2520, 2'520'000}, 2520)};
        b.of.judge(position_speed{l, r}, b.known,
                   {rule::whole(0x208E, l.count(), 2520), rule::range(0x208E, l.count(), 2520, 1, 1000),
                    rule::whole(0x208F, r.count(), 2520), rule::range(0x208F, r.count(), 2520, 1, 1000)});

        const auto n = static_cast<std::uint16_t>(b.pick.value({1, 10}));
        b.of.judge(resolution{n}, b.known, rule::range(0x2022, n, 1, 10));
        const auto stop = b.pick.code<quick_stop_option>(5, 7);
        b.of.judge(quick_stop_by{stop}, b.known, rule::range(0x2011, static_cast<long>(stop), 5, 7));
        const auto one = b.pick.code<brake>(0, 1);
        const auto two = b.pick.code<brake>(0, 1);
        b.of.judge(brakes{one, two}, b.known,
                   {rule::range(0x201A, static_cast<long>(one), 0, 1),
                    rule::range(0x201B, static_cast<long>(two), 0, 1)});
        const auto action = b.pick.code<input_stop_action>(0, 1);
        b.of.judge(on_input_stop{action}, b.known, rule::range(0x2021, static_cast<long>(action), 0, 1));
        const auto parked = b.pick.code<off_on>(0, 1);
        b.of.judge(park{parked}, b.known, rule::range(0x200C, static_cast<long>(parked), 0, 1));
        const auto which = b.pick.code<wheels>(0, 3);
        b.of.judge(clear_position{which}, b.known, rule::range(0x2005, static_cast<long>(which), 0, 3));
        const auto mode = b.pick.code<operating_mode>(0, 4);
        const bool is_mode = static_cast<unsigned>(mode) >= 1 && static_cast<unsigned>(mode) <= 4;
        b.of.judge(enable_in{checked(mode)}, b.known, rule::that(0x200D, errc::bad_argument, is_mode));
    }
    CHECK(b.of.seen() == "23129 accepted, 11173 out of range, 1156 inexact, 1369 bad argument, 2173 for the "
                         "state, 0 for other reasons");
}

} // namespace why_zlac8015d_tests
