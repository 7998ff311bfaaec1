// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G21: a register that a facade caches is written by another client on its line. Judged by the frames on the wire and
// by the simulated drive.
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/any_device.hpp>
#include <servobus/client/stepped_tables.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>
#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_zlac8015d.hpp>

namespace changed_settings_tests {

using namespace servobus;
using namespace servobus::units;
using zlac8015d::operating_mode;
using rig = simulated::driven_zlac8015d;
using other_client = client<rig::line_type, zlac8015d::device>;

namespace {

template <class Call, class... Arguments> void finish(rig& r, Call& call, Arguments... arguments) {
    REQUIRE(call.begin(arguments...) == errc::ok);
    while (!call.done()) {
        const duration idle = call.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    REQUIRE(call.status());
}

// Each sets the resolution of speeds, 2022h, to 1/10 r/min.
struct way {
    std::string_view name;
    void (*write)(rig&);
};
constexpr way ways[] = {
    {"write",
     [](rig& r) {
         REQUIRE(other_client{r.line, node<zlac8015d::device>{1}}.write<zlac8015d::speed_resolution>(10));
     }},
    {"a value of the running program",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         REQUIRE(c.write<zlac8015d::speed_resolution>(checked(10)));
     }},
    {"adjacent registers",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         REQUIRE(c.write<zlac8015d::input_stop, zlac8015d::speed_resolution>(
             zlac8015d::input_stop_action::lock_shaft, 10));
     }},
    {"store",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         REQUIRE(c.store<zlac8015d::speed_resolution>(10));
     }},
    {"write if different",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         REQUIRE(c.write_if_different<zlac8015d::speed_resolution>(10));
     }},
    {"broadcast",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         REQUIRE(c.broadcast<zlac8015d::speed_resolution>(10));
     }},
    {"a word by its address",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         REQUIRE(c.write_word(0x2022, 10));
     }},
    {"an array of words",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         REQUIRE(c.write_words(0x2021, {0, 10}));
     }},
    {"words",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         const std::array<u16, 2> words{0, 10};
         REQUIRE(c.write_words(0x2021, slice<const u16>{words.data(), 2}));
     }},
    {"a PDU",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         constexpr auto pdu = hex("10 20 22 00 01 02 00 0A");
         std::array<std::uint8_t, 5> response{};
         REQUIRE(c.transact(pdu, response));
     }},
    {"stepped",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         stepped_write<other_client, zlac8015d::speed_resolution> call{c};
         finish(r, call, checked(10));
     }},
    {"stepped, adjacent registers",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         stepped_write<other_client, zlac8015d::input_stop, zlac8015d::speed_resolution> call{c};
         finish(r, call, checked(zlac8015d::input_stop_action::lock_shaft), checked(10));
     }},
    {"stepped, words",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         stepped_write_words<other_client, 2> call{c};
         const std::array<u16, 2> words{0, 10};
         finish(r, call, u16{0x2021}, slice<const u16>{words.data(), 2});
     }},
    {"stepped, a word by its address",
     [](rig& r) {
         other_client c{r.line, node<zlac8015d::device>{1}};
         stepped_write_words<other_client, 2> call{c};
         finish(r, call, u16{0x2022}, u16{10});
     }},
};

// True for a frame that sets a target or enables.
bool is_motion(const simulated::frame& f) { return simulated::is_motion_or_enable(f); }

} // namespace

