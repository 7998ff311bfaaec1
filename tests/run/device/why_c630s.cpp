// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// C630S: every command with an argument, with random values around every limit, against the ranges of the manual's
// tables (V24.111, chapter 7) as this test states them, and `why` against both.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/device/c630s/arguments.hpp>
#include <servobus/device/c630s/registers.hpp>

#include <tests/support/refusals.hpp>

namespace why_c630s_tests {

using namespace servobus;
using namespace servobus::c630s;
using c630s::time; // and not that of the C library
using refusal_tests::rule;

namespace {

constexpr unsigned rounds = 1500;

struct bench {
    refusal_tests::near_limits pick{0x5EED'C630};
    refusal_tests::refusal_judge of{drive_states{drive_state::needs_init, drive_state::needs_set_up,
                                                 drive_state::needs_power_cycle, drive_state::disabled,
                                                 drive_state::enabled, drive_state::quick_stopped}};
    cached_settings known{};

    /// Seven of eight are in a state in which the command is possible.
    void draw(drive_state state, control_mode mode = control_mode::speed) {
        const auto limit = [&](std::uint32_t most) {
            return static_cast<std::uint16_t>(pick.one_in(6) ? pick.next() & 0xFFFF : pick.below(most + 1));
        };
        known = {.state = state,
                 .mode = mode,
                 .source = position_source::segments,
                 .inputs = static_cast<std::uint16_t>(terminal::servo_on | terminal::marker),
                 .word_order = pick.one_in(16) ? word_order::unknown : word_order::low_first,
                 .max_speed = limit(6000),
                 .max_forward = limit(6000),
                 .max_reverse = limit(6000),
                 .positive_torque = limit(3000),
                 .negative_torque = limit(3000)};
        if (!pick.one_in(8)) return;
        known.state = static_cast<drive_state>(pick.below(7));
        known.mode = static_cast<control_mode>(pick.below(7));
        known.source = static_cast<position_source>(pick.below(3));
        known.run = static_cast<segment_mode>(pick.below(4));
        known.runs_speed_segments = pick.one_in(2);
        if (pick.one_in(2)) known.inputs |= terminal::jog_forward;
    }
    void draw_off() { draw(drive_state::disabled); }

    speed speed_near(std::int64_t low, std::int64_t high) { return speed{pick.value({low, 0, high})}; }
    time time_near(std::int64_t low, std::int64_t high) { return time{pick.value({low, high})}; }
    distance way_near(std::int64_t most) { return distance{pick.value({-most, 0, most})}; }
    torque_share share_near(std::int64_t low, std::int64_t high) {
        return torque_share{pick.value({low, 0, high})};
    }
};

template <class E> long number(E e) { return static_cast<long>(e); }
rule code_rule(long address, long code, long low, long high) { return rule::range(address, code, low, high); }

} // namespace

TEST_CASE("C630S: a speed is refused by its row or by P06-07 to P06-09, and why says by which") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw(drive_state::enabled);
        const std::int64_t forward = b.known.max_forward;
        const std::int64_t reverse = b.known.max_reverse;
        const std::int64_t most = b.known.max_speed;
        const speed v{b.pick.value({-6000, -most, -reverse, 0, forward, most, 6000})};
        const long double d = v.count();
        const rule row = rule::range(0x0603, d, -6000, 6000);
        const rule own = rule::range(0x0603, d, -static_cast<long double>(reverse), forward);
        const rule either = rule::range(0x0603, d, -static_cast<long double>(most), most);
        b.of.judge(velocity{v}, b.known, {row, own, either});
        b.of.judge(hold{v, runs_on_without_line{}}, b.known, {row, own, either});
        // P06-04 takes the size of it.
        const rule jogs[] = {row, own, either};
        rule at_jog[] = {jogs[0], jogs[1], jogs[2]};
        for (rule& one : at_jog) one.address = 0x0604;
        b.of.judge(jog{v}, b.known, at_jog);
        const refusal r = commands::refusal_of(velocity{v}, b.known);
        if (r.error != errc::out_of_range) continue;
        const unsigned by = r.argument.limited_by;
        CHECK((by == 0x0603 || by == 0x0607 || by == (v.count() < 0 ? 0x0609u : 0x0608u)));
        // It is the narrowest of the three.
        const std::int64_t in_way = v.count() < 0 ? reverse : forward;
        const std::int64_t least = most < in_way ? most : in_way;
        const std::int64_t limit = v.count() < 0 ? -r.argument.limits.low : r.argument.limits.high;
        CHECK(limit == (least < 6000 ? least : 6000));
    }
    CHECK(b.of.seen() == "1449 accepted, 2491 out of range, 0 inexact, 0 bad argument, 560 for the state, 0 "
                         "for other reasons");
}

