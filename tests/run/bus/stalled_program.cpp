// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program that stalls for longer than the watchdog of a drive, at any moment of a cyclic read of its bus. The
// frames on the wire judge it.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/loop_bound.hpp>

namespace stalled_program_tests {

using namespace servobus;
using tests::lift_node, tests::wheels_node;
using wire = scheduled_line<sim::virtual_line>;

namespace {

/// Both drives are read often, so that a read of either waits for the line at many moments.
constexpr poll_plan often{modbus::timing_at(115200), controlled(wheels_node, unsupervised),
                          controlled(lift_node, unsupervised),
                          cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(16)),
                          cyclic<yako::error_code>(lift_node, milliseconds(16))};

struct rig {
    tests::wheels_and_lift machine;
    wire on{machine.wire, modbus::timing_at(115200)};
    zlac8015d::drive<wire> wheels{on, wheels_node, by_plan};
    yako::closed_loop::drive<wire> lift{on, lift_node};
    bus<often, wire, decltype(wheels), decltype(lift)> all{on, wheels, lift};
    std::vector<std::uint8_t> open{}; ///< of the request on the wire
    std::size_t requests[3]{};        ///< to each node

    rig() { machine.wire.set_hook(&rig::note, this); }
    rig(const rig&) = delete;
    rig& operator=(const rig&) = delete;

    static void note(void* self, const sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& r = *static_cast<rig*>(self);
        r.open.push_back(b.value);
        if (r.open.size() != modbus::request_length(r.open)) return;
        ++r.requests[r.open[0]];
        r.open.clear();
    }
    void turn() {
        const duration idle = all.step();
        machine.wire.wait(idle.us == 0 ? microseconds(50) : idle);
    }
    template <class Drive> void initialise(Drive& drive) {
        REQUIRE(drive.begin(init{}) == errc::ok);
        for (tests::loop_bound left{"the end of an init"}; !drive.is_idle(); left.use()) turn();
        REQUIRE(drive.last());
    }
};

} // namespace

TEST_CASE("S3: no cyclic read is the first frame after the watchdog's time, at whichever moment the program "
          "stalls") {
    rig r;
    r.initialise(r.lift);
    for (unsigned turns = 0; turns < 150; ++turns) {
        CAPTURE(turns);
        r.initialise(r.wheels);
        for (unsigned i = 0; i < turns; ++i) r.turn();
        REQUIRE(r.wheels.state() != drive_state::needs_init);
        r.machine.wire.pass(milliseconds(3000)); // the factory's watchdog has 1 s
        const std::size_t to_wheels = r.requests[1];
        const std::size_t to_lift = r.requests[2];
        for (const std::uint64_t end = r.machine.wire.time_us() + 100'000; r.machine.wire.time_us() < end;)
            r.turn();
        CHECK(r.requests[1] == to_wheels);
        CHECK(r.requests[2] >= to_lift + 4); // a drive without a watchdog is read on
        CHECK(r.wheels.state() == drive_state::needs_init);
        CHECK(r.all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(10'000)).error() ==
              errc::needs_init);
    }
}

} // namespace stalled_program_tests
