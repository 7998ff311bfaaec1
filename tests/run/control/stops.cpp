// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The stops of a routine: in which order they are sent if they get no response, how many of their frames have
// priority, and what is left out after one that was never acknowledged.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>

#include <tests/support/bare_drive.hpp>

namespace stops_tests {

using namespace servobus;

namespace {

struct axis {
    static constexpr profile facts{.name = "axis"};
};
inline constexpr reg<u16, access::rw, axis> targets{0x0010, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, axis> control{0x0020, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, axis> servo_on{0x0030, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::ro, axis> status_word{0x0040, full<u16>, no_unit, 0};

inline constexpr step enable[] = {steps::repeatable(steps::write<targets>(0)),
                                  steps::repeatable(steps::write<control>(0)),
                                  steps::expect_zero<status_word>(), steps::write<servo_on>(1)};
inline constexpr step stop[] = {steps::repeatable(steps::write<targets>(0)),
                                steps::repeatable(steps::write<control>(0)),
                                steps::expect_zero<status_word>()};

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

// Records the register that each request names.
struct addresses {
    std::vector<std::uint16_t> asked{};

    void on_request(bytes frame) { asked.push_back(load_word(frame, 2)); }
    void on_response(bytes, status) {}
    void on_unexpected(bytes) {}
};

using watched_line = line<sim::virtual_line, addresses>;
constexpr unsigned tries = 3;
constexpr duration quarantine = milliseconds(150);
constexpr std::uint32_t all = ~std::uint32_t{0};

struct rig {
    store registers;
    sim::station<store> drive{registers, 1, 115200};
    sim::virtual_line wire{115200};
    watched_line on{wire, modbus::timing_at(115200)};
    bare::drive<watched_line> machine{on, at()};
    std::vector<std::uint64_t> begun{}; // when each request began

    static node<axis> at() {
        node<axis> n{1};
        n.limits = {};
        n.gaps = {.quarantine = quarantine};
        return n;
    }
    rig() {
        wire.attach(drive);
        client prove{on, node<axis>{1}};
        REQUIRE(prove.read<status_word>());
        registers = {};
        on.observer() = {};
    }
    const std::vector<std::uint16_t>& asked() { return on.observer().asked; }
    // The requests in `lost` (bit 0: the first) do not reach the drive.
    command_status go_on(std::uint32_t lost) {
        while (!machine.is_idle()) {
            const duration idle = machine.step();
            if (begun.size() != asked().size()) begun.push_back(wire.time_us());
            const bool is_lost = !begun.empty() && ((lost >> (begun.size() - 1)) & 1u) != 0;
            wire.set_connected(0, !is_lost);
            wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
        return machine.last();
    }
    void begin(routine steps, stop_priority priority = stop_priority::halt) {
        REQUIRE(machine.begin(bare::command{.steps = steps, .stop = priority}) == errc::ok);
    }
    const command_status run(routine steps, std::uint32_t lost) {
        begin(steps);
        return go_on(lost);
    }
    // Whether request `i` waited for the quarantine after one without a response.
    bool waits_before(std::size_t i) const {
        return begun[i] - begun[i - 1] > (response_limits{}.response + quarantine).us;
    }
};

using list = std::vector<std::uint16_t>;

} // namespace

TEST_CASE("G25: each of several stops is sent before any is sent again") {
    rig r;
    const std::uint32_t first_two = 0b11;
    CHECK(r.run(stop, first_two));
    CHECK(r.asked() ==
          list{targets.address, control.address, targets.address, control.address, status_word.address});

    rig second;
    CHECK(second.run(stop, 0b10));
    CHECK(second.asked() == list{targets.address, control.address, control.address, status_word.address});

    rig first;
    CHECK(first.run(stop, 0b01));
    CHECK(first.asked() == list{targets.address, control.address, targets.address, status_word.address});
    CHECK(first.registers.written == list{control.address, targets.address});
}

TEST_CASE("G25: a stop that must not be the first frame waits for the response to another stop") {
    static constexpr step three[] = {steps::repeatable(steps::write<targets>(0)),
                                     steps::after_a_stop(steps::repeatable(steps::write<servo_on>(0))),
                                     steps::repeatable(steps::write<control>(0)),
                                     steps::expect_zero<status_word>()};
    rig fine;
    CHECK(fine.run(three, 0));
    CHECK(fine.asked() == list{targets.address, servo_on.address, control.address, status_word.address});

    rig late; // the first two requests are lost
    CHECK(late.run(three, 0b011));
    CHECK(late.asked() == list{targets.address, control.address, targets.address, servo_on.address,
                               control.address, status_word.address});
    CHECK(late.registers.written == list{targets.address, servo_on.address, control.address});

    rig last; // the drive responds in the last round
    CHECK(last.run(three, 0b01'1111).error() == errc::timeout);
    CHECK(last.registers.written == list{control.address});

    rig gone;
    CHECK(gone.run(three, all).error() == errc::timeout);
    CHECK(gone.asked().size() == 2u * tries);
    CHECK(gone.registers.written.empty());
}

TEST_CASE("S2: after a stop that was never acknowledged nothing is written but the stops next to it") {
    rig r;
    const command_status made = r.run(enable, 0b1101); // the targets are lost three times
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(made.has_changed());
    CHECK(r.registers.written == list{control.address});
    CHECK(r.registers.reads == 1);

    rig fine;
    CHECK(fine.run(enable, 0b0101));
    CHECK(fine.registers.written == list{control.address, targets.address, servo_on.address});
}

TEST_CASE("G26: a stop of which one frame failed still sends the other and reads back, and is no success") {
    for (const std::uint32_t lost : {0b1101u, 0b1110u}) {
        CAPTURE(lost);
        const std::uint16_t made_one = lost == 0b1101u ? control.address : targets.address;
        rig r;
        const command_status made = r.run(stop, lost);
        CHECK(made.outcome() == outcome::unknown);
        CHECK(made.error() == errc::timeout);
        CHECK(made.step() == 2);
        CHECK(r.registers.written == list{made_one});
        CHECK(r.registers.reads == 1);
    }
}

TEST_CASE("G26: after a stop of which one frame failed nothing is awaited, since the stop must be repeated") {
    static constexpr step stop_and_wait[] = {steps::repeatable(steps::write<targets>(0)),
                                             steps::repeatable(steps::write<control>(0)),
                                             steps::until_bits<status_word>(1, 1, 34'000)};
    rig r;
    const command_status made = r.run(stop_and_wait, 0b1110);
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(made.step() == 2);
    CHECK(made.has_changed());
    CHECK(r.registers.reads == 1);
}

TEST_CASE("G26: a stop without any response ends before its read") {
    rig r;
    const command_status made = r.run(stop, all);
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.error() == errc::timeout);
    CHECK(made.step() == 1);
    CHECK(r.asked().size() == 2u * tries);
    CHECK(r.registers.reads == 0);
}

TEST_CASE("G25: a lost port ends a stop immediately") {
    rig r;
    r.begin(stop);
    r.wire.unplug();
    const command_status made = r.go_on(0);
    CHECK(made.outcome() == outcome::not_sent);
    CHECK(made.error() == errc::port_lost);
    CHECK(made.step() == 0);
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

TEST_CASE("G19: a stop after other steps of a routine is repeated and has no priority") {
    static constexpr step late[] = {steps::expect_zero<status_word>(),
                                    steps::repeatable(steps::write<control>(0))};
    rig r;
    const command_status made = r.run(late, ~0b1u);
    CHECK(made.step() == 1);
    REQUIRE(r.begun.size() == 4);
    CHECK(r.waits_before(2));
    CHECK(r.waits_before(3));
    r.begun.clear();
    r.on.observer() = {};
    CHECK(r.run(late, 0b110).error() == errc::own_echo); // G3: nothing is read after the stop
    CHECK(r.asked() == list{status_word.address, control.address, control.address, control.address});
}

TEST_CASE("a routine may have more adjacent stops than are tried together") {
    static constexpr auto many = [] {
        std::array<step, 10> s{};
        for (std::size_t i = 0; i < s.size(); ++i) {
            s[i] = steps::repeatable(steps::write<targets>(0));
            s[i].address = static_cast<std::uint16_t>(0x100 + i);
        }
        return s;
    }();
    rig r;
    CHECK(r.run(many, 0b10'0000'0001).error() == errc::own_echo); // G3: nothing is read after the stops
    CHECK(r.asked() ==
          list{0x100, 0x101, 0x102, 0x103, 0x104, 0x105, 0x106, 0x107, 0x100, 0x108, 0x109, 0x108});

    rig gone;
    CHECK_FALSE(gone.run(many, 0xFF'FFFF)); // all three rounds of the first eight
    REQUIRE(gone.asked().size() == 26);
    CHECK(gone.asked()[24] == 0x108);
    CHECK(gone.registers.written == list{0x108, 0x109});
}

TEST_CASE("G25: a stop that replaces a waiting step is sent in the next loop iteration") {
    rig r;
    r.begin(enable);
    CHECK_FALSE(r.machine.is_idle());
    (void)r.machine.step(); // the line has not been quiet for t3.5 yet
    CHECK(r.wire.requests() == 1);
    CHECK(r.machine.machine().wants_stop());
    r.wire.wait(milliseconds(200));
    r.begin(stop, stop_priority::disable);
    CHECK(r.machine.machine().wants_stop());
    (void)r.machine.step();
    CHECK(r.on.is_sending());
    CHECK_FALSE(r.machine.machine().wants_stop());
}

TEST_CASE(
    "G21: a write that is dropped for a stop without a response invalidates the state, whatever is dropped "
    "after it") {
    static constexpr step set_only[] = {steps::write<servo_on>(1), steps::expect_zero<status_word>()};
    static constexpr step read_only[] = {steps::expect_zero<status_word>()};
    for (const bool is_first_lost : {false, true}) {
        for (const bool is_second_lost : {false, true}) {
            CAPTURE(is_first_lost);
            CAPTURE(is_second_lost);
            rig r;
            REQUIRE(r.machine.begin(bare::command{.steps = read_only, .then = command_kind::take_over}) ==
                    errc::ok);
            CHECK(r.go_on(0));
            REQUIRE(r.machine.state() == drive_state::enabled);
            for (const bool is_lost : {is_first_lost, is_second_lost}) {
                r.begin(set_only, stop_priority::no_stop);
                while (!r.on.is_sending()) {
                    (void)r.machine.step();
                    r.wire.wait(microseconds(10));
                }
                r.wire.set_connected(0, !is_lost);
                r.begin(stop);
                const std::size_t writes = r.asked().size();
                while (r.asked().size() == writes) { // until the first stop leaves
                    (void)r.machine.step();
                    r.wire.wait(microseconds(10));
                }
                r.wire.set_connected(0, true);
                while (!r.machine.is_idle()) r.wire.wait(r.machine.step());
                CHECK(r.machine.last());
            }
            const bool is_known = r.machine.state() == drive_state::enabled;
            CHECK(is_known == !(is_first_lost || is_second_lost));
        }
    }
}

TEST_CASE("a model whose stop has no steps ends the command at a fault, and nothing is known of its drive") {
    static constexpr step take[] = {steps::fetch<status_word>(0)};
    static constexpr step wait[] = {steps::until_bits<status_word>(1, 1, 1000)};
    for (const bool is_idle : {false, true}) {
        CAPTURE(is_idle);
        rig r;
        bare::drive<watched_line> polled{r.on, rig::at(), milliseconds(10)};
        REQUIRE(polled.run(bare::command{.steps = take, .then = command_kind::take_over}));
        REQUIRE(polled.state() == drive_state::enabled);
        if (!is_idle) REQUIRE(polled.begin(bare::command{.steps = wait}) == errc::ok);
        bare::model::stops_by = {.steps = no_steps, .stop = stop_priority::halt};
        bare::model::judges = [](std::uint16_t) { return verdict::faulted; };
        for (int i = 0; i < 1000; ++i) {
            (void)polled.step();
            r.wire.wait(microseconds(50));
        }
        bare::model::judges = [](std::uint16_t) { return verdict::as_expected; };
        bare::model::stops_by = {.steps = no_steps};
        CHECK(polled.is_idle());
        CHECK(polled.state() == drive_state::needs_init);
        if (!is_idle) CHECK(polled.last().error() == errc::faulted);
        CHECK(r.registers.written.empty());
    }
}

} // namespace stops_tests