TEST_CASE("G21: however another client of the line writes the resolution, no speed is sent in the old one") {
    unsigned played = 0;
    for (const way& w : ways) {
        for (const bool is_polled : {false, true}) {
            CAPTURE(w.name);
            CAPTURE(is_polled);
            rig r{{}, is_polled ? supervision{.command_timeout = no_command_timeout} : unsupervised};
            enabled_zlac8015d::be_enabled_in(r, operating_mode::velocity);
            REQUIRE(r.drive.run(velocity{20 * r_per_min, 20 * r_per_min}));
            w.write(r);
            REQUIRE(r.model.peek(0x2022) == 10);
            const std::size_t frames = r.log.frames.size();
            CHECK(r.drive.run(velocity{30 * r_per_min, 30 * r_per_min}).error() == errc::needs_init);
            CHECK(r.drive.state() == zlac8015d::drive_state::needs_init);
            CHECK(r.drive.run(enable{}).error() == errc::needs_init);
            for (std::size_t i = frames; i < r.log.frames.size(); ++i)
                CHECK_FALSE(is_motion(r.log.frames[i]));
            REQUIRE(r.drive.run(init{}));
            CHECK(r.drive.cached().resolution == 10);
            REQUIRE(r.drive.run(enable{}));
            REQUIRE(r.drive.run(velocity{30 * r_per_min, 30 * r_per_min}));
            CHECK(r.model.peek(0x2088) == 300);
            ++played;
        }
    }
    CHECK(played == 2 * std::size(ways));
}

TEST_CASE("G21: a parameter that is refused changes nothing, and no settings become stale") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    const std::size_t frames = r.log.frames.size();
    CHECK(r.drive.begin(zlac8015d::set<zlac8015d::max_motor_speed>{500 * r_per_min}) == errc::wrong_state);
    CHECK(r.log.frames.size() == frames);
    CHECK(r.drive.state() == drive_state::enabled);
}

TEST_CASE("G21: each register that is listed, and no other, makes the settings of a facade stale") {
    unsigned stale = 0;
    const auto play = [&stale](auto& r, auto& other, auto& drive, u16 address) {
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.state() != drive_state::needs_init);
        (void)other.write_word(address, static_cast<u16>(r.model.peek(address)));
        (void)drive.step();
        const bool is_stale = drive.state() == drive_state::needs_init;
        CAPTURE(address);
        CHECK(is_stale ==
              is_cached_by_facade<typename std::remove_cvref_t<decltype(other)>::device>(address, 1));
        stale += is_stale ? 1u : 0u;
    };
    SUBCASE("ZLAC8015D") {
        rig r;
        other_client other{r.line, node<zlac8015d::device>{1}};
        // 2009h restores the factory's parameters; 2001h and 2002h are settings of the line.
        for (u16 a = 0x2000; a <= 0x2070; ++a) {
            if (a != 0x2001 && a != 0x2002) play(r, other, r.drive, a);
        }
        CHECK(stale == 11);
    }
    SUBCASE("YAKO, closed loop") {
        simulated::closed_axis a;
        client other{a.line, node<yako::closed_loop::device>{1}};
        for (u16 at = 0x0010; at <= 0x0034; ++at) {
            if (at < 0x0013 || at > 0x0015) play(a, other, a.drive, at);
        }
        for (u16 at = 0x00B8; at <= 0x00BC; ++at) play(a, other, a.drive, at);
        CHECK(stale == 15);
    }
    SUBCASE("C630S") {
        simulated::driven_c630s r;
        REQUIRE(r.make_ready());
        client other{r.line, node<c630s::device>{1}};
        for (u16 at = 0x0500; at <= 0x0512; ++at) play(r, other, r.drive, at);
        for (u16 at = 0x0600; at <= 0x060A; ++at) play(r, other, r.drive, at);
        for (u16 at = 0x0C19; at <= 0x0C1B; ++at) play(r, other, r.drive, at);
        for (u16 at = 0x1100; at <= 0x1105; ++at) play(r, other, r.drive, at);
        for (u16 at = 0x173E; at <= 0x1742; ++at) play(r, other, r.drive, at);
        CHECK(stale == 18);
    }
}

