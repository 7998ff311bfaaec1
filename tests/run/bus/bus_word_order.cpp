// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// In which order of words a bus reads 32-bit values: a facade's on the same bus, or what it was told; never
// one that may have changed since.
#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/sim/c630s.hpp>

#include <tests/support/wheels_and_lift.hpp>

using namespace servobus;
using namespace servobus::units;

namespace {

struct rig : tests::wheels_and_lift, tests::wheels_and_lift_program {
    static constexpr std::int32_t place = 0x12345;
    unsigned wrong = 0;
    unsigned right = 0;

    rig() : wheels_and_lift_program{wire} {}

    // Looks at the lift's position at every turn.
    template <class Wanted> report watched(const Wanted& wanted) {
        if (const errc refusal = lift.begin(wanted); refusal != errc::ok) return report::not_sent(refusal);
        while (!lift.is_idle()) look();
        return lift.last();
    }
    void watch(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) look();
    }

  private:
    void look() {
        turn();
        const auto seen = all.latest<2>(milliseconds(200));
        if (!seen) return;
        ++(seen->get<yako::actual_position>().count() == place ? right : wrong);
    }
};

constexpr auto servo_node = tests::prompt<c630s::device>(1);
constexpr poll_plan servo_plan{modbus::timing_at(57600), controlled_drives{servo_node},
                               cyclic<c630s::feedback_pulses>(servo_node, milliseconds(50)),
                               cyclic<c630s::actual_speed>(servo_node, milliseconds(50))};

} // namespace

TEST_CASE("G22: the order that a facade knows is that of its node's reads, and no value is read in another") {
    rig r;
    r.run(200);
    CHECK(r.all.latest<2>(milliseconds(200)).error() == errc::needs_word_order);
    CHECK(r.all.latest<1>(milliseconds(200))); // 16 bits have none
    REQUIRE(r.order(r.lift, yako::init{}));
    REQUIRE(r.order(r.lift, yako::enable{}));
    REQUIRE(r.order(r.lift, yako::declare_position{rig::place * pulse}));
    r.run(200);
    // Whenever the change falls between two reads.
    for (std::uint32_t i = 0; i < 60; ++i) {
        CAPTURE(i);
        r.run(300 + i);
        r.right = 0;
        const auto other = i % 2 == 0 ? yako::pair_order::low_first : yako::pair_order::high_first;
        REQUIRE(r.watched(yako::set_word_order{other}));
        r.watch(150);
        CHECK(r.right > 100);
        REQUIRE(r.wrong == 0);
    }
}

TEST_CASE("G21, G22: a change of the order that ends unknown leaves no value until `init` has read it") {
    rig r;
    REQUIRE(r.order(r.lift, yako::init{}));
    REQUIRE(r.order(r.lift, yako::enable{}));
    REQUIRE(r.order(r.lift, yako::declare_position{rig::place * pulse}));
    r.run(200);
    REQUIRE(r.lift.begin(yako::set_word_order{yako::pair_order::low_first}) == errc::ok);
    while (r.lift_model.peek(yako::pair_word_order.address) == 0) r.turn();
    r.wire.set_connected(1, false); // its answer is lost
    while (!r.lift.is_idle()) r.turn();
    CHECK(r.lift.state() == yako::drive_state::needs_init);
    r.wire.set_connected(1, true);
    r.watch(3000);
    CHECK_FALSE(r.all.is_absent(2));
    CHECK(r.right + r.wrong == 0);
    REQUIRE(r.watched(yako::init{}));
    r.watch(300);
    CHECK(r.right > 100);
    CHECK(r.wrong == 0);
}

TEST_CASE("G22: what may reset the order, or move the drive, leaves none known while it is under way") {
    rig r;
    REQUIRE(r.order(r.lift, yako::init{}));
    REQUIRE(r.lift.order_of_pairs() == word_order::high_first);
    SUBCASE("a factory reset") {
        REQUIRE(r.lift.begin(yako::factory_reset{yako::sole_drive_on_the_line{}}) == errc::ok);
    }
    SUBCASE("another address") {
        REQUIRE(r.lift.begin(yako::set_node_address{9, yako::sole_drive_on_the_line{}}) == errc::ok);
    }
    CHECK(r.lift.order_of_pairs() == word_order::unknown);
    r.run(20);
    CHECK(r.all.latest<2>(milliseconds(1000)).error() == errc::needs_word_order);
}

TEST_CASE("what a facade knows takes the place of what the bus was told") {
    rig r;
    r.all.set_order(2, word_order::low_first);
    r.run(200);
    CHECK(r.all.latest<2>(milliseconds(200)));
    REQUIRE(r.order(r.lift, yako::init{}));
    REQUIRE(r.order(r.lift, yako::enable{}));
    REQUIRE(r.order(r.lift, yako::declare_position{rig::place * pulse}));
    r.watch(300);
    CHECK(r.wrong == 0);
    CHECK(r.right > 100);
}

TEST_CASE("G22: a C630S, whose first read of the plan has 32 bits") {
    sim::c630s servo;
    sim::station<sim::c630s> station{servo};
    sim::virtual_line wire{57600};
    wire.attach(station);
    line on{wire, modbus::timing_at(57600)};
    c630s::drive<line<sim::virtual_line>> drive{on, servo_node};
    bus<servo_plan, line<sim::virtual_line>> all{on};
    all.run_for(milliseconds(300), drive);
    CHECK(all.latest<0>(milliseconds(200)).error() == errc::needs_word_order);
    CHECK(all.latest<1>(milliseconds(200)));
    all.set_order(1, word_order::low_first);
    CHECK(all.latest<0>(milliseconds(200)).error() == errc::timeout);
    all.run_for(milliseconds(100), drive);
    CHECK(all.latest<0>(milliseconds(200)));
    all.set_order(1, word_order::unknown);
    CHECK(all.latest<0>(milliseconds(200)).error() == errc::needs_word_order);
    REQUIRE(all.run(drive, c630s::init{}));
    all.run_for(milliseconds(100), drive);
    CHECK(all.latest<0>(milliseconds(200)));

    // It may come back with another order.
    REQUIRE(drive.begin(c630s::factory_reset{c630s::sole_drive_on_the_line{}}) == errc::ok);
    all.run_for(milliseconds(1), drive);
    CHECK(all.latest<0>(milliseconds(200)).error() == errc::needs_word_order);
}
