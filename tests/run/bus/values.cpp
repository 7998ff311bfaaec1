// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Cyclic reads of each type of value.
#include <doctest/doctest.h>

#include <servobus/bus/bus.hpp>
#include <servobus/bus/scheduled_line.hpp>

#include <tests/support/every_value.hpp>
#include <tests/support/scripted_port.hpp>

namespace bus_value_tests {

using namespace servobus;
using namespace servobus::units;
namespace every_value = tests::every_value;
using device = every_value::device<word_order::low_first>;
using r = every_value::rows<device>;

namespace {
constexpr node<device> meter{1};
constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<r::voltage, r::flow, r::counter>(meter, milliseconds(50)),
    cyclic<r::target, r::gain>(meter, milliseconds(50)),
    cyclic<r::name, r::model>(meter, milliseconds(50)),
    cyclic<r::selector, r::level, r::inside, r::outside, r::hour>(meter, milliseconds(50)),
    cyclic<r::power, r::total, r::exponent>(meter, milliseconds(50)),
};
} // namespace

TEST_CASE("cyclic reads take values of each type") {
    tests::waiting_scripted_port port;
    tests::plain_tables model = every_value::model(word_order::low_first);
    port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) { model(p, f, 1); };
    scheduled_line<tests::waiting_scripted_port> on{port, modbus::timing_at(115200)};
    bus<plan, scheduled_line<tests::waiting_scripted_port>> all{on};
    all.run_for(milliseconds(400));
    constexpr duration oldest = milliseconds(500);
    CHECK(*all.latest<r::voltage>(meter, oldest)->rounded(millivolt) == 230'100);
    CHECK(all.latest<r::flow>(meter, oldest)->value() == -12.5);
    CHECK(*all.latest<r::counter>(meter, oldest) == 0xFFFF'FFFF'FFFF'FFFE);
    CHECK(all.latest<r::target>(meter, oldest)->value() == 21.5f);
    CHECK(*all.latest<r::name>(meter, oldest) == "KPE7B");
    CHECK(all.latest<r::level>(meter, oldest)->count() == 100);
    CHECK(all.latest<r::outside>(meter, oldest)->count() == -5);
    CHECK(**all.latest<r::hour>(meter, oldest) == 23);
    const auto several = all.latest<r::selector, r::level, r::inside>(meter, oldest);
    REQUIRE(several);
    CHECK(several->get<r::selector>() == 1);
    CHECK(several->get<r::inside>().count() == 21);
    const auto power = all.latest<r::power, r::exponent>(meter, oldest);
    REQUIRE(power);
    CHECK(power->get<r::power>()->rounded(part<1000>(watt)) == 12'340);
    model.holding_registers[0x54] = 11; // no exponent
    all.run_for(milliseconds(100));
    CHECK(!all.latest<r::power, r::exponent>(meter, oldest)->get<r::power>());
}

} // namespace bus_value_tests
