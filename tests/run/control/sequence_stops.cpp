// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The stops in a routine: in which order they go out if they are not answered, how many of their frames are
// urgent, and what is left out behind one that never got through.
#include <doctest/doctest.h>

#include <array>
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

// Whom each request went to: the register that it names.
struct addresses {
    std::vector<std::uint16_t> asked{};

    void on_request(bytes frame) { asked.push_back(load_word(frame, 2)); }
    void on_response(bytes, failure) {}
    void on_unexpected(bytes) {}
};

using watched_line = line<sim::virtual_line, addresses>;
constexpr auto tries = sequence<watched_line>::tries_of_a_stop;
constexpr duration quarantine = milliseconds(150);
constexpr std::uint32_t all = ~std::uint32_t{0};

struct rig {
    store registers;
    sim::station<store> drive{registers, 1, 115200};
    sim::virtual_line wire{115200};
    watched_line on{wire, modbus::timing_at(115200)};
    sequence<watched_line> routines{on, 1, response_limits{}, bus_gaps{.quarantine = quarantine}};
    std::vector<std::uint64_t> begun{}; // when each of them did

    rig() {
        wire.attach(drive);
        client prove{on, node<axis>{1}};
        REQUIRE(prove.read<status>());
        registers = {};
        on.observer() = {};
    }
    const std::vector<std::uint16_t>& asked() { return on.observer().asked; }
    // Of the requests those in `lost` (bit 0: the first) do not reach the drive.
    const report& go_on(std::uint32_t lost) {
        while (!routines.is_idle()) {
            const duration idle = routines.step();
            if (begun.size() != asked().size()) begun.push_back(wire.time_us());
            const bool is_lost = !begun.empty() && ((lost >> (begun.size() - 1)) & 1u) != 0;
            wire.set_connected(0, !is_lost);
            wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
        return routines.last();
    }
    const report& run(routine steps, std::uint32_t lost) {
        routines.begin(steps);
        return go_on(lost);
    }
    // Between two requests of which the first one is not answered.
    bool waits_before(std::size_t i) const {
        return begun[i] - begun[i - 1] > (response_limits{}.response + quarantine).us;
    }
};

using list = std::vector<std::uint16_t>;

} // namespace

TEST_CASE("G25: each of several stops goes out before any goes out again") {
    rig r;
    const std::uint32_t first_two = 0b11;
    CHECK(r.run(stop, first_two));
    CHECK(r.asked() ==
          list{targets.address, control.address, targets.address, control.address, status.address});

    rig second;
    CHECK(second.run(stop, 0b10));
    CHECK(second.asked() == list{targets.address, control.address, control.address, status.address});

    rig first;
    CHECK(first.run(stop, 0b01));
    CHECK(first.asked() == list{targets.address, control.address, targets.address, status.address});
    CHECK(first.registers.written == list{control.address, targets.address});
}

