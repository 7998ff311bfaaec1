// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The bound of a stop and each part that it contains: every part is provoked, and the bound is a tenth longer at
// most than the longest stop that this gave. Measured on the wire, from the command to the last bit of the stop's
// frame.
#include <doctest/doctest.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <servobus/bus/bus.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/late_port.hpp>
#include <tests/support/loop_bound.hpp>

namespace stop_bound_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

constexpr std::uint32_t limit_us = 20'000;
constexpr auto wheels_node = [] {
    node<zlac8015d::device> n{1};
    n.limits.response = microseconds(limit_us);
    n.gaps.quarantine = milliseconds(30);
    return n;
}();
constexpr auto other_node = [] {
    node<zlac8015d::device> n{9};
    n.limits.response = milliseconds(5);
    n.gaps.quarantine = milliseconds(30);
    return n;
}();
constexpr supervision often{.feedback = milliseconds(12), .command_timeout = no_command_timeout};
/// About as much as the line takes.
constexpr poll_plan loaded{modbus::timing_at(115200),
                           controlled(wheels_node, often).commands(milliseconds(20)),
                           cyclic<zlac8015d::bus_voltage>(other_node, milliseconds(60))};
static_assert(loaded.load_per_mille() > 900);
constexpr poll_plan loaded_strictly{modbus::timing_at(115200, modbus::timing_mode::strict),
                                    controlled(wheels_node, often).commands(milliseconds(20)),
                                    cyclic<zlac8015d::bus_voltage>(other_node, milliseconds(60))};

constexpr std::uint64_t character_us = 96;
constexpr std::uint64_t t1_5_us = 750;
constexpr std::uint64_t t3_5_us = 1750;
constexpr std::uint64_t inter_byte_us = 20'000;
constexpr std::uint64_t begun_us = limit_us - character_us; // just in time

struct play {
    const char* name;
    std::uint64_t (*due)(std::size_t byte);
    bool is_absent = false;
};
const play with_host_timing[] = {
    {"prompt", nullptr},
    {"absent", nullptr, true},
    {"at the last moment", [](std::size_t i) { return begun_us + i * character_us; }},
    {"at the last moment, with the longest pause",
     [](std::size_t i) { return begun_us + i * character_us + (i != 0 ? inter_byte_us - 200 : 0); }},
    {"at the last moment, with the longest pause before its last bytes",
     [](std::size_t i) { return begun_us + i * character_us + (i > 5 ? inter_byte_us - 200 : 0); }},
    {"trickling, with t1.5 after each byte",
     [](std::size_t i) { return begun_us + i * (character_us + t1_5_us); }},
    {"trickling, with almost the longest pause after each byte",
     [](std::size_t i) { return begun_us + i * (inter_byte_us - 1000); }},
    {"trickling, with half of the longest pause after each byte",
     [](std::size_t i) { return begun_us + i * (inter_byte_us / 2); }},
    {"too late, at the end of the gap, in one piece",
     [](std::size_t i) { return limit_us + t3_5_us - 150 + i * character_us; }},
    {"too late, at the end of the gap, with pauses as long as the gap",
     [](std::size_t i) {
         const std::uint64_t pauses = i * (t3_5_us - character_us - 150);
         return limit_us + t3_5_us - 150 + i * character_us +
                (pauses < inter_byte_us ? pauses : inter_byte_us);
     }},
};

const play with_strict_timing[] = {
    {"prompt", nullptr},
    {"absent", nullptr, true},
    {"at the last moment", [](std::size_t i) { return begun_us + i * character_us; }},
    {"trickling, with t1.5 after each byte",
     [](std::size_t i) { return begun_us + i * (character_us + t1_5_us - 20); }},
    {"too late, at the end of the gap, with t1.5 after each byte",
     [](std::size_t i) { return limit_us + t3_5_us - 150 + i * (character_us + t1_5_us - 20); }},
};

