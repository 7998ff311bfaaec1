// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D with two axes: places, ways and speeds of each in lengths, judged by the simulated motors' own positions
// and by what its registers hold.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/axes.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace axes_zlac8015d_tests {

using namespace servobus;
using namespace servobus::literals;
using zlac8015d::operating_mode, zlac8015d::synchronisation;

namespace {

constexpr auto belt = axis::of(rolling(120_mm, counts_per_turn{4096}));
constexpr auto turned = axis::of(mirrored(rolling(300_mm, counts_per_turn{4096}, gear_ratio{5, 1})));
constexpr auto other = axis::of(rolling(120_mm, counts_per_turn{16384}));

struct rig : simulated::driven_zlac8015d {
    zlac8015d::axes<line_type> belts;
    explicit rig(const axis& left = belt, const axis& right = turned)
        : belts{line, 1, left, right, {.feedback = milliseconds(20), .command_timeout = milliseconds(5000)}} {
    }
    void enable_for(operating_mode mode) {
        REQUIRE(belts.run(init{}));
        REQUIRE(belts.run(zlac8015d::enable_in{checked(mode), synchronisation::asynchronous}));
    }
};

} // namespace

TEST_CASE("each axis moves by its ways, which do not drift, and says where it is") {
    rig r;
    r.enable_for(operating_mode::relative_position);
    for (int i = 1; i <= 12; ++i) {
        REQUIRE(r.belts.left().run(move_by{10_mm}, wait_reached{}).how == arrival_state::reached);
        CHECK(r.belts.left().begin(move_by{2148_m}) == errc::out_of_range);
        CHECK(r.model.left().target == (i * 10 * 4096 * 2 / 120 + 1) / 2); // 341.3 counts
    }
    CHECK(r.model.right().position == 0);
    REQUIRE(r.belts.right().run(move_by{30_mm}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.model.right().target == -2048); // 30 mm are half a turn of the motor
    REQUIRE(r.belts.read());
    const std::int64_t left = r.belts.left().position(milliseconds(100))->count();
    const std::int64_t right = r.belts.right().position(milliseconds(100))->count();
    CHECK(left > 119'000);
    CHECK(left < 121'000);
    CHECK(right > 29'800);
    CHECK(right < 30'200);
    CHECK(r.belts.right().begin(move_to{1_mm}) == errc::wrong_state);
    CHECK(r.belts.right().begin(move_by{1_mm, {.top = 5_mm_per_s}}) == errc::bad_argument);
}

TEST_CASE("each axis goes to its places") {
    rig r;
    r.enable_for(operating_mode::absolute_position);
    REQUIRE(r.belts.left().run(move_to{-60_mm}, wait_reached{}).how == arrival_state::reached);
    REQUIRE(r.belts.right().run(move_to{60_mm}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.model.left().target == -2048);
    CHECK(r.model.right().target == -4096);
    CHECK(r.belts.left().begin(move_by{1_mm}) == errc::wrong_state);
    CHECK(r.belts.left().run(move_to{2148_m}, wait_reached{}).how == arrival_state::none);
}

TEST_CASE("G42: an axis is mirrored on either wheel: ways, places, speeds, and what is missing") {
    constexpr auto plain = axis::of(rolling(120_mm, counts_per_turn{4096}));
    constexpr auto back = axis::of(mirrored(rolling(120_mm, counts_per_turn{4096})));
    for (const bool is_left : {true, false}) {
        rig r{is_left ? back : plain, is_left ? plain : back};
        const auto targets = [&r](std::int64_t left, std::int64_t right) {
            return r.model.left().target == left && r.model.right().target == right;
        };
        const int left = is_left ? -1 : 1, right = -left;
        r.enable_for(operating_mode::absolute_position);
        REQUIRE(r.belts.left().run(move_to{60_mm}, wait_reached{}).how == arrival_state::reached);
        REQUIRE(r.belts.right().run(move_to{-30_mm}, wait_reached{}).how == arrival_state::reached);
        CHECK(targets(left * 2048, right * -1024));
        REQUIRE(r.belts.run(disable{}));
        REQUIRE(r.belts.run(zlac8015d::enable_in{operating_mode::velocity}));
        REQUIRE(r.belts.left().run(velocity{200_mm_per_s}));
        REQUIRE(r.belts.right().run(velocity{-100_mm_per_s}));
        CHECK(static_cast<std::int16_t>(r.model.peek(zlac8015d::left_target_speed.address)) == left * 100);
        CHECK(static_cast<std::int16_t>(r.model.peek(zlac8015d::right_target_speed.address)) == right * -50);
        REQUIRE(r.belts.left().run(velocity{-200_mm_per_s}));
        CHECK(static_cast<std::int16_t>(r.model.peek(zlac8015d::left_target_speed.address)) == left * -100);
        REQUIRE(r.belts.run(halt{}));
    }
}

TEST_CASE("the rest of each axis is kept over other commands") {
    rig r{belt, belt};
    r.enable_for(operating_mode::relative_position);
    for (int i = 1; i <= 6; ++i) {
        REQUIRE(r.belts.right().run(move_by{10_mm}, wait_reached{}).how == arrival_state::reached);
        REQUIRE(r.belts.read());
        REQUIRE(r.belts.left().run(move_by{10_mm}, wait_reached{}).how == arrival_state::reached);
        CHECK(r.model.left().target == (i * 10 * 4096 * 2 / 120 + 1) / 2); // 341.3 counts
        CHECK(r.model.right().target == r.model.left().target);
    }
}

TEST_CASE("a move that the drive refuses leaves no rest") {
    rig r{belt, belt};
    r.enable_for(operating_mode::relative_position);
    REQUIRE(r.belts.left().run(move_by{10_mm}, wait_reached{}).how == arrival_state::reached);
    for (int i = 0; i < 2; ++i) {
        r.model.refuses = true;
        CHECK(r.belts.left().run(move_by{10_mm}).error() == errc::exception);
        r.model.refuses = false;
    }
    REQUIRE(r.belts.state() == drive_state::enabled);
    REQUIRE(r.belts.left().run(move_by{10_mm}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.model.left().target == 341 + 342); // of 341.3 counts each, and without a rest of the two between
}

TEST_CASE("what each axis misses is its own") {
    rig r;
    r.enable_for(operating_mode::relative_position);
    REQUIRE(r.belts.left().run(move_by{10_mm}, wait_reached{}).how == arrival_state::reached);
    REQUIRE(r.belts.right().begin(move_by{900_mm}) == errc::ok);
    while (!r.belts.is_idle()) r.wire.wait(r.belts.step());
    REQUIRE(r.belts.read());
    const micrometres left = r.belts.left().arrival().missing, right = r.belts.right().arrival().missing;
    CHECK(left.count() > -1000);
    CHECK(left.count() < 1000);
    CHECK(right.count() > 800'000);
    CHECK(right.count() <= 900'000);
    rig other_way;
    other_way.enable_for(operating_mode::relative_position);
    REQUIRE(other_way.belts.right().run(move_by{10_mm}, wait_reached{}).how == arrival_state::reached);
    REQUIRE(other_way.belts.left().begin(move_by{900_mm}) == errc::ok);
    while (!other_way.belts.is_idle()) other_way.wire.wait(other_way.belts.step());
    REQUIRE(other_way.belts.read());
    CHECK(other_way.belts.left().arrival().missing.count() > 800'000);
    CHECK(other_way.belts.right().arrival().missing.count() < 1000);
}

TEST_CASE("each axis has its speed, to the nearest count") {
    rig r;
    r.enable_for(operating_mode::velocity);
    REQUIRE(r.belts.left().run(velocity{201_mm_per_s}));   // 100.5 r/min
    REQUIRE(r.belts.right().run(velocity{-250_mm_per_s})); // 250 r/min, mirrored
    CHECK(r.model.peek(zlac8015d::left_target_speed.address) == 101);
    CHECK(r.model.peek(zlac8015d::right_target_speed.address) == 250);
    const std::uint64_t end = r.wire.time_us() + 1'500'000;
    while (r.wire.time_us() < end) {
        (void)r.belts.step();
        r.wire.pass(microseconds(500));
    }
    const std::int32_t left = r.belts.left().speed(milliseconds(100))->count();
    CHECK(left > 199'000);
    CHECK(left < 205'000);
    const std::int32_t right = r.belts.right().speed(milliseconds(100))->count();
    CHECK(right < -247'000);
    CHECK(right > -253'000);
    CHECK(r.belts.left().begin(velocity{100_um_per_s}) == errc::out_of_range);
    CHECK(r.belts.left().begin(velocity{2147_m_per_s}) == errc::out_of_range);
    CHECK(r.belts.left().begin(velocity{-2147_m_per_s}) == errc::out_of_range);
    CHECK(r.belts.left().begin(velocity{2.1_m_per_s}) == errc::out_of_range); // 2008h is 1000 r/min
    REQUIRE(r.belts.run(halt{}));
    REQUIRE(r.belts.run(disable{}));
    r.model.store(0x2022, 10);
    r.model.power_cycle();
    REQUIRE(r.belts.run(init{}));
    REQUIRE(r.belts.run(enable{}));
    REQUIRE(r.belts.left().run(velocity{20.1_mm_per_s})); // 10.05 r/min
    CHECK(r.model.peek(zlac8015d::left_target_speed.address) == 101);
}

TEST_CASE("a belt whose speed is not commanded any more stops, and one that is told to stand stands") {
    rig r;
    r.enable_for(operating_mode::velocity);
    const auto live = [&r](std::uint32_t ms) {
        for (const std::uint64_t end = r.wire.time_us() + ms * 1000; r.wire.time_us() < end;) {
            const duration idle = r.belts.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    REQUIRE(r.belts.left().run(velocity{100_mm_per_s}));
    live(1000);
    CHECK_FALSE(r.model.stands_still());
    REQUIRE(r.belts.left().run(velocity{0_mm_per_s}));
    live(2000);
    CHECK(r.model.stands_still());
    REQUIRE(r.belts.left().run(velocity{100_mm_per_s}));
    live(4000);
    CHECK_FALSE(r.model.stands_still());
    live(3000);
    CHECK(r.model.stands_still());                                            // the command timeout of 5 s
    CHECK(r.belts.left().begin(velocity{100_m_per_s}) == errc::out_of_range); // 50 000 r/min
    CHECK(r.belts.left().begin(velocity{-100_m_per_s}) == errc::out_of_range);
    r.wire.set_connected(0, false);
    CHECK_FALSE(r.belts.left().run(velocity{100_mm_per_s}));
}

TEST_CASE("G42: an encoder that counts otherwise than the program says: not taken over") {
    rig r{belt, other};
    CHECK(r.belts.run(init{}).error() == errc::unexpected_value);
    CHECK(r.belts.state() == drive_state::needs_init);
    CHECK(r.belts.left().position(milliseconds(1000)).error() == errc::needs_init);
    CHECK(r.belts.left().speed(milliseconds(1000)).error() == errc::needs_init);
    // Each axis is compared with its own encoder: 4096 lines are 16384 counts.
    for (const bool is_left : {true, false}) {
        CAPTURE(is_left);
        rig uneven{is_left ? other : belt, is_left ? belt : other};
        uneven.set_by_hand((is_left ? zlac8015d::right_encoder_lines : zlac8015d::left_encoder_lines).address,
                           4096);
        CHECK(uneven.belts.run(init{}).error() == errc::unexpected_value);
        uneven.set_by_hand(zlac8015d::left_encoder_lines.address, is_left ? 4096 : 1024);
        uneven.set_by_hand(zlac8015d::right_encoder_lines.address, is_left ? 1024 : 4096);
        CHECK(uneven.belts.run(init{}));
        CHECK(uneven.belts.state() == drive_state::disabled);
    }
}

namespace {

constexpr axis_profile brisk{.top = 400_mm_per_s, .acceleration = 1_s, .deceleration = 500_ms}; // 200 r/min
constexpr axis_profile gentle{
    .top = 200_mm_per_s, .acceleration = 2_s, .deceleration = 1_s}; // 200 r/min, geared

struct limited_rig : rig {
    limited_rig() {
        REQUIRE(belts.set_limits(brisk, gentle) == errc::ok);
        enable_for(operating_mode::velocity);
    }
    std::int16_t left() {
        return static_cast<std::int16_t>(model.peek(zlac8015d::left_target_speed.address));
    }
    std::int16_t right() {
        return static_cast<std::int16_t>(model.peek(zlac8015d::right_target_speed.address));
    }
    template <class Wanted>
    void order(zlac8015d::axis_of_drive<zlac8015d::axes<line_type>> of, const Wanted& wanted) {
        REQUIRE(of.begin(wanted) == errc::ok);
        while (!belts.is_idle()) wire.wait(belts.step());
    }
    void pass(std::uint32_t ms) {
        for (const std::uint64_t end = wire.time_us() + 1000 * std::uint64_t{ms}; wire.time_us() < end;)
            wire.wait(belts.step());
    }
};

} // namespace

TEST_CASE("an axis with limits changes its speed within them, each for itself") {
    limited_rig r;
    r.order(r.belts.left(), velocity{300_mm_per_s});
    CHECK(r.left() == 4); // 200 r/min in a second, for 20 ms
    CHECK(r.belts.left().is_changing_speed());
    CHECK_FALSE(r.belts.right().is_changing_speed());
    r.order(r.belts.right(), velocity{-100_mm_per_s});
    CHECK(r.right() == 2); // mirrored, 100 r/min in a second
    r.pass(100);
    r.order(r.belts.left(), velocity{300_mm_per_s});
    CHECK(r.left() == 24); // 100 ms more
    CHECK(r.right() == 2);
    REQUIRE(r.belts.left().run(velocity{300_mm_per_s}));
    CHECK(r.left() == 150);
    CHECK_FALSE(r.belts.left().is_changing_speed());
    CHECK(r.belts.right().is_changing_speed());
    REQUIRE(r.belts.left().run(velocity{600_mm_per_s})); // beyond its top
    CHECK(r.left() == 200);
    REQUIRE(r.belts.left().run(velocity{-600_mm_per_s}));
    CHECK(r.left() == -200);
    r.order(r.belts.left(), velocity{0_mm_per_s});
    CHECK(r.left() <= -180); // 400 r/min in a second to slow down
    CHECK(r.left() > -200);
    REQUIRE(r.belts.run(halt{}));
    r.order(r.belts.left(), velocity{300_mm_per_s});
    CHECK(r.left() == 4);
    // Speeds of the drive's own are setpoints too, before any feedback has shown them.
    REQUIRE(r.belts.run(velocity{80 * units::r_per_min, 60 * units::r_per_min}));
    r.order(r.belts.left(), velocity{300_mm_per_s});
    CHECK(r.left() == 84);
    r.order(r.belts.right(), velocity{100_mm_per_s}); // mirrored: it slows down, 200 r/min in a second
    CHECK(r.right() == 56);
}

TEST_CASE("axes with limits: `init` writes what follows from them, moves are refused") {
    limited_rig r;
    const std::uint16_t written[]{10, 10, 10, 10, 938, 1875}; // 15/8 of the time to slow down
    for (std::uint16_t i = 0; i < 6; ++i)
        CHECK(r.model.peek(static_cast<std::uint16_t>(0x2080 + i)) == written[i]);
    CHECK(r.model.peek(zlac8015d::quick_stop_option_code.address) == 6);
    REQUIRE(r.belts.run(disable{}));
    REQUIRE(
        r.belts.run(zlac8015d::enable_in{operating_mode::relative_position, synchronisation::asynchronous}));
    CHECK(r.belts.left().begin(move_by{10_mm}) == errc::bad_argument);
    CHECK(r.belts.right().begin(move_to{10_mm}) == errc::bad_argument);
    CHECK(r.belts.begin(zlac8015d::move_left_by{10 * units::pulse}) == errc::bad_argument);
    CHECK(r.belts.begin(zlac8015d::ramps{zlac8015d::time{500}, zlac8015d::time{500}}) == errc::bad_argument);
    CHECK(r.belts.set_limits(brisk, gentle) == errc::wrong_state); // enabled
    rig without;
    REQUIRE(without.belts.run(init{}));
    CHECK(without.model.peek(0x2080) == 500); // as the program or the factory has set it
    CHECK(without.model.peek(zlac8015d::quick_stop_option_code.address) == 5);
    CHECK(without.belts.set_limits(brisk, {}) == errc::bad_argument);
    CHECK(without.belts.set_limits({}, gentle) == errc::bad_argument);
    CHECK(without.belts.set_limits({.top = 2000_m_per_s, .acceleration = 1_s, .deceleration = 1_s}, gentle) ==
          errc::out_of_range);
    REQUIRE(without.belts.run(init{}));
    CHECK(without.model.peek(0x2080) == 500);
}

} // namespace axes_zlac8015d_tests
