// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stepper whose word order was set and not saved restarts, and only a lost response shows it. No value is
// assembled in the word order that the restart has reset.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/client/client.hpp>

#include <tests/support/driven_wheels_and_lift.hpp>

namespace restart_word_order_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

using tests::lift_node;
constexpr poll_plan seldom{
    modbus::timing_at(115200),
    controlled(lift_node, {.feedback = milliseconds(200), .command_timeout = no_command_timeout}),
    cyclic<yako::positive_software_limit>(lift_node, milliseconds(500))};

struct rig {
    using line_type = scheduled_line<sim::virtual_line>;
    static constexpr std::int32_t end = 70'000;

    sim::yako_closed_loop model{sim::yako_options{.switches = 2}};
    sim::station<sim::yako_closed_loop> station{model};
    sim::virtual_line wire{115200};
    line_type on{wire, modbus::timing_at(115200)};
    yako::closed_loop::drive<line_type> lift{on, lift_node, servobus::by_plan};
    bus<seldom, line_type, decltype(lift)> all{on, lift};

    rig() {
        wire.attach(station);
        REQUIRE(command(init{}));
        REQUIRE(command(limit_travel{-end * pulse, end * pulse}));
        REQUIRE(command(yako::save{}));
        run(300);
        REQUIRE(command(yako::set_word_order{yako::word_order_setting::low_first})); // until the power goes
        run(1200);
        REQUIRE(limit() == end);
    }
    rig(const rig&) = delete;

    void turn() {
        const duration idle = all.step();
        wire.wait(idle.us == 0 ? microseconds(1) : idle);
    }
    void run(std::uint32_t ms) {
        const std::uint64_t until = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < until) turn();
    }
    template <class Wanted> command_status command(const Wanted& wanted) {
        REQUIRE(lift.begin(wanted) == errc::ok);
        while (!lift.is_idle()) turn();
        return lift.last();
    }
    std::int32_t limit() const {
        const auto seen = all.latest<yako::positive_software_limit>(lift_node, milliseconds(600));
        return seen ? seen->count() : 0;
    }
};

} // namespace

TEST_CASE("G21, G22: a bus gives no 32-bit value in the old word order after a drive restarted while one of "
          "the bus's reads was lost") {
    for (std::uint32_t gone_ms = 600; gone_ms <= 2000; gone_ms += 100) { // the bus reads twice a second
        for (const bool is_enabled : {false, true}) {
            CAPTURE(gone_ms);
            CAPTURE(is_enabled);
            rig r;
            if (is_enabled) REQUIRE(r.command(enable{}));
            r.wire.set_connected(0, false);
            r.model.power_cycle();
            r.run(gone_ms);
            r.wire.set_connected(0, true);
            for (const std::uint64_t until = r.wire.time_us() + 5'000'000; r.wire.time_us() < until;) {
                r.turn();
                const std::int32_t limit = r.limit();
                if (limit != 0) REQUIRE(limit == rig::end);
            }
            CHECK(r.lift.state() == yako::drive_state::needs_init);
        }
    }
}

TEST_CASE("G21, G22: a facade's read fails if the drive restarted while one attempt of it was lost") {
    rig r;
    REQUIRE(r.lift.begin(read_feedback{}) == errc::ok);
    r.wire.set_connected(0, false);
    const std::uint32_t asked = r.wire.requests();
    while (r.wire.requests() == asked) r.lift.step(), r.wire.wait(microseconds(10));
    r.wire.wait(milliseconds(5));
    r.model.power_cycle();
    r.wire.set_connected(0, true);
    while (!r.lift.is_idle()) r.turn();
    CHECK(r.lift.last().error() == errc::needs_init);
    CHECK(r.lift.state() == yako::drive_state::needs_init);
}

TEST_CASE("G21: a lost attempt without a restart only costs a read of the word order, and the cached state "
          "stays valid") {
    rig r;
    REQUIRE(r.lift.begin(read_feedback{}) == errc::ok);
    r.wire.set_connected(0, false);
    const std::uint32_t asked = r.wire.requests();
    while (r.wire.requests() == asked) r.lift.step(), r.wire.wait(microseconds(10));
    r.wire.wait(milliseconds(5));
    r.wire.set_connected(0, true);
    while (!r.lift.is_idle()) r.turn();
    CHECK(r.lift.last());
    CHECK(r.lift.current_word_order() == word_order::low_first);
    r.run(1200);
    CHECK(r.limit() == rig::end);
}

