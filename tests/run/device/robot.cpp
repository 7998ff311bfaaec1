// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot on a ZLAC8015D: twists on the wire, its pose against the simulated wheels, when a pose is not continuous, and
// a drive that counts otherwise than the program says. robot_runs.cpp plays 10 000 random runs.
#include <array>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/parameters.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/endings.hpp>
#include <tests/support/robot_world.hpp>

namespace robot_tests {

using namespace servobus;
using namespace servobus::literals;

namespace {

constexpr feed wheel = rolling(600_mm, counts_per_turn{4096}); // 100 r/min are 1 m/s
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 500_mm});
constexpr robots::machine machine{600, -600, 500, 1024};

struct rig : robots::world {
    explicit rig(duration feedback = milliseconds(20))
        : world{machine, base, {}, {.feedback = feedback, .command_timeout = milliseconds(400)}} {}
    void be_enabled() {
        REQUIRE(robot.run(init{}));
        REQUIRE(robot.run(enable{}));
    }
    /// Drives for a time.
    void go(const twist& by, std::uint32_t ms) {
        for (std::uint32_t t = 0; t < ms; t += 20) {
            (void)robot.begin(by);
            live(milliseconds(20));
        }
    }
    long double off() const { return robots::distance(robot.pose(), *this, machine); }
};
constexpr twist forward{1_m_per_s, 0_rad_per_s}, curve{600_mm_per_s, 800_mrad_per_s}, none{};

} // namespace

TEST_CASE("G42: twists become speeds of both wheels in one frame; above the limit both slow down") {
    struct sender : simulated::driven_zlac8015d {
        zlac8015d::robot<line_type> robot{line, 1, base, unsupervised};
        std::size_t sent_speeds(std::int32_t left, std::int32_t right) {
            const std::array words{static_cast<std::uint16_t>(left), static_cast<std::uint16_t>(right)};
            return sent(modbus::write_frame(1, zlac8015d::left_target_speed.address, words));
        }
    } r;
    REQUIRE(r.robot.run(init{}));
    CHECK(r.robot.begin(forward) == errc::wrong_state);
    REQUIRE(r.robot.run(enable{}));
    REQUIRE(r.robot.run(twist{400_mm_per_s, 200_mrad_per_s})); // 35, 45 r/min
    CHECK(r.sent_speeds(35, -45) == 1);
    REQUIRE(r.robot.run(twist{-400_mm_per_s, 200_mrad_per_s}));
    CHECK(r.sent_speeds(-45, 35) == 1);
    REQUIRE(r.robot.run(twist{20_m_per_s, 40_rad_per_s})); // 1000 and 3000 r/min, 2008h is 1000
    CHECK(r.robot.cached().max_speed == 1000);
    CHECK(r.sent_speeds(333, -1000) == 1);
    REQUIRE(r.robot.run(halt{}));
    REQUIRE(r.robot.run(disable{}));
    r.model.store(0x2022, 10);
    r.model.power_cycle();
    REQUIRE(r.robot.run(init{}));
    REQUIRE(r.robot.run(enable{}));
    REQUIRE(r.robot.run(twist{123_mm_per_s, 0_rad_per_s})); // 12.3 r/min
    CHECK(r.sent_speeds(123, -123) == 1);
    REQUIRE(r.robot.run(twist{20_m_per_s, 40_rad_per_s})); // 2008h is 10'000 tenths, but 2088h takes 3000
    CHECK(r.sent_speeds(1000, -3000) == 1);
    REQUIRE(r.robot.run(disable{}));
    REQUIRE(r.robot.run(zlac8015d::enable_in{zlac8015d::operating_mode::torque}));
    CHECK(r.robot.begin(forward) == errc::wrong_state);
}

