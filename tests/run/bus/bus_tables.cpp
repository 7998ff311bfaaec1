// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of all four tables as cyclic reads of a plan: their requests, values, ages, back-off and times are those of
// registers. The device is a model that shares nothing with the library.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/any_device.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/tank.hpp>

namespace bus_tables_tests {

using namespace servobus;
using namespace servobus::units;
namespace tank = tests::tank;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;

namespace {
constexpr node<tank::device> tank_node = [] {
    node<tank::device> n{9};
    n.limits.response = milliseconds(30);
    n.gaps.quarantine = milliseconds(40);
    return n;
}();
constexpr modbus::rtu_timing timing = modbus::timing_at(38400);
constexpr auto inputs = cyclic<tank::temperature, tank::level>(tank_node, milliseconds(100));
constexpr auto coils = cyclic<tank::heater, tank::valve, tank::pump>(tank_node, milliseconds(200));
constexpr auto door = cyclic<tank::is_door_open>(tank_node, milliseconds(200));
constexpr auto target = cyclic<tank::target>(tank_node, milliseconds(400));
constexpr poll_plan plan{timing, inputs, coils, door, target};

// One frame each, and as long as the standard says: head, byte count, data, CRC.
static_assert(inputs.code == 4 && inputs.address == 0 && inputs.quantity == 2 && inputs.response_size() == 9);
static_assert(coils.code == 1 && coils.address == 3 && coils.quantity == 3 && coils.response_size() == 6);
static_assert(door.code == 2 && door.address == 9 && door.quantity == 1 && door.response_size() == 6);
static_assert(target.code == 3 && target.response_size() == 9);
static_assert(plan.words == 2 + 1 + 1 + 2 && plan.response_room == 9 && plan.has_other_tables);
// The plan counts them: a request of 8 characters, its response, and t3.5 twice, so many times a second.
static_assert(plan.shortest(coils) == timing.wire_time(8 + 6) + duration{timing.t3_5} * 2);
static_assert(plan.longest_in_flight() >= milliseconds(30));
static_assert(!poll_plan{timing, target}.has_other_tables);

struct rig {
    tests::waiting_scripted_port port;
    tests::plain_tables model = tank::model();
    scheduled_line<tests::waiting_scripted_port> wire{port, timing};
    bus<plan, scheduled_line<tests::waiting_scripted_port>> all{wire};

