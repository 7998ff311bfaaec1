// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program that pauses at any moment, a drive that restarts while a bus continues, a lost port that only one
// user of the line has noticed: which frame the wheels get first, and whose drive state is invalidated.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/client/client.hpp>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/loop_bound.hpp>

namespace bus_standstill_tests {

using namespace servobus;
using namespace servobus::units;
using zlac8015d::operating_mode;

namespace {

constexpr auto zero_speeds = modbus::write_frame(1, 0x2088, std::array<std::uint16_t, 2>{0, 0});
constexpr auto quick_stop_frame = modbus::write_frame(1, 0x200E, 5);
constexpr auto disable_frame = modbus::write_frame(1, 0x200E, 7);

// Records the requests to the wheels.
struct ear {
    std::vector<std::vector<std::uint8_t>> requests;
    std::vector<std::uint8_t> open;

    static void note(void* self, const sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& e = *static_cast<ear*>(self);
        e.open.push_back(b.value);
        if (e.open.size() != modbus::request_length(e.open)) return;
        if (e.open[0] == 1) e.requests.push_back(e.open);
        e.open.clear();
    }
    // No frame, or a stop first.
    bool began_with_a_stop() const {
        return requests.empty() || same_bytes(requests[0], zero_speeds) ||
               same_bytes(requests[0], disable_frame);
    }
};

struct rig : tests::wheels_and_lift, tests::wheels_and_lift_program, ear {
    rig() : wheels_and_lift_program{wire} { wire.set_hook(&ear::note, static_cast<ear*>(this)); }

    void enable_wheels(operating_mode mode = operating_mode::velocity) {
        REQUIRE(command(wheels, init{}));
        REQUIRE(command(lift, init{}));
        REQUIRE(command(wheels, zlac8015d::enable_in{checked(mode)}));
    }
    void drive_wheels() {
        enable_wheels();
        REQUIRE(command(wheels, velocity{30 * r_per_min, 30 * r_per_min}));
        run(300);
        REQUIRE_FALSE(wheels_model.stands_still());
    }
    // The program pauses for so long that the drive's watchdog stops the wheels.
    void stand_still() {
        wire.pass(milliseconds(4000));
        REQUIRE(wheels_model.in_watchdog_stop());
        place_ = wheels_model.left().position;
        requests.clear();
    }
    void check_that_nothing_went_on(std::uint32_t ms) {
        run(ms);
        CHECK(began_with_a_stop());
        CHECK(wheels_model.left().position == place_);
        CHECK(wheels.state() == zlac8015d::drive_state::needs_init);
        CHECK(command(wheels, init{}));
        CHECK(began_with_a_stop());
        CHECK_FALSE(requests.empty());
        CHECK(wheels_model.left().position == place_);
    }

  private:
    std::int64_t place_ = 0;
};

// A facade without a bus, whose application reads feedback as often as it can.
struct facade_alone : ear {
    using line_type = scheduled_line<sim::virtual_line>;
    sim::zlac8015d model;
    sim::station<sim::zlac8015d> station{model};
    sim::virtual_line wire{115200};
    line_type on{wire, modbus::timing_at(115200)};
    zlac8015d::drive<line_type> wheels{on, tests::wheels_node, unsupervised};