TEST_CASE("C630S: torques keep P07-09 and P07-10, and their limits and speeds their rows") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw(drive_state::enabled, control_mode::torque);
        const std::int64_t positive = b.known.positive_torque;
        const std::int64_t negative = b.known.negative_torque;
        const torque_share t{b.pick.value({-3000, -negative, 0, positive, 3000})};
        b.of.judge(torque{t}, b.known,
                   {rule::range(0x0703, t.count(), -3000, 3000),
                    rule::range(0x0703, t.count(), -static_cast<long double>(negative), positive)});
        const torque_share up = b.share_near(0, 3000);
        const torque_share down = b.share_near(0, 3000);
        b.of.judge(torque_limits{up, down}, b.known,
                   {rule::range(0x0709, up.count(), 0, 3000), rule::range(0x070A, down.count(), 0, 3000)});
        const speed f = b.speed_near(0, 6000);
        const speed r = b.speed_near(0, 6000);
        const speed e = b.speed_near(0, 6000);
        b.of.judge(torque_speed_limits{f, r}, b.known,
                   {rule::range(0x0713, f.count(), 0, 6000), rule::range(0x0714, r.count(), 0, 6000)});
        b.of.judge(top_speeds{e, f, r}, b.known,
                   {rule::range(0x0607, e.count(), 0, 6000), rule::range(0x0608, f.count(), 0, 6000),
                    rule::range(0x0609, r.count(), 0, 6000)});
        const time rise = b.time_near(0, 65'535);
        const time fall = b.time_near(0, 65'535);
        b.of.judge(
            ramps{rise, fall}, b.known,
            {rule::range(0x0605, rise.count(), 0, 65'535), rule::range(0x0606, fall.count(), 0, 65'535)});
    }
    CHECK(b.of.seen() == "4549 accepted, 2665 out of range, 0 inexact, 0 bad argument, 286 for the state, 0 "
                         "for other reasons");
}

