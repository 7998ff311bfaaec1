// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G21, G35: a stop of a C630S writes P31-00 with the marker by which a restart shows. The stop reads the marker first,
// while another stop acts.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>

namespace restart_c630s_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

namespace {

/// When the witness, P31-00, was read last, and when the first write after that was sent.
struct wire_log {
    std::vector<std::uint8_t> open;
    std::uint64_t last_us = 0;
    std::uint64_t witness_us = 0;
    std::uint64_t write_us = 0;

    static void note(void* self, const sim::wire_byte& b) {
        auto& log = *static_cast<wire_log*>(self);
        if (!b.is_from_client) return;
        if (b.at_us - log.last_us > 1000) log.open.clear(); // another frame
        log.last_us = b.at_us;
        log.open.push_back(b.value);
        if (log.open.size() != modbus::request_length(log.open)) return;
        const bool is_write = modbus::is_write(log.open[1]);
        if (is_write && log.write_us == 0) log.write_us = b.at_us;
        if (!is_write && load_word(log.open, 2) == virtual_input_levels.address && log.write_us == 0)
            log.witness_us = b.at_us;
        log.open.clear();
    }
};

struct program : simulated::simulated_c630s {
    c630s::drive<line_type> servo;

    explicit program(duration every)
        : servo{line, 1, {.feedback = every, .command_timeout = no_command_timeout}} {
        REQUIRE(servo.run(init{}));
        REQUIRE(servo.run(set_up{}));
        model.power_cycle();
        REQUIRE(servo.run(init{}));
        REQUIRE(servo.run(enable_in{control_mode::speed}));
        REQUIRE(servo.run(velocity{100 * r_per_min}));
    }
    void turn() {
        const duration idle = servo.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) turn();
    }
};

/// Until P31-00 is written, reads of it are lost on the way to the drive.
struct marker_thief {
    program* of = nullptr;
    std::vector<std::uint8_t> open;
    std::uint64_t last_us = 0;
    unsigned reads = 0;
    bool is_over = false;

    static void note(void* self, const sim::wire_byte& b) {
        auto& thief = *static_cast<marker_thief*>(self);
        if (!b.is_from_client) return;
        if (b.at_us - thief.last_us > 1000) { // another frame
            thief.open.clear();
            thief.of->wire.set_connected(0, true);
        }
        thief.last_us = b.at_us;
        thief.open.push_back(b.value);
        if (thief.open.size() != 4 || load_word(thief.open, 2) != virtual_input_levels.address) return;
        thief.is_over = thief.is_over || modbus::is_write(thief.open[1]);
        if (thief.is_over) return;
        ++thief.reads;
        thief.of->wire.set_connected(0, false);
    }
};

} // namespace

