// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC steppers: every command with an argument, with random values around every limit, against the ranges of the
// manual's table (V2.6.0, chapter 5) as this test states them, and `why` against both.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/device/yako/arguments.hpp>

#include <tests/support/refusals.hpp>

namespace why_yako_tests {

using namespace servobus;
using namespace servobus::yako;
using refusal_tests::rule;
using yako::time; // and not that of the C library

namespace {

constexpr unsigned rounds = 3000;

struct three_rules {
    rule r[3];
};

struct bench {
    refusal_tests::near_limits pick{0x5EED'0A40};
    refusal_tests::refusal_judge of{
        drive_states{drive_state::needs_init, drive_state::disabled, drive_state::enabled}};
    cached_settings known{};

    void draw() {
        known = {.state = static_cast<drive_state>(pick.one_in(8) ? 0 : 1 + pick.below(6)),
                 .is_closed_loop = pick.one_in(2),
                 .word_order = word_order::high_first,
                 .resolution = pick.one_in(2) ? speed_count::tenth_r_per_min : speed_count::one_r_per_min,
                 .has_scale = !pick.one_in(16),
                 .has_profile = !pick.one_in(16),
                 .has_homing_profile = !pick.one_in(16),
                 .is_homed = !pick.one_in(8),
                 .microsteps = 1000};
    }
    // r/min, in tenths.
    speed speed_near(std::int64_t low, std::int64_t high) {
        return speed{pick.value({low * 10, 0, high * 10}, 10)};
    }
    time time_near(std::int64_t low, std::int64_t high) { return time{pick.value({low, high})}; }
    distance place() { return distance{pick.value({-0x7FFF'FFFF, 0, 0x7FFF'FFFF})}; }
    motion_profile profile() {
        if (pick.one_in(6)) return {};
        return {speed_near(0, 3000), time_near(0, 2000), time_near(0, 2000), speed_near(0, 3000)};
    }

    // The worth of a count must be certain; then the range, which is in r/min; then whole counts.
    three_rules speed_rules(long address, speed v, long double low, long double high) const {
        const bool is_whole = known.resolution == speed_count::tenth_r_per_min || v.count() % 10 == 0;
        return {{rule::that(address, errc::wrong_state, known.has_scale),
                 rule::range(address, v.count(), 10, low, high),
                 rule::that(address, errc::inexact, is_whole)}};
    }
    // The ends of 32 bits are refused: a saturated quantity has them.
    static rule way_rule(long address, distance d) {
        return rule::range(address, d.count(), -2'147'483'647.0L, 2'147'483'646.0L);
    }
    // 0020h..0023h after the rules of the command.
    template <class Command>
    void judge_profile(const Command& c, const motion_profile& p, std::initializer_list<rule> before,
                       std::initializer_list<rule> after = {}) {
        std::vector<rule> all{before};
        if (p.is_stored()) {
            all.push_back(rule::that(-1, errc::wrong_state, known.has_profile));
        } else {
            const three_rules start = speed_rules(0x0020, p.start(), 0, 3000);
            const three_rules top = speed_rules(0x0023, p.top(), 0, 3000);
            all.insert(all.end(), start.r, start.r + 3);
            all.push_back(rule::range(0x0021, p.acceleration().count(), 0, 2000));
            all.push_back(rule::range(0x0022, p.deceleration().count(), 0, 2000));
            all.insert(all.end(), top.r, top.r + 3);
            const bool has_order = p.top().count() > 0 && p.start().count() <= p.top().count();
            all.push_back(rule::that(0x0023, errc::out_of_range, has_order));
        }
        all.insert(all.end(), after);
        of.judge(c, known, all);
    }
};

rule code_rule(long address, long code, long low, long high) { return rule::range(address, code, low, high); }
template <class E> long number(E e) { return static_cast<long>(e); }

} // namespace

TEST_CASE("YAKO: moves keep the profile's ranges, a way its 32 bits, and why says which register") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw();
        const distance d = b.place();
        const motion_profile p = b.profile();
        const auto then = b.pick.one_in(2) ? while_moving::ignore : while_moving::interrupt;
        const rule way = bench::way_rule(0x0024, d);
        b.judge_profile(move_by{d, p, then}, p, {way});
        b.judge_profile(bounded_jog{d, p}, p, {way});
        b.judge_profile(move_to{d, p, then}, p, {way},
                        {rule::that(-1, errc::needs_homing, b.known.is_homed)});
        const rule named = rule::that(-1, errc::bad_argument, !p.is_stored());
        if (!p.is_stored()) b.judge_profile(set_profile{p}, p, {named});

