// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of all four tables and functions 16h and 17h, by blocking calls on both lines, against a model of the device
// that shares nothing with the library.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/any_device.hpp>
#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/tank.hpp>

namespace table_calls_tests {

using namespace servobus;
using namespace servobus::units;
namespace tank = tests::tank;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

struct any_line {
    using line = servobus::line<tests::waiting_scripted_port>;
    using node = servobus::node<tank::device>;
    static line on(tests::waiting_scripted_port& port) { return line{port, timing}; }
};
template <class Node> struct small {
    using line = blocking_line<tests::waiting_scripted_port, timing>;
    using node = Node;
    static line on(tests::waiting_scripted_port& port) { return line{port}; }
};
using small_line = small<servobus::node<tank::device>>;
using constants = small<fixed_node<tank::device, 1>>;

template <class Kind> struct setup {
    tests::waiting_scripted_port port;
    tests::plain_tables model = tank::model();
    typename Kind::line on = Kind::on(port);
    client<typename Kind::line, tank::device, typename Kind::node> drive{
        on, [] {
            if constexpr (is_fixed<typename Kind::node>)
                return typename Kind::node{};
            else
                return typename Kind::node{1};
        }()};

    setup() {
        port.device = [this](scripted_port& p, const sent_frame& f) { model(p, f, 1); };
    }
    setup(const setup&) = delete;
    void answer(const byte_list& body) {
        port.device = [body](scripted_port& p, const sent_frame&) { p.say(500, framed(body)); };
    }
    void rule_out_echo() { // by a read
        CHECK(drive.template read<tank::options>());
        model.requests.clear();
    }
};
} // namespace

#define TABLES_ON_EACH_LINE any_line, small_line, constants

TEST_CASE_TEMPLATE("each row is read by the function of its table", Kind, TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    r.model.coils[4] = r.model.discrete_inputs[9] = true;
    r.model.input_registers = {{0, 17}, {1, 0xFFFF}, {2, 1}, {3, 2}};
    r.model.holding_registers[5] = 9;
    CHECK(*r.drive.template read<tank::pump>());
    CHECK(!*r.drive.template read<tank::valve>());
    CHECK(*r.drive.template read<tank::is_door_open>());
    CHECK(!*r.drive.template read<tank::is_full>());
    CHECK(*r.drive.template read<tank::level>() == 17);
    CHECK(r.drive.template read<tank::temperature>()->count() == -1);
    CHECK(*r.drive.template read<tank::volume>() == 0x1'0002);
    CHECK(*r.drive.template read<tank::target>() == 9);
    const std::vector<byte_list> asked{{1, 0, 4, 0, 1}, {1, 0, 3, 0, 1}, {2, 0, 9, 0, 1}, {2, 0, 3, 0, 1},
                                       {4, 0, 0, 0, 1}, {4, 0, 1, 0, 1}, {4, 0, 2, 0, 2}, {3, 0, 4, 0, 2}};
    CHECK(r.model.requests == asked);
}

TEST_CASE_TEMPLATE("rows of several tables are read in one request for each run of addresses in a table",
                   Kind, TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    r.model.coils[3] = r.model.coils[0x10] = r.model.discrete_inputs[9] = true;
    r.model.input_registers[1] = 250;
    r.model.holding_registers[4] = 0xFFFF;
    r.model.holding_registers[5] = 0xFFFE;
    const auto all = r.drive.template read<tank::temperature, tank::lamp, tank::target, tank::pump,
                                           tank::level, tank::is_door_open, tank::valve, tank::ramp>();
    REQUIRE(all);
    CHECK(all->template get<tank::valve>());
    CHECK(!all->template get<tank::pump>());
    CHECK(all->template get<tank::lamp>());
    CHECK(all->template get<tank::is_door_open>());
    CHECK(all->template get<tank::temperature>() == 25 * degree_celsius);
    CHECK(all->template get<tank::level>() == 0);
    CHECK(all->template get<tank::target>() == -2);
    CHECK(all->template get<tank::ramp>() == 0 * millisecond);
    const std::vector<byte_list> asked{
        {1, 0, 3, 0, 2}, {1, 0, 0x10, 0, 1}, {2, 0, 9, 0, 1}, {3, 0, 3, 0, 3}, {4, 0, 0, 0, 2}};
    CHECK(r.model.requests == asked);
}

TEST_CASE_TEMPLATE("a request that fails leaves no value of several, and its error", Kind,
                   TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    r.model.coils[3] = true;
    r.model.discrete_inputs.clear();
    const auto all = r.drive.template read<tank::valve, tank::is_full>();
    CHECK(all.error() == errc::exception);
    CHECK(all.status().exception() == 2);
    r.model.requests.clear();
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[1] == 1) r.model(p, f, 1);
    };
    const auto none = r.drive.template read<tank::valve, tank::level>();
    CHECK(none.error() == errc::timeout);
    CHECK(r.port.frames.size() == 6); // three attempts at function 04
}

