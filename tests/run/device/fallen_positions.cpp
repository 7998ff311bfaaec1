// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A position that falls as a restart makes it fall ends the knowledge of it: either wheel of a ZLAC8015D, and a YAKO.
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

} // namespace fallen_positions_tests