TEST_CASE("G25: a stop that must not be the first frame heard waits for another's answer") {
    static constexpr step three[] = {steps::repeatable(steps::write<targets>(0)),
                                     steps::behind_a_stop(steps::repeatable(steps::write<servo_on>(0))),
                                     steps::repeatable(steps::write<control>(0)),
                                     steps::expect_zero<status>()};
    rig fine;
    CHECK(fine.run(three, 0));
    CHECK(fine.asked() == list{targets.address, servo_on.address, control.address, status.address});

    rig late; // two of the first are lost
    CHECK(late.run(three, 0b011));
    CHECK(late.asked() == list{targets.address, control.address, targets.address, servo_on.address,
                               control.address, status.address});
    CHECK(late.registers.written == list{targets.address, servo_on.address, control.address});

    rig last; // found in the last round
    CHECK(last.run(three, 0b01'1111).error() == errc::timeout);
    CHECK(last.registers.written == list{control.address});

    rig gone;
    CHECK(gone.run(three, all).error() == errc::timeout);
    CHECK(gone.asked().size() == 2u * tries);
    CHECK(gone.registers.written.empty());
}

TEST_CASE("S2: behind a stop that never got through nothing is written but the stops beside it") {
    rig r;
    const report made = r.run(enable, 0b1101); // the targets, three times
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(made.has_changed);
    CHECK(r.registers.written == list{control.address});
    CHECK(r.registers.reads == 1);

    rig fine;
    CHECK(fine.run(enable, 0b0101));
    CHECK(fine.registers.written == list{control.address, targets.address, servo_on.address});
}

TEST_CASE("G26: a stop that missed one of its frames still makes the other and looks, and is no success") {
    for (const std::uint32_t lost : {0b1101u, 0b1110u}) {
        CAPTURE(lost);
        const std::uint16_t made_one = lost == 0b1101u ? control.address : targets.address;
        rig r;
        const report made = r.run(stop, lost);
        CHECK(made.outcome() == outcome::unknown);
        CHECK(made.error() == errc::timeout);
        CHECK(made.step == 2);
        CHECK(r.registers.written == list{made_one});
        CHECK(r.registers.reads == 1);
    }
}

TEST_CASE("G26: behind a stop that missed one of its frames nothing is waited for: it is to be made again") {
    static constexpr step stop_and_wait[] = {steps::repeatable(steps::write<targets>(0)),
                                             steps::repeatable(steps::write<control>(0)),
                                             steps::until_bits<status>(1, 1, 34'000)};
    rig r;
    const report made = r.run(stop_and_wait, 0b1110);
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(made.step == 2);
    CHECK(made.has_changed);
    CHECK(r.registers.reads == 1);
}

TEST_CASE("G25: what has not left keeps its urgency") {
    rig r;
    r.routines.begin(stop);
    r.wire.unplug();
    CHECK(r.go_on(0).outcome() == outcome::not_sent);
    CHECK(r.routines.urgent_left() == steps::urgent_frames);
    r.wire.plug();
    (void)r.run(stop, 0);
    CHECK(r.routines.urgent_left() == steps::urgent_frames - 2);
}

TEST_CASE("G26: a stop of which nothing was answered ends there") {
    rig r;
    const report made = r.run(stop, all);
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(made.step == 1);
    CHECK(r.asked().size() == 2u * tries);
    CHECK(r.registers.reads == 0);
}

TEST_CASE("G25: a port that is lost ends a stop at once") {
    rig r;
    r.routines.begin(stop);
    r.wire.unplug();
    const report made = r.go_on(0);
    CHECK(made.outcome() == outcome::not_sent);
    CHECK(made.error() == errc::port_lost);
    CHECK(made.step == 0);
}

TEST_CASE("G19, G25: the first frames of a stop wait for no quarantine, the others do") {
    rig r;
    (void)r.run(stop, all);
    REQUIRE(r.begun.size() == 6);
    for (std::size_t i = 1; i < 6; ++i) {
        CAPTURE(i);
        CHECK(r.waits_before(i) == (i >= steps::urgent_frames));
    }
}

TEST_CASE("G19: a stop that is begun again is not urgent") {
    rig r;
    r.routines.begin(stop, {}, 0);
    CHECK_FALSE(r.routines.has_stop_to_send());
    (void)r.go_on(all);
    REQUIRE(r.begun.size() == 6);
    for (std::size_t i = 1; i < 6; ++i) CHECK(r.waits_before(i));
}

TEST_CASE("G19: a stop behind other steps of a routine is repeated and is not urgent") {
    static constexpr step late[] = {steps::expect_zero<status>(),
                                    steps::repeatable(steps::write<control>(0))};
    rig r;
    const report made = r.run(late, ~0b1u);
    CHECK(made.step == 1);
    REQUIRE(r.begun.size() == 4);
    CHECK(r.waits_before(2));
    CHECK(r.waits_before(3));
    r.begun.clear();
    r.on.observer() = {};
    CHECK(r.run(late, 0b110));
    CHECK(r.asked() == list{status.address, control.address, control.address, control.address});
}

TEST_CASE("a routine may have more stops side by side than are tried together") {
    static constexpr auto many = [] {
        std::array<step, 10> s{};
        for (std::size_t i = 0; i < s.size(); ++i) {
            s[i] = steps::repeatable(steps::write<targets>(0));
            s[i].address = static_cast<std::uint16_t>(0x100 + i);
        }
        return s;
    }();
    rig r;
    CHECK(r.run(many, 0b10'0000'0001));
    CHECK(r.asked() ==
          list{0x100, 0x101, 0x102, 0x103, 0x104, 0x105, 0x106, 0x107, 0x100, 0x108, 0x109, 0x108});

    rig gone;
    CHECK_FALSE(gone.run(many, 0xFF'FFFF)); // all three rounds of the first eight
    REQUIRE(gone.asked().size() == 26);
    CHECK(gone.asked()[24] == 0x108);
    CHECK(gone.registers.written == list{0x108, 0x109});
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