TEST_CASE_TEMPLATE("a lost response to a read of bits is asked for again", Kind, TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    int lost = 2;
    r.model.coils[3] = true;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (lost-- <= 0) r.model(p, f, 1);
    };
    CHECK(*r.drive.template read<tank::valve>());
    CHECK(r.port.frames.size() == 3);
}

TEST_CASE_TEMPLATE("padding that is not 0 is no value, and neither is a byte too many", Kind,
                   TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    r.answer({1, 1, 1, 0x02});
    CHECK(r.drive.template read<tank::valve>().error() == errc::unexpected_value);
    r.answer({1, 1, 2, 0x01, 0x00});
    CHECK(r.drive.template read<tank::valve>().error() == errc::wrong_byte_count);
    r.answer({1, 1, 1, 0x08}); // three coils
    const auto three = r.drive.template read<tank::valve, tank::pump, tank::heater>();
    CHECK(three.error() == errc::unexpected_value);
    r.answer({1, 1, 1, 0x05});
    const auto good = r.drive.template read<tank::valve, tank::pump, tank::heater>();
    CHECK((good && good->template get<tank::heater>() && !good->template get<tank::pump>()));
}

TEST_CASE_TEMPLATE("a coil is written by function 05, adjacent ones by 0F", Kind, TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    r.rule_out_echo();
    CHECK(r.drive.template write<tank::valve>(true));
    CHECK(r.model.coils[3]);
    CHECK(r.drive.template write<tank::valve>(false));
    CHECK(!r.model.coils[3]);
    CHECK(r.drive.template write<tank::valve, tank::pump, tank::heater>(true, false, true));
    CHECK((r.model.coils[3] && !r.model.coils[4] && r.model.coils[5]));
    const std::vector<byte_list> asked{{5, 0, 3, 0xFF, 0}, {5, 0, 3, 0, 0}, {15, 0, 3, 0, 3, 1, 0x05}};
    CHECK(r.model.requests == asked);
    r.model.coils.clear();
    CHECK(r.drive.template write<tank::valve>(true).exception() == 2);
}

TEST_CASE_TEMPLATE("G3: the response to 05 may be an echo: the coil is read before the write counts as done",
                   Kind, TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    CHECK(r.drive.template write<tank::pump>(true));
    const std::vector<byte_list> asked{{5, 0, 4, 0xFF, 0}, {1, 0, 4, 0, 1}};
    CHECK(r.model.requests == asked);

    setup<Kind> echoes; // a line without a device, whose adapter echoes
    echoes.port.device = [](scripted_port& p, const sent_frame& f) { p.say(0, f.data); };
    CHECK(echoes.drive.template write<tank::pump>(true).error() == errc::own_echo);
    CHECK(!echoes.drive.template write<tank::valve, tank::pump>(true, true));
    CHECK((echoes.drive.template change_bits<tank::options, 0x000C>(4)).error() == errc::own_echo);
    CHECK(!echoes.drive.template write_then_read<rows<tank::options>, tank::ramp>(checked(7 * millisecond)));
}

