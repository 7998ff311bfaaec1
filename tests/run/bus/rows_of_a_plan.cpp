// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The values of cyclic reads by row and node: like sensors, rows of all tables, 32-bit values, and several rows of one
// moment. The devices are models that share nothing with the library.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <utility>

#include <servobus/any_device.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/plain_tables.hpp>
#include <tests/support/scripted_port.hpp>

namespace rows_of_a_plan_tests {

using namespace servobus;
using tests::plain_tables;
using tests::scripted_port;
using tests::sent_frame;

namespace {
struct meter {
    static constexpr profile facts{
        .name = "meter", .word_order = word_order::unknown, .word_order_register = 0x0000};
};
inline constexpr reg<u16, access::ro, meter> voltage{0x0010, full<u16>, units::volt / 10, no_default};
inline constexpr reg<i16, access::ro, meter> current{0x0011, full<i16>, units::ampere / 10, no_default};
inline constexpr reg<u32, access::ro, meter> energy{0x0012, full<u32>, no_unit, no_default};
inline constexpr reg<i16, access::ro, meter> temperature{0x0014, full<i16>, units::degree_celsius / 10,
                                                         no_default};
inline constexpr reg<u16, access::ro, meter> alarms{0x0015, full<u16>, no_unit, no_default};
inline constexpr input_reg<u16, meter> pressure{0x0001, full<u16>, no_unit, no_default};
inline constexpr input_reg<u16, meter> flow{0x0002, full<u16>, no_unit, no_default};
inline constexpr input_reg<i32, meter> volume{0x0003, full<i32>, no_unit, no_default};
inline constexpr input_reg<i16, meter> level{0x0005, full<i16>, no_unit, no_default};
template <std::size_t N> inline constexpr coil<access::rw, meter> relay{static_cast<u16>(0x0100u + N)};

// Another device with a register at the address of `voltage`.
struct fan {
    static constexpr profile facts{.name = "fan"};
};
inline constexpr reg<u16, access::rw, fan> speed{0x0010, full<u16>, units::r_per_min, no_default};

constexpr node<meter> first_meter = responds_within(node<meter>{1}, milliseconds(30));
constexpr node<meter> second_meter = responds_within(node<meter>{2}, milliseconds(30));
constexpr node<fan> fan_node = responds_within(node<fan>{3}, milliseconds(30));
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

/// A bus of a plan, and three nodes.
template <const auto& Plan> struct rig {
    using line_type = scheduled_line<tests::waiting_scripted_port>;

    tests::waiting_scripted_port port;
    plain_tables nodes[3]{};
    line_type wire{port, timing};
    bus<Plan, line_type> all{wire};

    rig() {
        for (plain_tables& n : nodes) {
            for (std::uint16_t address = 0; address < 0x20; ++address) {
                n.holding_registers[address] = 0;
                n.input_registers[address] = 0;
            }
            for (std::uint16_t address = 0x0100; address < 0x0120; ++address) n.coils[address] = false;
        }
        port.device = [this](scripted_port& p, const sent_frame& f) {
            if (f.data[0] >= 1 && f.data[0] <= 3) nodes[f.data[0] - 1](p, f, f.data[0]);
        };
    }
    rig(const rig&) = delete;
};

constexpr auto of_first = cyclic<voltage>(first_meter, milliseconds(100));
constexpr auto of_second = cyclic<voltage>(second_meter, milliseconds(100));
constexpr auto of_fan = cyclic<speed>(fan_node, milliseconds(100));
constexpr poll_plan in_order{timing, of_first, of_second, of_fan};
constexpr poll_plan in_reverse{timing, of_fan, of_second, of_first};

template <const auto& Plan> void check_like_sensors() {
    rig<Plan> r;
    r.nodes[0].holding_registers[0x0010] = 2301;
    r.nodes[1].holding_registers[0x0010] = 2287;
    r.nodes[2].holding_registers[0x0010] = 900;
    r.all.run_for(milliseconds(300));
    CHECK(r.all.template latest<voltage>(first_meter, milliseconds(150))->count() == 2301);
    CHECK(r.all.template latest<voltage>(second_meter, milliseconds(150))->count() == 2287);
    CHECK(r.all.template latest<speed>(milliseconds(150))->count() == 900); // the row of one node alone
    CHECK(*r.all.template latest<voltage>(first_meter, milliseconds(150)) > 230 * units::volt);
}
} // namespace

TEST_CASE("two like sensors whose entries change places in the plan keep their values") {
    check_like_sensors<in_order>();
    check_like_sensors<in_reverse>();
}

TEST_CASE("the value of a node is not that of another, whichever of them responds") {
    rig<in_order> r;
    r.nodes[1].holding_registers.clear();
    r.all.run_for(milliseconds(300));
    CHECK(r.all.latest<voltage>(first_meter, milliseconds(150)));
    const auto refused = r.all.latest<voltage>(second_meter, milliseconds(150));
    CHECK(refused.error() == errc::exception);
    CHECK(refused.exception() == 2);
    r.port.device = nullptr;
    r.all.run_for(milliseconds(500));
    CHECK(r.all.latest<voltage>(first_meter, milliseconds(150)).error() == errc::timeout);
    CHECK(r.all.latest<voltage>(first_meter, milliseconds(1000))); // an old one
    CHECK(r.all.latest<speed>(milliseconds(150)).error() == errc::timeout);
}

namespace {
constexpr poll_plan of_all_registers{
    timing, of_second, cyclic<voltage, current, energy, temperature, alarms>(first_meter, milliseconds(100))};
} // namespace

TEST_CASE("G22: of a read, rows of 32 bits need the word order of the node, and the others do not") {
    rig<of_all_registers> r;
    plain_tables& n = r.nodes[0];
    n.holding_registers[0x0010] = 2301;
    n.holding_registers[0x0011] = 0xFFFE;
    n.holding_registers[0x0012] = 0x0001;
    n.holding_registers[0x0013] = 0x2345;
    n.holding_registers[0x0014] = 215;
    n.holding_registers[0x0015] = 0x8001;
    CHECK(r.all.latest<current>(first_meter, milliseconds(150)).error() == errc::timeout); // not read yet
    r.all.run_for(milliseconds(300));
    CHECK(r.all.latest<current>(milliseconds(150))->count() == -2);
    CHECK(r.all.latest<temperature>(milliseconds(150))->count() == 215);
    CHECK(*r.all.latest<alarms>(milliseconds(150)) == 0x8001);
    CHECK(r.all.latest<energy>(milliseconds(150)).error() == errc::needs_word_order);
    CHECK((r.all.latest<current, energy>(milliseconds(150)).error() == errc::needs_word_order));
    CHECK((r.all.latest<current, alarms>(milliseconds(150))));
    for (const bool is_high_first : {true, false}) {
        CAPTURE(is_high_first);
        const std::uint32_t energy_then = is_high_first ? 0x0001'2345 : 0x2345'0001;
        r.all.set_word_order(1, is_high_first ? word_order::high_first : word_order::low_first);
        r.all.run_for(milliseconds(300));
        CHECK(*r.all.latest<energy>(first_meter, milliseconds(150)) == energy_then);
        const auto seen = r.all.latest<temperature, energy>(first_meter, milliseconds(150));
        REQUIRE(seen);
        CHECK(seen->get<energy>() == energy_then);
        CHECK(seen->get<temperature>().count() == 215);
    }
}

TEST_CASE("several rows of one read are of one moment, also rows that are not side by side") {
    rig<of_all_registers> r;
    std::uint16_t asked = 0;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[0] != 1) return;
        for (std::uint16_t i = 0; i < 6; ++i) r.nodes[0].holding_registers[0x0010u + i] = asked;
        ++asked;
        r.nodes[0](p, f, 1);
    };
    r.all.run_for(milliseconds(200));
    for (int i = 0; i < 20; ++i) {
        r.all.run_for(milliseconds(35));
        const auto seen = r.all.latest<alarms, voltage, temperature>(first_meter, milliseconds(150));
        REQUIRE(seen);
        CHECK(seen->get<voltage>().count() == asked - 1);
        CHECK(seen->get<temperature>().count() == asked - 1);
        CHECK(seen->get<alarms>() == asked - 1);
        const auto middle = r.all.latest<current, temperature>(milliseconds(150)); // of one node alone
        REQUIRE(middle);
        CHECK(middle->get<current>().count() == asked - 1);
        CHECK(middle->get<temperature>().count() == asked - 1);
    }
    CHECK(asked >= 6);
}

