// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Gives single words to the model of a ZLAC8015D: a shaft without power in each mode, a wheel that begins late, targets
// of before an enable, and a move that failed when nothing is known of the drive.
#include <array>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/endings.hpp>

namespace model_zlac8015d_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;

namespace {

using image_words = std::array<std::uint16_t, model::blocks.image().words>;

cached_settings enabled_in(operating_mode mode) {
    return {.state = drive_state::enabled,
            .mode = mode,
            .starts = synchronisation::synchronous,
            .max_speed = 1000};
}
image_words at(std::int32_t left, std::int32_t right, std::uint16_t status = status_flags::both_locked) {
    image_words w{};
    const auto put = [&](std::size_t to, std::int32_t place) {
        const auto bits = static_cast<std::uint32_t>(place);
        w[to] = static_cast<std::uint16_t>(bits >> 16);
        w[to + 1] = static_cast<std::uint16_t>(bits & 0xFFFFu);
    };
    w[0] = status;
    put(routines::before_word, left);
    put(routines::before_word + 2, right);
    return w;
}
/// A model that has begun a relative move of both wheels by 1000 counts, from zero.
model moving(cached_settings& known) {
    model m;
    prepared_command c = commands::prepared(move_by{1000 * pulse, 1000 * pulse}, known);
    REQUIRE(c.refusal == errc::ok);
    const image_words before = at(0, 0);
    REQUIRE(m.learn(c, endings{}.done({before.data(), before.size()}), known) == errc::ok);
    return m;
}

} // namespace

TEST_CASE("a shaft without power is a restart at standstill, and a suspicion in torque mode or while it runs "
          "[errata "
          "B30]") {
    const std::uint16_t running = status_flags::running_bits;
    for (const operating_mode mode : {operating_mode::velocity, operating_mode::relative_position}) {
        cached_settings known = enabled_in(mode);
        CHECK(model::judge(at(0, 0, 0).data(), known) == verdict::disabled);
        CHECK(model::judge(at(0, 0, running).data(), known) == verdict::uncertain);
        CHECK(model::judge(at(0, 0).data(), known) == verdict::as_expected);
    }
    cached_settings known = enabled_in(operating_mode::torque);
    CHECK(model::judge(at(0, 0, 0).data(), known) == verdict::uncertain);
    CHECK(model::judge(at(0, 0, running).data(), known) == verdict::uncertain);
    CHECK(model::judge(at(0, 0).data(), known) == verdict::as_expected);
}

TEST_CASE("G34: a wheel that does not run 200 ms after its start has stopped short, and not before") {
    cached_settings known = enabled_in(operating_mode::relative_position);
    const model m = moving(known);
    CHECK(m.arrival_of(wheels::both, at(0, 0).data(), milliseconds(0)).how == arrival_state::under_way);
    CHECK(m.arrival_of(wheels::both, at(0, 0).data(), microseconds(199'999)).how == arrival_state::under_way);
    CHECK(m.arrival_of(wheels::both, at(0, 0).data(), milliseconds(200)).how == arrival_state::stopped_short);
    CHECK(m.arrival_of(wheels::both, at(1000, 1000).data(), milliseconds(0)).how == arrival_state::reached);
    const image_words on_the_way = at(400, 400, status_flags::both_locked | status_flags::running_bits);
    CHECK(m.arrival_of(wheels::both, on_the_way.data(), milliseconds(900)).how == arrival_state::under_way);
}

TEST_CASE("G34: after an enable there is no move of which the end could be told") {
    cached_settings known = enabled_in(operating_mode::relative_position);
    model m = moving(known);
    REQUIRE(m.arrival_of(wheels::both, at(1000, 1000).data(), {}).how == arrival_state::reached);
    prepared_command c = enable_in{operating_mode::relative_position}.prepare(known);
    REQUIRE(m.learn(c, endings{}.done(), known) == errc::ok);
    CHECK(m.arrival_of(wheels::both, at(1000, 1000).data(), {}).how == arrival_state::none);
}

TEST_CASE(
    "G21: after a start without a response the positions are compared only if the drive is still known") {
    for (const drive_state state : {drive_state::enabled, drive_state::needs_init}) {
        cached_settings known = enabled_in(operating_mode::relative_position);
        model m = moving(known);
        prepared_command c = commands::prepared(move_by{500 * pulse, 500 * pulse}, known);
        const auto failed_at = static_cast<std::uint8_t>(routines::start_step);
        const command_status lost{status::sent(errc::timeout), failed_at, true};
        c.steps = no_steps; // as the facade calls it
        known.state = state;
        REQUIRE(m.learn(c, endings{}.failed(lost), known) == errc::ok);
        CHECK(c.steps.empty() == (state == drive_state::needs_init));
        CHECK(m.motion() == motion_check::unknown);
        CHECK(m.arrival_of(wheels::both, at(1000, 1000).data(), {}).how == arrival_state::none);
    }
}

TEST_CASE("G34: a move of both wheels is reached once both are within 20 counts of their targets") {
    cached_settings known = enabled_in(operating_mode::relative_position);
    const model m = moving(known);
    for (const std::int32_t left : {979, 980, 1000, 1020, 1021}) {
        for (const std::int32_t right : {979, 980, 1000, 1020, 1021}) {
            CAPTURE(left);
            CAPTURE(right);
            const image_words there = at(left, right);
            const auto is_near = [](std::int32_t place) { return place >= 980 && place <= 1020; };
            const auto reached = [](bool is) {
                return is ? arrival_state::reached : arrival_state::stopped_short;
            };
            const auto how = [&](wheels which) {
                return m.arrival_of(which, there.data(), milliseconds(500)).how;
            };
            CHECK(how(wheels::both) == reached(is_near(left) && is_near(right)));
            CHECK(how(wheels::left) == reached(is_near(left)));
            CHECK(how(wheels::right) == reached(is_near(right)));
        }
    }
    for (const std::uint16_t running : {status_flags::left_running_bit, status_flags::right_running_bit}) {
        const image_words there = at(1000, 1000, running);
        const auto is_under_way = [&](wheels which) {
            return m.arrival_of(which, there.data(), milliseconds(500)).how == arrival_state::under_way;
        };
        CHECK(is_under_way(wheels::both));
        CHECK(is_under_way(wheels::left) == (running == status_flags::left_running_bit));
        CHECK(is_under_way(wheels::right) == (running == status_flags::right_running_bit));
    }
}

TEST_CASE("a fault of either motor, and an alarm of either shaft, is a fault of the drive") {
    constexpr auto alarm = static_cast<unsigned>(shaft_state::alarm);
    const auto with = [](std::size_t place, unsigned word) {
        image_words w = at(0, 0);
        w[place] = static_cast<std::uint16_t>(word);
        return w;
    };
    const auto is_faulted = [](const image_words& w) { return model::is_faulted(w.data(), {}); };
    CHECK_FALSE(is_faulted(at(0, 0)));
    for (unsigned bit = 1; bit <= 0x8000; bit <<= 1) {
        CHECK(is_faulted(with(model::image::place_of<left_faults>, bit)));
        CHECK(is_faulted(with(model::image::place_of<right_faults>, bit)));
    }
    CHECK(is_faulted(with(model::image::place_of<status_word>, alarm << 14)));
    CHECK(is_faulted(with(model::image::place_of<status_word>, alarm << 6)));
}

} // namespace model_zlac8015d_tests