TEST_CASE_TEMPLATE("a coil of every device on the line is written by a broadcast", Kind,
                   TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    CHECK(r.drive.template broadcast<tank::reset>(true));
    CHECK(r.model.coils[0x11]);
    CHECK(r.port.frames.back().data == framed({0, 5, 0, 0x11, 0xFF, 0}));
}

TEST_CASE_TEMPLATE("16h changes the bits of the mask and no other", Kind, TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    r.rule_out_echo();
    r.model.holding_registers[0] = 0x1238;
    CHECK((r.drive.template change_bits<tank::options, 0x000C>(0xFFF4)));
    CHECK(r.model.holding_registers[0] == 0x1234);
    CHECK(r.model.requests.back() == byte_list{22, 0, 0, 0xFF, 0xF3, 0, 4});
    r.answer({1, 22, 0, 0, 0xFF, 0xF3, 0, 5});
    CHECK((r.drive.template change_bits<tank::options, 0x000C>(4)).error() == errc::wrong_value);
    r.answer({1, 22, 0, 1, 0xFF, 0xF3, 0, 4});
    CHECK((r.drive.template change_bits<tank::options, 0x000C>(4)).error() == errc::wrong_address);
}

TEST_CASE_TEMPLATE("16h: no byte count is taken for a mask, on a device that answers 10h with its byte count",
                   Kind, any_line, small_line) {
    setup<Kind> r;
    r.rule_out_echo();
    r.drive.node().limits.echoes_byte_count = true;
    r.answer({1, 22, 0, 0, 0xFF, 1, 0, 4}); // the byte count that a request of this length would have
    CHECK((r.drive.template change_bits<tank::options, 0x000C>(4)).error() == errc::wrong_value);
}

TEST_CASE_TEMPLATE("17h writes, then reads, in one transaction that is never repeated", Kind,
                   TABLES_ON_EACH_LINE) {
    setup<Kind> r;
    r.model.holding_registers[6] = 3;
    const auto seen =
        r.drive.template write_then_read<rows<tank::target, tank::state>, tank::ramp, tank::target>(
            700 * millisecond, raw(-9));
    REQUIRE(seen);
    CHECK(seen->template get<tank::target>() == -9);
    CHECK(seen->template get<tank::state>() == 3);
    CHECK(r.model.holding_registers[3] == 700);
    CHECK(r.model.requests ==
          std::vector<byte_list>{{23, 0, 4, 0, 3, 0, 3, 0, 3, 6, 0x02, 0xBC, 0xFF, 0xFF, 0xFF, 0xF7}});

    const auto refused =
        r.drive.template write_then_read<rows<tank::state>, tank::ramp>(checked(6000 * millisecond));
    CHECK(refused.error() == errc::out_of_range);
    CHECK(r.model.requests.size() == 1);

    r.port.device = nullptr;
    const auto lost = r.drive.template write_then_read<rows<tank::state>, tank::ramp>(1 * millisecond);
    CHECK(lost.error() == errc::timeout);
    CHECK(lost.status().was_sent());
    CHECK(r.port.frames.size() == 2);
    r.answer({1, 23, 4, 0, 3, 0, 0});
    const auto longer = r.drive.template write_then_read<rows<tank::state>, tank::ramp>(1 * millisecond);
    CHECK(longer.error() == errc::wrong_byte_count);
}

TEST_CASE("a node that the device cannot have gets no request of any table") {
    setup<any_line> r;
    client nobody{r.on, node<tank::device>{248}};
    CHECK(nobody.read<tank::valve>().error() == errc::bad_argument);
    CHECK(nobody.read<tank::valve, tank::level>().error() == errc::bad_argument);
    CHECK(nobody.write<tank::valve>(true).error() == errc::bad_argument);
    CHECK(nobody.write<tank::valve, tank::pump>(true, true).error() == errc::bad_argument);
    CHECK(nobody.change_bits<tank::options, 1>(1).error() == errc::bad_argument);
    CHECK(nobody.write_then_read<rows<tank::state>, tank::ramp>(1 * millisecond).error() ==
          errc::bad_argument);
    CHECK(r.port.frames.empty());
}

} // namespace table_calls_tests