namespace {
template <std::size_t... N> consteval auto relays(std::index_sequence<N...>) {
    return cyclic<relay<N>...>(second_meter, milliseconds(100));
}
constexpr auto all_relays = relays(std::make_index_sequence<20>{});
constexpr poll_plan of_tables{timing, cyclic<voltage>(second_meter, milliseconds(100)),
                              cyclic<pressure, flow, volume, level>(second_meter, milliseconds(100)),
                              all_relays, cyclic<relay<3>>(first_meter, milliseconds(100))};
} // namespace

TEST_CASE("each bit of a read by its row, and several of them") {
    rig<of_tables> r;
    for (std::uint16_t set = 0; set < 20; ++set) {
        CAPTURE(set);
        for (std::uint16_t i = 0; i < 20; ++i) r.nodes[1].coils[0x0100u + i] = i == set;
        r.nodes[0].coils[0x0103] = set % 2 == 1;
        r.all.run_for(milliseconds(250));
        CHECK(*r.all.latest<relay<0>>(second_meter, milliseconds(150)) == (set == 0));
        CHECK(*r.all.latest<relay<3>>(second_meter, milliseconds(150)) == (set == 3));
        CHECK(*r.all.latest<relay<3>>(first_meter, milliseconds(150)) == (set % 2 == 1));
        CHECK(*r.all.latest<relay<8>>(milliseconds(150)) == (set == 8)); // the lowest of the second byte
        CHECK(*r.all.latest<relay<15>>(milliseconds(150)) == (set == 15));
        CHECK(*r.all.latest<relay<19>>(milliseconds(150)) == (set == 19));
        const auto seen =
            r.all.latest<relay<17>, relay<6>, relay<7>, relay<8>, relay<12>>(second_meter, milliseconds(150));
        REQUIRE(seen);
        CHECK(seen->get<relay<6>>() == (set == 6));
        CHECK(seen->get<relay<7>>() == (set == 7));
        CHECK(seen->get<relay<8>>() == (set == 8));
        CHECK(seen->get<relay<12>>() == (set == 12));
        CHECK(seen->get<relay<17>>() == (set == 17));
    }
}

