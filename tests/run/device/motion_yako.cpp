// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The images of a YAKO decide what is said of a motion. A drive reports what a table has, before a start and after it.
// The simulated drive's own motor stands still.
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/yako.hpp>
#include <tests/support/driven_yako.hpp>

namespace motion_yako_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
namespace cl = closed_loop;

namespace {

constexpr u16 homed = 0x0002; // 0007h, section 3.2 of the manual
constexpr u16 moving = 0x0004;

/// The words of 0006h..000Ch.
struct image {
    std::int32_t place;
    u16 status = 0;
    int r_per_minute = 0;
};
using images = std::vector<image>;

/// A drive that reports these images: the first one until a start, then one for each read, and the last one for good.
struct reporting : sim::yako_closed_loop {
    using sim::yako_closed_loop::yako_closed_loop;
    images all{};
    std::size_t at = 0;
    std::vector<u16> written{}; ///< addresses
    sim::fault_plan* faults = nullptr;
    bool loses_start = false;
    bool is_low_first = false; ///< not as from the factory

    void show(const images& i) {
        all = i;
        at = 0;
        written.clear();
    }
    std::uint8_t read(u16 address, slice<u16> to) {
        const std::uint8_t why = sim::yako_closed_loop::read(address, to);
        if (faults != nullptr) faults->lost_response = 0;
        if (address != 0x0006 || all.empty()) return why;
        const image& now = all[at];
        to[1] = static_cast<u16>((to[1] & ~(homed | moving)) | now.status);
        to[is_low_first ? 5 : 4] = static_cast<u16>(static_cast<u32>(now.place) >> 16);
        to[is_low_first ? 4 : 5] = static_cast<u16>(static_cast<u32>(now.place) & 0xFFFF);
        to[6] = static_cast<u16>(now.r_per_minute);
        if (at != 0 && at + 1 < all.size()) ++at;
        return why;
    }
    std::uint8_t write(u16 address, words_view from) {
        written.push_back(address);
        const bool is_start = address == 0x0027 && (from[0] & 0x00FF) != 0;
        if (faults != nullptr) faults->lost_response = is_start && loses_start ? 1000 : 0;
        if (is_start && all.size() > 1) at = 1;
        return is_start ? std::uint8_t{0} : sim::yako_closed_loop::write(address, from);
    }
};

struct axis : simulated::driven_yako<reporting, cl::drive> {
    axis() {
        model.faults = &wire.faults();
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable{}));
        REQUIRE(drive.run(set_homing_profile{90 * r_per_min, 20 * r_per_min}));
    }
    std::size_t starts() const {
        std::size_t n = 0;
        for (const u16 a : model.written) n += a == 0x0027 ? 1u : 0u;
        return n;
    }
};

constexpr bool is(motion_check a, motion_check b) { return a == b; }

} // namespace