    rig() {
        port.device = [this](scripted_port& p, const sent_frame& f) { model(p, f, 9); };
    }
    rig(const rig&) = delete;
};
} // namespace

TEST_CASE("a bus reads all tables, and has their values") {
    rig r;
    r.model.input_registers = {{0, 17}, {1, 0xFFFF}, {2, 0}, {3, 0}};
    r.model.coils = {{3, true}, {4, false}, {5, true}};
    r.model.discrete_inputs = {{9, true}};
    r.model.holding_registers = {{4, 0xFFFF}, {5, 0xFFFE}};
    r.all.run_for(milliseconds(1000));
    const auto analog = r.all.latest<tank::temperature, tank::level>(tank_node, milliseconds(150));
    REQUIRE(analog);
    CHECK(analog->get<tank::level>() == 17);
    CHECK(analog->get<tank::temperature>().count() == -1);
    const auto bits = r.all.latest<tank::heater, tank::valve, tank::pump>(tank_node, milliseconds(250));
    REQUIRE(bits);
    CHECK((bits->get<tank::valve>() && !bits->get<tank::pump>() && bits->get<tank::heater>()));
    const auto is_open = r.all.latest<tank::is_door_open>(tank_node, milliseconds(250));
    CHECK((is_open && *is_open));
    CHECK(*r.all.latest<tank::target>(tank_node, milliseconds(450)) == -2);
    unsigned counts[5]{};
    for (const byte_list& pdu : r.model.requests) ++counts[pdu[0]];
    CHECK((counts[4] >= 9 && counts[4] <= 11));
    CHECK((counts[1] >= 4 && counts[1] <= 6));
    CHECK((counts[2] >= 4 && counts[2] <= 6));
    CHECK((counts[3] >= 2 && counts[3] <= 3));
    r.model.coils[3] = false;
    r.all.run_for(milliseconds(300));
    CHECK(!*r.all.latest<tank::valve>(tank_node, milliseconds(250)));
}

TEST_CASE("values that became old, or never came, are none: the reason is that of the last attempt") {
    rig r;
    r.all.run_for(milliseconds(500));
    REQUIRE(r.all.latest<tank::valve>(tank_node, milliseconds(250)));
    r.port.device = nullptr;
    r.all.run_for(milliseconds(600));
    CHECK(r.all.latest<tank::level>(tank_node, milliseconds(150)).error() == errc::timeout);
    CHECK(r.all.latest<tank::valve>(tank_node, milliseconds(250)).error() == errc::timeout);
    r.all.run_for(milliseconds(3000));
    CHECK(r.all.is_absent(9));
    r.port.device = [&](scripted_port& p, const sent_frame& f) { r.model(p, f, 9); };
    r.all.run_for(milliseconds(4500));
    CHECK(!r.all.is_absent(9));
    CHECK(r.all.latest<tank::valve>(tank_node, milliseconds(250)));
    r.model.coils.clear();
    r.all.run_for(milliseconds(600));
    CHECK(r.all.latest<tank::valve>(tank_node, milliseconds(250)).status().exception() == 2);
}

TEST_CASE("padding that is not 0 is no value, and does not count as a response that is lost") {
    rig r;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[1] == 1) return p.say(500, framed({9, 1, 1, 0x08}));
        r.model(p, f, 9);
    };
    r.all.run_for(milliseconds(5000));
    CHECK(r.all.latest<tank::valve>(tank_node, milliseconds(250)).error() == errc::unexpected_value);
    CHECK(r.all.latest<tank::level>(tank_node, milliseconds(150)));
    CHECK(!r.all.is_absent(9));
}

namespace {
constexpr poll_plan with_1{timing, target, own_requests(tank_node, milliseconds(50), 1)};
constexpr poll_plan with_2{timing, target, own_requests(tank_node, milliseconds(50), 2)};
constexpr poll_plan with_3{timing, target, own_requests(tank_node, milliseconds(50), 3)};

// The errors of the program's own 16h, 17h (of one register, and one read) and 0F, beside a bus.
template <const auto& Plan> void check_own(bool has_16h, bool has_17h) {
    tests::waiting_scripted_port port;
    tests::plain_tables model = tank::model();
    port.device = [&](scripted_port& p, const sent_frame& f) { model(p, f, 9); };
    scheduled_line<tests::waiting_scripted_port> wire{port, timing};
    bus<Plan, scheduled_line<tests::waiting_scripted_port>> all{wire};
    client io{wire, tank_node};
    const auto error_of = [&](auto& call) {
        for (int i = 0; i < 20'000 && !call.done(); ++i) {
            all.step();
            (void)call.step();
            port.time += 200;
        }
        return call.status().error();
    };
    stepped_change_bits<decltype(io), tank::options, 1> change{io};
    REQUIRE(change.begin(1) == errc::ok);
    CHECK(error_of(change) == (has_16h ? errc::ok : errc::not_in_plan));
    stepped_write_then_read<decltype(io), rows<tank::state>, tank::ramp> both{io};
    REQUIRE(both.begin(7 * millisecond) == errc::ok);
    CHECK(error_of(both) == (has_17h ? errc::ok : errc::not_in_plan));
    stepped_write<decltype(io), tank::valve, tank::pump, tank::heater> coils_written{io};
    REQUIRE(coils_written.begin(true, true, true) == errc::ok);
    CHECK(error_of(coils_written) == errc::ok);
}
} // namespace

TEST_CASE("own requests beside a bus: 16h counts as two registers, 17h as all of its registers and one") {
    check_own<with_1>(false, false);
    check_own<with_2>(true, false);
    check_own<with_3>(true, true);
}

} // namespace bus_tables_tests
