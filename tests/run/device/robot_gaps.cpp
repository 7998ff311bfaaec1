// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot's pose over gaps of its feedback: responses that are lost or late while it keeps its twist, and while it
// changes it; the first command after a restart of the drive. The simulated wheels are the judge.
#include <cstdint>
#include <iterator>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/parameters.hpp>
#include <servobus/sim/faults.hpp>
#include <tests/support/robot_world.hpp>

namespace robot_gaps_tests {

using namespace servobus;
using namespace servobus::literals;

namespace {

constexpr feed wheel = rolling(534_mm, counts_per_turn{4096});
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 400_mm});
constexpr robots::machine machine{534, -534, 400, 1024};

struct rig : robots::world {
    rig(bool is_prompt, duration feedback, std::uint64_t seed = 1, sim::zlac8015d_options options = {})
        : world{machine,
                base,
                options,
                {.feedback = feedback, .command_timeout = milliseconds(2000)},
                seed,
                is_prompt ? responds_within(node<zlac8015d::device>{1}, milliseconds(30))
                          : node<zlac8015d::device>{1}} {
        drive.store(0x2022, 10);
        drive.power_cycle();
        REQUIRE(robot.run(init{}));
        REQUIRE(robot.run(enable{}));
        live(milliseconds(60));
    }
    /// Commands a twist every 40 ms.
    void go(const twist& by, std::uint32_t ms) {
        for (std::uint32_t t = 0; t < ms; t += 40) {
            if (robot.is_idle()) (void)robot.begin(by);
            live(milliseconds(ms - t < 40 ? ms - t : 40));
        }
    }
    /// Tells the robot where the drive was when it gave its positions away last.
    void learn_place() {
        while (drive.given().back().us - robot.pose().time.us > 10'000) live(milliseconds(1));
        robots::tell(*this, drive.given().back().at);
    }
    long double off() const { return robots::distance(robot.pose(), *this, machine); }
};

constexpr twist twists[] = {
    {400_mm_per_s, 0_rad_per_s},      {800_mm_per_s, 0_rad_per_s},       {600_mm_per_s, 1_rad_per_s},
    {600_mm_per_s, -1_rad_per_s},     {-500_mm_per_s, 500_mrad_per_s},   {0_mm_per_s, 1500_mrad_per_s},
    {300_mm_per_s, -1500_mrad_per_s}, {1000_mm_per_s, 300_mrad_per_s},   {0_mm_per_s, 0_rad_per_s},
    {50_mm_per_s, 20_mrad_per_s},     {-800_mm_per_s, -1000_mrad_per_s},
};

} // namespace

TEST_CASE("G43: while the robot keeps its twist, of single lost responses up to 200 ms at least 99 % cost no "
          "pose") {
    sim::dice random{7};
    unsigned gaps = 0, kept = 0;
    for (const bool is_prompt : {false, true})
        for (const twist& by : twists)
            for (const duration feedback : {20_ms, 50_ms}) {
                rig r{is_prompt, feedback};
                r.go(by, 1200);
                REQUIRE(r.robot.pose().is_continuous);
                for (int i = 0; i < 30; ++i) {
                    r.live(milliseconds(random.below(60)));
                    r.wire.faults().lost_response = 1000;
                    r.live(milliseconds(1 + random.below(feedback.us / 1000)));
                    r.wire.faults() = {};
                    if (random.below(2) == 0)
                        r.wait(milliseconds(random.below(120))); // the program is late as well
                    r.go(by, 320);
                    ++gaps;
                    const plane_pose p = r.robot.pose();
                    kept += p.is_continuous;
                    CHECK((!p.is_continuous || r.off() < 1));
                    if (!p.is_continuous) r.learn_place();
                }
            }
    MESSAGE(kept, " of ", gaps, " kept the pose");
    CHECK(gaps == 1320);
    CHECK(kept * 100 >= gaps * 99);
}