template <const auto& Plan> struct rig {
    using line_type = scheduled_line<tests::late_port>;

    sim::zlac8015d model{};
    sim::station<sim::zlac8015d> station{model};
    sim::virtual_line wire{115200};
    tests::late_port port{wire};
    line_type on{port, Plan.timing()};
    zlac8015d::drive<line_type> wheels{on, wheels_node, by_plan};
    bus<Plan, line_type, decltype(wheels)> all{on, wheels};
    std::vector<std::uint8_t> open{};
    std::uint64_t stop_end = 0; // of the first stop since it was set to 0

    rig() {
        wire.attach(station);
        wire.set_hook(&rig::note, this);
    }
    rig(const rig&) = delete;
    rig& operator=(const rig&) = delete;

    static void note(void* self, const sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& r = *static_cast<rig*>(self);
        r.open.push_back(b.value);
        if (r.open.size() != modbus::request_length(r.open)) return;
        const bool is_stop = r.open[1] == 6 && r.open[2] == 0x20 && r.open[3] == 0x0E && r.open[5] == 5;
        if (is_stop && r.stop_end == 0) r.stop_end = b.at_us;
        r.open.clear();
    }
    void turn() { port.wait(longer_of(microseconds(1), all.step())); }
    void run(std::uint32_t us) {
        const std::uint64_t end = wire.time_us() + us;
        while (wire.time_us() < end) turn();
    }
    template <class Wanted> bool command(const Wanted& wanted) {
        return static_cast<bool>(all.run(wheels, wanted));
    }
};

/// Of so many stops, each commanded while the first byte of another frame leaves. Longest, in us.
template <const auto& Plan> std::uint64_t longest_of(const play& how, std::uint32_t stops) {
    CAPTURE(std::string{how.name});
    rig<Plan> r;
    std::uint64_t longest = 0;
    std::uint32_t in_progress = 0;
    for (std::uint32_t k = 0; k < stops; ++k) {
        r.port.due = nullptr;
        r.wire.set_connected(0, true);
        r.run(100'000);
        if (r.wheels.state() == zlac8015d::drive_state::needs_init) REQUIRE(r.command(init{}));
        REQUIRE(r.command(zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
        REQUIRE(r.command(velocity{30 * r_per_min, 30 * r_per_min}));
        r.run(5'000 + k * 733 % 20'000);
        if (k % 3 == 0) (void)r.wheels.begin(velocity{20 * r_per_min, 20 * r_per_min});
        // The next request of the bus, which the drive gets.
        const std::uint32_t asked = r.wire.requests();
        while (r.wire.requests() == asked) r.turn();
        if (how.due != nullptr) r.port.due = how.due;
        if (how.is_absent) r.wire.set_connected(0, false);
        r.stop_end = 0;
        const std::uint64_t ordered = r.wire.time_us();
        REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
        while (r.stop_end == 0) r.turn();
        const std::uint64_t took = r.stop_end - ordered;
        CHECK(took <= Plan.worst_case_stop_latency().us);
        longest = took > longest ? took : longest;
        in_progress += took > 3000 ? 1u : 0u;
        r.port.due = nullptr;
        r.wire.set_connected(0, true);
        for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
        r.run(150'000);
    }
    if (how.due != nullptr) CHECK(r.port.delayed != 0);
    CHECK(in_progress > stops / 2); // the others were commanded at the end of a frame
    return longest;
}

template <const auto& Plan> void check(std::span<const play> plays) {
    std::uint64_t longest = 0;
    for (const play& how : plays) {
        const std::uint64_t own = longest_of<Plan>(how, 40);
        if (how.due == nullptr && !how.is_absent) CHECK(own < 10'000); // of an undisturbed line
        longest = own > longest ? own : longest;
    }
    CHECK(Plan.worst_case_stop_latency().us * 10 <= 11 * longest);
}

} // namespace

TEST_CASE("G25: each part of a stop's bound can be provoked, and the bound is a tenth longer at most") {
    check<loaded>(with_host_timing);
    check<loaded_strictly>(with_strict_timing);
}

} // namespace stop_bound_tests