        const speed v = b.speed_near(-3000, 3000);
        const time rise = b.time_near(0, 2000);
        const time fall = b.time_near(0, 2000);
        const three_rules s = b.speed_rules(0x001D, v, -3000, 3000);
        b.of.judge(velocity{v, rise, fall}, b.known,
                   {rule::that(0x001D, errc::out_of_range, v.count() != 0), s.r[0], s.r[1], s.r[2],
                    rule::range(0x001E, rise.count(), 0, 2000), rule::range(0x001F, fall.count(), 0, 2000)});
        const speed top = v.count() < 0 ? -v : v;
        const duration every{static_cast<std::uint32_t>(b.pick.value({1000, 1'000'000}))};
        const three_rules t = b.speed_rules(0x0023, top, 0, 3000);
        b.of.judge(hold{v, every, rise, fall}, b.known,
                   {t.r[0], rule::range(0x0021, rise.count(), 0, 2000),
                    rule::range(0x0022, fall.count(), 0, 2000), t.r[1], t.r[2],
                    rule::that(0x0023, errc::out_of_range, v.count() != 0),
                    rule::range(-1, every.us, 1000, 1'000'000)});
    }
    CHECK(b.of.seen() == "1211 accepted, 8496 out of range, 717 inexact, 0 bad argument, 6989 for the state, "
                         "92 for other reasons");
}

TEST_CASE("YAKO: homing takes the methods of its device, offsets and handlings") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw();
        const distance d = b.place();
        const auto n = static_cast<std::int16_t>(b.pick.value({-4, -1, 1, 14, 17, 30, 33, 35}));
        const auto method = static_cast<homing>(n);
        const auto then = b.pick.code<offset_handling>(0, 11);
        const rule offset = bench::way_rule(0x0035, d);
        const rule handling = code_rule(0x0030, number(then), 0, 11);
        const rule profile = rule::that(-1, errc::wrong_state, b.known.has_homing_profile);
        // The mechanical stops, -4..-1, enter as constants only.
        const bool in_both = (n >= 17 && n <= 30) || n == 35;
        const bool in_closed = in_both || (n >= 1 && n <= 14) || n == 33 || n == 34;
        b.of.judge(closed_loop::home{checked(method), d, then}, b.known,
                   {offset, handling, rule::that(0x0031, errc::out_of_range, in_closed), profile});
        b.of.judge(open_loop::home{checked(method), d, then}, b.known,
                   {offset, handling, rule::that(0x0031, errc::out_of_range, in_both), profile});
        b.of.judge(declare_position{d}, b.known, offset);

        const speed fast = b.speed_near(5, 3000);
        const speed slow = b.speed_near(5, 300);
        const time ramp = b.time_near(30, 2000);
        const three_rules f = b.speed_rules(0x0032, fast, 5, 3000);
        const three_rules s = b.speed_rules(0x0033, slow, 5, 300);
        b.of.judge(
            set_homing_profile{fast, slow, ramp}, b.known,
            {f.r[0], f.r[1], f.r[2], s.r[0], s.r[1], s.r[2], rule::range(0x0034, ramp.count(), 30, 2000)});
    }
    CHECK(b.of.seen() == "1872 accepted, 5066 out of range, 112 inexact, 0 bad argument, 4950 for the state, "
                         "0 for other reasons");
}