TEST_CASE(
    "a geometry that is known at run time only drives like a constant; a refused one is not taken over") {
    struct rig_of : simulated::driven_zlac8015d {
        explicit rig_of(const differential& of) : robot{line, 1, of, unsupervised} {}
        zlac8015d::robot<line_type> robot;
    };
    const auto of_lines = [](std::uint32_t lines) {
        const result<feed> tyre = feed::checked(600_mm, counts_per_turn{4 * lines});
        return differential::checked({.left = *tyre, .right = mirrored(*tyre), .track = 500_mm});
    };
    const result<differential> made = of_lines(1024);
    REQUIRE(made);
    rig_of r{*made};
    REQUIRE(r.robot.run(init{}));
    REQUIRE(r.robot.run(enable{}));
    REQUIRE(r.robot.run(twist{400_mm_per_s, 200_mrad_per_s})); // 35, 45 r/min
    const std::array words{std::uint16_t{35}, static_cast<std::uint16_t>(-45)};
    CHECK(r.sent(modbus::write_frame(1, zlac8015d::left_target_speed.address, words)) == 1);

    const result<differential> refused = of_lines(0);
    CHECK(refused.error() == errc::out_of_range);
    rig_of n{*refused};
    CHECK(n.robot.run(init{}).error() == errc::unexpected_value);
    CHECK(n.robot.state() == drive_state::needs_init);
    CHECK_FALSE(n.robot.run(enable{}));
    CHECK(n.robot.begin(twist{2147_m_per_s, 1_rad_per_s}) != errc::ok);
}

TEST_CASE("a pose that is set without a time while the wheels turn stays continuous") {
    rig r;
    r.be_enabled();
    r.go(forward, 1000);
    r.robot.set_pose(plane_pose::at(1_m, 0_m, 90_mrad));
    REQUIRE(r.robot.pose().is_continuous);
    r.go(forward, 200);
    CHECK(r.robot.pose().is_continuous);
    CHECK(r.robot.pose().x_mm() > 1100_mm);
}

TEST_CASE("a pose begins with the first feedback, says when it was true, and follows the wheels") {
    rig r;
    CHECK_FALSE(r.robot.pose().is_continuous);
    REQUIRE(r.robot.run(init{}));
    CHECK_FALSE(r.robot.pose().is_continuous);
    REQUIRE(r.robot.read());
    CHECK(r.robot.pose().is_continuous);
    REQUIRE(r.robot.run(enable{}));
    r.go(forward, 2000);
    r.go(curve, 3000);
    r.go(none, 1000);
    const plane_pose p = r.robot.pose();
    CHECK(p.is_continuous);
    CHECK(since(p.time, r.line.now()) <= milliseconds(25));
    CHECK(r.off() < 0.5L);
    CHECK(p.x().count() > 1'000'000);
    CHECK(p.heading().count() > 1'500'000);
}

TEST_CASE("an arc is not lost during blocking calls and stops") {
    rig r;
    r.be_enabled();
    r.go(curve, 1000);
    REQUIRE(r.robot.run(halt{}));
    r.go(curve, 1000);
    REQUIRE(r.robot.run(curve));
    REQUIRE(r.robot.run(wait_standstill{milliseconds(300)}).error() == errc::not_reached);
    REQUIRE(r.robot.run(quick_stop{}));
    REQUIRE(r.robot.run(disable{}));
    REQUIRE(r.robot.read());
    CHECK(r.robot.pose().is_continuous);
    CHECK(r.off() < 1);
}

TEST_CASE("G43: a restart after 3.0 m straight, with the wheels rolling on") {
    rig r;
    r.be_enabled();
    while (r.robot.pose().x() < 3_m) r.go(forward, 20);
    CHECK(r.robot.pose().is_continuous);
    CHECK(r.off() < 0.5L);
    r.drive.power_cycle();
    bool is_continuous = true;
    for (int i = 0; i < 200; ++i) {
        r.live(milliseconds(5));
        const plane_pose p = r.robot.pose();
        is_continuous = is_continuous && p.is_continuous;
        if (p.is_continuous) CHECK(r.off() < 1);
    }
    CHECK_FALSE(is_continuous);
    r.be_enabled();
    r.go(forward, 200);
    CHECK_FALSE(r.robot.pose().is_continuous);
}

