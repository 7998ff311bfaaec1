// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The words of a C630S decide what is said of a move. A drive reports what a table has, before a start and after it.
// The simulated drive's own motor stands still.
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <tests/support/loop_bound.hpp>
#include <tests/support/simulated_c630s.hpp>

namespace motion_c630s_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

namespace {

// VDO2 TGON, VDO5 COIN, VDO7 the torque limit, as `set_up` assigns them; VDI7 starts a segment.
constexpr u16 rotating = 0x0002, completed = 0x0010, pressing = 0x0040;
constexpr u16 start = 0x0040;

struct image {
    std::int32_t place;
    u16 outputs = 0;
    std::int32_t deviation = 0;
    int r_per_minute = 0;
    u16 alarm = 0;
    u16 record = 0; ///< 0: the present one
    bool is_restarted = false;
};
using images = std::vector<image>;

/// A drive that reports these images: the first one until a start, the last one for good. Each read of its outputs goes
/// on to the next one.
struct reporting : sim::c630s {
    using sim::c630s::c630s;
    images all{};
    std::size_t at = 0;
    unsigned starts = 0;
    sim::fault_plan* faults = nullptr;
    bool loses_start = false;

    void show(const images& i) {
        all = i;
        at = 0;
        starts = 0;
    }
    std::uint8_t read(u16 address, slice<u16> to) {
        const std::uint8_t why = sim::c630s::read(address, to);
        faults->lost_response = 0;
        if (all.empty()) return why;
        if (address == 0x1720 && at != 0 && at + 1 < all.size() && !is_fresh) ++at;
        if (address == 0x1720) is_fresh = false;
        const image& now = all[at];
        const auto put = [&](std::int32_t n) { // the low word first, as from the factory
            to[0] = static_cast<u16>(static_cast<u32>(n) & 0xFFFF);
            to[1] = static_cast<u16>(static_cast<u32>(n) >> 16);
        };
        if (address == 0x1720)
            to[0] = static_cast<u16>((to[0] & ~(rotating | completed | pressing)) | now.outputs);
        if (address == 0x0B00) to[0] = static_cast<u16>(now.r_per_minute);
        if (address == 0x0B07) put(now.place);
        if (address == 0x0B35) put(now.deviation);
        if (address == 0x0B21) {
            to[0] = now.record;
            to[1] = now.alarm;
        }
        if (address == 0x3100 && inputs != 0) to[0] = inputs;
        if (address == 0x3100 && now.is_restarted) to[0] = 0;
        return why;
    }
    std::uint8_t write(u16 address, words_view from) {
        const bool is_start = address == 0x3100 && (from[0] & start) != 0;
        faults->lost_response = is_start && loses_start ? 1000 : 0;
        if (address == 0x3100) inputs = is_start ? from[0] : u16{0};
        if (!is_start) return sim::c630s::write(address, from);
        ++starts; // its own motor is told nothing
        if (all.size() > 1) at = 1;
        is_fresh = true;
        return 0;
    }
    bool is_fresh = false; ///< the present image was not read yet
    u16 inputs = 0;        ///< of the start
};

struct servo : simulated::simulated_model<reporting, sim::c630s_options, 57600> {
    c630s::drive<line_type> drive{line, 1, unsupervised};
    servo() {
        model.faults = &wire.faults();
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(set_up{}));
        model.power_cycle();
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable_in{control_mode::position}));
    }
    command_status move(std::int32_t way) {
        REQUIRE(drive.run(segment{1, way * reference_unit, 60 * r_per_min}));
        return drive.run(start_segment{1});
    }
    std::uint64_t now() { return wire.time_us(); }
};

images after(image before, std::size_t times, image first, image then) {
    images all{before};
    all.insert(all.end(), times, first);
    all.push_back(then);
    return all;
}

} // namespace