TEST_CASE(
    "G34: whether a move, a jog and a bounded jog have begun, by the images before and after the start") {
    struct scene {
        char command; // m: a move by `way`, i: one that interrupts, b: a bounded jog, j: a jog
        std::int32_t way;
        images seen;
        errc ends;
        motion_check motion;
        drive_state state = drive_state::enabled;
    };
    using enum motion_check;
    const scene all[] = {
        {'m', 100, {{1000}, {1000, moving}}, errc::ok, seen},
        {'m', 100, {{1000}, {1000}, {1000}, {1000, moving}}, errc::ok, seen},
        {'m', 100, {{1000}, {1100}}, errc::ok, seen},
        {'m', 100, {{1000}, {1105}}, errc::ok, seen}, // it trembles by 5 pulses
        {'m', 100, {{1000}, {1106}}, errc::not_reached, unknown},
        {'m', 100, {{1000}, {1000}}, errc::not_executed, not_seen},
        {'m', 100, {{1000}, {1005}}, errc::not_executed, not_seen},
        {'m', 100, {{1000}, {1050}}, errc::not_reached, unknown},
        {'m', 100, {{1000}, {1050}, {1050, moving}}, errc::ok, seen},
        // So short a way is no trembling only where it is exact.
        {'m', 3, {{1000}, {1002}}, errc::not_executed, not_seen},
        {'m', 3, {{1000}, {1003}}, errc::ok, seen},
        {'m', 5, {{1000}, {1002}}, errc::not_executed, not_seen},
        {'m', 6, {{1000}, {1004}}, errc::ok, seen},
        // A restart may put the position to zero, where it would also be.
        {'m', -1000, {{1000}, {0}}, errc::ok, unknown},
        {'m', -1000, {{1000}, {0, moving}}, errc::ok, seen},
        {'m', -3, {{3}, {0}}, errc::ok, seen},
        {'m', 100, {{1000}, {0}}, errc::not_reached, unknown, drive_state::needs_init},
        // The end of a way from a moving motor is not known, and is no error.
        {'i', 100, {{1000, moving, 30}, {1030}}, errc::ok, unknown},
        {'i', 100, {{1000, moving, 30}, {1030, moving, 30}}, errc::ok, unknown},
        {'i', 100, {{1000, moving, 30}, {1000}}, errc::not_executed, not_seen},
        {'i', 100, {{1000}, {1050}}, errc::not_reached, unknown},
        {'b', 100, {{1000}, {1000, moving}}, errc::ok, seen},
        {'b', 100, {{1000}, {1000}}, errc::not_executed, not_seen},
        {'j', 0, {{1000}, {1000, moving}}, errc::ok, seen},
        {'j', 0, {{1000}, {1000}}, errc::not_executed, not_seen},
        {'j', 0, {{1000}, {1050}}, errc::not_reached, unknown},
    };
    for (const scene& s : all) {
        CAPTURE(s.command);
        CAPTURE(s.way);
        CAPTURE(s.seen.back().place);
        axis a;
        a.model.show(
            {{s.seen[0].place + 4321}, {s.seen[0].place + 4321, moving}}); // one before, from elsewhere
        REQUIRE(a.drive.run(move_by{10'000 * pulse}));
        a.model.show(s.seen);
        const distance way = s.way * pulse;
        const command_status got = s.command == 'm'   ? a.drive.run(move_by{way})
                                   : s.command == 'i' ? a.drive.run(move_by{way, {}, while_moving::interrupt})
                                   : s.command == 'b' ? a.drive.run(bounded_jog{way})
                                                      : a.drive.run(velocity{30 * r_per_min});
        CHECK(got.error() == s.ends);
        CHECK(is(a.drive.motion(), s.motion));
        CHECK(a.drive.state() == s.state);
        CHECK(a.starts() == 1);
    }
}

TEST_CASE("G34: whether a homing has found home, by the images before and after the start") {
    struct scene {
        std::int32_t offset;
        offset_handling then;
        images seen;
        errc ends;
    };
    using enum offset_handling;
    const scene all[] = {
        {0, move_position_zero, {{1000}, {1000, moving}, {0, homed}}, errc::ok},
        {0, move_position_zero, {{1000}, {500}, {0, homed}}, errc::ok}, // seen by its place only
        {0, move_position_zero, {{1000}, {1000, homed}}, errc::ok},     // it says so, and did not before
        {0, move_position_zero, {{1000}, {1000}}, errc::not_executed},
        {0, move_position_zero, {{1000}, {500}}, errc::not_reached},
        {0, move_position_zero, {{1000, homed}, {1000, homed}}, errc::not_executed},
        {0, move_position_zero, {{1000}, {900, moving}, {500}}, errc::not_reached},
        // "Homed" did not fall: the place tells.
        {0, move_position_zero, {{1000, homed}, {900, homed | moving}, {0, homed}}, errc::ok},
        {0, move_position_zero, {{1000, homed}, {900, homed | moving}, {400, homed}}, errc::not_reached},
        {70, move_position_zero, {{1000, homed}, {900, homed | moving}, {70, homed}}, errc::not_reached},
        {70, move_position_offset, {{1000, homed}, {900, homed | moving}, {70, homed}}, errc::ok},
        {70, move_position_offset, {{1000, homed}, {900, homed | moving}, {0, homed}}, errc::not_reached},
        {70, move_position_negative_offset, {{1000, homed}, {900, homed | moving}, {-70, homed}}, errc::ok},
        {70, stay_position_offset, {{1000, homed}, {900, homed | moving}, {70, homed}}, errc::ok},
        {70, stay_position_negative_offset, {{1000, homed}, {900, homed | moving}, {-70, homed}}, errc::ok},
        {70, move_position_actual, {{1000, homed}, {900, homed | moving}, {70, homed}}, errc::not_reached},
        // The homed bit fell, so the motor is home wherever it stands.
        {0, move_position_zero, {{1000, homed}, {900, moving}, {400, homed}}, errc::ok},
    };
    for (const scene& s : all) {
        CAPTURE(s.offset);
        CAPTURE(static_cast<int>(s.then));
        CAPTURE(s.seen.back().place);
        axis a;
        a.model.show(s.seen);
        CHECK(a.drive.run(cl::home{homing::home_24, s.offset * pulse, s.then}).error() == s.ends);
    }
}

TEST_CASE("G16: what a start without a response has done, by the image after it") {
    struct scene {
        image before;
        image after;
        motion_check motion;
    };
    using enum motion_check;
    const scene all[] = {
        {{1000}, {1000}, not_seen},  {{1000}, {1000, moving}, seen}, {{1000}, {1005}, not_seen},
        {{1000}, {1006}, seen},      {{1000}, {0}, unknown}, // perhaps by a restart
        {{1000}, {0, moving}, seen}, {{5}, {0}, not_seen},           {{70'000}, {70'000 + 65'536}, seen}};
    for (const scene& s : all) {
        CAPTURE(s.before.place);
        CAPTURE(s.after.place);
        for (const bool is_low_first : {false, true}) {
            CAPTURE(is_low_first);
            const bool is_jog = is_low_first;
            axis a;
            if (is_low_first) REQUIRE(a.drive.run(set_word_order{word_order_setting::low_first}));
            a.model.is_low_first = is_low_first;
            a.model.show({s.before, s.after});
            a.model.loses_start = true;
            const command_status got =
                is_jog ? a.drive.run(velocity{30 * r_per_min}) : a.drive.run(move_by{100 * pulse});
            CHECK(got.error() == errc::timeout);
            const std::size_t asked = a.requests.size();
            a.finish();
            CHECK(a.requests.size() == asked);
            CHECK(is(a.drive.motion(), s.motion));
            CHECK(a.starts() == 1);
        }
    }
}

TEST_CASE("a bounded jog that is under way is let be, one that is at rest or another one is not") {
    struct scene {
        std::int32_t way;
        image now;
        errc ends;
        std::size_t starts;
    };
    const scene all[] = {{100, {1050, moving, 30}, errc::ok, 0},
                         {100, {1050, moving, 0}, errc::ok, 0},
                         {100, {1050, moving, -30}, errc::busy, 0},
                         {-100, {1050, moving, -30}, errc::ok, 0},
                         {-100, {1050, moving, 30}, errc::busy, 0},
                         {-100, {1050, moving, 0}, errc::ok, 0},
                         {100, {1050}, errc::ok, 1}};
    for (const scene& s : all) {
        CAPTURE(s.way);
        CAPTURE(s.now.r_per_minute);
        axis a;
        a.model.show({{1000}, {1010, moving, 30}});
        REQUIRE(a.drive.run(bounded_jog{100 * pulse}));
        a.model.show({s.now, {s.now.place, moving, 30}});
        CHECK(a.drive.run(bounded_jog{s.way * pulse}).error() == s.ends);
        CHECK(a.model.written.size() == 2 * s.starts);
        if (s.ends == errc::ok) CHECK(is(a.drive.motion(), motion_check::seen));
    }
}

TEST_CASE("G34: where a move has come to, from its start to its end") {
    axis a;
    a.model.show({{1000}, {1000, moving}});
    REQUIRE(a.drive.run(move_by{100 * pulse}));
    const auto arrives = [&](image at) {
        a.model.show({at});
        REQUIRE(a.drive.read());
        return a.drive.arrival();
    };
    // Within 200 ms of its start it may not have begun, but it may have ended.
    CHECK(arrives({1000}).how == arrival_state::under_way);
    CHECK(arrives({1104}).how == arrival_state::reached);
    CHECK(arrives({1050, moving}).how == arrival_state::under_way);
    CHECK(arrives({1050, moving}).missing == 50 * pulse);
    a.run(200);
    CHECK(arrives({1100, moving}).how == arrival_state::under_way);
    CHECK(arrives({1095}).how == arrival_state::reached);
    CHECK(arrives({1094}).how == arrival_state::stopped_short);
    CHECK(arrives({1094}).missing == 6 * pulse);
    // A way over the end of the counter, which may stop there.
    for (const std::int32_t sign : {1, -1}) {
        CAPTURE(sign);
        const std::int32_t end = 0x7FFF'FFFF;
        a.model.show({{sign * (end - 50)}, {sign * (end - 50), moving}});
        REQUIRE(a.drive.run(move_by{sign * 100 * pulse}));
        a.run(200);
        CHECK(arrives({sign * (end - 5), moving}).how == arrival_state::under_way);
        CHECK(arrives({sign * (end - 5)}).how == arrival_state::none);
        CHECK(arrives({sign * (end - 6)}).how == arrival_state::stopped_short);
        CHECK(arrives({-sign * (end - 49)}).how == arrival_state::reached);
    }
}

TEST_CASE("a bounded jog that is refused is the last motion: the one before has no target any more") {
    axis a;
    a.model.show({{1000}, {1000, moving}, {1100}});
    REQUIRE(a.drive.run(move_by{100 * pulse}));
    REQUIRE(a.drive.run(wait_reached{}));
    const motion_profile too_fast{10 * r_per_min, 90 * millisecond, 80 * millisecond, 3001 * r_per_min};
    CHECK(a.drive.run(bounded_jog{100 * pulse, too_fast}).outcome() == outcome::not_sent);
    CHECK(a.drive.run(wait_reached{}).error() == errc::wrong_state);
    CHECK(a.drive.arrival().how == arrival_state::none);
}

TEST_CASE("a jog has no target, and leaves none of the move before it") {
    axis a;
    a.model.show({{1000}, {1000, moving}, {1100}});
    REQUIRE(a.drive.run(move_by{100 * pulse}));
    REQUIRE(a.drive.run(wait_reached{}));
    a.model.show({{1100}, {1100, moving}});
    REQUIRE(a.drive.run(velocity{30 * r_per_min}));
    CHECK(a.drive.arrival().how == arrival_state::none);
    CHECK(a.drive.run(wait_reached{}).error() == errc::wrong_state);
}

} // namespace motion_yako_tests
