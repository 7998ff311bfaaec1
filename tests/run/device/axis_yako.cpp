// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A YAKO that moves an axis: places, ways, speeds and limits in lengths, judged by the simulated motor's own position
// and by what its registers hold.
#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/yako/axis_drive.hpp>
#include <tests/support/simulated_yako.hpp>

namespace axis_yako_tests {

using namespace servobus;
using namespace servobus::literals;
using simulated::simulated_closed_loop;
using simulated::simulated_open_loop;

namespace {

constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000})); // 200 pulses a mm
constexpr auto turned = axis::of(mirrored(lead(5_mm, counts_per_turn{1000})));
constexpr auto third = axis::of(lead(3_mm, counts_per_turn{1000})); // 3 um a pulse
constexpr auto other = axis::of(lead(5_mm, counts_per_turn{2000}));
constexpr axis_profile quick{.top = 50_mm_per_s, .acceleration = 50_ms, .deceleration = 50_ms};

struct closed : simulated_closed_loop {
    yako::closed_loop::axis_drive<line_type> drive;
    explicit closed(const axis& of, const supervision& by = without_watchdog, sim::yako_options options = {})
        : simulated_closed_loop{options}, drive{line, 1, of, by} {}
};
struct open : simulated_open_loop {
    yako::open_loop::axis_drive<line_type> drive;
    explicit open(const axis& of, const supervision& by = without_watchdog) : drive{line, 1, of, by} {}
};
template <class Rig> struct ready : Rig {
    explicit ready(const axis& of, const supervision& by = without_watchdog) : Rig{of, by} {
        REQUIRE(this->drive.run(init{}));
        REQUIRE(this->drive.run(enable{}));
        REQUIRE(this->drive.run(declare_position{0_mm}));
    }
    std::int64_t pulses() const { return this->model.view().position; }
    /// Reads the feedback and says where the axis is.
    micrometres place() {
        REQUIRE(this->drive.read());
        return *this->drive.position(milliseconds(100));
    }
    arrival_state to(const axis_move_to& there) { return this->drive.run(there, wait_reached{}).how; }
    arrival_state by(const axis_move_by& way) { return this->drive.run(way, wait_reached{}).how; }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = this->wire.time_us() + std::uint64_t{ms} * 1000u;
        while (this->wire.time_us() < end) {
            const duration idle = this->drive.step();
            this->wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    }
};

} // namespace

TEST_CASE_TEMPLATE("an axis goes to places, and says where it is", Rig, closed, open) {
    ready<Rig> r{screw};
    CHECK(r.to({12.5_mm, quick}) == arrival_state::reached);
    CHECK(r.pulses() == 2500);
    CHECK(r.place() == 12.5_mm);
    CHECK(r.to({-0.4_mm}) == arrival_state::reached); // by the profile that the drive holds
    CHECK(r.pulses() == -80);
    CHECK(r.place() == -0.4_mm);
    CHECK(r.drive.arrival().missing == 0_mm);
}