TEST_CASE("G43: a pose is not continuous after init, cleared positions, a lost port; set_pose makes it so") {
    rig r;
    r.be_enabled();
    r.go(curve, 500);
    SUBCASE("init") { REQUIRE(r.robot.run(init{})); }
    SUBCASE("cleared positions") {
        REQUIRE(r.robot.run(disable{}));
        REQUIRE(r.robot.run(zlac8015d::clear_position{}));
        r.live(milliseconds(100));
    }
    SUBCASE("a lost port") {
        r.wire.unplug();
        r.live(milliseconds(100));
        CHECK_FALSE(r.robot.pose().is_continuous);
        r.wire.plug();
        REQUIRE(r.robot.run(init{}));
    }
    CHECK_FALSE(r.robot.pose().is_continuous);
    r.be_enabled();
    REQUIRE(r.robot.read());
    CHECK_FALSE(r.robot.pose().is_continuous);
    robots::tell(r, r.drive.at());
    CHECK(r.robot.pose().is_continuous);
    r.go(curve, 1000);
    CHECK(r.robot.pose().is_continuous);
    CHECK(r.off() < 0.5L);
}

TEST_CASE("a program that stalls keeps its pose, also where it has just begun another twist") {
    for (const bool is_steady : {true, false}) {
        rig r;
        r.be_enabled();
        r.go(curve, 1500);
        if (!is_steady) {
            REQUIRE(r.robot.begin(twist{600_mm_per_s, -800_mrad_per_s}) == errc::ok);
            r.live(milliseconds(30)); // it leaves
        }
        r.wait(milliseconds(350));
        r.live(milliseconds(40));
        CHECK(r.robot.pose().is_continuous);
        CHECK(r.off() < 0.5L);
    }
}

TEST_CASE("G42: a drive that counts otherwise than the program says is not taken over") {
    for (const unsigned lines : {1024u, 4096u, 0u}) {
        CAPTURE(lines);
        robots::machine other = machine;
        other.lines = lines;
        robots::world w{other, base};
        const bool is_right = lines != 4096; // 0 lines count as 1024
        CHECK(static_cast<bool>(w.robot.run(init{})) == is_right);
        CHECK((w.robot.state() == drive_state::disabled) == is_right);
        if (!is_right) CHECK(w.robot.last().error() == errc::unexpected_value);
    }
}

TEST_CASE("each wheel is compared with its own encoder") {
    static constexpr auto uneven =
        differential::of({.left = wheel, .right = rolling(600_mm, counts_per_turn{16384}), .track = 500_mm});
    struct rig_of : simulated::driven_zlac8015d {
        zlac8015d::robot<line_type> robot{line, 1, uneven, unsupervised};
    } r;
    CHECK(r.robot.run(init{}).error() == errc::unexpected_value); // both have 1024 lines
    r.set_by_hand(zlac8015d::right_encoder_lines.address, 4096);
    CHECK(r.robot.run(init{}));
    r.set_by_hand(zlac8015d::left_encoder_lines.address, 4096);
    CHECK(r.robot.run(init{}).error() == errc::unexpected_value);
}

