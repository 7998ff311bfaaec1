// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The word order in which a bus reads 32-bit values: that of a facade on the same bus, or one that the
// program set; never one that may have changed since.
#include <doctest/doctest.h>

#include <servobus/client/stepped_write.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/sim/c630s.hpp>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/loop_bound.hpp>
#include <tests/support/scripted_port.hpp>

namespace bus_word_order_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

struct rig : tests::wheels_and_lift, tests::wheels_and_lift_program {
    static constexpr std::int32_t place = 0x12345;
    unsigned wrong = 0;
    unsigned right = 0;

    rig() : wheels_and_lift_program{wire} {}

    // Runs a command and checks the lift's position in each loop iteration.
    template <class Wanted> command_status watched(const Wanted& wanted) {
        if (const command_status begun = lift.begin(wanted); !begun) return begun;
        for (tests::loop_bound left{"the end of a command"}; !lift.is_idle(); left.use()) look();
        return lift.last();
    }
    void watch(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) look();
    }

  private:
    void look() {
        turn();
        const auto seen = all.latest<yako::actual_position>(tests::lift_node, milliseconds(200));
        if (!seen) return;
        ++(seen->count() == place ? right : wrong);
    }
};

constexpr auto servo_node = responds_within(node<c630s::device>{1}, milliseconds(30));
constexpr poll_plan servo_plan{modbus::timing_at(57600),
                               controlled(servo_node, {.command_timeout = no_command_timeout}),
                               cyclic<c630s::feedback_pulses>(servo_node, milliseconds(50)),
                               cyclic<c630s::actual_speed>(servo_node, milliseconds(50))};

constexpr auto table_node = responds_within(node<yako::closed_loop::device>{7}, milliseconds(30));
constexpr poll_plan table_plan{modbus::timing_at(115200),
                               cyclic<yako::actual_position>(table_node, milliseconds(100)),
                               own_requests(table_node, milliseconds(200), 2)};

} // namespace

TEST_CASE("G22: a bus reads a node in the word order of its facade, and delivers no value in another") {
    rig r;
    r.run(200);
    CHECK(r.all.latest<yako::actual_position>(tests::lift_node, milliseconds(200)).error() ==
          errc::needs_init);
    REQUIRE(r.command(r.lift, init{}));
    REQUIRE(r.command(r.lift, enable{}));
    REQUIRE(r.command(r.lift, declare_position{rig::place * pulse}));
    r.run(200);
    // The change falls at each moment between two reads.
    for (std::uint32_t i = 0; i < 60; ++i) {
        CAPTURE(i);
        r.run(300 + i);
        r.right = 0;
        const auto other =
            i % 2 == 0 ? yako::word_order_setting::low_first : yako::word_order_setting::high_first;
        REQUIRE(r.watched(yako::set_word_order{other}));
        r.watch(150);
        CHECK(r.right > 100);
        REQUIRE(r.wrong == 0);
    }
}

TEST_CASE("G21, G22: after a change of the word order with an unknown outcome no value is delivered until "
          "`init` has read it") {
    rig r;
    REQUIRE(r.command(r.lift, init{}));
    REQUIRE(r.command(r.lift, enable{}));
    REQUIRE(r.command(r.lift, declare_position{rig::place * pulse}));
    r.run(200);
    REQUIRE(r.lift.begin(yako::set_word_order{yako::word_order_setting::low_first}) == errc::ok);
    while (r.lift_model.peek(yako::pair_word_order.address) == 0) r.turn();
    r.wire.set_connected(1, false); // its response is lost
    for (tests::loop_bound left{"the end of a command"}; !r.lift.is_idle(); left.use()) r.turn();
    CHECK(r.lift.state() == yako::drive_state::needs_init);
    r.wire.set_connected(1, true);
    r.watch(3000);
    CHECK(r.right + r.wrong == 0);
    REQUIRE(r.watched(init{}));
    r.watch(300);
    CHECK(r.right > 100);
    CHECK(r.wrong == 0);
}

TEST_CASE("G22: the word order is unknown while a command that may reset it, or changes the address, is in "
          "progress") {
    rig r;
    REQUIRE(r.command(r.lift, init{}));
    REQUIRE(r.lift.current_word_order() == word_order::high_first);
    SUBCASE("a factory reset") {
        REQUIRE(r.lift.begin(yako::factory_reset{yako::sole_drive_on_the_line{}}) == errc::ok);
    }
    SUBCASE("another address") {
        REQUIRE(r.lift.begin(yako::set_node_address{9, yako::sole_drive_on_the_line{}}) == errc::ok);
    }
    CHECK(r.lift.current_word_order() == word_order::unknown);
    r.run(20);
    CHECK_FALSE(r.all.latest<yako::actual_position>(tests::lift_node, milliseconds(1000)));
}

