// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stepped calls for rows of all four tables, and for functions 16h and 17h: on a good line, on one that loses
// responses, on one that only echoes and before a device that refuses, their frames and results are those of the
// blocking calls.
#include <doctest/doctest.h>

#include <cstdint>
#include <functional>
#include <vector>

#include <servobus/any_device.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/tank.hpp>

namespace stepped_tables_tests {

using namespace servobus;
using namespace servobus::units;
namespace tank = tests::tank;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;
using tests::operator+;

namespace {
struct machine {
    tests::waiting_scripted_port port;
    tests::plain_tables model = tank::model();
    line<tests::waiting_scripted_port> on{port, modbus::timing_at(115200)};
    client<line<tests::waiting_scripted_port>, tank::device> drive{on, node<tank::device>{1}};

    explicit machine(int world) {
        model.coils[3] = model.coils[5] = model.discrete_inputs[9] = true;
        model.input_registers = {{0, 17}, {1, 0xFFFF}, {2, 1}, {3, 2}};
        model.holding_registers = {{0, 0x1238}, {3, 7}, {4, 0xFFFF}, {5, 0xFFFE}, {6, 9}};
        port.device = [this, world](scripted_port& p, const sent_frame& f) {
            const std::size_t number = p.frames.size();
            if (world == loses_one && number == 1) return;
            if (world == loses_all) return;
            if (world == echoes) return p.say(0, f.data);
            if (world == pads && (f.data[1] == 1 || f.data[1] == 2))
                return p.say(500, framed({1, f.data[1], 1, 0xC0}));
            if (world == refuses) return p.say(500, framed({1, tests::low_byte(f.data[1] + 128u), 2}));
            if (world == answers_06_late && number == 1) return p.say(300'000, framed({1, 3, 2, 0, 0}));
            model(p, f, 1);
        };
    }
    machine(const machine&) = delete;
    enum kind { good, loses_one, loses_all, echoes, pads, refuses, answers_06_late, worlds };

    template <class Call> void finish(Call& call) {
        for (int i = 0; i < 20'000 && !call.done(); ++i) {
            (void)call.step();
            port.time += 200;
        }
        REQUIRE(call.done());
    }
    std::vector<byte_list> frames() const {
        std::vector<byte_list> all;
        for (const auto& f : port.frames) all.push_back(f.data);
        return all;
    }
};
using test_client = decltype(machine::drive);

/// `blocking(machine)` and `stepped(machine)` return a status and what was read, as words.
struct outcome_of {
    status why;
    std::vector<std::int64_t> values{};
};
void check_same(const std::function<outcome_of(machine&)>& blocking,
                const std::function<outcome_of(machine&)>& stepped) {
    for (int world = 0; world < machine::worlds; ++world) {
        CAPTURE(world);
        for (const bool is_ruled_out : {false, true}) {
            CAPTURE(is_ruled_out);
            machine a{world};
            machine b{world};
            if (is_ruled_out) {
                for (machine* m : {&a, &b}) {
                    const auto usual = m->port.device;
                    m->port.device = [m](scripted_port& p, const sent_frame& f) { m->model(p, f, 1); };
                    REQUIRE(m->drive.read<tank::options>());
                    m->port.frames.clear();
                    m->port.device = usual;
                }
            }
            const outcome_of x = blocking(a);
            const outcome_of y = stepped(b);
            CHECK(x.why.error() == y.why.error());
            CHECK(x.why.was_sent() == y.why.was_sent());
            CHECK(x.why.exception() == y.why.exception());
            CHECK(x.values == y.values);
            CHECK(a.frames() == b.frames());
            CHECK(a.model.coils == b.model.coils);
            CHECK(a.model.holding_registers == b.model.holding_registers);
            if (world == machine::good) CHECK(x.why);
        }
    }
}

// Its rows are deduced: g++ 12 fails on rows that are given.
template <const auto&... Rs> outcome_of values_of(const result<readings<Rs...>>& r) {
    outcome_of o{r.status()};
    const auto add = [&o](auto value) {
        if constexpr (requires { value.count(); })
            o.values.push_back(value.count());
        else
            o.values.push_back(static_cast<std::int64_t>(value));
    };
    if (r) (add(r->template get<Rs>()), ...);
    return o;
}
template <const auto& R> outcome_of value_of(const result<reading<R>>& r) {
    outcome_of o{r.status()};
    if (r) {
        if constexpr (requires { r->count(); })
            o.values.push_back(r->count());
        else
            o.values.push_back(static_cast<std::int64_t>(*r));
    }
    return o;
}
template <const auto& R> void check_read() {
    check_same([](machine& m) { return value_of<R>(m.drive.read<R>()); },
               [](machine& m) {
                   stepped_read<test_client, R> call{m.drive};
                   CHECK(call.begin() == errc::ok);
                   CHECK(call.begin() == errc::busy);
                   m.finish(call);
                   return value_of<R>(call.value());
               });
}
template <const auto&... Rs> void check_reads() {
    check_same([](machine& m) { return values_of(m.drive.read<Rs...>()); },
               [](machine& m) {
                   stepped_read<test_client, Rs...> call{m.drive};
                   CHECK(call.begin() == errc::ok);
                   CHECK(call.begin() == errc::busy);
                   m.finish(call);
                   return values_of(call.value());
               });
}
} // namespace

TEST_CASE("a stepped read of a row of any table is the blocking one") {
    check_read<tank::valve>();
    check_read<tank::is_full>();
    check_read<tank::is_door_open>();
    check_read<tank::level>();
    check_read<tank::temperature>();
    check_read<tank::volume>();
}

TEST_CASE("a stepped read of rows of several tables is the blocking one") {
    check_reads<tank::valve, tank::pump, tank::heater>();
    check_reads<tank::level, tank::temperature>();
    check_reads<tank::temperature, tank::lamp, tank::target, tank::pump, tank::is_door_open, tank::valve>();
}

TEST_CASE("a stepped write of coils is the blocking one") {
    check_same([](machine& m) { return outcome_of{m.drive.write<tank::pump>(true)}; },
               [](machine& m) {
                   stepped_write<test_client, tank::pump> call{m.drive};
                   CHECK(call.begin(true) == errc::ok);
                   CHECK(call.begin(false) == errc::busy);
                   m.finish(call);
                   return outcome_of{call.status()};
               });
    check_same(
        [](machine& m) {
            return outcome_of{m.drive.write<tank::valve, tank::pump, tank::heater>(false, true, false)};
        },
        [](machine& m) {
            stepped_write<test_client, tank::valve, tank::pump, tank::heater> call{m.drive};
            CHECK(call.begin(false, true, false) == errc::ok);
            CHECK(call.begin(true, true, true) == errc::busy);
            m.finish(call);
            return outcome_of{call.status()};
        });
}

TEST_CASE("a stepped change of bits, and a write and read in one transaction, are the blocking ones") {
    check_same([](machine& m) { return outcome_of{m.drive.change_bits<tank::options, 0x000C>(0xFFF4)}; },
               [](machine& m) {
                   stepped_change_bits<test_client, tank::options, 0x000C> call{m.drive};
                   CHECK(call.begin(0xFFF4) == errc::ok);
                   CHECK(call.begin(8) == errc::busy);
                   m.finish(call);
                   return outcome_of{call.status()};
               });
    check_same(
        [](machine& m) {
            return values_of(m.drive.write_then_read<rows<tank::target, tank::state>, tank::ramp>(
                checked(70 * millisecond)));
        },
        [](machine& m) {
            stepped_write_then_read<test_client, rows<tank::target, tank::state>, tank::ramp> call{m.drive};
            CHECK(call.begin(checked(6000 * millisecond)) == errc::out_of_range);
            CHECK(call.begin(checked(70 * millisecond)) == errc::ok);
            CHECK(call.begin(checked(70 * millisecond)) == errc::busy);
            m.finish(call);
            return values_of(call.value());
        });
}

TEST_CASE("a stepped call of any table that is destroyed sends nothing more, and one of a wrong node nothing "
          "at all") {
    machine m{machine::good};
    {
        stepped_write<test_client, tank::pump> call{m.drive};
        CHECK(call.begin(true) == errc::ok);
        (void)call.step();
    }
    m.port.time += 1'000'000;
    CHECK(m.drive.read<tank::pump>());
    CHECK(m.model.requests.size() <= 2);

    client nobody{m.on, node<tank::device>{250}};
    stepped_read<test_client, tank::valve, tank::level> read{nobody};
    stepped_change_bits<test_client, tank::options, 1> change{nobody};
    stepped_write<test_client, tank::valve> write{nobody};
    stepped_write_then_read<test_client, rows<tank::state>, tank::ramp> both{nobody};
    CHECK(read.begin() == errc::bad_argument);
    CHECK(change.begin(1) == errc::bad_argument);
    CHECK(write.begin(true) == errc::bad_argument);
    CHECK(both.begin(1 * millisecond) == errc::bad_argument);
    CHECK(both.value().error() == errc::bad_argument);
}

TEST_CASE(
    "a stepped call of any table that is refused after one that has succeeded has its own error, and no "
    "value") {
    machine m{machine::good};
    stepped_read<test_client, tank::valve, tank::level> read{m.drive};
    stepped_change_bits<test_client, tank::options, 1> change{m.drive};
    stepped_write<test_client, tank::valve> write{m.drive};
    stepped_write_then_read<test_client, rows<tank::state>, tank::ramp> both{m.drive};
    const auto begun = [&](errc how) {
        CHECK(read.begin() == how);
        m.finish(read);
        CHECK(change.begin(1) == how);
        m.finish(change);
        CHECK(write.begin(true) == how);
        m.finish(write);
        CHECK(both.begin(70 * millisecond) == how);
        m.finish(both);
        CHECK(read.value().error() == how);
        CHECK(change.status() == how);
        CHECK(write.status() == how);
        CHECK(both.value().error() == how);
    };
    begun(errc::ok);
    m.drive.node().address = 250;
    begun(errc::bad_argument);
}

} // namespace stepped_tables_tests