TEST_CASE("G43: a gap in which the path bends both ways is within 1 mm of the wheels, or not continuous") {
    struct change {
        twist from, to;
    };
    constexpr change changes[] = {
        {{600_mm_per_s, 1_rad_per_s}, {600_mm_per_s, -1_rad_per_s}},         // an S-curve
        {{500_mm_per_s, 800_mrad_per_s}, {-500_mm_per_s, 800_mrad_per_s}},   // reversing
        {{700_mm_per_s, 0_rad_per_s}, {-700_mm_per_s, 0_rad_per_s}},         //
        {{0_mm_per_s, 1500_mrad_per_s}, {0_mm_per_s, -1500_mrad_per_s}},     // spinning
        {{300_mm_per_s, 1500_mrad_per_s}, {300_mm_per_s, -1500_mrad_per_s}}, // slalom
        {{0_mm_per_s, 0_rad_per_s}, {500_mm_per_s, 900_mrad_per_s}},         // from standing
        {{800_mm_per_s, 100_mrad_per_s}, {0_mm_per_s, 0_rad_per_s}},         // to a stop
    };
    unsigned all = 0, continuous = 0, lost = 0;
    for (const change& c : changes)
        for (const bool is_prompt : {false, true})
            for (const std::int32_t ramp : {50, 150, 500})
                for (std::uint32_t late = 0; late <= 120; late += 40)
                    for (std::uint32_t gap = 0; gap <= 240; gap += 30) {
                        rig r{is_prompt, milliseconds(20)};
                        for (std::uint16_t at = 0x2080; at <= 0x2083; ++at)
                            r.drive.set(at, static_cast<std::uint16_t>(ramp));
                        r.go(c.from, 900);
                        if (r.robot.is_idle()) (void)r.robot.begin(c.to);
                        r.live(milliseconds(5 + late));
                        r.wire.faults().lost_response = 1000;
                        r.live(milliseconds(gap));
                        r.wire.faults() = {};
                        r.live(milliseconds(320));
                        const plane_pose p = r.robot.pose();
                        ++all;
                        continuous += p.is_continuous;
                        lost += gap != 0 && !p.is_continuous;
                        CAPTURE(ramp);
                        CAPTURE(late);
                        CAPTURE(gap);
                        CHECK((!p.is_continuous || r.off() < 1));
                        if (gap == 0 && ramp >= 150) CHECK(p.is_continuous);
                    }
    MESSAGE(continuous, " of ", all, " continuous, ", lost, " lost");
    CHECK(all == 1512);
    CHECK(lost > 300);
    CHECK(continuous > 400);
}

namespace {

// Plays the first command after a restart of a turning drive, at any moment of the feedback and of a blocked program.
template <class Command> void restart_and(const Command& first, unsigned& continuous, unsigned& all) {
    sim::dice random{11};
    for (int i = 0; i < 500; ++i) {
        CAPTURE(i);
        using reading = sim::zlac8015d_options::running;
        sim::zlac8015d_options options;
        options.bit = random.below(2) == 0 ? reading::enabled : reading::turns;
        const std::uint32_t periods[] = {20, 50, 100};
        rig r{random.below(2) == 0, milliseconds(periods[random.below(3)]), 1, options};
        const twist by = twists[random.below(8)];
        r.live(milliseconds(random.below(500)));
        (void)r.robot.begin(by);
        // Half of them in the first ramp, when no feedback has shown a motion yet
        r.live(milliseconds(random.below(2) == 0 ? 30 + random.below(60) : 10 + random.below(400)));
        const bool is_blocked = random.below(2) == 0;
        if (is_blocked) r.wait(milliseconds(random.below(300)));
        r.drive.power_cycle();
        if (random.below(4) == 0) {
            r.wait(milliseconds(random.below(15)));
            r.drive.power_cycle();
        }
        r.wait(milliseconds(random.below(is_blocked ? 300 : 25)));
        (void)r.robot.begin(first);
        long double worst = 0;
        const auto look = [&](std::uint32_t ms) {
            for (std::uint32_t t = 0; t < ms; t += 2) {
                r.live(milliseconds(2));
                ++all;
                if (!r.robot.pose().is_continuous) continue;
                ++continuous;
                worst = r.off() > worst ? r.off() : worst;
            }
        };
        look(1200);
        // A pose that is wrong for good shows after the next enable too.
        if (r.robot.state() != drive_state::needs_init && r.robot.is_idle() &&
            r.robot.begin(enable{}) == errc::ok)
            look(1200);
        CHECK(worst < 1);
    }
}

} // namespace