TEST_CASE("the word order of a facade replaces the one that was set on the bus") {
    rig r;
    r.all.set_word_order(2, word_order::low_first);
    REQUIRE(r.command(r.lift, init{}));
    REQUIRE(r.command(r.lift, enable{}));
    REQUIRE(r.command(r.lift, declare_position{rig::place * pulse}));
    r.watch(300);
    CHECK(r.wrong == 0);
    CHECK(r.right > 100);
}

TEST_CASE("G22: a 32-bit read of a C630S delivers no value while its word order is unknown") {
    sim::c630s servo;
    sim::station<sim::c630s> station{servo};
    sim::virtual_line wire{57600};
    wire.attach(station);
    scheduled_line on{wire, modbus::timing_at(57600)};
    c630s::drive<scheduled_line<sim::virtual_line>> drive{on, servo_node};
    auto all = make_bus<servo_plan>(on, drive);
    all.run_for(milliseconds(300));
    CHECK(all.latest<c630s::feedback_pulses>(servo_node, milliseconds(200)).error() == errc::needs_init);
    REQUIRE(all.run(drive, init{}));
    all.run_for(milliseconds(200));
    CHECK(all.latest<c630s::feedback_pulses>(servo_node, milliseconds(200)));
    CHECK(all.latest<c630s::actual_speed>(servo_node, milliseconds(200)));
    all.set_word_order(1, word_order::unknown); // that of the facade counts
    CHECK(all.latest<c630s::feedback_pulses>(servo_node, milliseconds(200)));

    // It may come back with another word order.
    REQUIRE(drive.begin(c630s::factory_reset{c630s::sole_drive_on_the_line{}}) == errc::ok);
    all.run_for(milliseconds(1));
    CHECK_FALSE(all.latest<c630s::feedback_pulses>(servo_node, milliseconds(200)));
}

TEST_CASE("G22: a bus delivers no value in the word order before a write of its register beside the bus") {
    tests::scripted_port port;
    tests::register_file table;
    table.words = {{0x000A, 0}, {0x000B, 5}, {0x0019, 0}};
    port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) {
        if (f.data[0] != 7) return;
        p.say(500, table.response_to(f.data));
        if (table.words[0x0019] == 1) table.words[0x000A] = 5, table.words[0x000B] = 0;
    };
    scheduled_line on{port, modbus::timing_at(115200)};
    auto all = make_bus<table_plan>(on);
    client own{on, table_node};
    stepped_write<decltype(own), yako::pair_word_order> put{own};
    const auto watch = [&](unsigned ms) {
        unsigned right = 0;
        for (const auto end = port.time + ms * 1000u; port.time < end; port.time += 100) {
            (void)all.step();
            (void)put.step();
            const auto seen = all.latest<yako::actual_position>(milliseconds(300));
            if (!seen) continue;
            REQUIRE(seen->count() == 5);
            ++right;
        }
        return right;
    };
    CHECK(watch(300) == 0);
    all.set_word_order(7, word_order::high_first);
    CHECK(watch(500) > 1000);
    REQUIRE(put.begin(yako::word_order_setting::low_first) == errc::ok);
    (void)watch(1000);
    CHECK(put.status());
    CHECK(table.words[0x0019] == 1);
    CHECK(all.latest<yako::actual_position>(table_node, milliseconds(300)).error() == errc::needs_word_order);
    all.set_word_order(7, word_order::low_first);
    CHECK(watch(500) > 1000);
    // The program was wrong, and corrects itself.
    all.set_word_order(7, word_order::high_first);
    all.run_for(milliseconds(500));
    REQUIRE(all.latest<yako::actual_position>(table_node, milliseconds(300))->count() != 5);
    all.set_word_order(7, word_order::low_first);
    CHECK(watch(500) > 1000);
}

namespace {
constexpr auto other_node = responds_within(node<yako::closed_loop::device>{8}, milliseconds(30));
constexpr poll_plan two{modbus::timing_at(115200),
                        cyclic<yako::actual_position>(table_node, milliseconds(100)),
                        cyclic<yako::actual_position>(other_node, milliseconds(100))};
} // namespace

TEST_CASE("G22: the word order of one node is not that of another") {
    tests::scripted_port port;
    port.device = [](tests::scripted_port& p, const tests::sent_frame& f) {
        p.say(500, tests::read_response(f.data[0], {0, 5}));
    };
    scheduled_line on{port, modbus::timing_at(115200)};
    auto all = make_bus<two>(on);
    all.set_word_order(8, word_order::high_first);
    all.run_for(milliseconds(500));
    CHECK(all.latest<yako::actual_position>(table_node, milliseconds(300)).error() == errc::needs_word_order);
    REQUIRE(all.latest<yako::actual_position>(other_node, milliseconds(300)));
    CHECK(all.latest<yako::actual_position>(other_node, milliseconds(300))->count() == 5);
    all.set_word_order(7, word_order::low_first);
    all.run_for(milliseconds(500));
    CHECK(all.latest<yako::actual_position>(table_node, milliseconds(300))->count() == 5 << 16);
    CHECK(all.latest<yako::actual_position>(other_node, milliseconds(300))->count() == 5);
}

} // namespace bus_word_order_tests
