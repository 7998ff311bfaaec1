// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Requests of other programs to real drives, played to the simulated ones. What a real drive accepts, these accept, by
// default or under the switch that stands beside the sequence.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <servobus/sim/c630s.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/field_sequence.hpp>

namespace field_tests {

using namespace servobus;

namespace {

struct sequence {
    const char* name;
    std::size_t mismatches = 0; ///< under the default switches
};

struct wheels_sequence : sequence {
    sim::zlac8015d_options plays{}; ///< under which there is none
};
const wheels_sequence of_wheels[] = {
    {{"zlac8015d_velocity"}},
    {{"zlac8015d_position"}},
    {{"zlac8015d_wheels_driver"}},
    {{"zlac8015d_enable_before_mode", 1}, {.enables_without_mode = true}},
    {{"zlac8030d_one_wheel_at_a_time"}},
    {{"zlac8015d_watchdog"}},
    {{"zlac8015d_reset"}},
    {{"zlac8015d_guide_position"}},
    {{"zlac8015d_odd_frames", 1}, {.checks_option_codes = false}},
};

struct servo_sequence : sequence {
    sim::c630s_options plays{};
};
const servo_sequence of_servos[] = {
    {{"a5_position", 1}, {.servo_on_waits_for_power_on = false}},
    {{"a5_position_continuous", 1}, {.servo_on_waits_for_power_on = false}},
    {{"a5_speed", 2}, {.servo_on_waits_for_power_on = false}},
    {{"a5_homing", 1}, {.servo_on_waits_for_power_on = false}},
    {{"a5_speed_logger"}},
    {{"sv660p"}},
};

template <class Drive, class Sequence> void play(const Sequence& s) {
    CAPTURE(std::string{s.name});
    REQUIRE_FALSE(field::sequence(s.name).empty());
    Drive by_default{};
    const std::vector<unsigned> wrong = field::mismatches(by_default, s.name);
    CAPTURE(wrong.empty() ? 0u : wrong.front());
    CHECK(wrong.size() == s.mismatches);
    Drive as_seen{s.plays};
    const std::vector<unsigned> none = field::mismatches(as_seen, s.name);
    CAPTURE(none.empty() ? 0u : none.front());
    CHECK(none.size() == 0);
}

} // namespace

TEST_CASE("the field's requests to a ZLAC8015D get the responses that a real drive has given") {
    for (const auto& s : of_wheels) play<sim::zlac8015d>(s);
}

TEST_CASE("the field's requests to ancestors of the C630S get the responses that those have given") {
    for (const auto& s : of_servos) play<sim::c630s>(s);
}

TEST_CASE("each sequence of the field is played") {
    std::set<std::string> played;
    for (const auto& s : of_wheels) played.insert(s.name);
    for (const auto& s : of_servos) played.insert(s.name);
    std::set<std::string> there;
    for (const auto& file : std::filesystem::directory_iterator{"tests/field"})
        there.insert(file.path().stem().string());
    CHECK(played == there);
}

// augustocamaral2003/zlac8015d-tests, 2024: 754 samples of a ZLAC8015D, right wheel, ramps of 200 ms. A loop of 13.3 ms
// writes 2089h, a saw from 20 to 100 r/min once a second, and reads 20ACh.
TEST_CASE("B36: a stream of changed speeds reaches what the field's drive has reached, or is followed") {
    using ramp = sim::zlac8015d_options::ramp;
    struct seen {
        std::uint64_t ms;
        double speed;     ///< r/min
        double tolerance; ///< of it
    };
    constexpr seen real[] = {{1000, 8.2, 0.2}, {2000, 13.4, 0.1}, {5000, 26.7, 0.1}, {9900, 40.7, 0.1}};
    for (const ramp which : {ramp::begins_anew, ramp::linear}) {
        CAPTURE(static_cast<int>(which));
        sim::zlac8015d drive{{.speed_ramp = which}};
        instant now{};
        const auto write = [&](std::uint16_t address, unsigned word) {
            const std::uint8_t payload[] = {static_cast<std::uint8_t>(word >> 8),
                                            static_cast<std::uint8_t>(word & 0xFFu)};
            CHECK(drive.write(address, words_view{bytes{payload}}) == 0);
        };
        drive.advance(now);
        write(0x200D, 3);
        for (const std::uint16_t ramp_time :
             std::initializer_list<std::uint16_t>{0x2080, 0x2081, 0x2082, 0x2083})
            write(ramp_time, 200);
        write(0x200E, 8);
        double sum = 0;
        unsigned of_last_seconds = 0;
        const seen* next = real;
        for (std::uint64_t us = 0; us < 10'000'000; us += 13'300) {
            now = now + microseconds(13'300);
            drive.advance(now);
            const double speed = static_cast<double>(drive.right().speed) / 1e6;
            if (next != std::end(real) && us >= next->ms * 1000) {
                if (which == ramp::begins_anew)
                    CHECK(std::abs(speed - next->speed) < next->tolerance * next->speed);
                if (which == ramp::linear) CHECK(speed > 2 * next->speed);
                ++next;
            }
            if (us >= 8'000'000) {
                sum += speed;
                ++of_last_seconds;
            }
            write(0x2089, static_cast<unsigned>(20 + 80 * (us % 1'000'000) / 1'000'000));
        }
        const double mean = sum / of_last_seconds;
        if (which == ramp::begins_anew) CHECK(std::abs(mean - 37.7) < 3.77);
        if (which == ramp::linear) CHECK(mean > 60);
    }
}

} // namespace field_tests