    facade_alone() {
        wire.attach(station);
        wire.set_hook(&ear::note, static_cast<ear*>(this));
    }
    void turn() {
        const duration idle = wheels.step();
        wire.wait(idle.us == 0 ? microseconds(1) : idle);
    }
    void look_for(unsigned turns) {
        for (unsigned i = 0; i < turns; ++i) {
            if (wheels.is_idle()) (void)wheels.begin(read_feedback{});
            turn();
        }
    }
    template <class Wanted> void command(const Wanted& wanted) {
        REQUIRE(wheels.begin(wanted) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !wheels.is_idle(); left.use()) turn();
        REQUIRE(wheels.last());
    }
};

} // namespace

TEST_CASE("S3, G20: a read that waits for the line, or is being sent, does not let stopped wheels move on") {
    for (unsigned turns = 0; turns < 240; ++turns) {
        CAPTURE(turns);
        rig r;
        r.drive_wheels();
        for (unsigned i = 0; i < turns; ++i) r.turn();
        r.stand_still();
        r.check_that_nothing_went_on(300);
    }
}

TEST_CASE("G21: after a pause in which the wheels' watchdog has struck their values count no more, before "
          "the next step") {
    rig r;
    r.drive_wheels();
    r.run(1000);
    REQUIRE(r.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(500)));
    r.stand_still();
    CHECK(r.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(10'000)).error() ==
          errc::needs_init);
}

TEST_CASE(
    "S3, G20: the frame of a command does not let stopped wheels move on, whenever the program paused") {
    for (unsigned turns = 0; turns < 240; ++turns) {
        CAPTURE(turns);
        rig r;
        r.drive_wheels();
        for (unsigned i = 0; i < turns; ++i) r.turn();
        REQUIRE(r.wheels.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::ok);
        for (unsigned i = 0; i < turns % 13 && !r.wheels.is_idle(); ++i) r.turn();
        r.stand_still();
        r.check_that_nothing_went_on(300);
    }
}

TEST_CASE("S3, G20: without a bus, a response that arrived while the program paused does not let stopped "
          "wheels move on") {
    for (unsigned turns = 0; turns < 60; ++turns) {
        CAPTURE(turns);
        facade_alone f;
        f.command(init{});
        f.command(enable{});
        f.command(velocity{30 * r_per_min, 30 * r_per_min});
        f.look_for(600);
        for (tests::loop_bound left{"the end of a command"}; !f.wheels.is_idle(); left.use()) f.turn();
        REQUIRE(f.wheels.begin(read_feedback{}) == errc::ok);
        for (unsigned i = 0; i < turns && !f.wheels.is_idle(); ++i) f.turn();
        f.wire.pass(milliseconds(4000));
        REQUIRE(f.model.in_watchdog_stop());
        const auto place = f.model.left().position;
        f.look_for(2000);
        CHECK(f.model.left().position == place);
        CHECK(f.wheels.state() == zlac8015d::drive_state::needs_init);
    }
}

TEST_CASE("S3: the read that follows a start without a response is not the first frame after a pause") {
    for (unsigned turns = 0; turns < 400; turns += 5) {
        CAPTURE(turns);
        facade_alone f;
        f.command(init{});
        f.command(zlac8015d::enable_in{operating_mode::relative_position});
        REQUIRE(f.wheels.begin(move_by{40000 * pulse, 40000 * pulse}) == errc::ok);
        for (tests::loop_bound left{"a start"}; f.model.starts() == 0; left.use()) f.turn();
        f.wire.faults().lost_response = 1000;
        for (unsigned i = 0; i < turns; ++i) f.turn();
        CHECK((f.wire.struck() != 0) == (turns != 0));
        f.wire.faults() = {};
        f.wire.pass(milliseconds(4000));
        if (!f.model.in_watchdog_stop()) continue;
        const auto place = f.model.left().position;
        for (int i = 0; i < 2000; ++i) f.turn();
        CHECK(f.model.left().position == place);
        CHECK(f.wheels.state() == zlac8015d::drive_state::needs_init);
    }
}

TEST_CASE("S3: after a watchdog write with an unknown outcome the shorter of both times counts") {
    struct times {
        int before; // 0: the factory setting, one second
        int ordered;
        std::uint32_t counts;
    };
    for (const times t : {times{20'000, 500, 500}, times{500, 20'000, 500}, times{0, 2000, 1000}}) {
        CAPTURE(t.before);
        CAPTURE(t.ordered);
        rig r;
        r.drive_wheels();
        if (t.before != 0) { REQUIRE(r.command(r.wheels, zlac8015d::watchdog{t.before * millisecond})); }
        REQUIRE(r.wheels.begin(zlac8015d::watchdog{t.ordered * millisecond}) == errc::ok);
        for (tests::loop_bound left{"the write"}; r.wheels_model.peek(0x2000) != t.ordered; left.use())
            r.turn();
        r.wire.faults().lost_response = 1000;
        for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
        CHECK(r.wire.struck() != 0);
        r.wire.faults() = {};
        CHECK(r.wheels.last().outcome() == outcome::unknown);
        r.run(100);
        REQUIRE(r.wheels.state() == zlac8015d::drive_state::needs_init);
        REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
        r.requests.clear();
        r.wire.pass(milliseconds(t.counts));
        REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
        CHECK(same_bytes(r.requests.at(0), zero_speeds)); // the watchdog may have expired
    }
    rig r; // not sent: the old time counts
    r.drive_wheels();
    r.wire.unplug();
    CHECK(r.command(r.wheels, zlac8015d::watchdog{500 * millisecond}).outcome() == outcome::not_sent);
}

TEST_CASE("S3: a stop that is repeated after a pause begins with a stop frame, in every mode") {
    const auto scene = [](operating_mode mode, const auto& wanted) {
        CAPTURE(mode);
        rig r;
        r.enable_wheels(mode);
        if (mode == operating_mode::torque) {
            REQUIRE(r.command(r.wheels, zlac8015d::torque{500 * milliampere, 500 * milliampere}));
        } else {
            REQUIRE(r.command(r.wheels, velocity{30 * r_per_min, 30 * r_per_min}));
        }
        r.run(300);
        r.wire.set_connected(0, false);
        CHECK_FALSE(r.command(r.wheels, wanted));
        r.run(3000);
        for (tests::loop_bound left{"a free line"}; !r.on.is_free(); left.use()) r.turn();
        r.requests.clear();
        r.wire.set_connected(0, true);
        r.run(3000);
        CHECK(r.began_with_a_stop());
        CHECK(r.wheels_model.stands_still());
        r.requests.clear();
        r.run(1000); // confirmed: no further stops
        for (const auto& request : r.requests) CHECK(modbus::is_read(request[1]));
    };
    scene(operating_mode::velocity, quick_stop{});
    scene(operating_mode::velocity, halt{});
    scene(operating_mode::torque, halt{});
    scene(operating_mode::velocity, disable{});
}

TEST_CASE("G21: a bus detects the restart of a drive that it reads, however soon the drive responds again") {
    for (const std::uint32_t gone_ms : {200u, 800u, 1500u, 4000u}) {
        for (const bool is_watched : {false, true}) {
            CAPTURE(gone_ms);
            CAPTURE(is_watched);
            rig r;
            r.drive_wheels();
            REQUIRE(r.command(r.wheels, zlac8015d::watchdog{5000 * millisecond}));
            if (is_watched) r.wheels.set_command_timeout(milliseconds(60'000));
            r.wire.set_connected(0, false);
            r.wheels_model.power_cycle();
            r.run(gone_ms);
            r.wire.set_connected(0, true);
            r.run(2500);
            CHECK(r.wheels.state() == zlac8015d::drive_state::needs_init);
            CHECK(r.command(r.wheels, velocity{20 * r_per_min, 20 * r_per_min}).error() == errc::needs_init);
        }
    }
}

TEST_CASE("G21: after a lost response a facade reads the drive again, and its state stays valid if nothing "
          "has changed") {
    rig r;
    r.drive_wheels();
    REQUIRE(r.command(r.lift, enable{}));
    r.requests.clear();
    r.wire.faults().lost_response = 1000;
    for (tests::loop_bound left{"a request"}; r.requests.empty(); left.use()) r.turn();
    r.run(5);
    CHECK(r.wire.struck() != 0);
    r.wire.faults() = {};
    r.requests.clear();
    r.run(500);
    bool has_looked = false;
    for (const auto& request : r.requests) {
        CHECK(modbus::is_read(request[1]));
        has_looked = has_looked || load_word(request, 2) == 0x200D; // the witness
    }
    CHECK(has_looked);
    CHECK(r.wheels.state() == zlac8015d::drive_state::enabled);
    CHECK(r.lift.state() == yako::drive_state::enabled);
}

TEST_CASE("G21: a lost port invalidates all cached settings, whichever user of the line got the error") {
    for (unsigned turns = 0; turns < 80; ++turns) {
        CAPTURE(turns);
        rig r;
        r.drive_wheels();
        REQUIRE(r.command(r.lift, enable{}));
        r.run(100 + turns);
        REQUIRE(r.wheels.begin(velocity{20 * r_per_min, 20 * r_per_min}) == errc::ok);
        for (unsigned i = 0; i < turns; ++i) r.turn();
        r.wire.unplug();
        const std::uint8_t losses = r.on.epoch(1).events.losses;
        for (tests::loop_bound left{"a loss"}; r.on.epoch(1).events.losses == losses; left.use()) r.turn();
        r.wire.plug(); // opened again before another user of the line has noticed
        if (turns % 2 != 0) { REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok); }
        r.run(400);
        CHECK(r.wheels.state() == zlac8015d::drive_state::needs_init);
        CHECK(r.lift.state() == yako::drive_state::needs_init);
        CHECK(r.all.latest<yako::actual_position>(tests::lift_node, milliseconds(200)).error() ==
              errc::needs_init);
        CHECK(r.command(r.lift, move_by{100 * pulse}).error() == errc::needs_init);
    }
}

TEST_CASE("G21, G25: a stop replaces a command after a client has found the port lost") {
    unsigned seen = 0;
    for (unsigned turns = 0; turns < 200; ++turns) {
        CAPTURE(turns);
        rig r;
        r.drive_wheels();
        r.run(turns % 20); // a different place in the plan
        REQUIRE(r.wheels.begin(velocity{20 * r_per_min, 20 * r_per_min}) == errc::ok);
        for (unsigned i = 0; i < turns / 20 && !r.wheels.is_idle(); ++i) r.turn();
        if (r.wheels.is_idle() || !r.on.is_free()) continue;
        r.wire.unplug();
        CHECK(client{r.on, tests::lift_node}.read<yako::status_word>().error() == errc::port_lost);
        r.wire.plug();
        ++seen;
        r.requests.clear();
        REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
        REQUIRE_FALSE(r.requests.empty());
        CHECK(same_bytes(r.requests[0], zero_speeds)); // the drive's watchdog may have expired
        CHECK(same_bytes(r.requests.at(1), quick_stop_frame));
        CHECK(r.wheels_model.stands_still());
        CHECK(r.wheels.state() == zlac8015d::drive_state::needs_init);
    }
    CHECK(seen > 0);
}

TEST_CASE("G20: a stale value does not become fresh again when the clock wraps") {
    rig r;
    r.drive_wheels();
    r.wire.set_connected(0, false);
    r.wire.set_connected(1, false);
    r.run(2000);
    for (unsigned s = 0; s < 2 * 4295; s += 2) {
        r.wire.pass(milliseconds(2000));
        r.turn();
        REQUIRE_FALSE(r.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(1000)));
        REQUIRE_FALSE(r.all.latest<yako::closed_loop::output_polarity>(tests::lift_node, milliseconds(1000)));
        REQUIRE_FALSE(r.wheels.feedback(milliseconds(1000)));
        REQUIRE_FALSE(r.lift.feedback(milliseconds(1000)));
    }
}

TEST_CASE(
    "a bus that was not stepped for longer than its clock takes to wrap continues its reads immediately") {
    for (const std::uint32_t minutes : {30u, 40u, 60u, 75u}) {
        CAPTURE(minutes);
        rig r;
        r.drive_wheels();
        for (std::uint32_t s = 0; s < 60 * minutes; ++s) r.wire.pass(milliseconds(1000));
        r.run(2000);
        REQUIRE(r.command(r.wheels, init{}));
        r.run(100);
        const std::uint32_t before[] = {r.all.count(0), r.all.count(1), r.all.count(2)};
        r.run(3000);
        CHECK(r.all.count(0) - before[0] >= 59);
        CHECK(r.all.count(1) - before[1] >= 49);
        CHECK(r.all.count(2) - before[2] >= 29);
    }
}

TEST_CASE("G28: repeated commands to absent wheels leave the lift one read after each of their stops") {
    rig r;
    r.wire.set_connected(0, false);
    REQUIRE(r.command(r.lift, init{}));
    const auto run_and_try = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (r.wire.time_us() < end) {
            r.turn();
            if (r.wheels.is_idle()) (void)r.wheels.begin(init{});
        }
    };
    run_and_try(5000);
    const std::uint32_t before = r.all.count(1) + r.all.count(2);
    r.requests.clear();
    run_and_try(30'000);
    CHECK(r.requests.size() > 200);
    // Three frames of each `init` are stop frames, which go ahead of reads.
    CHECK(3 * (r.all.count(1) + r.all.count(2) - before) >= r.requests.size());
}

namespace {
constexpr poll_plan lift_without_facade{modbus::timing_at(115200),
                                        cyclic<yako::status_word>(tests::lift_node, milliseconds(30)),
                                        cyclic<yako::actual_position>(tests::lift_node, milliseconds(50))};

/// A bus on which the program has set the lift's word order, and which delivers its 32-bit values.
struct told_bus {
    using line_type = scheduled_line<sim::virtual_line>;

