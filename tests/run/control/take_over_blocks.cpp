// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A position that has fallen raises the question whether the drive has restarted: the witness is read. A take-over that
// has begun meanwhile asks nothing, since it finds out anew what the drive is.
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>

#include <tests/support/simulated_c630s.hpp>

namespace take_over_blocks_tests {

using namespace servobus;
using namespace servobus::units;
using namespace c630s;

namespace {

constexpr register_block positions = c630s::model::blocks[c630s::model::blocks.positions()];

/// Its witness counts during a take-over too, as that of a program's own model may.
struct own_model : c630s::model {
    static constexpr steps::recheck witness(const settings& known, const prepared_command& c) {
        return c.then == effect::initialised ? c630s::model::witness(known, {.steps = no_steps})
                                             : c630s::model::witness(known, c);
    }
};
struct rig : simulated::simulated_c630s {
    struct own_drive : facade<own_model, line_type> {
        explicit own_drive(line_type& on)
            : facade<own_model, line_type>{on, node<c630s::device>{1}, milliseconds(20), no_command_timeout} {
        }
    };
    own_drive drive{line};

    /// At rest far from zero, switched off and known; then it restarts, and its position is asked for.
    bool is_asked() {
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(set_up{}));
        model.power_cycle();
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(segment{1, 30'000 * reference_unit, 600 * units::r_per_min}));
        REQUIRE(drive.run(enable_in{control_mode::position}));
        REQUIRE(drive.run(start_segment{1}));
        REQUIRE(drive.run(wait_reached{}));
        REQUIRE(drive.run(disable{}));
        loop(500);
        while (!asks_for(requests.size() - 1, positions.address)) turn();
        loop(20); // the response has come
        model.power_cycle();
        while (!asks_for(requests.size() - 1, positions.address)) turn();
        return drive.state() == drive_state::disabled;
    }
    void turn() {
        const duration idle = drive.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) turn();
    }
    bool asks_for(std::size_t i, std::uint16_t address) const {
        return requests[i][1] == 0x03 && load_word(requests[i], 2) == address;
    }
    bool is_write(std::size_t i) const { return modbus::is_write(requests[i][1]); }
};

} // namespace

TEST_CASE("a position that has fallen makes the witness due") {
    rig r;
    REQUIRE(r.is_asked());
    const std::size_t next = r.requests.size();
    r.loop(1000);
    REQUIRE(r.requests.size() > next);
    const routine witness = routines::same_inputs;
    CHECK(r.asks_for(next, witness[0].address));
    CHECK(r.drive.state() == drive_state::needs_init);
}
TEST_CASE("a position that has fallen makes no witness due for a take-over") {
    rig r;
    REQUIRE(r.is_asked());
    const std::size_t next = r.requests.size();
    REQUIRE(r.drive.begin(init{}) == errc::ok);
    while (!r.drive.is_idle()) r.turn();
    CHECK(r.drive.last());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.requests.size() > next);
    CHECK(r.is_write(next)); // its first stop
}

} // namespace take_over_blocks_tests