TEST_CASE("YAKO: segments are numbered 1 to 16, and their values belong to the registers of that segment") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw();
        const std::int32_t n = b.pick.value({1, 16});
        const bool is_segment = n >= 1 && n <= 16;
        const long at = is_segment ? n - 1 : 0;
        const distance d = b.place();
        const time rise = b.time_near(0, 2000);
        const time fall = b.time_near(0, 2000);
        const auto from = b.pick.code<positioning>(0, 1);
        const speed top = b.speed_near(0, 3000);
        const three_rules t = b.speed_rules(0x0062 + 6 * at, top, 0, 3000);
        // A segment's speed is worked out before the number is looked at, and is refused after it.
        b.of.judge(set_position_segment{checked(n), d, top, rise, fall, from}, b.known,
                   {rule::index(n, 1, 16), bench::way_rule(0x0060 + 6 * at, d), t.r[0], t.r[1], t.r[2],
                    rule::range(0x0063 + 6 * at, rise.count(), 0, 2000),
                    rule::range(0x0064 + 6 * at, fall.count(), 0, 2000),
                    code_rule(0x0065 + 6 * at, number(from), 0, 1)});
        const speed v = b.speed_near(-3000, 3000);
        const three_rules s = b.speed_rules(0x00C0 + 3 * at, v, -3000, 3000);
        b.of.judge(set_speed_segment{checked(n), v, rise, fall}, b.known,
                   {rule::index(n, 1, 16), s.r[0], s.r[1], s.r[2],
                    rule::range(0x00C1 + 3 * at, rise.count(), 0, 2000),
                    rule::range(0x00C2 + 3 * at, fall.count(), 0, 2000)});
        const motion_profile p = b.profile();
        if (p.is_stored()) continue;
        const bool is_homed_enough = from != positioning::absolute || b.known.is_homed;
        b.judge_profile(
            set_input_move{d, p, from}, p, {bench::way_rule(0x0024, d)},
            {code_rule(0x0050, number(from), 0, 1), rule::that(-1, errc::needs_homing, is_homed_enough)});
    }
    CHECK(b.of.seen() == "1697 accepted, 4111 out of range, 304 inexact, 890 bad argument, 1488 for the "
                         "state, 4 for other reasons");
}

TEST_CASE("YAKO: terminals, limits and communication") {
    bench b;
    for (unsigned i = 0; i < rounds; ++i) {
        b.draw();
        const bool closed = b.known.is_closed_loop;
        const auto in = static_cast<input_terminal>(b.pick.below(8));
        const auto in_as = b.pick.code<input_function>(0, 18);
        b.of.judge(set_input{in, in_as}, b.known,
                   {rule::index(number(in), 0, closed ? 3 : 6),
                    code_rule(0x0041 + number(in), number(in_as), 0, 18)});
        const auto out = static_cast<output_terminal>(b.pick.below(4));
        const auto out_as = b.pick.code<output_function>(0, 11);
        const long o = number(out_as);
        b.of.judge(set_output{out, out_as}, b.known,
                   {rule::index(number(out), 0, closed ? 1 : 2),
                    rule::that(0x004C + number(out), errc::out_of_range, o <= 5 || (o >= 9 && o <= 11))});
        const distance up = b.place();
        const distance down = b.pick.one_in(2) ? b.place() : distance{up.count() / 2};
        b.of.judge(limit_travel{down, up}, b.known,
                   {rule::that(0x0037, errc::bad_argument, up.count() > down.count()),
                    bench::way_rule(0x0037, up), bench::way_rule(0x0039, down)});
        const auto trigger = b.pick.code<pv_trigger>(0, 1);
        b.of.judge(set_pv_trigger{trigger}, b.known, code_rule(0x0051, number(trigger), 0, 1));
        const auto stop = b.pick.code<over_travel_stop>(0, 1);
        b.of.judge(set_over_travel_stop{stop}, b.known, code_rule(0x0017, number(stop), 0, 1));
        const auto order = b.pick.code<word_order_setting>(0, 1);
        b.of.judge(set_word_order{order}, b.known, code_rule(0x0019, number(order), 0, 1));
        const auto count = b.pick.code<speed_count>(0, 1);
        if (closed) b.of.judge(set_speed_resolution{count}, b.known, code_rule(0x001A, number(count), 0, 1));
        const auto address = static_cast<std::uint8_t>(b.pick.below(256));
        b.of.judge(set_node_address{address, sole_drive_on_the_line{}}, b.known,
                   code_rule(0x0013, address, 1, 247));
        const auto baud = b.pick.code<baud_rate>(0, 3);
        b.of.judge(set_baud_rate{baud}, b.known, code_rule(0x0014, number(baud), 0, 3));
        const auto format = b.pick.code<serial_format>(0, 3);
        b.of.judge(set_serial_format{format}, b.known, code_rule(0x0015, number(format), 0, 3));
    }
    CHECK(b.of.seen() == "12893 accepted, 8724 out of range, 0 inexact, 3193 bad argument, 3685 for the "
                         "state, 0 for other reasons");
}

} // namespace why_yako_tests
