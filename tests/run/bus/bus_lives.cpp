// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a bus delivers of a drive that has restarted and is initialised again at once: nothing that was read before.
#include <doctest/doctest.h>

#include <tests/support/driven_wheels_and_lift.hpp>

namespace bus_lives_tests {

using namespace servobus;
using namespace servobus::units;

TEST_CASE("G21, G36: after a restart and an `init` a bus delivers no cyclic value that it read before") {
    constexpr std::int32_t place = 0x12345;
    unsigned read_again = 0;
    for (std::uint32_t phase = 0; phase < 40; ++phase) {
        CAPTURE(phase);
        tests::wheels_and_lift machine;
        tests::wheels_and_lift_program p{machine.wire};
        REQUIRE(p.all.run(p.lift, init{}));
        REQUIRE(p.all.run(p.lift, enable{}));
        REQUIRE(p.all.run(p.lift, declare_position{place * pulse}));
        p.run(300 + 3 * phase);
        const auto before = p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(500));
        REQUIRE(before);
        REQUIRE(before->count() == place);
        machine.lift_model.power_cycle();
        while (p.lift.state() != yako::drive_state::needs_init || !p.lift.is_idle()) p.turn();
        REQUIRE(p.lift.begin(init{}) == errc::ok); // in the same loop iteration
        const std::uint32_t exchanges = p.all.count(2);
        const std::uint64_t end = machine.wire.time_us() + 600'000;
        while (machine.wire.time_us() < end) {
            const auto seen = p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(2000));
            if (p.all.count(2) == exchanges) REQUIRE_FALSE(seen); // none was read since
            if (seen) REQUIRE(seen->count() == 0);
            p.turn();
        }
        REQUIRE(p.lift.last());
        read_again += p.all.count(2) != exchanges ? 1u : 0u;
    }
    CHECK(read_again == 40);
}

} // namespace bus_lives_tests
