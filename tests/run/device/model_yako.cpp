// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a YAKO facade makes of single words: the feedback, word by word; the state between two steps of an init; and of
// a drive that begins to move late.
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>
#include <tests/support/endings.hpp>

namespace model_yako_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using simulated::closed_axis;

TEST_CASE("0006h to 000Ch: the feedback has each word in its place") {
    const std::array<u16, 7> words{3, 0x0004, 0x0001, 0x0002, 0x0001, 0x0005, static_cast<u16>(-60)};
    const slice<const u16> all{words.data(), words.size()};
    const auto f = closed_loop::feedback::from_words(all, word_order::high_first, speed_count::one_r_per_min);
    CHECK(f.error == 3);
    CHECK(f.state.is_moving());
    CHECK_FALSE(f.has_fault());
    CHECK(f.inputs.to_word() == 0x0001);
    CHECK(f.outputs.to_word() == 0x0002);
    CHECK(f.position == 0x1'0005 * pulse);
    CHECK(f.speed == -60 * r_per_min);
    const auto swapped =
        closed_loop::feedback::from_words(all, word_order::low_first, speed_count::tenth_r_per_min);
    CHECK(swapped.position == 0x5'0001 * pulse);
    CHECK(swapped.speed == -6 * r_per_min);
}

TEST_CASE("a drive whose address is not given has address 1") {
    closed_axis a;
    const closed_loop::drive closed{a.line};
    const open_loop::drive open{a.line};
    CHECK(closed.address() == 1);
    CHECK(open.address() == 1);
}

TEST_CASE("G21: a stop before an init has written its marker leaves the drive unknown") {
    closed_axis a;
    REQUIRE(a.drive.begin(init{}) == errc::ok);
    while (a.drive.cached().microsteps == 0) a.turn(); // all is read
    REQUIRE_FALSE(a.drive.is_idle());
    CHECK(a.drive.state() == drive_state::needs_init);
    REQUIRE(a.drive.begin(halt{}) == errc::ok);
    a.finish();
    for (const auto& f : a.requests) CHECK_FALSE(simulated::is_marker(f));
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.drive.run(enable{}).error() == errc::needs_init);
}

TEST_CASE("4.3: a position that is not the declared one after 200 ms was not taken over") {
    cached_settings known{};
    known.state = drive_state::enabled;
    known.word_order = word_order::high_first;
    const prepared_command c = commands::prepared(declare_position{500 * pulse}, known);
    std::array<u16, 8> words{};
    words[routines::status_at] = 0x0002; // homed
    motion_under_way<closed_loop::device> m;
    REQUIRE(m.status_of(words.data()).is_homed());
    m.begin(c, words.data(), known);
    CHECK(m.confirm_home(c, words.data(), microseconds(199'999), known) == errc::busy);
    CHECK(m.confirm_home(c, words.data(), milliseconds(200), known) == errc::not_executed);
}

TEST_CASE("4.1: a drive that begins 100 ms after its start was acknowledged carries the move out, the second "
          "one too") {
    simulated::closed_axis a{{.start_delay = milliseconds(100)}};
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    for (const std::int32_t target : {1000, 2000}) {
        CHECK(a.drive.run(
            move_by{1000 * pulse, {10 * r_per_min, 20 * millisecond, 20 * millisecond, 300 * r_per_min}}));
        CHECK(a.drive.motion() == motion_check::seen);
        CHECK(a.drive.run(wait_reached{}));
        CHECK(a.place() == target);
        a.run(1000);
    }
}

TEST_CASE_TEMPLATE(
    "G34: an input that stops a motor and is active is the cause of a short move, any other is not", D,
    closed_loop::device, open_loop::device) {
    constexpr std::size_t inputs = std::is_same_v<D, closed_loop::device> ? 4 : 7;
    // The manual's table of input functions: limits, motor free, stop and emergency stop.
    const auto stops = [](u16 function) { return function >= 2 && function <= 6; };
    for (std::size_t at = 0; at < inputs; ++at) {
        for (u16 function = 0; function <= 20; ++function) {
            for (const bool is_active : {false, true}) {
                CAPTURE(at);
                CAPTURE(function);
                std::array<u16, 14> words{};
                words[routines::functions_word + at] = function;
                words[routines::inputs_at] = static_cast<u16>((is_active ? 1u : 0u) << at);
                motion_under_way<D> m;
                m.examine(slice<const u16>{words.data(), words.size()});
                const bool is_cause = is_active && stops(function);
                CHECK(m.cause() == (is_cause ? stop_cause::input : stop_cause::unknown));
            }
        }
    }
}

TEST_CASE("G34: either software limit is the cause of a move that ends short at it") {
    for (unsigned bit = 0; bit < 16; ++bit) {
        std::array<u16, 14> words{};
        words[routines::status_at] = static_cast<u16>(1u << bit);
        motion_under_way<closed_loop::device> m;
        m.examine(slice<const u16>{words.data(), words.size()});
        const bool is_limit = bit == 5 || bit == 6; // 0006h: beyond the positive, beyond the negative limit
        CHECK(m.cause() == (is_limit ? stop_cause::software_limit : stop_cause::unknown));
    }
    closed_axis a;
    enabled_yako::take_homed(a);
    REQUIRE(a.drive.run(limit_travel{-2'000 * pulse, 8'000 * pulse}));
    const arrival end = a.drive.run(move_by{-9'000 * pulse, enabled_yako::brisk}, wait_reached{});
    CHECK(end.how == arrival_state::stopped_short);
    CHECK(end.cause == stop_cause::software_limit);
    CHECK(a.place() < -1'900);
}

TEST_CASE("A61: a wait for a move that rests at the end of the counter's range, and goes beyond it, is no "
          "success") {
    cached_settings known{};
    known.state = drive_state::enabled;
    known.word_order = word_order::high_first;
    const auto image = [](std::int64_t position) {
        const auto bits = static_cast<std::uint32_t>(position & 0xFFFF'FFFF);
        return std::array<u16, 7>{0, 0, 0, 0, static_cast<u16>(bits >> 16), static_cast<u16>(bits & 0xFFFF),
                                  0};
    };
    prepared_command move{.steps = no_steps};
    move.then = effect::moved;
    move.has_target = true;
    move.target = 2'000;
    model<closed_loop::device> m;
    REQUIRE(m.permit(move, {image(2'147'483'000).data(), {}, {}}, known) == errc::ok);
    REQUIRE(m.learn(move, endings{}.done(), known) == errc::ok);
    const prepared_command wait = prepare(wait_reached{}, known);
    const auto ended = [&](std::int64_t position) {
        return m.confirm(wait, {image(position).data(), {}, milliseconds(5000)}, known);
    };
    CHECK(ended(2'147'483'647) == errc::unexpected_value);
    CHECK(ended(2'147'485'000) == errc::ok);
    CHECK(ended(2'147'483'100) == errc::stopped_short);
}

TEST_CASE("G34: a move that was replaced, or a way that began while the motor moved, has no known end "
          "[errata A59]") {
    cached_settings known{};
    known.state = drive_state::enabled;
    known.word_order = word_order::high_first;
    known.is_homed = true;
    const std::array<u16, 7> at_rest{0, motion_status::homed_bit};
    const std::array<u16, 7> moving{0, motion_status::homed_bit | motion_status::moving_bit};
    const std::array<u16, 7> at_500{0, motion_status::homed_bit, 0, 0, 0, 500};
    const auto arrives = [&](const auto& wanted, const std::array<u16, 7>& before) {
        motion_under_way<closed_loop::device> m;
        const prepared_command c = commands::prepared(wanted, known);
        m.begin(c, before.data(), known);
        m.keep_goal(c);
        return m.arrival_of(at_500.data(), milliseconds(900), known).how;
    };
    CHECK(arrives(move_by{500 * pulse}, at_rest) == arrival_state::reached);
    CHECK(arrives(move_by{500 * pulse}, moving) == arrival_state::none);
    CHECK(arrives(move_to{500 * pulse}, at_rest) == arrival_state::reached);
    CHECK(arrives(move_to{500 * pulse}, moving) == arrival_state::reached);

    model<closed_loop::device> m;
    prepared_command c = commands::prepared(move_by{500 * pulse}, known);
    REQUIRE(m.permit(c, {at_rest.data(), {}, {}}, known) == errc::ok);
    REQUIRE(m.learn(c, endings{}.done({at_rest.data(), at_rest.size()}), known) == errc::ok);
    REQUIRE(m.arrival_of(at_500.data(), milliseconds(900), known).how == arrival_state::reached);
    m.preempt(c);
    CHECK(m.arrival_of(at_500.data(), milliseconds(900), known).how == arrival_state::none);
}

} // namespace model_yako_tests
