// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The age of a feedback that is read in several blocks, the C630S's. Each block is as old as the first byte of its
// request on the wire, since the drive may have taken the values as soon as it had received that.
#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/loop_bound.hpp>

namespace slower_block_age_tests {

using namespace servobus;
using namespace servobus::c630s;

namespace {

/// When the requests began on the wire, by the address that they read.
struct wire_log {
    sim::virtual_line* wire;
    std::uint32_t character_us;
    std::map<unsigned, std::uint64_t> begun;
    std::vector<std::uint8_t> open;
    std::uint64_t first_us = 0;

    static void note(void* self, const sim::wire_byte& b) {
        auto& log = *static_cast<wire_log*>(self);
        if (!b.is_from_client) return;
        if (log.open.empty()) log.first_us = b.at_us - log.character_us;
        log.open.push_back(b.value);
        if (log.open.size() != modbus::request_length(log.open)) return;
        if (log.open[1] == 0x03) log.begun[load_word(log.open, 2)] = log.first_us;
        log.open.clear();
    }
};

template <class Servo> void make_ready(simulated::simulated_c630s& r, Servo& servo) {
    REQUIRE(servo.run(init{}));
    REQUIRE(servo.run(set_up{}));
    r.model.power_cycle();
    REQUIRE(servo.run(init{}));
}

} // namespace

TEST_CASE("G36: a block of the feedback is as old as the first byte of its request, to the microsecond") {
    // The position of an enabled drive is held back until the status after it: it is no younger for that.
    bool is_enabled = false;
    SUBCASE("disabled") {}
    SUBCASE("enabled") { is_enabled = true; }
    simulated::simulated_c630s r;
    c630s::drive servo{r.line, 1, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
    make_ready(r, servo);
    if (is_enabled) REQUIRE(servo.run(enable_in{control_mode::position}));
    wire_log log{&r.wire, r.line.timing().character, {}, {}};
    r.wire.set_hook(&wire_log::note, &log);
    const auto run_until = [&](std::uint64_t end) {
        while (r.wire.time_us() < end) {
            const duration idle = servo.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    };
    run_until(r.wire.time_us() + 500'000);
    unsigned looks = 0;
    for (unsigned i = 0; i < 400; ++i) {
        run_until(r.wire.time_us() + 1'700);
        // Not while a request of the feedback is on its way.
        std::uint64_t oldest = ~std::uint64_t{0};
        std::uint64_t newest = 0;
        for (std::size_t b = 1; b < model::blocks.size(); ++b) {
            const std::uint16_t at = model::blocks[b].address;
            REQUIRE(log.begun.count(at) == 1);
            oldest = std::min(oldest, log.begun[at]);
            newest = std::max(newest, log.begun[at]);
        }
        if (r.wire.time_us() < newest + 6'000 || !log.open.empty()) continue;
        const std::uint64_t status = log.begun[model::blocks.image().address];
        if (is_enabled && (status < newest || r.wire.time_us() < status + 6'000)) continue;
        ++looks;
        // What the calls of the clock take.
        constexpr std::uint32_t slack_us = 20;
        const auto age = static_cast<std::uint32_t>(r.wire.time_us() - oldest);
        CAPTURE(age);
        CHECK(servo.feedback(microseconds(age - 1)).error() == errc::timeout);
        CHECK(servo.feedback(microseconds(age + slack_us)));
    }
    CHECK(looks > (is_enabled ? 100 : 200));
}

TEST_CASE("G36: after an init each block of the feedback is read anew, however old a feedback may be") {
    simulated::simulated_c630s r;
    c630s::drive servo{r.line, 1, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
    make_ready(r, servo);
    wire_log log{&r.wire, r.line.timing().character, {}, {}};
    r.wire.set_hook(&wire_log::note, &log);
    const auto turn = [&] {
        const duration idle = servo.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    };
    for (unsigned phase = 0; phase < 12; ++phase) { // of the turn of the blocks
        CAPTURE(phase);
        const std::uint64_t end = r.wire.time_us() + 300'000 + phase * 13'000;
        while (r.wire.time_us() < end) turn();
        REQUIRE(servo.feedback(milliseconds(5000)));
        REQUIRE(servo.run(init{}));
        const std::uint64_t ended = r.wire.time_us();
        for (tests::loop_bound left{"a feedback"}; !servo.feedback(milliseconds(5000)); left.use()) turn();
        for (std::size_t b = 0; b < model::blocks.size(); ++b) {
            CAPTURE(b);
            CHECK(log.begun[model::blocks[b].address] >= ended);
        }
    }
}

} // namespace slower_block_age_tests