TEST_CASE("G21, G22: a command that waited for the line fails if the drive restarted while a read of the bus "
          "was lost") {
    for (std::uint32_t turns = 0; turns < 60; ++turns) {
        const bool is_restarted = turns % 2 == 0;
        CAPTURE(turns);
        rig r;
        REQUIRE(r.command(enable{}));
        const std::uint32_t read = r.all.count(0);
        while (r.all.count(0) == read) r.turn();
        // The next read is sent and lost; then the drive is connected again, in half of the cases after a
        // restart.
        const std::uint32_t asked = r.wire.requests();
        r.wire.set_connected(0, false);
        while (r.wire.requests() == asked) r.turn();
        if (is_restarted) r.model.power_cycle();
        for (std::uint32_t i = 0; i < turns; ++i) r.turn();
        REQUIRE(r.lift.begin(read_feedback{}) == errc::ok);
        r.turn();
        r.wire.set_connected(0, true);
        while (!r.lift.is_idle()) r.turn();
        CHECK(bool{r.lift.last()} == !is_restarted);
        CHECK((r.lift.state() == yako::drive_state::needs_init) == is_restarted);
    }
}

namespace {

constexpr poll_plan without_a_facade{modbus::timing_at(115200),
                                     cyclic<yako::positive_software_limit>(lift_node, milliseconds(500)),
                                     cyclic<yako::status_word>(lift_node, milliseconds(700))};

// A request of another client is lost, and the drive restarts before the next frame reaches it.
void restart_while_another_client_asks(rig& r) {
    client other{r.on, lift_node};
    r.wire.set_connected(0, false);
    CHECK(other.read<yako::status_word>().error() == errc::timeout);
    r.model.power_cycle();
    r.wire.set_connected(0, true);
}

} // namespace

TEST_CASE("G22: a bus that was given the word order gives no 32-bit value after another client got no "
          "response from a restarted drive") {
    for (const std::uint32_t asked_after_ms : {0u, 100u, 450u, 520u}) {
        for (const bool is_restarted : {false, true}) {
            CAPTURE(asked_after_ms);
            CAPTURE(is_restarted);
            rig r;
            while (!r.on.is_free()) r.turn();
            bus<without_a_facade, rig::line_type> all{r.on};
            all.set_word_order(2, word_order::low_first);
            const auto limit = [&] {
                return all.latest<yako::positive_software_limit>(lift_node, milliseconds(600));
            };
            all.run_for(milliseconds(510));
            REQUIRE(limit());
            REQUIRE(limit()->count() == rig::end);
            all.run_for(milliseconds(asked_after_ms));
            if (is_restarted) restart_while_another_client_asks(r);
            for (int i = 0; i < 3000; ++i) { // also before the bus is stepped again
                if (is_restarted) {
                    REQUIRE_FALSE(limit());
                } else if (limit()) {
                    REQUIRE(limit()->count() == rig::end);
                }
                all.run_for(milliseconds(1));
            }
            CHECK(limit().error() == (is_restarted ? errc::needs_word_order : errc::ok));
            all.set_word_order(2, is_restarted ? word_order::high_first
                                               : word_order::low_first); // as if it had been read again
            all.run_for(milliseconds(600));
            REQUIRE(limit());
            CHECK(limit()->count() == rig::end);
        }
    }
}

TEST_CASE("G22: a bus whose facade has cached the word order gives no 32-bit value in the old order, "
          "although only another client's request was lost") {
    for (const std::uint32_t asked_after_ms : {0u, 100u, 450u, 520u}) {
        for (const bool is_enabled : {false, true}) { // false: only reads between the set-up and the restart
            CAPTURE(asked_after_ms);
            CAPTURE(is_enabled);
            rig r;
            if (is_enabled) REQUIRE(r.command(enable{}));
            r.run(510 + asked_after_ms);
            REQUIRE(r.limit() == rig::end);
            restart_while_another_client_asks(r);
            for (int i = 0; i < 3000; ++i) {
                const std::int32_t limit = r.limit();
                if (limit != 0) REQUIRE(limit == rig::end);
                r.run(1);
            }
            CHECK(r.lift.state() == yako::drive_state::needs_init);
        }
    }
}

TEST_CASE("G22: a bus gives no 32-bit value in the old order also if the restart follows directly after "
          "`init`") {
    rig r;
    yako::closed_loop::drive<rig::line_type> fresh{r.on, lift_node, servobus::by_plan};
    auto all = make_bus<seldom>(r.on, fresh);
    const auto run = [&](std::uint32_t ms) {
        const std::uint64_t until = r.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (r.wire.time_us() < until) {
            const duration idle = all.step();
            r.wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
    };
    REQUIRE(fresh.begin(init{}) == errc::ok);
    while (!fresh.is_idle()) run(1);
    REQUIRE(fresh.last());
    run(600);
    REQUIRE(all.latest<yako::positive_software_limit>(lift_node, milliseconds(600)));
    restart_while_another_client_asks(r);
    for (int i = 0; i < 3000; ++i) {
        const auto seen = all.latest<yako::positive_software_limit>(lift_node, milliseconds(600));
        if (seen) REQUIRE(seen->count() == rig::end);
        run(1);
    }
    CHECK(fresh.state() == yako::drive_state::needs_init);
}

} // namespace restart_word_order_tests