TEST_CASE("G43: whatever a program commands first after a restart, no pose is continuous and wrong") {
    unsigned continuous = 0, all = 0;
    restart_and(disable{}, continuous, all);
    restart_and(halt{}, continuous, all);
    restart_and(quick_stop{}, continuous, all);
    restart_and(twist{-300_mm_per_s, 0_rad_per_s}, continuous, all);
    restart_and(read_feedback{}, continuous, all);
    restart_and(wait_standstill{milliseconds(1000)}, continuous, all);
    restart_and(init{}, continuous, all);
    MESSAGE(continuous, " of ", all, " poses after a restart are continuous");
    CHECK(all > 1'000'000);
}

TEST_CASE("G43: a robot at its origin keeps its pose over an enable, a stop and a disable, and in each "
          "feedback after them") {
    for (const std::uint32_t period : {20u, 50u, 100u}) {
        CAPTURE(period);
        rig r{false, milliseconds(period)};
        const auto has_kept = [&](const auto& command) {
            const bool is_done = static_cast<bool>(r.robot.run(command));
            bool is_continuous = true;
            for (int i = 0; i < 100; ++i) {
                r.live(milliseconds(10));
                is_continuous = is_continuous && r.robot.pose().is_continuous;
            }
            return is_done && is_continuous;
        };
        CHECK(has_kept(twist{30_mm_per_s, 0_rad_per_s}));
        CHECK(has_kept(halt{}));
        CHECK(has_kept(disable{}));
        CHECK(has_kept(enable{}));
        CHECK(has_kept(twist{-30_mm_per_s, 0_rad_per_s}));
        CHECK(has_kept(disable{}));
        CHECK(has_kept(zlac8015d::save{}));
        CHECK(has_kept(enable{}));
        CHECK(has_kept(quick_stop{}));
        CHECK(has_kept(disable{}));
        CHECK(r.off() < 1);
    }
}

TEST_CASE("G39: a restart of a robot's drive that is disabled shows, wherever it is") {
    for (const twist& by : {twist{10_mm_per_s, 0_rad_per_s}, twist{300_mm_per_s, 200_mrad_per_s}}) {
        rig r{false, milliseconds(20)};
        r.go(by, 400);
        REQUIRE(r.robot.run(disable{}));
        r.live(milliseconds(700));
        REQUIRE(r.robot.state() == drive_state::disabled);
        REQUIRE(r.robot.pose().is_continuous);
        r.drive.power_cycle();
        r.live(milliseconds(600));
        CHECK(r.robot.state() == drive_state::needs_init);
        CHECK_FALSE(r.robot.pose().is_continuous);
    }
}

TEST_CASE("G43: wheels that were faster and slower in a gap, and have their speeds again, leave a pose that "
          "is honest") {
    unsigned all = 0, continuous = 0;
    for (const std::int32_t turn : {0, 600, 1500}) {
        for (const std::int32_t ramp : {20, 60}) {
            for (const std::uint32_t part : {20u, 40u, 60u}) {
                CAPTURE(turn);
                CAPTURE(ramp);
                CAPTURE(part);
                rig r{true, milliseconds(400)}; // the period is the gap
                for (std::uint16_t at = 0x2080; at <= 0x2083; ++at)
                    r.drive.set(at, static_cast<std::uint16_t>(ramp));
                const twist straight{700_mm_per_s, 0_rad_per_s};
                const auto bent = [&](int sign) {
                    return twist{.speed = straight.speed, .turn = decltype(twist::turn){sign * turn * 1000}};
                };
                r.go(straight, 1210);
                for (unsigned i = 0; r.wire.clock().us - r.robot.pose().time.us > 20'000; ++i) {
                    REQUIRE(i < 1000);
                    r.live(milliseconds(1));
                }
                robots::tell(r, r.drive.given().back().at);
                REQUIRE(r.off() < 1);
                for (const int sign : {1, -1, -1, 1, 0}) {
                    (void)r.robot.begin(bent(sign));
                    r.live(milliseconds(part));
                }
                r.live(milliseconds(900));
                const plane_pose p = r.robot.pose();
                ++all;
                continuous += p.is_continuous;
                CHECK((!p.is_continuous || r.off() < 1));
            }
        }
    }
    MESSAGE(continuous, " of ", all, " are continuous");
    CHECK(continuous < all);
}

