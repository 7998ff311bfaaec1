// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus whose clock jumps or stops: its reads continue, and its blocking calls end.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/scripted_port.hpp>

namespace bus_clock_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

using tests::fast_plan, tests::lift_node, tests::wheels_node;

inline constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels_node, milliseconds(20))};

struct jumping_port {
    sim::virtual_line* wire;
    std::uint32_t offset = 0;

    transfer send(bytes out) { return wire->send(out); }
    bool sent() { return wire->sent(); }
    transfer receive(byte_buffer in) { return wire->receive(in); }
    instant now() { return wire->now() + duration{offset}; }
    void wait(duration longest) { wire->wait(longest); }
};

} // namespace

TEST_CASE("G19, G29: a bus continues its reads after its clock has jumped") {
    for (const std::uint32_t by : {1'000'000u, 0u - 50'000u, 0u - 10'000'000u, 0u - 1'000'000'000u}) {
        CAPTURE(by);
        sim::zlac8015d model;
        sim::station at_the_drive{model};
        sim::virtual_line wire{115200};
        wire.attach(at_the_drive);
        jumping_port port{&wire};
        scheduled_line on{port, modbus::timing_at(115200)};
        bus<plan, decltype(on)> all{on};
        all.run_for(milliseconds(200));
        port.offset += by;
        const std::uint32_t before = all.count(0);
        for (const std::uint64_t end = wire.time_us() + 500'000; wire.time_us() < end;) {
            const duration idle = all.step();
            wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
        CHECK(all.count(0) - before >= 10);
    }
}

namespace {
struct requests_log {
    std::vector<std::uint8_t> bytes;

    static void note(void* self, const sim::wire_byte& b) {
        if (b.is_from_client) static_cast<requests_log*>(self)->bytes.push_back(b.value);
    }
};
} // namespace

TEST_CASE("G28: the numbers of the queue wrap, and the one that has waited longest is next all the same") {
    // Begins after so many exchanges of an earlier part of the program, which were given up.
    const auto requests_after = [](unsigned earlier) {
        tests::wheels_and_lift there;
        tests::wheels_and_lift_program program{there.wire};
        const auto request = modbus::read_frame(1, 0x20A2, 1);
        const response_limits limits{};
        std::array<std::uint8_t, 7> response{};
        for (unsigned i = 0; i < earlier; ++i) {
            modbus::exchange x{request, response, program.on.timing(), limits, priority::planned};
            (void)program.on.step(x, {});
            program.on.abandon(x);
        }
        REQUIRE(program.command(program.wheels, init{}));
        REQUIRE(program.command(program.lift, init{}));
        requests_log log;
        there.wire.set_hook(&requests_log::note, &log);
        program.run(2000);
        return log.bytes;
    };
    const std::vector<std::uint8_t> usual = requests_after(0);
    CHECK(usual.size() > 8 * 200);
    for (unsigned wraps_at = 50; wraps_at < 250; wraps_at += 7) {
        CAPTURE(wraps_at);
        CHECK(requests_after(0xFFFE - wraps_at) == usual);
    }
}

namespace {
inline constexpr poll_plan mute_plan{modbus::timing_at(115200), controlled(wheels_node, unsupervised),
                                     cyclic<yako::status_word>(lift_node, milliseconds(20)),
                                     cyclic<yako::closed_loop::output_polarity>(lift_node, milliseconds(50))};

// No drive responds, and the clock stops some time after the start.
template <class Port> struct mute_rig {
    using line_type = scheduled_line<Port>;
    Port port;
    line_type on{port, modbus::timing_at(115200)};
    zlac8015d::drive<line_type> wheels{on, wheels_node, by_plan};
    bus<mute_plan, line_type, decltype(wheels)> all{on, wheels};
    const std::uint64_t start = port.time;

    void stop_clock(std::uint64_t after) {
        port.most_calls = 200'000'000;
        const std::uint64_t at = start + after;
        port.clock = [at](std::uint64_t t) { return static_cast<std::uint32_t>(t < at ? t : at); };
    }
    // Returns how long it took.
    std::uint64_t run_for(std::uint32_t us) {
        all.run_for(microseconds(us));
        return port.time - start;
    }
};
} // namespace

TEST_CASE_TEMPLATE("G29: blocking calls of a bus end when the clock stops, whatever is in progress", Port,
                   tests::scripted_port, tests::waiting_scripted_port) {
    for (const std::uint32_t after : {0u, 41'000u, 43'000u, 60'000u, 100'000u}) {
        CAPTURE(after);
        if (!waiting_port<Port> && after != 43'000) continue; // each would read the clock millions of times
        mute_rig<Port> r;
        r.stop_clock(after);
        r.run_for(1'000'000);
        CHECK_FALSE(r.port.ran_away);
        const command_status stopped = r.all.run(r.wheels, init{});
        CHECK_FALSE(r.port.ran_away);
        CHECK(stopped.error() == errc::clock_stopped);
        bool was_sent = false;
        for (const auto& f : r.port.frames) was_sent = was_sent || f.data[0] == 1;
        CHECK(stopped.outcome() == (was_sent ? outcome::unknown : outcome::not_sent));
    }
    // The clock stops after the time of `run_for` has passed, while the bus waits for the read in progress.
    bool has_waited = false;
    for (std::uint32_t time = 10'000; time < 300'000 && !has_waited; time += 5000) {
        const std::uint64_t end = mute_rig<Port>{}.run_for(time);
        has_waited = end > time + 20'000;
        if (!has_waited) continue;
        mute_rig<Port> r;
        r.stop_clock(time + 10'000);
        r.run_for(time);
        CHECK_FALSE(r.port.ran_away);
    }
    CHECK(has_waited);
}

namespace {
// Its clock jumps 500 ms ahead between two reads of it.
struct jumping_wire : sim::virtual_line {
    using sim::virtual_line::virtual_line;
    std::uint64_t jumps_at = 0;
    std::uint64_t looks = 0;
    instant now() {
        const instant at = sim::virtual_line::now();
        return ++looks > jumps_at ? at + milliseconds(500) : at;
    }
};
} // namespace

TEST_CASE(
    "G29: commands end and the reads continue, between whichever two reads of the clock it jumps ahead") {
    using line_type = scheduled_line<jumping_wire>;
    for (std::uint64_t looks = 0; looks < 200; ++looks) {
        CAPTURE(looks);
        sim::zlac8015d wheels_model;
        sim::yako_closed_loop lift_model{sim::yako_options{.switches = 2}};
        sim::station<sim::zlac8015d> wheels_station{wheels_model};
        sim::station<sim::yako_closed_loop> lift_station{lift_model};
        jumping_wire wire{115200};
        wire.attach(wheels_station);
        wire.attach(lift_station);
        line_type on{wire, modbus::timing_at(115200)};
        zlac8015d::drive<line_type> wheels{on, wheels_node, by_plan};
        yako::closed_loop::drive<line_type> lift{on, lift_node};
        auto all = make_bus<fast_plan>(on, wheels, lift);
        const auto run = [&](std::uint32_t ms) {
            const std::uint64_t end = wire.time_us() + ms * 1000u;
            while (wire.time_us() < end) {
                const duration idle = all.step();
                wire.wait(idle.us == 0 ? microseconds(1) : idle);
            }
        };
        const auto command = [&](auto& drive, const auto& wanted) {
            REQUIRE(drive.begin(wanted) == errc::ok);
            for (int i = 0; i < 400 && !drive.is_idle(); ++i) run(1);
            return bool{drive.last()};
        };
        wire.jumps_at = ~std::uint64_t{0};
        REQUIRE(command(lift, init{}));
        REQUIRE(command(wheels, init{}));
        REQUIRE(command(wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
        run(20);
        const velocity slow{30 * r_per_min, 30 * r_per_min};
        wire.jumps_at = wire.looks + looks;
        for (int i = 0; i < 10; ++i) {
            if (wheels.is_idle()) (void)wheels.begin(slow); // refused if the last response seems too long ago
            run(2);
        }
        run(1000);
        CHECK(wheels.is_idle());
        CHECK(wheels.feedback(milliseconds(100)));
        CHECK(lift.feedback(milliseconds(100)));
        CHECK(all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(150)));
        CHECK(all.latest<yako::closed_loop::output_polarity>(lift_node, milliseconds(150)));
        const std::uint32_t read = all.count(0);
        run(500);
        CHECK(all.count(0) - read >= 9); // every 50 ms
    }
}

} // namespace bus_clock_tests
