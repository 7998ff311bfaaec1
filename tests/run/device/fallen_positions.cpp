// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A position that falls as a restart makes it fall ends the knowledge of it: either wheel of a ZLAC8015D, and a YAKO.
#include <array>
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace fallen_positions_tests {

using namespace servobus;
using namespace servobus::units;

TEST_CASE("G39: a YAKO has fallen where a restart puts it, but for a trembling") {
    using model = yako::model<yako::closed_loop::device>;
    yako::cached_settings known{};
    known.state = drive_state::enabled;
    known.word_order = word_order::high_first;
    known.microsteps = 1000;
    const auto falls = [&](std::uint16_t then, std::uint16_t there) {
        const std::uint16_t before[7]{0, 0, 0, 0, 0, then, 0};
        const std::uint16_t now[7]{0, 0, 0, 0, 0, there, 0};
        block_feedback r{.block = 0, .words = now, .taken = instant{20'000}, .epoch = 1};
        r.before = before;
        r.between = milliseconds(20);
        return model::has_fallen(r, known);
    };
    CHECK(falls(30, 0)); // 32 pulses are where a restart puts it
    CHECK(falls(38, 32));
    CHECK_FALSE(falls(5, 0));   // a trembling
    CHECK_FALSE(falls(70, 40)); // and farther away 32 are allowed
    CHECK(falls(80, 40));
}

namespace {

/// A way towards zero that the speeds and the time of two images allow. `too_long` is so even for 1 r/min more and half
/// as much time again. Windows of more than 4 s count as 4 s.
struct way {
    std::int64_t made;
    std::int64_t too_long;
};
way way_at(std::int64_t r_per_minute, std::int64_t counts_of_turn, std::int64_t ms, std::int64_t trembling) {
    const std::int64_t counts_of_r_per_min = counts_of_turn * (ms < 4000 ? ms : 4000);
    return {r_per_minute * counts_of_r_per_min / 60'000,
            (r_per_minute + 1) * counts_of_r_per_min * 3 / 2 / 60'000 + trembling};
}
constexpr std::int64_t windows_ms[] = {5, 20, 500, 3900, 4100, 60'000};

} // namespace

TEST_CASE(
    "G39: a YAKO has fallen where it is nearer to zero than its speed, in its unit, and the time allow") {
    using model = yako::model<yako::closed_loop::device>;
    yako::cached_settings known{};
    known.state = drive_state::enabled;
    known.word_order = word_order::high_first;
    for (const auto unit : {yako::speed_count::one_r_per_min, yako::speed_count::tenth_r_per_min}) {
        for (const std::uint16_t microsteps : {u16{200}, u16{1000}, u16{10'000}}) {
            for (const std::int64_t ms : windows_ms) {
                for (const int speed : {0, 60, -600, 3000}) {
                    CAPTURE(microsteps);
                    CAPTURE(ms);
                    CAPTURE(speed);
                    known.resolution = unit;
                    known.microsteps = microsteps;
                    const int pace = unit == yako::speed_count::tenth_r_per_min ? 10 * speed : speed;
                    const way allowed = way_at(speed < 0 ? -speed : speed, microsteps, ms, 60);
                    const auto falls_by = [&](std::int64_t pulses, int then, int there) {
                        const std::int64_t from = 500'000'000, to = from - pulses;
                        const auto image = [](std::int64_t at, int by) {
                            return std::array<u16, 7>{0,
                                                      0,
                                                      0,
                                                      0,
                                                      static_cast<u16>(at >> 16),
                                                      static_cast<u16>(at & 0xFFFF),
                                                      static_cast<u16>(by)};
                        };
                        const auto before = image(from, then), now = image(to, there);
                        return model::has_fallen({.block = 0,
                                                  .words = now.data(),
                                                  .before = before.data(),
                                                  .between = milliseconds(static_cast<std::uint32_t>(ms)),
                                                  .taken = instant{20'000},
                                                  .epoch = 1},
                                                 known);
                    };
                    CHECK_FALSE(falls_by(allowed.made, pace, pace));
                    CHECK_FALSE(falls_by(allowed.made, pace, 0)); // by the faster of both
                    CHECK_FALSE(falls_by(allowed.made, 0, pace));
                    CHECK(falls_by(allowed.too_long, pace, pace));
                    CHECK_FALSE(falls_by(-allowed.too_long, pace, pace)); // away from zero
                }
            }
        }
    }
}

TEST_CASE("G39: either wheel of a ZLAC8015D has fallen where it is nearer to zero than its speed and the "
          "time allow") {
    using model = zlac8015d::model;
    constexpr std::size_t places = model::image::place_of<zlac8015d::left_actual_position>;
    constexpr std::size_t speeds = model::image::place_of<zlac8015d::left_actual_speed>;
    for (const std::size_t wheel : {std::size_t{0}, std::size_t{1}}) {
        for (const std::int64_t ms : windows_ms) {
            for (const int speed : {0, 60, -600, 1000}) {
                CAPTURE(wheel);
                CAPTURE(ms);
                CAPTURE(speed);
                // A turn has at most 16384 counts.
                const way allowed = way_at(speed < 0 ? -speed : speed, 16'384, ms, 150);
                const auto falls_by = [&](std::int64_t counts, int then, int there) {
                    const std::int64_t from = 500'000'000, to = from - counts;
                    const auto image = [&](std::int64_t at, int tenths) {
                        std::array<u16, image_block<model>.words> w{};
                        w[places + 2 * wheel] = static_cast<u16>(at >> 16);
                        w[places + 2 * wheel + 1] = static_cast<u16>(at & 0xFFFF);
                        w[speeds + wheel] = static_cast<u16>(tenths);
                        return w;
                    };
                    const auto before = image(from, then), now = image(to, there);
                    return model::has_fallen({.block = 0,
                                              .words = now.data(),
                                              .before = before.data(),
                                              .between = milliseconds(static_cast<std::uint32_t>(ms)),
                                              .taken = instant{20'000},
                                              .epoch = 1},
                                             {});
                };
                CHECK_FALSE(falls_by(allowed.made, 10 * speed, 10 * speed));
                CHECK_FALSE(falls_by(allowed.made, 10 * speed, 0));
                CHECK_FALSE(falls_by(allowed.made, 0, 10 * speed));
                CHECK(falls_by(allowed.too_long, 10 * speed, 10 * speed));
                CHECK_FALSE(falls_by(-allowed.too_long, 10 * speed, 10 * speed));
            }
        }
    }
}

TEST_CASE("G39: the fall of either wheel of a ZLAC8015D is seen") {
    using model = zlac8015d::model;
    const auto falls = [](std::uint16_t left, std::uint16_t left_now, std::uint16_t right,
                          std::uint16_t right_now) {
        std::uint16_t before[image_block<model>.words]{}, now[image_block<model>.words]{};
        before[model::image::place_of<zlac8015d::left_actual_position> + 1] = left;
        before[model::image::place_of<zlac8015d::right_actual_position> + 1] = right;
        now[model::image::place_of<zlac8015d::left_actual_position> + 1] = left_now;
        now[model::image::place_of<zlac8015d::right_actual_position> + 1] = right_now;
        block_feedback r{.block = 0, .words = now, .taken = instant{20'000}, .epoch = 1};
        r.before = before;
        r.between = milliseconds(20);
        return model::has_fallen(r, {});
    };
    CHECK_FALSE(falls(1000, 1000, 1000, 1000));
    CHECK(falls(1000, 0, 0, 0));
    CHECK(falls(0, 0, 1000, 0));
}

TEST_CASE("G39: where the right wheel alone has counted, no position of after a restart is given away") {
    using namespace zlac8015d;
    simulated::driven_zlac8015d r;
    client direct{r.line, node<device>{1}};
    REQUIRE(r.drive.run(init{}));
    REQUIRE(direct.write<shaft_at_power_on>(power_on_shaft::locked));
    r.save_by_hand();
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    REQUIRE(r.drive.run(right_velocity{60 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.live(milliseconds(600)));
    const auto before = r.drive.read();
    REQUIRE(before);
    REQUIRE(before->right_position.count() > 1000);
    r.model.power_cycle();
    r.wire.pass(milliseconds(20));
    const auto after = r.drive.read();
    CHECK_FALSE(after);
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("G39: wheels that run towards zero raise no suspicion, however short the feedback's period is") {
    using namespace zlac8015d;
    for (const std::uint32_t period_ms : {4u, 20u, 250u}) {
        CAPTURE(period_ms);
        simulated::driven_zlac8015d r{
            {}, {.feedback = milliseconds(period_ms), .command_timeout = no_command_timeout}};
        r.set_by_hand(left_encoder_lines.address, 4096);
        r.set_by_hand(right_encoder_lines.address, 4096);
        const auto live = [&](std::uint32_t ms) {
            const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
            while (r.wire.time_us() < end) {
                const duration idle = r.drive.step();
                r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            }
        };
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable{}));
        REQUIRE(r.drive.run(velocity{900 * r_per_min, -900 * r_per_min}));
        live(2500);
        REQUIRE(r.drive.run(velocity{-900 * r_per_min, 900 * r_per_min}));
        live(1200);
        r.log.frames.clear();
        live(1000);
        std::size_t witnesses = 0;
        for (const auto& f : r.log.frames) witnesses += load_word(f, 2) == 0x200D ? 1u : 0u;
        CHECK(witnesses <= 3); // twice a second
        CHECK(r.model.left().position > 1000);
    }
}

} // namespace fallen_positions_tests