TEST_CASE("G43: a way that its speeds contradict, as of a response that is late by several requests, ends "
          "the pose") {
    using model = zlac8015d::robot_model;
    const auto pose_after = [](std::int32_t left, std::int32_t right) {
        model m;
        m.set_base(base);
        zlac8015d::cached_settings known{};
        known.state = drive_state::enabled;
        const auto note = [&](std::int32_t at_left, std::int32_t at_right, std::uint32_t us) {
            std::uint16_t words[image_block<model>.words]{};
            const auto put = [&](std::size_t place, std::int32_t position) {
                words[place] = static_cast<std::uint16_t>(static_cast<std::uint32_t>(position) >> 16);
                words[place + 1] = static_cast<std::uint16_t>(position);
            };
            put(model::image::place_of<zlac8015d::left_actual_position>, at_left);
            put(model::image::place_of<zlac8015d::right_actual_position>, -at_right);
            words[model::image::place_of<zlac8015d::left_actual_speed>] = 600;
            words[model::image::place_of<zlac8015d::right_actual_speed>] = static_cast<std::uint16_t>(-600);
            m.note({.block = 0, .words = words, .taken = instant{us}, .epoch = 7}, known);
        };
        note(5000, 5000, 20'000);
        note(5082, 5082, 40'000); // 60 r/min are 82 counts in 20 ms
        note(5082 + left, 5082 + right, 60'000);
        return m.pose().is_continuous;
    };
    // The result is the same if one wheel alone contradicts its speeds.
    const auto is_continuous_after = [&](std::int32_t way) {
        const bool both = pose_after(way, way);
        CHECK(pose_after(way, 82) == both);
        CHECK(pose_after(82, way) == both);
        return both;
    };
    CHECK(is_continuous_after(82));
    CHECK(is_continuous_after(82 + 12));
    CHECK(is_continuous_after(82 - 12));
    CHECK_FALSE(is_continuous_after(82 + 20));
    CHECK_FALSE(is_continuous_after(82 - 20));
    CHECK_FALSE(is_continuous_after(-600)); // of 150 ms ago
}

TEST_CASE("an enable in another mode, and one that loses a response, is no restart of a robot's drive") {
    for (std::uint32_t phase = 0; phase < 600; phase += 20) {
        CAPTURE(phase);
        rig r{false, milliseconds(20)};
        REQUIRE(r.robot.run(disable{}));
        r.live(milliseconds(phase));
        CHECK(r.robot.run(zlac8015d::enable_in{zlac8015d::operating_mode::torque}));
        REQUIRE(r.robot.run(disable{}));
        r.live(milliseconds(phase));
        CHECK(r.robot.run(enable{}));
        CHECK(r.robot.pose().is_continuous);
        // A read of the routine is repeated: the witness would be due in the middle of it.
        REQUIRE(r.robot.run(disable{}));
        REQUIRE(r.robot.begin(zlac8015d::enable_in{zlac8015d::operating_mode::torque}) == errc::ok);
        const std::uint32_t begun = r.wire.requests();
        for (unsigned i = 0; !r.robot.is_idle(); ++i) {
            REQUIRE(i < 100'000);
            r.wire.faults().lost_response = r.wire.requests() - begun == 10 ? 1000 : 0;
            (void)r.robot.step();
            r.wire.pass(microseconds(50));
        }
        CHECK((r.robot.last() || r.robot.last().error() == errc::timeout));
    }
}

namespace {

/// A robot's model and the images that it is given.
struct told_model {
    using model = zlac8015d::robot_model;
    struct wheels {
        std::int32_t left, right; ///< positions
        std::int16_t left_speed = 0, right_speed = 0;
    };
    struct image {
        std::uint16_t words[image_block<model>.words]{};

        explicit image(const wheels& of) {
            put<zlac8015d::left_actual_position>(of.left);
            put<zlac8015d::right_actual_position>(of.right);
            words[model::image::place_of<zlac8015d::left_actual_speed>] =
                static_cast<std::uint16_t>(of.left_speed);
            words[model::image::place_of<zlac8015d::right_actual_speed>] =
                static_cast<std::uint16_t>(of.right_speed);
        }
        template <const auto& Row> void put(std::int32_t position) {
            const auto bits = static_cast<std::uint32_t>(position);
            words[model::image::place_of<Row>] = static_cast<std::uint16_t>(bits >> 16);
            words[model::image::place_of<Row> + 1] = static_cast<std::uint16_t>(bits);
        }
    };

    model m{};
    zlac8015d::cached_settings known{};
    std::uint32_t us = 0;

    told_model() {
        m.set_base(base);
        known.state = drive_state::enabled;
        known.mode = zlac8015d::operating_mode::velocity;
        known.resolution = 10;
        known.max_speed = 1000;
    }
    void note(const wheels& at, duration gap = 20_ms) {
        const image now{at};
        m.note({.block = 0, .words = now.words, .taken = instant{us += gap.us}, .epoch = 7}, known);
    }
    bool has_fallen(const wheels& from, const wheels& to) const {
        const image before{from}, now{to};
        return m.has_fallen({.block = 0, .words = now.words, .before = before.words, .between = 20_ms},
                            known);
    }
    /// A twist whose setpoints the drive acknowledges until it is reached, or refuses.
    void drive(const twist& by, bool is_refused = false) {
        std::uint32_t begun = us;
        do {
            zlac8015d::robot_command c = m.prepare(by, instant{begun += 20'000}, known);
            REQUIRE(c.refusal == errc::ok);
            REQUIRE(m.admit(c, {}) == errc::ok);
            duration watchdog{};
            response_limits limits{};
            const command_status how{status::sent(is_refused ? errc::exception : errc::ok)};
            (void)m.learn(c, {!is_refused, c.steps, how, {}, watchdog, limits}, known);
        } while (m.is_changing());
    }
};

} // namespace

TEST_CASE("G39: a restart puts both wheels to zero: one that is far from it shows that there was none") {
    const told_model t;
    CHECK(t.has_fallen({10, -10, 100, -100}, {12, -12, 100, -100}));
    CHECK_FALSE(t.has_fallen({10, -40'000, 100, -100}, {12, -40'014, 100, -100}));
    CHECK_FALSE(t.has_fallen({40'000, -10, 100, -100}, {40'014, -12, 100, -100}));
}

TEST_CASE("G39: a robot at its origin that is to move may have restarted, however often it was read since") {
    told_model t;
    t.note({2, -2});
    CHECK_FALSE(t.has_fallen({2, -2}, {0, 0}));
    t.drive({100_mm_per_s, 0_rad_per_s});
    for (int i = 0; i < 3; ++i) {
        CHECK(t.has_fallen({2, -2}, {0, 0}));
        t.note({2, -2});
    }
    t.drive({});
    CHECK(t.has_fallen({2, -2}, {0, 0}));
    t.note({2, -2}, 250_ms);
    CHECK_FALSE(t.has_fallen({2, -2}, {0, 0}));
}

TEST_CASE("G43: a response that is late by up to 250 ms shows where the robot stood, and is not taken for "
          "where it is") {
    told_model t;
    t.note({1000, -1000});
    t.note({1000, -1000});
    const instant stood = t.m.pose().time;
    t.drive({400_mm_per_s, 0_rad_per_s}); // 45 r/min
    t.note({1040, -1040, 400, -400});
    const plane_pose moved = t.m.pose();
    CHECK(since(stood, moved.time) == 20_ms);
    t.note({1000, -1000}); // of before the command, or of a robot that went back and stands again
    CHECK(t.m.pose().time == moved.time);
    CHECK(t.m.pose().x_fine == moved.x_fine);
    CHECK(t.m.pose().is_continuous);
    t.note({1160, -1160, 449, -449});
    CHECK(t.m.pose().is_continuous);
    CHECK(since(moved.time, t.m.pose().time) == 40_ms);
    CHECK(t.m.pose().x_mm() == 21_mm); // 160 counts of 534 mm / 4096
    told_model back; // a request without a response, then one that is answered by the response to it
    back.note({0, 0, 449, -449});
    back.note({61, -61, 449, -449});
    back.note({245, -245, 449, -449}, 60_ms);
    CHECK(back.m.pose().is_continuous);
    back.drive({-400_mm_per_s, 0_rad_per_s});
    told_model on = back;
    back.note({215, -215, -200, 200});
    CHECK_FALSE(back.m.pose().is_continuous); // or it went back
    on.note({260, -260, 200, -200});
    on.note({262, -262, -10, 10});
    CHECK(on.m.pose().is_continuous);
    on.note({256, -256, -40, 40}, 230_ms);
    on.note({230, -230, -200, 200});
    CHECK(on.m.pose().is_continuous); // too late for any response
    told_model held;                  // by a brake, perhaps: the pose is true at its time
    held.note({1000, -1000});
    held.note({1000, -1000});
    const instant last = held.m.pose().time;
    held.drive({400_mm_per_s, 0_rad_per_s});
    for (int i = 0; i < 11; ++i) held.note({1000, -1000});
    CHECK(held.m.pose().time == last);
    held.note({1000, -1000}, 50_ms);
    CHECK(since(last, held.m.pose().time) > 250_ms);
    CHECK(held.m.pose().is_continuous);
}

TEST_CASE("G43: a twist that the drive has refused is a new one when it comes again") {
    for (const bool is_refused : {false, true}) {
        CAPTURE(is_refused);
        told_model t;
        const twist by{600_mm_per_s, 0_rad_per_s}; // 67.4 r/min: 92 counts in 20 ms
        t.drive(by, is_refused);
        t.note({0, 0, 674, -674});
        t.note({92, -92, 674, -674});
        REQUIRE(t.m.pose().is_continuous);
        t.drive(by);
        t.note({92 + 1380, -92 - 1380, 674, -674}, 300_ms);
        CHECK(t.m.pose().is_continuous == !is_refused); // it may have bent the path
    }
}

TEST_CASE("G43: lower limits keep the pose over longer gaps; the larger of both counts") {
    struct times {
        std::int32_t faster, slower; // ms to and from 712 mm/s, 80 r/min
    };
    const auto kept = [](const times& in) {
        unsigned n = 0;
        for (std::uint32_t gap = 60; gap <= 240; gap += 5) {
            rig r{true, milliseconds(gap)};
            REQUIRE(r.robot.run(disable{}));
            REQUIRE(r.robot.set_limits({.top = 712_mm_per_s,
                                        .acceleration = in.faster * units::millisecond,
                                        .deceleration = in.slower * units::millisecond}) == errc::ok);
            REQUIRE(r.robot.run(enable{}));
            r.go({690_mm_per_s, 0_rad_per_s}, 8000 + 3 * gap);
            r.robot.set_pose(r.robot.pose());
            (void)r.robot.begin(twist{691_mm_per_s, 0_rad_per_s});
            r.live(milliseconds(2 * gap));
            n += r.robot.pose().is_continuous;
        }
        return n;
    };
    const unsigned least = kept({8000, 8000}); // 10 r/min in a second
    CHECK(least > kept({400, 8000}));
    CHECK(least > kept({8000, 200}) + 5);
    CHECK(least > kept({200, 8000}) + 5);
    CHECK(kept({400, 400}) > kept({160, 160}));
}

} // namespace robot_gaps_tests
