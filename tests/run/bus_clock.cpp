// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus whose clock jumps: its reads go on.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/bus.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

using namespace servobus;

namespace {

inline constexpr node<zlac8015d::device> wheels_node{1};
inline constexpr poll_plan plan{
    modbus::timing_at(115200), drives_with_a_facade{},
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

TEST_CASE("G19, G29: a bus whose clock jumps reads on within a period") {
    for (const std::uint32_t by : {1'000'000u, 0u - 50'000u, 0u - 10'000'000u, 0u - 1'000'000'000u}) {
        CAPTURE(by);
        sim::zlac8015d model;
        sim::station at_the_drive{model};
        sim::virtual_line wire{115200};
        wire.attach(at_the_drive);
        jumping_port port{&wire};
        line on{port, modbus::timing_at(115200)};
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