TEST_CASE("C630S: segments are numbered 1 to 16, and their values belong to the registers of that segment") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw_off();
        const std::int32_t n = b.pick.value({1, 16});
        const bool is_segment = n >= 1 && n <= 16;
        const long at = is_segment ? n - 1 : 0;
        const rule numbered = rule::index(n, 1, 16);
        const distance d = b.way_near(1'073'741'824);
        const speed v = b.speed_near(1, 6000);
        const time ramp = b.time_near(0, 65'535);
        const time wait = b.time_near(0, 10'000);
        b.of.judge(segment{checked(n), d, v, ramp, wait}, b.known,
                   {numbered,
                    rule::range(0x0B00 + 0x600 + 12 + 5 * at, d.count(), -1'073'741'824.0L, 1'073'741'824.0L),
                    rule::range(0x1100 + 14 + 5 * at, v.count(), 1, 6000),
                    rule::range(0x1100 + 15 + 5 * at, ramp.count(), 0, 65'535),
                    rule::range(0x1100 + 16 + 5 * at, wait.count(), 0, 10'000)});
        const auto remainder = b.pick.code<segment_remainder>(0, 1);
        const auto type = b.pick.code<displacement_type>(0, 1);
        const auto first = static_cast<std::uint16_t>(b.pick.value({0, 16}));
        b.of.judge(position_segments{type, checked(n), remainder, first}, b.known,
                   {numbered, code_rule(0x1102, number(remainder), 0, 1),
                    code_rule(0x1104, number(type), 0, 1), rule::range(0x1105, first, 0, 16)});
        const speed w = b.speed_near(-6000, 6000);
        const time run{b.pick.value({0, 6'553'500}, 100)};
        const auto by = b.pick.code<segment_ramp>(0, 4);
        b.of.judge(speed_segment{checked(n), w, run, by}, b.known,
                   {numbered, rule::range(0x1200 + 20 + 3 * at, w.count(), -6000, 6000),
                    rule::whole(0x1200 + 21 + 3 * at, run.count(), 100),
                    rule::range(0x1200 + 21 + 3 * at, run.count(), 100, 0, 65'535),
                    code_rule(0x1200 + 22 + 3 * at, number(by), 0, 4)});
        const long pair = number(by) >= 1 && number(by) <= 4 ? 2 * (number(by) - 1) : 0;
        const time rise = b.time_near(0, 65'535);
        const time fall = b.time_near(0, 65'535);
        b.of.judge(segment_ramp_times{by, rise, fall}, b.known,
                   {rule::range(0x1203 + pair, rise.count(), 0, 65'535),
                    rule::range(0x1204 + pair, fall.count(), 0, 65'535), rule::index(number(by), 1, 4)});
        const auto run_by = b.pick.code<segment_mode>(0, 2);
        const std::int32_t last = b.pick.value({1, 16});
        b.of.judge(run_speed_segments{run_by, checked(n), checked(last)}, b.known,
                   {code_rule(0x1200, number(run_by), 0, 2), numbered, rule::index(last, 1, 16)});

        b.draw(drive_state::enabled, control_mode::position);
        b.of.judge(start_segment{checked(n)}, b.known, numbered);
        b.draw(drive_state::enabled);
        b.known.runs_speed_segments = true;
        b.of.judge(select_speed_segment{checked(n)}, b.known, numbered);
    }
    CHECK(b.of.seen() == "4484 accepted, 3054 out of range, 242 inexact, 1827 bad argument, 807 for the "
                         "state, 86 for other reasons");
}

TEST_CASE("C630S: enabling, homing, gears, address and line") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw_off();
        const auto mode = b.pick.code<control_mode>(0, 6);
        const auto from = b.pick.code<position_source>(0, 2);
        const auto run = b.pick.code<segment_mode>(0, 3);
        b.of.judge(enable_in{mode, from, run}, b.known,
                   {rule::that(0x0200, errc::bad_argument, number(mode) <= 2),
                    code_rule(0x1100, number(run), 0, 3), code_rule(0x0500, number(from), 0, 2)});
        const distance step = b.way_near(9999);
        b.of.judge(step_size{step}, b.known, rule::range(0x0505, step.count(), -9999, 9999));
        const auto method = b.pick.code<homing_mode>(0, 9);
        const speed fast = b.speed_near(0, 3000);
        const speed slow = b.speed_near(0, 1000);
        const time ramp = b.time_near(0, 1000);
        b.of.judge(homing_by{method, fast, slow, ramp}, b.known,
                   {code_rule(0x051F, number(method), 0, 9), rule::range(0x0520, fast.count(), 0, 3000),
                    rule::range(0x0521, slow.count(), 0, 1000), rule::range(0x0522, ramp.count(), 0, 1000)});
        const auto n = static_cast<std::uint32_t>(b.pick.value({1, 1'073'741'824}));
        const auto d = static_cast<std::uint32_t>(b.pick.value({1, 1'073'741'824}));
        const unsigned which = b.pick.below(4);
        const long second = which == 2 ? 4 : 0;
        b.of.judge(gear{n, d, which}, b.known,
                   {rule::range(0x0507 + second, n, 1, 1'073'741'824),
                    rule::range(0x0509 + second, d, 1, 1'073'741'824), rule::index(which, 1, 2)});
        const auto address = static_cast<std::uint16_t>(b.pick.value({1, 247}));
        b.of.judge(change_address{address, sole_drive_on_the_line{}}, b.known,
                   rule::range(0x0C00, address, 1, 247));
        const auto baud = b.pick.code<baud_rate>(0, 5);
        const auto format = b.pick.code<serial_format>(0, 3);
        b.of.judge(change_line{baud, format}, b.known,
                   {code_rule(0x0C02, number(baud), 0, 5), code_rule(0x0C03, number(format), 0, 3)});

        b.draw(drive_state::enabled, control_mode::position);
        const time within = b.time_near(1, 2'000'000);
        const rule waits = rule::range(-1, within.count(), 1, 2'000'000);
        b.of.judge(home{within}, b.known, waits);
        b.of.judge(home_electrically{within}, b.known, waits);
    }
    CHECK(b.of.seen() == "6446 accepted, 3224 out of range, 0 inexact, 1535 bad argument, 719 for the state, "
                         "76 for other reasons");
}

TEST_CASE("C630S: any parameter, set or kept") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw_off();
        const std::int32_t v = b.pick.value({0, 1, 6000, 65'535});
        const rule speeds = rule::range(0x1214, v, -6000, 6000);
        b.of.judge(set<servobus::at<speed_segment_speeds, 0>>{checked(raw(v))}, b.known, speeds);
        b.of.judge(keep<servobus::at<speed_segment_speeds, 0>>{checked(raw(v))}, b.known, speeds);
        const std::int32_t w = b.pick.value({-1'073'741'824, 0, 1'073'741'824});
        const rule offset = rule::range(0x0524, w, -1'073'741'824.0L, 1'073'741'824.0L);
        b.of.judge(set<home_offset>{checked(raw(w))}, b.known, offset);
        b.of.judge(keep<home_offset>{checked(raw(w))}, b.known, offset);
        const rule pulses = rule::range(0x0502, w, 0, 1'048'576);
        b.of.judge(keep<pulses_per_revolution>{checked(raw(w))}, b.known, pulses);
        // No input is servo-on (1).
        const auto as = b.pick.code<input_function>(0, 38);
        const rule in_list = code_rule(0x0302, number(as), 0, 38);
        const rule not_on = rule::that(0x0302, errc::out_of_range, number(as) != 1);
        b.of.judge(set<di1_function>{checked(as)}, b.known, {in_list, not_on});
        b.of.judge(keep<di1_function>{checked(as)}, b.known, {in_list, not_on});
        // A quantity that is no whole number of counts: 0.1 % of the torque.
        const quantity<units::percent / 100, std::int32_t> share{b.pick.value({0, 30'000})};
        b.of.judge(set<positive_internal_torque_limit>{checked(share)}, b.known,
                   {rule::whole(0x0709, share.count(), 10), rule::range(0x0709, share.count(), 10, 0, 3000)});
    }
    CHECK(b.of.seen() == "5578 accepted, 4353 out of range, 1318 inexact, 0 bad argument, 460 for the state, "
                         "291 for other reasons");
}

} // namespace why_c630s_tests