TEST_CASE("G21: each setting that an init reads is in the list of its device") {
    // Of the frames of an init; `is_exempt`: read-only registers, and those that each enable sets.
    const auto unlisted = [](const auto& frames, auto is_listed, auto is_exempt) {
        std::vector<unsigned> all;
        for (const auto& f : frames) {
            if (f[1] != 0x03) continue;
            const unsigned first = load_word(f, 2);
            for (unsigned at = first; at < first + load_word(f, 4); ++at) {
                if (!is_exempt(at) && !is_listed(static_cast<u16>(at))) all.push_back(at);
            }
        }
        return all;
    };
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.log.frames.size() >= 6);
    CHECK(unlisted(
              r.log.frames, [](u16 at) { return is_cached_by_facade<zlac8015d::device>(at, 1); },
              [](unsigned at) { return at >= 0x20A0; })
              .empty());
    simulated::open_axis a;
    REQUIRE(a.drive.run(init{}));
    CHECK(unlisted(
              a.requests, [](u16 at) { return is_cached_by_facade<yako::open_loop::device>(at, 1); },
              [](unsigned at) { return at < 0x0010; })
              .empty());
    simulated::driven_c630s c;
    REQUIRE(c.make_ready());
    c.requests.clear();
    REQUIRE(c.drive.run(init{}));
    CHECK(unlisted(
              c.requests, [](u16 at) { return is_cached_by_facade<c630s::device>(at, 1); },
              [](unsigned at) {
                  return at >> 8 == 0x0B || at == 0x0200 || (at >= 0x051E && at <= 0x0521);
              }) == std::vector<unsigned>{});
}

TEST_CASE("G21: other rows, reads, and writes that do not leave change nothing for a facade") {
    rig r;
    enabled_zlac8015d::be_enabled_in(r, operating_mode::velocity);
    other_client other{r.line, node<zlac8015d::device>{1}};
    REQUIRE(other.write<zlac8015d::left_speed_kp>(600));
    REQUIRE(other.read<zlac8015d::speed_resolution>());
    REQUIRE(other.write_if_different<zlac8015d::speed_resolution>(1)); // which it has
    CHECK(other.write<zlac8015d::speed_resolution>(checked(11)).error() == errc::out_of_range);
    other_client nobody{r.line, node<zlac8015d::device>{0}};
    CHECK(nobody.write<zlac8015d::speed_resolution>(10).error() == errc::bad_argument);
    constexpr auto pdu = hex("03 20 22 00 01");
    std::array<std::uint8_t, 4> response{};
    REQUIRE(other.transact(pdu, response));
    REQUIRE(r.drive.run(velocity{30 * r_per_min, 30 * r_per_min}));
    CHECK(r.model.peek(0x2088) == 30);
}

TEST_CASE("G21: a setting whose response is lost makes the settings of another facade stale too") {
    unsigned unknown = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        simulated::driven_c630s r{{}, seed};
        REQUIRE(r.make_ready());
        c630s::drive other{r.line, 1, unsupervised};
        REQUIRE(other.run(init{}));
        r.wire.faults().lost_response = 500;
        const auto how = r.drive.run(c630s::set<c630s::brake_on_to_command_delay>{300 * millisecond});
        r.wire.faults() = {};
        if (how.outcome() != outcome::unknown) continue;
        ++unknown;
        CHECK(other.begin(enable{}) == errc::needs_init);
    }
    CHECK(unknown > 2);
}

TEST_CASE("G21: a setting that a facade refuses leaves the settings of another facade") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    zlac8015d::drive other{r.line, 1, unsupervised};
    REQUIRE(other.run(init{}));
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    REQUIRE(other.run(init{})); // the drive is disabled again
    REQUIRE(r.drive.run(init{}));
    const auto wanted = zlac8015d::set<zlac8015d::max_motor_speed>{500};
    REQUIRE(r.drive.begin(enable{}) == errc::ok);
    CHECK(r.drive.begin(wanted) == errc::busy);
    CHECK(r.drive.run(wanted).error() == errc::busy);
    while (!r.drive.is_idle()) {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(r.drive.begin(wanted) == errc::wrong_state);
    CHECK(other.state() == drive_state::disabled);
    CHECK(other.begin(read_feedback{}) == errc::ok);
}

} // namespace changed_settings_tests
