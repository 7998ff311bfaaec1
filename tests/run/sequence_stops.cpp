// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stop in a routine that never gets through: the stops behind it are still made, and nothing else is.
#include <doctest/doctest.h>

#include <cstdint>
#include <span>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>

using namespace servobus;

namespace {

struct axis {
    static constexpr profile facts{.name = "axis"};
};
inline constexpr reg<u16, access::rw, axis> targets{0x0010, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, axis> control{0x0020, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, axis> servo_on{0x0030, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::ro, axis> status{0x0040, full<u16>, no_unit, 0};

inline constexpr step enable[] = {steps::repeatable(steps::write<targets>(0)),
                                  steps::repeatable(steps::write<control>(0)), steps::expect_zero<status>(),
                                  steps::write<servo_on>(1)};
inline constexpr step stop[] = {steps::repeatable(steps::write<targets>(0)),
                                steps::repeatable(steps::write<control>(0)), steps::expect_zero<status>()};

struct store {
    std::vector<std::uint16_t> written;
    unsigned reads = 0;

    std::uint8_t read(std::uint16_t, std::span<std::uint16_t> to) {
        for (std::uint16_t& word : to) word = 0;
        ++reads;
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view) {
        written.push_back(address);
        return 0;
    }
};

struct rig {
    store registers;
    sim::station<store> drive{registers, 1, 115200};
    sim::virtual_line wire{115200};
    line<sim::virtual_line> on{wire, modbus::timing_at(115200)};
    sequence<line<sim::virtual_line>> routines{on, 1, patience{}, silences{}};

    rig() {
        wire.attach(drive);
        client prove{on, node<axis>{1}};
        REQUIRE(prove.read<status>());
        registers = {};
    }
    // The drive is gone for the first `lost` requests.
    const report& run(routine steps, std::uint32_t lost) {
        const std::uint32_t before = wire.requests();
        wire.set_connected(0, lost == 0);
        routines.begin(steps);
        while (!routines.is_idle()) {
            const duration idle = routines.step();
            if (wire.requests() > before + lost) wire.set_connected(0, true);
            wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
        return routines.last();
    }
};

} // namespace

TEST_CASE("S2: behind a stop that never got through nothing is written but the stops behind it") {
    constexpr auto tries = sequence<line<sim::virtual_line>>::tries_of_a_stop;
    rig r;
    const report made = r.run(enable, tries);
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(made.has_changed);
    CHECK(r.registers.written == std::vector<std::uint16_t>{control.address});

    rig fine;
    CHECK(fine.run(enable, tries - 1u));
    CHECK(fine.registers.written ==
          std::vector<std::uint16_t>{targets.address, control.address, servo_on.address});
}

TEST_CASE("G26: a stop that missed one of its frames still makes the other and looks, and is no success") {
    rig r;
    const report made = r.run(stop, sequence<line<sim::virtual_line>>::tries_of_a_stop);
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(r.registers.written == std::vector<std::uint16_t>{control.address});
    CHECK(r.registers.reads == 1);
}

TEST_CASE("G25: a stop that takes the place of a step that waits leaves at the next look") {
    rig r;
    r.routines.begin(enable);
    CHECK_FALSE(r.routines.is_idle());
    (void)r.routines.step(); // the line has not been silent for t3.5 yet
    CHECK(r.wire.requests() == 1);
    CHECK(r.routines.has_stop_to_send());
    r.wire.wait(milliseconds(200));
    r.routines.begin(stop);
    CHECK(r.routines.has_stop_to_send());
    (void)r.routines.step();
    CHECK(r.on.is_sending());
    CHECK_FALSE(r.routines.has_stop_to_send());
}
