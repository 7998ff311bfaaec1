// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A C630S that moves an axis: segments, places, ways and speeds in lengths, judged by the simulated motor's own
// position, a count of its encoder being 10000 / 131072 reference units; and the comparison of what a reference unit is
// worth.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/c630s/axis_drive.hpp>
#include <tests/support/driven_c630s.hpp>

namespace axis_c630s_tests {

using namespace servobus;
using namespace servobus::literals;

namespace {

constexpr auto ram = axis::of(lead(5_mm, counts_per_turn{10'000}));
constexpr auto turned = axis::of(mirrored(lead(5_mm, counts_per_turn{10'000})));
constexpr auto third = axis::of(lead(3_mm, counts_per_turn{10'000})); // 0.3 um a unit
constexpr auto fast = axis::of(lead(10_mm, counts_per_turn{10'000})); // 1 um a unit
constexpr auto coarse = axis::of(lead(5_mm, counts_per_turn{1000}));
constexpr axis_profile quick{.top = 50_mm_per_s, .acceleration = 50_ms, .deceleration = 50_ms};

struct rig : simulated::simulated_c630s {
    c630s::axis_drive<line_type> drive;

    explicit rig(const axis& of, c630s::encoder_counts encoder = c630s::encoder_counts::unknown,
                 const supervision& by = without_watchdog, const sim::c630s_options& read_as = {})
        : simulated::simulated_c630s{read_as}, drive{line, 1, of, by, encoder} {}
    /// Sets up, and enables it for places or ways.
    void enable_for(c630s::displacement_type ways) {
        REQUIRE(drive.run(init{}));
        if (drive.state() == drive_state::needs_set_up) {
            REQUIRE(drive.run(c630s::set_up{}));
            model.power_cycle();
            REQUIRE(drive.run(init{}));
        }
        REQUIRE(drive.run(c630s::position_segments{.type = ways}));
        REQUIRE(drive.run(c630s::enable_in{c630s::control_mode::position}));
    }
    /// In reference units of 10000 a turn.
    std::int64_t units() const { return (model.position() * 10'000 + 65'536) >> 17; }
    /// How far the axis is from a place, um. A unit is 13 counts of the encoder, so that the motor may stand beside it.
    std::int64_t off(micrometres place) {
        REQUIRE(drive.read());
        const std::int64_t d = drive.position(milliseconds(1000))->count() - place.count();
        return d < 0 ? -d : d;
    }
    void set(std::uint16_t address, std::uint32_t value) {
        const auto high = static_cast<std::uint16_t>(value >> 16), low = static_cast<std::uint16_t>(value);
        const std::uint8_t words[]{static_cast<std::uint8_t>(low >> 8), static_cast<std::uint8_t>(low),
                                   static_cast<std::uint8_t>(high >> 8), static_cast<std::uint8_t>(high)};
        REQUIRE(model.write(address, words_view{words}) == 0);
    }
};
constexpr auto places = c630s::displacement_type::absolute;
constexpr auto ways = c630s::displacement_type::relative;

} // namespace

TEST_CASE("an axis goes to places by its own segment, and says where it is") {
    rig r{ram};
    r.enable_for(places);
    CHECK(r.drive.run(move_to{12.5_mm, quick}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.units() == 25'000);
    CHECK(r.model.peek(servobus::at<c630s::position_segment_wait_times, 15>.address) == 0);
    CHECK(r.off(12.5_mm) <= 1);
    CHECK(r.drive.run(move_to{-0.4_mm, quick}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.units() == -800);
    CHECK(r.off(-0.4_mm) <= 1);
    CHECK(r.drive.begin(move_by{1_mm, quick}) == errc::wrong_state);
}

TEST_CASE("where an axis is follows from its position only, whichever block is read") {
    rig r{ram,
          c630s::encoder_counts::unknown,
          {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
    r.enable_for(places);
    REQUIRE(r.drive.run(move_to{12.5_mm, quick}, wait_reached{}).how == arrival_state::reached);
    const std::uint64_t end = r.wire.time_us() + 300'000;
    std::size_t looks = 0;
    while (r.wire.time_us() < end) {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 || idle.us > 200 ? microseconds(200) : idle);
        const result<micrometres> there = r.drive.position(milliseconds(1000));
        if (!there) continue;
        ++looks;
        const std::int64_t d = there->count() - 12'500;
        CHECK(d * d <= 1);
    }
    CHECK(looks > 100);
}

TEST_CASE("a mirrored axis, by segments that were set before") {
    rig r{turned};
    r.enable_for(places);
    REQUIRE(r.drive.run(c630s::axis_segment{2, 7.5_mm, 20_mm_per_s, 100_ms}));
    REQUIRE(r.drive.run(c630s::axis_segment{3, -2.5_mm, 20_mm_per_s}));
    CHECK(r.drive.run(c630s::start_segment{2}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.units() == -15'000);
    CHECK(r.off(7.5_mm) <= 1);
    CHECK(r.drive.run(c630s::start_segment{3}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.units() == 5000);
    CHECK(r.drive.run(move_to{5_mm, quick}, wait_reached{}).how == arrival_state::reached);
    CHECK(r.units() == -10'000);
}

TEST_CASE("G42: a mirrored axis has its ways and speeds the other way round, and nothing else") {
    for (const axis* of : {&ram, &turned}) {
        rig r{*of};
        const int sign = of == &ram ? 1 : -1;
        r.enable_for(ways);
        const std::int64_t from = r.units();
        CHECK(r.drive.run(move_by{7.5_mm, quick}, wait_reached{}).how == arrival_state::reached);
        CHECK(r.units() - from == sign * 15'000);
        CHECK(r.model.peek(servobus::at<c630s::position_segment_speeds, 15>.address) == 600); // r/min
        CHECK(r.model.peek(servobus::at<c630s::position_segment_acceleration_times, 15>.address) == 50);
        CHECK(r.drive.run(move_by{-2.5_mm, quick}, wait_reached{}).how == arrival_state::reached);
        CHECK(r.units() - from == sign * 10'000);
        REQUIRE(r.drive.run(disable{}));
        REQUIRE(r.drive.run(c630s::enable_in{c630s::control_mode::speed}));
        const auto speed_after = [&r] {
            r.wire.pass(milliseconds(1500));
            REQUIRE(r.drive.read());
            return r.drive.speed(milliseconds(1000))->count();
        };
        const std::int64_t before = r.model.position();
        REQUIRE(r.drive.run(velocity{10_mm_per_s}));
        CHECK(speed_after() > 9'900);
        CHECK((r.model.position() - before) * sign > 0);
        REQUIRE(r.drive.run(velocity{-10_mm_per_s}));
        CHECK(speed_after() < -9'900);
    }
}

TEST_CASE("ways do not drift, and the rest is kept over what is refused") {
    rig r{third};
    r.enable_for(ways);
    std::int64_t commanded = 0;
    for (int i = 1; i <= 30; ++i) {
        REQUIRE(r.drive.run(move_by{100_um, quick}, wait_reached{}).how ==
                arrival_state::reached); // 333.3 units
        commanded += r.model.peek(servobus::at<c630s::position_segment_displacements, 15>.address);
        CHECK(commanded == (i * 1000 + 1) / 3);
        if (i % 5 == 0) CHECK(r.drive.run(halt{}).error() == errc::wrong_state);
        if (i % 7 == 0) CHECK(r.drive.begin(move_by{2148_m, quick}) == errc::out_of_range);
    }
    CHECK(r.off(3000_um) <= 2); // the drive rounds each way to its encoder
}

// 475 units of 13.1072 counts are 6225.92 counts [erratum C84].
TEST_CASE("a gear that keeps what is below a count of the encoder does not drift; one that drops it does") {
    for (const bool keeps : {false, true}) {
        rig r{fast, c630s::encoder_counts::unknown, without_watchdog, {.gear_keeps_rest = keeps}};
        r.enable_for(ways);
        const std::int64_t from = r.model.position();
        for (int i = 0; i < 100; ++i)
            REQUIRE(r.drive.run(move_by{475_um, quick}, wait_reached{}).how == arrival_state::reached);
        CHECK(r.model.position() - from == (keeps ? 622'592 : 622'500));
    }
}

TEST_CASE("speeds, in whole r/min of the motor") {
    rig r{ram};
    r.enable_for(places);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(c630s::enable_in{c630s::control_mode::speed}));
    REQUIRE(r.drive.run(velocity{-10.04_mm_per_s})); // 120.48 r/min
    r.wire.pass(milliseconds(1500));
    REQUIRE(r.drive.read());
    const std::int32_t um_per_s = r.drive.speed(milliseconds(1000))->count();
    CHECK(um_per_s >= -10'100);
    CHECK(um_per_s <= -9'900);
    CHECK(r.drive.begin(velocity{1_um_per_s}) == errc::out_of_range);
    CHECK(r.drive.begin(velocity{2147_m_per_s}) == errc::out_of_range);
    CHECK(r.drive.run(velocity{0_mm_per_s}));
}

TEST_CASE("the speed of a segment is rounded to whole r/min, also of a mirrored axis") {
    for (const axis* of : {&ram, &turned}) {
        rig r{*of};
        r.enable_for(places);
        const auto set = [&](micrometres_per_second at) {
            REQUIRE(r.drive.run(c630s::axis_segment{2, 1_mm, at}));
            return r.model.peek(servobus::at<c630s::position_segment_speeds, 1>.address);
        };
        CHECK(set(1533_um_per_s) == 18); // 18.4
        CHECK(set(1542_um_per_s) == 19); // 18.5
    }
}

TEST_CASE("an axis whose speed is not commanded any more stops") {
    rig r{ram,
          c630s::encoder_counts::unknown,
          {.feedback = milliseconds(50), .command_timeout = milliseconds(500)}};
    r.enable_for(places);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(c630s::enable_in{c630s::control_mode::speed}));
    REQUIRE(r.drive.run(velocity{10_mm_per_s}));
    const auto live = [&r](std::uint32_t ms) {
        for (const std::uint64_t end = r.wire.time_us() + ms * 1000; r.wire.time_us() < end;) {
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    live(400);
    CHECK_FALSE(r.model.stands_still());
    live(2000);
    CHECK(r.model.stands_still());
}

TEST_CASE("bad input: nothing is sent") {
    rig r{ram};
    CHECK(r.drive.begin(move_to{1_mm, quick}) == errc::needs_init);
    r.enable_for(places);
    const std::size_t before = r.requests.size();
    CHECK(r.drive.begin(move_to{1_mm}) == errc::bad_argument);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 5_mm_per_s, .acceleration = 10_ms}}) == errc::bad_argument);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 5_mm_per_s, .start = 1_mm_per_s}}) == errc::bad_argument);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 5_mm_per_s, .acceleration = 10_ms, .deceleration = 20_ms}}) ==
          errc::bad_argument);
    CHECK(
        r.drive.begin(move_to{
            1_mm, {.top = 5_mm_per_s, .acceleration = 10_ms, .deceleration = 10_ms, .start = 1_mm_per_s}}) ==
        errc::bad_argument);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 1_um_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
          errc::out_of_range);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 5_mm_per_s}}) == errc::bad_argument);
    CHECK(r.drive.begin(move_to{1_mm, {.top = -5_mm_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
          errc::bad_argument);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 510_mm_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
          errc::out_of_range); // 6120 r/min
    CHECK(r.drive.begin(move_to{1_mm, {.top = 2147_m_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
          errc::out_of_range);
    CHECK(r.drive.begin(move_to{2148_m, quick}) == errc::out_of_range);
    CHECK(r.drive.begin(move_to{1000_m, quick}) == errc::out_of_range); // 2e9 units
    CHECK(r.drive.begin(c630s::axis_segment{1, 2148_m, 5_mm_per_s}) == errc::out_of_range);
    CHECK(r.drive.begin(c630s::axis_segment{1, 1_mm, 0_mm_per_s}) == errc::out_of_range);
    CHECK(r.requests.size() == before);
}

TEST_CASE("the units are read anew where their read gets no response") {
    std::size_t lost = 0;
    for (std::uint32_t request = 10; request < 40; ++request) {
        rig r{ram};
        REQUIRE(r.drive.begin(init{}) == errc::ok);
        while (!r.drive.is_idle()) {
            r.wire.faults().lost_response =
                r.requests.size() + 1 >= request && r.requests.size() < request + 4 ? 1000 : 0;
            (void)r.drive.step();
            r.wire.pass(microseconds(200));
        }
        r.wire.faults() = {};
        if (r.drive.last()) continue;
        ++lost;
        CHECK(r.drive.state() == drive_state::needs_init);
        CHECK(r.drive.run(init{}));
    }
    CHECK(lost > 5);
}

TEST_CASE("a stop between setting a segment and starting it: it is not started") {
    rig r{ram};
    r.enable_for(places);
    std::size_t between = 0;
    for (int turns = 1; turns < 400; ++turns) {
        REQUIRE(r.drive.begin(move_to{turns % 2 == 0 ? 1_mm : 2_mm, quick}) == errc::ok);
        for (int i = 0; i < turns && !r.drive.is_idle(); ++i) {
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 || idle.us > 200 ? microseconds(200) : idle);
        }
        if (r.drive.is_idle()) break;
        const std::int64_t was = r.units();
        REQUIRE(r.drive.run(disable{}));
        r.wire.pass(milliseconds(300));
        between += r.units() == was ? 1u : 0u;
        CHECK(r.model.stands_still());
        REQUIRE(r.drive.run(c630s::enable_in{c630s::control_mode::position}));
    }
    CHECK(between > 20);
}

TEST_CASE("a way that was set and not started leaves no rest") {
    rig r{third};
    r.enable_for(ways);
    REQUIRE(r.drive.run(move_by{100_um, quick}, wait_reached{}).how == arrival_state::reached);
    const auto set = [&] {
        return r.model.peek(servobus::at<c630s::position_segment_displacements, 15>.address);
    };
    CHECK(set() == 333);
    std::size_t between = 0;
    for (int turns = 1; turns < 400; ++turns) {
        const std::int64_t was = r.units();
        REQUIRE(r.drive.begin(move_by{100_um, quick}) == errc::ok);
        for (int i = 0; i < turns && !r.drive.is_idle(); ++i) {
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 || idle.us > 200 ? microseconds(200) : idle);
        }
        REQUIRE(r.drive.run(disable{}));
        r.wire.pass(milliseconds(300));
        if (r.units() != was) break;
        REQUIRE(r.drive.run(c630s::enable_in{c630s::control_mode::position}));
        if (set() == 333 && between == 0) continue;
        ++between;
        CHECK(set() == 334); // a third was open, each time
    }
    CHECK(between > 3);
}

TEST_CASE("a drive whose reference units are worth something else is not taken over") {
    constexpr std::uint16_t pulses = c630s::pulses_per_revolution.address,
                            gear = c630s::gear_1_numerator.address, below = c630s::gear_1_denominator.address;
    SUBCASE("other pulses of a turn") {
        rig r{coarse};
        REQUIRE(r.drive.begin(init{}) == errc::ok);
        bool is_known = false; // not even until the units are read
        while (!r.drive.is_idle()) {
            r.wire.wait(r.drive.step());
            is_known = is_known || r.drive.state() != drive_state::needs_init;
        }
        CHECK_FALSE(is_known);
        CHECK(r.drive.last().error() == errc::unexpected_value);
        CHECK(r.drive.state() == drive_state::needs_init);
        CHECK(r.drive.begin(velocity{1_mm_per_s}) == errc::needs_init);
    }
    SUBCASE("the gear says the same as the program, of this encoder") {
        rig r{ram, c630s::encoder_counts::of_17_bits};
        r.set(pulses, 0);
        r.set(gear, 131'072);
        r.set(below, 10'000);
        CHECK(r.drive.run(init{}));
        CHECK(r.drive.state() != drive_state::needs_init);
    }
    SUBCASE("the same of another encoder") {
        rig r{ram, c630s::encoder_counts::of_23_bits};
        r.set(pulses, 0);
        r.set(gear, 131'072);
        r.set(below, 10'000);
        CHECK(r.drive.run(init{}).error() == errc::unexpected_value);
    }
    SUBCASE("the gear counts, and the program does not say which encoder") {
        rig r{ram};
        r.set(pulses, 0);
        r.set(gear, 131'072);
        r.set(below, 10'000);
        CHECK(r.drive.run(init{}).error() == errc::unexpected_value);
        CHECK(r.drive.state() == drive_state::needs_init);
    }
}

TEST_CASE("soft limits: a place beyond one is refused before a frame is sent, and the end is named") {
    for (const axis& of : {ram, turned}) {
        rig r{of};
        r.enable_for(places);
        REQUIRE(r.drive.run(limit_travel{-2_mm, 20_mm}));
        CHECK(r.drive.run(move_to{20_mm, quick}, wait_reached{}));
        CHECK(r.drive.run(move_to{-2_mm, quick}, wait_reached{}));
        const std::int64_t there = r.units();
        const std::size_t frames = r.requests.size();
        constexpr axis_move_to above{20.001_mm, quick}, below{-2.001_mm, quick};
        CHECK(r.drive.begin(above) == errc::out_of_range);
        CHECK(r.drive.end_passed_by(above) == c630s::travel_end::highest);
        CHECK(r.drive.begin(below) == errc::out_of_range);
        CHECK(r.drive.end_passed_by(below) == c630s::travel_end::lowest);
        CHECK(r.drive.end_passed_by(move_to{20_mm, quick}) == c630s::travel_end::none);
        CHECK(r.requests.size() == frames);
        CHECK(r.units() == there);
        // They hold over an init, and others replace them.
        REQUIRE(r.drive.run(disable{}));
        r.enable_for(places);
        CHECK(r.drive.run(above).error() == errc::out_of_range);
        REQUIRE(r.drive.run(limit_travel{-2_mm, 30_mm}));
        CHECK(r.drive.run(above, wait_reached{}));
    }
}

TEST_CASE("soft limits: a way is refused by where the drive is when it would start, and starts nothing") {
    rig r{ram, c630s::encoder_counts::unknown, {.feedback = {}, .command_timeout = no_command_timeout}};
    r.enable_for(ways);
    REQUIRE(r.drive.run(limit_travel{-2_mm, 20_mm}));
    CHECK(r.drive.run(move_by{15_mm, quick}, wait_reached{}));
    CHECK(r.units() == 30'000);
    CHECK(r.drive.run(move_by{5.001_mm, quick}).error() == errc::out_of_range);
    REQUIRE(r.drive.read());
    CHECK(r.drive.end_passed_by(move_by{5.01_mm, quick}) == c630s::travel_end::highest);
    CHECK(r.drive.end_passed_by(move_by{-17.01_mm, quick}) == c630s::travel_end::lowest);
    CHECK(r.units() == 30'000);
    CHECK(r.drive.run(move_by{5_mm, quick}, wait_reached{}));
    CHECK(r.units() == 40'000);
    // A segment of the drive's own is a move too.
    REQUIRE(r.drive.run(c630s::axis_segment{3, 1_mm, 50_mm_per_s, 50_ms}));
    CHECK(r.drive.run(c630s::start_segment{3}).error() == errc::out_of_range);
    CHECK(r.units() == 40'000);
    CHECK(r.drive.run(move_by{-40_mm, quick}).error() == errc::out_of_range);
    CHECK(r.drive.run(move_by{-22_mm, quick}, wait_reached{}));
    CHECK(r.units() == -4'000);
}

TEST_CASE("soft limits: a speed has no end, so an axis with limits has none") {
    rig r{ram};
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(c630s::set_up{}));
    r.model.power_cycle();
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.begin(limit_travel{2_mm, 2_mm}) == errc::bad_argument);
    CHECK(r.drive.begin(limit_travel{3_mm, 2_mm}) == errc::bad_argument);
    CHECK(r.drive.begin(limit_travel{0_mm, 600_m}) == errc::out_of_range);
    REQUIRE(r.drive.run(enable{}));
    CHECK(r.drive.run(velocity{10_mm_per_s}));
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.drive.run(limit_travel{-2_mm, 20_mm}));
    CHECK(r.drive.run(velocity{10_mm_per_s}).error() == errc::bad_argument);
    CHECK(r.drive.run(velocity{10_r_per_min}).error() == errc::bad_argument);
    CHECK(r.drive.run(c630s::jog{10 * units::r_per_min}).error() == errc::bad_argument);
    CHECK(r.drive.state() == drive_state::enabled);
}

TEST_CASE("soft limits: those whose command was not answered are not set") {
    rig r{ram};
    r.enable_for(places);
    r.wire.faults().lost_response = 1000;
    CHECK_FALSE(r.drive.run(limit_travel{-2_mm, 20_mm}));
    r.wire.faults() = {};
    r.enable_for(places);
    CHECK(r.drive.run(move_to{25_mm, quick}, wait_reached{}));
}

TEST_CASE("G34: a move of an axis that begins, or is refused, ends the arrival of the one before") {
    rig r{ram};
    r.enable_for(places);
    REQUIRE(r.drive.run(limit_travel{-2_mm, 60_mm}));
    const auto arrive = [&] {
        REQUIRE(r.drive.run(move_to{5_mm, quick}, wait_reached{}));
        REQUIRE(r.drive.arrival());
    };
    arrive();
    REQUIRE(r.drive.begin(move_to{10_mm, quick}));
    CHECK(r.drive.arrival().how == arrival_state::none);
    while (!r.drive.is_idle()) (void)r.drive.step(), r.wire.pass(microseconds(100));
    CHECK(r.drive.run(wait_reached{}));
    const auto refused = [&](const auto& move, errc why) {
        arrive();
        CHECK(r.drive.begin(move) == why);
        CHECK(r.drive.arrival().how == arrival_state::none);
        CHECK(r.drive.run(wait_reached{}).error() == errc::wrong_state);
    };
    refused(move_to{10_mm}, errc::bad_argument);
    refused(move_by{10_mm, quick}, errc::wrong_state);
    refused(move_to{61_mm, quick}, errc::out_of_range);
}

TEST_CASE("another gear makes the units of an axis unknown until the next init has compared them") {
    rig r{ram, c630s::encoder_counts::of_17_bits};
    r.set(c630s::pulses_per_revolution.address, 0);
    r.set(c630s::gear_1_numerator.address, 131'072);
    r.set(c630s::gear_1_denominator.address, 10'000);
    r.enable_for(places);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(c630s::gear{131'072, 1'000}));
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK(r.drive.run(init{}).error() == errc::unexpected_value);
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("soft limits are set at standstill only") {
    rig r{ram};
    r.enable_for(places);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable{}));
    REQUIRE(r.drive.run(velocity{50_mm_per_s}));
    r.wire.pass(milliseconds(500));
    CHECK(r.drive.run(limit_travel{0_mm, 200_mm}).error() == errc::busy);
    CHECK(r.drive.run(velocity{-50_mm_per_s})); // none are set
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.drive.run(limit_travel{0_mm, 200_mm}));
}

} // namespace axis_c630s_tests