TEST_CASE("G34: how a move has ended, by the words after its start") {
    struct scene {
        std::int32_t way;
        images seen;
        errc ends;
        stop_cause cause;
        std::int32_t missing;
    };
    using enum stop_cause;
    constexpr errc ok = errc::ok, stopped = errc::stopped_short;
    const scene all[] = {
        {1000, {{0}, {1000, completed}}, ok, unknown, 0},
        {1000, {{0}, {300, rotating}, {1000, completed}}, ok, unknown, 0},
        {1000, {{0}, {980, completed}}, ok, unknown, 20}, // it trembles by 20 units
        {1000, {{0}, {1020, completed}}, ok, unknown, -20},
        {1000, {{0}, {979, completed}}, stopped, unknown, 21},
        {1000, {{0}, {1021, completed}}, stopped, unknown, -21},
        {-1000, {{0}, {-979, completed}}, stopped, unknown, -21},
        // The place and its deviation add up to the target, before the start too.
        {1000, {{0}, {900, completed, 100}}, ok, unknown, 100},
        {1000, {{0}, {1000, completed, 100}}, stopped, unknown, 0},
        {1000, {{70'000, 0, 30}, {71'030, completed}}, ok, unknown, 0},
        {1000, {{70'000, 0, 30}, {71'000, completed}}, stopped, unknown, 30},
        // COIN within 500 ms of the start may be that of the move before.
        {1000, after({0}, 4, {0, completed}, {1000, completed}), ok, unknown, 0},
        // The motor is at a stop once it has pressed for 100 ms. It is not while it turns, nor sooner.
        {1000, {{0}, {500, pressing}}, stopped, blocked, 500},
        {1000,
         {{0}, {900, pressing, 100}},
         stopped,
         blocked,
         100}, // the deviation is no way that it has gone
        {1000, {{0}, {1000, pressing}}, ok, unknown, 0},
        {1000, after({0}, 20, {500, pressing | rotating}, {1000, completed}), ok, unknown, 0},
        {1000, {{0}, {500, pressing}, {500}, {500, pressing}, {500}, {1000, completed}}, ok, unknown, 0},
        // The present alarm: FunIN.34, and the limit switches.
        {1000, {{0}, {500, completed, 0, 0, 0x900}}, stopped, input, 500},
        {1000, {{0}, {500, completed, 0, 0, 0x950}}, stopped, input, 500},
        {1000, {{0}, {500, completed, 0, 0, 0x952}}, stopped, input, 500},
        {1000, {{0}, {500, completed, 0, 0, 0x951}}, stopped, unknown, 500},
        {1000, {{0}, {500, completed, 0, 0, 0x900, 1}}, stopped, unknown, 500}, // an older one
    };
    servo s;
    for (const scene& n : all) {
        for (const bool is_blocked_before : {false, true}) {
            CAPTURE(&n - all);
            CAPTURE(is_blocked_before);
            if (is_blocked_before)
                s.model.show({{0}, {500, pressing}});
            else
                s.model.show({{0}, {500, completed, 0, 0, 0x900}});
            REQUIRE(s.move(1000)); // the one before has ended short, with its cause
            REQUIRE(s.drive.run(wait_reached{}).error() == stopped);
            s.model.show(n.seen);
            REQUIRE(s.move(n.way));
            CHECK(s.drive.arrival().how == arrival_state::under_way);
            CHECK(s.drive.arrival().cause == unknown);
            const std::uint64_t begun = s.now();
            CHECK(s.drive.run(wait_reached{milliseconds(5000)}).error() == n.ends);
            CHECK(s.now() - begun > (n.cause == blocked ? 80'000u : 0u));
            CHECK(s.now() - begun < 800'000);
            REQUIRE(s.drive.run(read_feedback{}));
            CHECK(s.drive.arrival().how ==
                  (n.ends == ok ? arrival_state::reached : arrival_state::stopped_short));
            CHECK(s.drive.arrival().cause == n.cause);
            CHECK(s.drive.arrival().missing == n.missing * reference_unit);
        }
    }
}

TEST_CASE("G34: a move towards a limit switch that is active is not started") {
    struct scene {
        std::int32_t place;
        std::int32_t way;
        u16 alarm;
        u16 record;
        bool is_started;
    };
    for (const scene& n : {scene{0, 1000, 0x950, 0, false},
                           {0, -1000, 0x950, 0, true},
                           {0, -1000, 0x952, 0, false},
                           {0, 1000, 0x952, 0, true},
                           {5000, -1000, 0x950, 0, true},
                           {-5000, 1000, 0x952, 0, true},
                           {0, 1000, 0x950, 1, true},
                           {0, 1000, 0x900, 0, true}}) {
        CAPTURE(n.way);
        CAPTURE(n.alarm);
        servo s;
        s.model.show({{n.place, 0, 0, 0, n.alarm, n.record}});
        CHECK(s.move(n.way).error() == (n.is_started ? errc::ok : errc::wrong_state));
        CHECK(s.model.starts == (n.is_started ? 1u : 0u));
    }
}

TEST_CASE("S4: what a start without a response has done, by the words after it") {
    struct scene {
        image before;
        image then;
        motion_check motion;
    };
    using enum motion_check;
    for (const scene& n : {scene{{5000}, {5020}, not_seen},
                           {{5000}, {4980}, not_seen},
                           {{5000}, {5021}, seen},
                           {{5000}, {4979}, seen},
                           {{70'000}, {70'000 + 65'536}, seen},
                           {{5000}, {5000, 0, 0, 3}, seen},
                           {{5000}, {5000, 0, 0, -3}, seen},
                           {{5000}, {5000, 0, 0, 2}, not_seen},
                           {{5000}, {5000, 0, 0, 0, 0, 0, true}, unknown}, // it has restarted
                           {{5000}, {0, 0, 0, 100, 0, 0, true}, unknown}}) {
        CAPTURE(n.then.place);
        CAPTURE(n.then.r_per_minute);
        servo s;
        s.model.show({n.before, n.then});
        s.model.loses_start = true;
        CHECK(s.move(1000).error() == errc::timeout);
        for (tests::loop_bound left{"what follows"}; !s.drive.is_idle(); left.use())
            s.wire.wait(s.drive.step());
        CHECK(s.drive.motion() == n.motion);
        CHECK(s.model.starts == 1);
    }
}

TEST_CASE("G34: a stop ends the move that is under way, and none that has ended") {
    for (const bool has_arrived : {false, true}) {
        CAPTURE(has_arrived);
        servo s;
        s.model.show({{0}, {1000, completed}});
        REQUIRE(s.move(1000));
        if (has_arrived) REQUIRE(s.drive.run(wait_reached{}));
        REQUIRE(s.drive.run(disable{}));
        CHECK(s.drive.arrival().how == (has_arrived ? arrival_state::reached : arrival_state::stopped_short));
    }
}

} // namespace motion_c630s_tests