TEST_CASE("G21, G35: a restart shows although a fault stops the drive while its witness is due to be read") {
    unsigned was_due = 0;
    // The feedback after which the stop follows is under way as the time of the witness, 500 ms, passes.
    for (std::uint32_t phase = 0; phase < 120; ++phase) {
        program p{milliseconds(16 + phase % 20)};
        p.loop(700);
        wire_log log;
        p.wire.set_hook(&wire_log::note, &log);
        const std::uint64_t begun = p.wire.time_us();
        while (log.witness_us == 0 && p.wire.time_us() - begun < 600'000) p.turn();
        while (p.wire.time_us() < log.witness_us + 485'000 + 125 * phase) p.turn();
        log.write_us = 0;
        p.model.raise(0x620, true);
        p.model.power_cycle();
        p.loop(1200);
        CAPTURE(phase);
        // The frames take 7 ms of this time.
        if (log.write_us < log.witness_us + 507'000) continue;
        ++was_due;
        CHECK(p.servo.state() == drive_state::needs_init);
        CHECK(p.servo.begin(enable_in{control_mode::speed}) == errc::needs_init);
    }
    CHECK(was_due > 10);
}

TEST_CASE("G21, G35: a restart at any moment before a stop shows, for a fault and by the program") {
    enum class stop : std::uint8_t { for_fault, by_disable, by_quick_stop };
    for (const stop how : {stop::for_fault, stop::by_disable, stop::by_quick_stop}) {
        for (const control_mode mode : {control_mode::speed, control_mode::torque, control_mode::position}) {
            for (std::uint32_t phase = 0; phase < 50; ++phase) {
                program p{milliseconds(20)};
                if (mode != control_mode::speed) {
                    REQUIRE(p.servo.run(disable{}));
                    REQUIRE(p.servo.run(enable_in{mode}));
                }
                p.loop(300);
                const std::uint64_t begun = p.wire.time_us();
                while (p.wire.time_us() < begun + 411 * phase) p.turn();
                if (how == stop::for_fault) p.model.raise(0x620, true);
                p.model.power_cycle();
                while (p.wire.time_us() < begun + 411 * phase + 37 * (phase % 11)) p.turn();
                if (how == stop::by_disable) (void)p.servo.run(disable{});
                if (how == stop::by_quick_stop) (void)p.servo.run(quick_stop{});
                p.loop(1200);
                CAPTURE(int(how));
                CAPTURE(int(mode));
                CAPTURE(phase);
                REQUIRE(p.servo.state() == drive_state::needs_init);
                REQUIRE(p.servo.begin(enable_in{control_mode::speed}) == errc::needs_init);
                REQUIRE(!p.model.enabled());
            }
        }
    }
}

TEST_CASE("G21, G35: a restart at any moment of a fault's reset shows, though the reset sets the marker") {
    unsigned moments = 0;
    for (const std::uint32_t off_ms : {20u, 100u}) {
        for (std::uint32_t at_ms = 0;; at_ms += 3) {
            CAPTURE(off_ms);
            CAPTURE(at_ms);
            program p{milliseconds(20)};
            p.model.raise(0x620, true);
            p.loop(300);
            p.model.end_causes();
            REQUIRE(p.servo.begin(fault_reset{}) == errc::ok);
            const std::uint64_t at = p.wire.time_us() + at_ms * 1000u;
            while (p.wire.time_us() < at && !p.servo.is_idle()) p.turn();
            if (p.servo.is_idle()) break;
            ++moments;
            p.model.power_cycle();
            p.wire.set_connected(0, false);
            p.loop(off_ms);
            p.wire.set_connected(0, true);
            while (!p.servo.is_idle()) p.turn();
            p.loop(1000);
            CHECK(p.servo.state() == drive_state::needs_init);
        }
    }
    CHECK(moments >= 40);
}

TEST_CASE("G25, G26: a stop that gets no response to its read of the marker switches the servo off") {
    for (const control_mode mode : {control_mode::speed, control_mode::torque, control_mode::position}) {
        program p{milliseconds(20)};
        REQUIRE(p.servo.run(disable{}));
        REQUIRE(p.servo.run(enable_in{mode}));
        marker_thief thief;
        p.wire.set_hook(&marker_thief::note, &thief);
        thief.of = &p;
        REQUIRE(p.servo.run(disable{}));
        CHECK(thief.reads >= 1);
        CHECK(!p.model.enabled());
        CHECK(p.servo.state() == drive_state::needs_init);
    }
}

TEST_CASE("G21, G35: a restart shows that makes the servo-off of a stop get no response") {
    unsigned judged = 0;
    for (std::uint32_t phase = 0; phase < 100; ++phase) {
        CAPTURE(phase);
        program p{milliseconds(20)};
        p.loop(300);
        REQUIRE(p.servo.begin(disable{}) == errc::ok);
        const std::uint64_t end = p.wire.time_us() + 400 * phase;
        while (p.wire.time_us() < end && !p.servo.is_idle()) {
            (void)p.servo.step();
            p.wire.wait(microseconds(100));
        }
        if (!p.model.enabled()) break;
        ++judged;
        p.model.power_cycle();
        p.wire.set_connected(0, false); // while it starts
        const std::uint64_t up = p.wire.time_us() + 60'000;
        while (p.wire.time_us() < up) p.turn();
        p.wire.set_connected(0, true);
        p.loop(1500);
        REQUIRE(p.servo.is_idle());
        CHECK(p.servo.state() == drive_state::needs_init);
        CHECK(p.servo.begin(enable_in{control_mode::speed}) == errc::needs_init);
    }
    CHECK(judged > 20);
}

} // namespace restart_c630s_tests