TEST_CASE("a wheel swings by counts of its own encoder") {
    static constexpr auto uneven =
        differential::of({.left = wheel, .right = rolling(600_mm, counts_per_turn{16384}), .track = 500_mm});
    for (const bool is_right : {false, true}) {
        CAPTURE(is_right);
        zlac8015d::robot_model m;
        m.set_base(uneven);
        zlac8015d::cached_settings known{.state = drive_state::disabled};
        std::array<std::uint16_t, 11> words{};
        m.note({.block = 0, .words = words.data(), .taken = instant{1000}, .epoch = 1}, known);
        REQUIRE(m.pose().is_continuous);
        // A way of 200 counts without a speed is 4.4 degrees of the right wheel, and 17.6 of the left.
        const word_pair way = split_words(200, zlac8015d::device::facts.word_order);
        words[is_right ? 7 : 5] = way.first;
        words[is_right ? 8 : 6] = way.second;
        m.note({.block = 0, .words = words.data(), .taken = instant{101'000}, .epoch = 1}, known);
        CHECK(m.pose().is_continuous == is_right);
    }
}

namespace {

using words = std::array<std::uint16_t, 11>; // 20A2h..20ACh
/// Positions in counts, speeds in 0.1 r/min.
words wheels_at(std::int32_t left, std::int32_t right, int left_speed = 0, int right_speed = 0) {
    words w{};
    const auto put = [&](std::size_t to, std::int32_t place) {
        const word_pair pair =
            split_words(static_cast<std::uint32_t>(place), zlac8015d::device::facts.word_order);
        w[to] = pair.first;
        w[to + 1] = pair.second;
    };
    put(5, left);
    put(7, right);
    w[9] = static_cast<std::uint16_t>(left_speed);
    w[10] = static_cast<std::uint16_t>(right_speed);
    return w;
}
const zlac8015d::cached_settings enabled_at_1_r_per_min{.state = drive_state::enabled,
                                                        .mode = zlac8015d::operating_mode::velocity,
                                                        .resolution = 1,
                                                        .max_speed = 1000};
constexpr auto uneven =
    differential::of({.left = wheel, .right = rolling(600_mm, counts_per_turn{16384}), .track = 500_mm});

/// True if a restart is suspected where the wheels go there in 20 ms.
bool is_suspected(const zlac8015d::robot_model& m, const words& from, const words& to) {
    const block_feedback r{.block = 0,
                           .words = to.data(),
                           .before = from.data(),
                           .between = milliseconds(20),
                           .taken = instant{21'000},
                           .epoch = 1};
    return m.has_fallen(r, enabled_at_1_r_per_min);
}

} // namespace

TEST_CASE(
    "G43: wheels that may both come from zero raise a suspicion if one of them turns, whichever it is") {
    zlac8015d::robot_model m;
    m.set_base(uneven);
    // 60 r/min are 82 counts of the left wheel in 20 ms, and 328 of the right one.
    CHECK_FALSE(is_suspected(m, wheels_at(3, 3), wheels_at(3, 3)));
    CHECK(is_suspected(m, wheels_at(3, 3, 600), wheels_at(85, 3, 600)));
    CHECK(is_suspected(m, wheels_at(3, 3, 0, 600), wheels_at(3, 331, 0, 600)));
    CHECK(is_suspected(m, wheels_at(-3, 3, -600), wheels_at(-85, 3, -600)));
    // One that is farther from zero shows that there was no restart.
    CHECK_FALSE(is_suspected(m, wheels_at(9000, 3, 600), wheels_at(9082, 3, 600)));
    CHECK_FALSE(is_suspected(m, wheels_at(9000, 3, 0, 600), wheels_at(9000, 331, 0, 600)));
    CHECK_FALSE(is_suspected(m, wheels_at(3, 9000, 600), wheels_at(85, 9000, 600)));
    CHECK_FALSE(is_suspected(m, wheels_at(-9000, 3, -600), wheels_at(-9082, 3, -600)));
    CHECK_FALSE(is_suspected(m, wheels_at(-3, -9000, -600), wheels_at(-85, -9000, -600)));
    CHECK_FALSE(is_suspected(m, wheels_at(-9000, -9000, -600, -2400), wheels_at(-9082, -9328, -600, -2400)));
    // By 0.5 r/min in a millisecond: 21 counts of the left wheel, and 37 of the right one.
    CHECK(is_suspected(m, wheels_at(21, 3, 0, 600), wheels_at(21, 331, 0, 600)));
    CHECK_FALSE(is_suspected(m, wheels_at(23, 3, 0, 600), wheels_at(23, 331, 0, 600)));
    CHECK(is_suspected(m, wheels_at(3, 37, 600), wheels_at(85, 37, 600)));
    CHECK_FALSE(is_suspected(m, wheels_at(3, 39, 600), wheels_at(85, 39, 600)));
}

TEST_CASE("G43: for 250 ms from the end of a gap a position from within it may be of a late response") {
    for (const bool is_late : {false, true}) {
        for (const std::uint32_t ms : {20u, 40u, 180u, 230u, 249u, 250u, 270u}) {
            CAPTURE(ms);
            zlac8015d::robot_model m;
            m.set_base(base);
            std::uint32_t now = 1000;
            const auto note = [&m, &now](std::int32_t way, std::uint32_t after_ms, int speed) {
                now += after_ms * 1000;
                const words w = wheels_at(way, -way, speed, -speed);
                m.note({.block = 0, .words = w.data(), .taken = instant{now}, .epoch = 1},
                       enabled_at_1_r_per_min);
            };
            note(0, 0, 100); // 10 r/min are 14 counts in 20 ms
            note(14, 20, 100);
            note(68, 80, 100); // the gap
            REQUIRE(m.pose().is_continuous);
            note(is_late ? 55 : 75, ms, 0);
            // One that is not late is from beyond the gap.
            CHECK(m.pose().is_continuous == (!is_late || ms >= 250));
        }
    }
}

TEST_CASE("G43: wheels at rest near zero raise a suspicion only if a command may have moved them") {
    using namespace zlac8015d;
    using namespace units;
    struct scene {
        prepared_command last;
        bool is_done;
        bool may_move;
    };
    const auto& known = enabled_at_1_r_per_min;
    const prepared_command turn = commands::prepared(velocity{60 * r_per_min, 60 * r_per_min}, known);
    const prepared_command stand = commands::prepared(velocity{0 * r_per_min, 0 * r_per_min}, known);
    const prepared_command stop = prepare(servobus::halt{}, known);
    const prepared_command off = prepare(servobus::disable{}, known);
    const prepared_command on = prepare(servobus::enable{}, known);
    const prepared_command look = prepare(servobus::init{}, known);
    const prepared_command read = prepare(servobus::read_feedback{}, known);
    const scene scenes[] = {{turn, true, true},   {turn, false, true}, {stand, true, false},
                            {stand, false, true}, {stop, true, false}, {stop, false, true},
                            {off, true, false},   {off, false, true},  {on, true, false},
                            {on, false, true},    {look, true, false}, {read, true, true},
                            {read, false, true}};
    const words there = wheels_at(3, -3);
    const command_status lost{status::sent(errc::timeout)};
    for (const scene& s : scenes) {
        CAPTURE(&s - scenes);
        robot_model m;
        m.set_base(base);
        cached_settings cached = known;
        endings e;
        const auto play = [&](zlac8015d::robot_command c, bool is_done) {
            REQUIRE(m.admit(c, milliseconds(100)) == errc::ok);
            const routine steps = c.steps;
            c.steps = no_steps;
            const std::array<std::uint16_t, 16> read_words{};
            ending how = is_done ? e.done({read_words.data(), read_words.size()}) : e.failed(lost, steps);
            how.steps = steps;
            (void)m.learn(c, how, cached);
        };
        std::uint32_t now = 1000;
        const auto note = [&] {
            m.note({.block = 0, .words = there.data(), .taken = instant{now}, .epoch = 1}, known);
        };
        note();
        CHECK_FALSE(is_suspected(m, there, there));
        play(turn, true);
        note();
        CHECK(is_suspected(m, there, there)); // it may have moved since then, and still may
        play(s.last, s.is_done);
        note();
        CHECK(is_suspected(m, there, there)); // until a feedback that cannot be late
        now += 250'000;
        note();
        CHECK(is_suspected(m, there, there) == s.may_move);
    }
}

TEST_CASE("G43: the mode is no witness while an enable or a save changes it") {
    using namespace zlac8015d;
    const auto& known = enabled_at_1_r_per_min;
    CHECK(robot_model::witness(known, {.steps = no_steps}).look != nullptr);
    CHECK(robot_model::witness(known, prepare(servobus::read_feedback{}, known)).look != nullptr);
    CHECK(robot_model::witness(known, prepare(servobus::enable{}, known)).look == nullptr);
    cached_settings disabled = known;
    disabled.state = drive_state::disabled;
    CHECK(robot_model::witness(disabled, prepare(servobus::enable{}, disabled)).look == nullptr);
    CHECK(robot_model::witness(disabled, save{}.prepare(disabled)).look == nullptr);
    CHECK(robot_model::witness(disabled, {.steps = no_steps}).look != nullptr);
}

TEST_CASE("G43: only the twist that the drive has acknowledged last is no new command, for either wheel") {
    using namespace zlac8015d;
    using namespace units;
    commanded_motion m;
    endings e;
    const auto is_new_after = [&](std::int32_t left, std::int32_t right, bool is_done) {
        m.note_feedback();
        prepared_command c =
            commands::prepared(velocity{left * r_per_min, right * r_per_min}, enabled_at_1_r_per_min);
        REQUIRE(c.refusal == errc::ok);
        m.begin(c);
        ending how = is_done ? e.done() : e.failed(command_status{status::sent(errc::timeout)});
        how.steps = c.steps;
        m.end(c, how);
        return m.is_new();
    };
    CHECK(is_new_after(60, 90, true));
    CHECK_FALSE(is_new_after(60, 90, true));
    CHECK_FALSE(is_new_after(60, 90, true));
    CHECK(is_new_after(60, 60, true)); // the right wheel alone
    CHECK(is_new_after(90, 60, true)); // the left one alone
    CHECK_FALSE(is_new_after(90, 60, true));
    CHECK(is_new_after(60, 90, false));
    CHECK(is_new_after(60, 90, true)); // it was not acknowledged before
    CHECK_FALSE(is_new_after(60, 90, true));
}

namespace {

/// The highest speed, in r/min, up to which a pose is continuous if a new twist leaves both wheels at it for 100 ms.
int fastest_known(const differential& on) {
    using namespace units;
    int fastest = 0;
    for (int speed = 5; speed < 600; speed += 5) {
        zlac8015d::robot_model m;
        m.set_base(on);
        zlac8015d::cached_settings known = enabled_at_1_r_per_min;
        const auto way_of = [&](const feed& w) {
            return static_cast<std::int32_t>(w.counts() * static_cast<unsigned>(speed) / 600);
        };
        const words first = wheels_at(0, 0, 10 * speed, 10 * speed);
        const words second =
            wheels_at(way_of(on.base().left()), way_of(on.base().right()), 10 * speed, 10 * speed);
        m.note({.block = 0, .words = first.data(), .taken = instant{1000}, .epoch = 1}, known);
        zlac8015d::robot_command c =
            commands::prepared(velocity{speed * r_per_min, speed * r_per_min}, known);
        endings e;
        REQUIRE(m.admit(c, milliseconds(100)) == errc::ok);
        ending how = e.done();
        how.steps = c.steps;
        (void)m.learn(c, how, known);
        m.note({.block = 0, .words = second.data(), .taken = instant{101'000}, .epoch = 1}, known);
        if (m.pose().is_continuous) fastest = speed;
    }
    return fastest;
}
constexpr feed coarse = rolling(600_mm, counts_per_turn{4096}),
               fine = rolling(600_mm, counts_per_turn{16384});
constexpr differential both_coarse = differential::of({.left = coarse, .right = coarse, .track = 500_mm});
constexpr differential both_fine = differential::of({.left = fine, .right = fine, .track = 500_mm});
constexpr differential left_fine = differential::of({.left = fine, .right = coarse, .track = 500_mm});
constexpr differential right_fine = differential::of({.left = coarse, .right = fine, .track = 500_mm});

} // namespace

TEST_CASE("G43: how fast a path may be to be known depends on the wheels' lengths, and not on what each one "
          "counts") {
    const int usual = fastest_known(both_coarse);
    CHECK(usual > 50);
    CHECK(usual < 500);
    for (const differential* on : {&both_fine, &left_fine, &right_fine}) {
        CHECK(fastest_known(*on) >= usual * 85 / 100);
        CHECK(fastest_known(*on) <= usual * 115 / 100);
    }
}

} // namespace robot_tests