    tests::wheels_and_lift machine{};
    line_type on{machine.wire, modbus::timing_at(115200)};
    bus<lift_without_facade, line_type> all{on};

    told_bus() {
        all.set_word_order(2, word_order::high_first);
        all.run_for(milliseconds(300));
        REQUIRE(all.latest<yako::actual_position>(tests::lift_node, milliseconds(1000)));
    }
};
} // namespace

TEST_CASE("G21, G22: a read without a response invalidates the word order that was set, for all reads of the "
          "node") {
    told_bus r;
    auto& all = r.all;
    r.machine.wire.faults().lost_response = 1000;
    const std::uint32_t asked = r.machine.wire.requests();
    for (tests::loop_bound left{"a request"}; r.machine.wire.requests() == asked; left.use())
        all.run_for(milliseconds(1));
    CHECK(r.machine.wire.struck() != 0);
    r.machine.wire.faults() = {};
    all.run_for(milliseconds(200));
    CHECK_FALSE(all.is_absent(2));
    CHECK(all.latest<yako::status_word>(tests::lift_node, milliseconds(100)));
    CHECK(all.latest<yako::actual_position>(tests::lift_node, milliseconds(10'000)).error() ==
          errc::needs_word_order);
}

TEST_CASE("G21, G22: a word order that is set again after a lost port stays valid") {
    told_bus r;
    auto& all = r.all;
    r.machine.wire.unplug();
    all.run_for(milliseconds(30));
    r.machine.wire.plug();
    all.run_for(milliseconds(2000));
    CHECK(all.latest<yako::status_word>(tests::lift_node, milliseconds(100)));
    CHECK(all.latest<yako::actual_position>(tests::lift_node, milliseconds(10'000)).error() ==
          errc::needs_word_order);
    all.set_word_order(2, word_order::high_first);
    all.run_for(milliseconds(200));
    CHECK(all.latest<yako::actual_position>(tests::lift_node, milliseconds(200)));
}

TEST_CASE("G28: a drive that has executed a command is read as often as any other, also without a watchdog "
          "of its own") {
    rig r;
    REQUIRE(r.command(r.lift, init{}));
    r.wire.set_connected(1, false);
    r.run(2000);
    REQUIRE(r.lift.is_absent());
    r.wire.set_connected(1, true);
    REQUIRE(r.command(r.lift, init{}));
    r.turn();
    CHECK_FALSE(r.lift.is_absent());
    r.run(100);
    CHECK(r.lift.feedback(milliseconds(70)));
}

} // namespace bus_standstill_tests