TEST_CASE("input registers by row, and several of them with a 32-bit value between") {
    rig<of_tables> r;
    plain_tables& n = r.nodes[1];
    n.input_registers[1] = 0x1234;
    n.input_registers[2] = 77;
    n.input_registers[3] = 0xFFFF;
    n.input_registers[4] = 0xFFFB;
    n.input_registers[5] = 0xFFFF;
    n.holding_registers[0x0010] = 5;
    r.all.set_word_order(2, word_order::high_first);
    r.all.run_for(milliseconds(250));
    CHECK(*r.all.latest<pressure>(second_meter, milliseconds(150)) == 0x1234);
    CHECK(*r.all.latest<flow>(milliseconds(150)) == 77);
    CHECK(*r.all.latest<volume>(milliseconds(150)) == -5);
    CHECK(*r.all.latest<level>(milliseconds(150)) == -1);
    CHECK(r.all.latest<voltage>(milliseconds(150))->count() == 5);
    const auto seen = r.all.latest<level, pressure, volume>(second_meter, milliseconds(150));
    REQUIRE(seen);
    CHECK(seen->get<pressure>() == 0x1234);
    CHECK(seen->get<volume>() == -5);
    CHECK(seen->get<level>() == -1);
    const auto two = r.all.latest<flow, volume>(milliseconds(150));
    REQUIRE(two);
    CHECK(two->get<flow>() == 77);
    CHECK(two->get<volume>() == -5);
}

namespace {
constexpr poll_plan seldom_first{timing, cyclic<voltage, current>(first_meter, milliseconds(5000)),
                                 cyclic<voltage>(first_meter, milliseconds(100))};
constexpr poll_plan often_first{timing, cyclic<voltage>(first_meter, milliseconds(100)),
                                cyclic<voltage, current>(first_meter, milliseconds(5000))};
template <const auto& Plan> void check_row_of_two_reads() {
    rig<Plan> r;
    r.all.run_for(milliseconds(1000));
    r.nodes[0].holding_registers[0x0010] = 1;
    r.all.run_for(milliseconds(1000));
    CHECK(r.all.template latest<voltage>(first_meter, milliseconds(150))->count() == 1);
    CHECK(r.all.template latest<voltage>(milliseconds(150))->count() == 1);
    CHECK((!r.all.template latest<voltage, current>(first_meter, milliseconds(150))));
    const auto both = r.all.template latest<voltage, current>(first_meter, milliseconds(5500));
    REQUIRE(both);
    CHECK(both->template get<voltage>().count() == 0);
}
} // namespace

TEST_CASE("a row of several reads has the value of the one that is read most often") {
    check_row_of_two_reads<seldom_first>();
    check_row_of_two_reads<often_first>();
}

} // namespace rows_of_a_plan_tests