TEST_CASE("a mirrored axis: commands, feedback, limits and declared places") {
    ready<closed> r{turned};
    CHECK(r.to({12.5_mm, quick}) == arrival_state::reached);
    CHECK(r.pulses() == -2500);
    CHECK(r.place() == 12.5_mm);
    REQUIRE(r.drive.run(declare_position{20_mm}));
    CHECK(r.place() == 20_mm);
    REQUIRE(r.drive.run(yako::set_over_travel_stop{yako::over_travel_stop::emergency_stop}));
    REQUIRE(r.drive.run(limit_travel{10_mm, 30_mm}));
    const auto limit = [&](std::uint16_t at) {
        const u32 raw = join_words(r.model.peek(at), r.model.peek(static_cast<std::uint16_t>(at + 1)),
                                   word_order::high_first);
        return static_cast<std::int32_t>(raw);
    };
    CHECK(limit(yako::positive_software_limit.address) == -2000);
    CHECK(limit(yako::negative_software_limit.address) == -6000);
    const axis_arrival far = r.drive.run(move_to{40_mm, quick}, wait_reached{});
    CHECK(far.how == arrival_state::stopped_short);
    CHECK(far.cause == stop_cause::software_limit);
    CHECK(far.missing.count() > 9'000);
    CHECK(far.missing.count() < 10'100);
    REQUIRE(r.drive.run(velocity{-20_mm_per_s}));
    r.loop(300);
    CHECK(r.model.view().speed > 0);
    REQUIRE(r.drive.read());
    CHECK(r.drive.speed(milliseconds(100)).value_or({}) == -20_mm_per_s);
}

TEST_CASE_TEMPLATE("G42: a mirrored axis takes all fields of a profile as any other does", Rig, closed,
                   open) {
    constexpr axis_profile whole{
        .top = 50_mm_per_s, .acceleration = 60_ms, .deceleration = 40_ms, .start = 5_mm_per_s};
    for (const axis* of : {&screw, &turned}) {
        ready<Rig> r{*of};
        const int sign = of == &screw ? 1 : -1;
        const auto has_profile = [&r] {
            return r.model.peek(yako::closed_loop::start_speed.address) == 60 && // r/min
                   r.model.peek(yako::closed_loop::positioning_speed.address) == 600 &&
                   r.model.peek(yako::acceleration_time.address) == 60 &&
                   r.model.peek(yako::deceleration_time.address) == 40;
        };
        CHECK(r.to({12.5_mm, whole}) == arrival_state::reached);
        CHECK(has_profile());
        CHECK(r.pulses() == sign * 2500);
        REQUIRE(r.to({0_mm, {.top = 25_mm_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
                arrival_state::reached);
        CHECK_FALSE(has_profile());
        CHECK(r.by({-7.5_mm, whole}) == arrival_state::reached);
        CHECK(has_profile());
        CHECK(r.pulses() == sign * -1500);
        constexpr axis_profile early{
            .top = 5_mm_per_s, .acceleration = 60_ms, .deceleration = 40_ms, .start = 5.1_mm_per_s};
        CHECK(r.drive.begin(move_to{0_mm, early}) == errc::bad_argument);
        for (const int way : {1, -1}) {
            const std::int64_t from = r.pulses();
            const micrometres_per_second speed = way == 1 ? 20_mm_per_s : -20_mm_per_s;
            for (int i = 0; i < 10; ++i) {
                REQUIRE(r.drive.begin(hold{speed, milliseconds(50)}) == errc::ok);
                r.loop(50);
            }
            CHECK((r.pulses() - from) * sign * way > 1000); // 5 mm
            REQUIRE(r.drive.run(halt{}));
        }
    }
}

TEST_CASE("G42: ways that are no whole number of pulses do not drift; what did not begin leaves no trace") {
    ready<closed> r{third};
    for (int i = 1; i <= 300; ++i) {
        REQUIRE(r.by({100_um, quick}) == arrival_state::reached); // 33.3 pulses
        CHECK(r.pulses() == (i * 100 + 1) / 3);
        if (i % 10 == 0) CHECK(r.drive.begin(move_by{2148_m, quick}) == errc::out_of_range);
        if (i % 20 != 0) continue;
        REQUIRE(r.drive.begin(move_by{100_um, quick}) == errc::ok);
        CHECK(r.drive.begin(move_by{50_um, quick}) == errc::busy);
        while (!r.drive.is_idle()) (void)r.drive.step();
        REQUIRE(r.drive.run(wait_reached{}));
        REQUIRE(r.by({-100_um, quick}) == arrival_state::reached);
    }
    CHECK(r.place() == 30_mm);
}

TEST_CASE("the rest is kept over a halt, and dropped where the position is declared") {
    ready<closed> r{third};
    REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
    CHECK(r.pulses() == 33);
    REQUIRE(r.drive.run(halt{}));
    REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
    CHECK(r.pulses() == 67);
    REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
    REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
    CHECK(r.pulses() == 133); // a third of a pulse is open
    REQUIRE(r.drive.run(declare_position{0_mm}));
    REQUIRE(r.drive.read());
    REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
    REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
    CHECK(r.place() == 201_um); // 67 pulses
}

TEST_CASE("a way that is refused while the motor moves leaves no rest") {
    ready<closed> r{third};
    REQUIRE(r.drive.run(move_by{10_mm, quick})); // 3333.3 pulses
    CHECK(r.drive.run(move_by{100_um, quick}).error() == errc::busy);
    REQUIRE(r.drive.run(wait_reached{}));
    REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
    CHECK(r.pulses() == 3367);
}

TEST_CASE("a way that a halt has cut before its start leaves no rest") {
    std::size_t cut = 0;
    for (int steps = 1; steps < 40; ++steps) {
        CAPTURE(steps);
        ready<closed> r{third};
        REQUIRE(r.by({100_um, quick}) == arrival_state::reached); // 33.3 pulses
        REQUIRE(r.drive.begin(move_by{100_um, quick}) == errc::ok);
        for (int i = 0; i < steps; ++i) r.wire.wait(r.drive.step());
        REQUIRE(r.drive.run(halt{}));
        r.loop(300);
        if (r.pulses() != 33) break;
        ++cut;
        REQUIRE(r.by({100_um, quick}) == arrival_state::reached);
        CHECK(r.pulses() == 67);
    }
    CHECK(cut > 3);
}

TEST_CASE("G42: a drive that counts otherwise than the program says is not taken over") {
    closed r{other};
    CHECK(r.drive.run(init{}).error() == errc::unexpected_value);
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK(r.drive.begin(move_by{1_mm}) == errc::needs_init);
    CHECK(r.drive.speed(milliseconds(1000)).error() == errc::needs_init);
    CHECK(r.drive.run(move_by{1_mm}, wait_reached{}).how == arrival_state::none);
    CHECK(r.drive.position(milliseconds(1000)).error() == errc::needs_init);
    // A drive whose segment 16 is in use gets no marker, so that its state is known at once.
    const std::uint8_t in_use[]{0, 0, 0x03, 0x09};
    REQUIRE(r.model.write(servobus::at<yako::position_segment_targets, 15>.address, words_view{in_use}) == 0);
    CHECK(r.drive.run(init{}).error() == errc::unexpected_value);
    CHECK(r.drive.state() == drive_state::needs_init);
    closed right{screw};
    CHECK(right.drive.run(init{}));
    CHECK(right.drive.position(milliseconds(1000)).error() == errc::timeout);
    CHECK(right.drive.read());
    CHECK(right.drive.position(milliseconds(1000)).value_or({1_mm}) == 0_mm);
}

TEST_CASE("bad input: nothing is sent") {
    ready<closed> r{screw};
    const std::size_t before = r.requests.size();
    CHECK(r.drive.begin(move_to{2148_m}) == errc::out_of_range);
    CHECK(r.drive.begin(move_to{-2148_m}) == errc::out_of_range);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 1_um_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
          errc::out_of_range);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 300_mm_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
          errc::out_of_range); // 3600 r/min
    CHECK(r.drive.begin(move_to{1_mm, {.top = 2147_m_per_s, .acceleration = 10_ms, .deceleration = 10_ms}}) ==
          errc::out_of_range);
    CHECK(r.drive.begin(move_to{1_mm, {.top = 5_mm_per_s, .acceleration = 2001_ms, .deceleration = 10_ms}}) ==
          errc::out_of_range);
    // A profile is whole, or the drive's own: no ramp of 0 ms, and nothing is ignored.
    CHECK(axis_profile{}.is_stored());
    CHECK_FALSE(axis_profile{.deceleration = 50_ms}.is_stored());
    CHECK_FALSE(axis_profile{.start = 1_mm_per_s}.is_stored());
    const axis_profile wrong[] = {
        {.top = 50_mm_per_s},
        {.top = 50_mm_per_s, .acceleration = 200_ms},
        {.top = 50_mm_per_s, .deceleration = 200_ms},
        {.acceleration = 200_ms, .deceleration = 200_ms},
        {.start = 1_mm_per_s},
        {.top = -50_mm_per_s, .acceleration = 200_ms, .deceleration = 200_ms},
        {.top = 50_mm_per_s, .acceleration = -200_ms, .deceleration = 200_ms},
        {.top = 50_mm_per_s, .acceleration = 200_ms, .deceleration = 200_ms, .start = 51_mm_per_s},
        {.top = 50_mm_per_s, .acceleration = 200_ms, .deceleration = 200_ms, .start = -1_mm_per_s},
    };
    for (const axis_profile& by : wrong) {
        CHECK(r.drive.begin(move_to{1_mm, by}) == errc::bad_argument);
        CHECK(r.drive.begin(move_by{1_mm, by}) == errc::bad_argument);
    }
    CHECK(r.drive.begin(velocity{0_mm_per_s}) == errc::out_of_range);
    CHECK(r.drive.begin(velocity{10_um_per_s}) == errc::out_of_range);
    CHECK(r.drive.begin(hold{10_um_per_s, milliseconds(50)}) == errc::out_of_range);
    CHECK(r.drive.begin(hold{2147_m_per_s, milliseconds(50)}) == errc::out_of_range);
    CHECK(r.drive.begin(velocity{2147_m_per_s}) == errc::out_of_range);
    CHECK(r.drive.begin(limit_travel{1_mm, 1_mm}) == errc::bad_argument);
    CHECK(r.drive.begin(limit_travel{1_mm, 2148_m}) == errc::out_of_range);
    CHECK(r.drive.begin(declare_position{2148_m}) == errc::out_of_range);
    CHECK(r.requests.size() == before);
    CHECK(r.to({1_mm, quick}) == arrival_state::reached);
    CHECK(r.pulses() == 200);
    CHECK(r.to({2148_m, quick}) == arrival_state::none); // not that of the move before
}

TEST_CASE("G42: a speed of a profile that rounds to no r/min is refused, whichever it is") {
    const axis_profile starts_slowly{
        .top = 50_mm_per_s, .acceleration = 50_ms, .deceleration = 50_ms, .start = 10_um_per_s};
    axis_profile is_slow = quick;
    is_slow.top = 10_um_per_s; // 0.12 r/min
    for (const axis_profile& crawl : {starts_slowly, is_slow}) {
        ready<closed> r{screw};
        CHECK(r.drive.begin(move_by{1_mm, crawl}) == errc::out_of_range);
        CHECK(r.drive.begin(move_to{1_mm, crawl}) == errc::out_of_range);
    }
}

TEST_CASE("an axis moves while a button is held") {
    ready<closed> r{turned};
    for (int i = 0; i < 20; ++i) {
        REQUIRE(r.drive.begin(hold{20_mm_per_s, milliseconds(50)}) == errc::ok);
        r.loop(50);
    }
    CHECK(r.pulses() < -2500); // 17 mm
    REQUIRE(r.drive.run(halt{}));
    CHECK_FALSE(r.model.view().is_moving);
}

TEST_CASE("where the drive counts tenths of r/min, speeds are finer") {
    ready<closed> r{screw};
    const axis_profile slow{.top = 1.05_mm_per_s, .acceleration = 50_ms, .deceleration = 50_ms}; // 12.6 r/min
    REQUIRE(r.to({1_mm, slow}) == arrival_state::reached);
    CHECK(r.model.peek(yako::closed_loop::positioning_speed.address) == 13);
    REQUIRE(r.drive.run(yako::set_speed_resolution{yako::speed_count::tenth_r_per_min}));
    REQUIRE(r.to({2_mm, slow}) == arrival_state::reached);
    CHECK(r.model.peek(yako::closed_loop::positioning_speed.address) == 126);
}

TEST_CASE("a restart: the place is not known, and begins anew after init") {
    ready<closed> r{screw, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
    REQUIRE(r.to({12.5_mm, quick}) == arrival_state::reached);
    r.loop(100);
    CHECK(r.drive.position(milliseconds(100)).value_or({}) == 12.5_mm);
    r.model.power_cycle();
    r.loop(1000);
    CHECK(!r.drive.position(milliseconds(100)));
    REQUIRE(r.drive.run(init{}));
    r.loop(100);
    CHECK(r.drive.position(milliseconds(100)).value_or({1_mm}) == 0_mm);
}

} // namespace axis_yako_tests
