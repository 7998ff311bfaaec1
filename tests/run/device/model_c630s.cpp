// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a C630S facade makes of words that the simulated drive does not send: a brake that is slow to release, and words
// on either side of a limit.
#include <array>
#include <cstdint>
#include <cstdlib>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/frame_port.hpp>

namespace model_c630s_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

namespace {

/// A drive whose brake shows as released only so long after servo-on.
struct slow_brake : sim::c630s {
    static constexpr std::uint32_t delay_ms = 200;
    std::uint32_t since_ms = 0;

    explicit slow_brake(const sim::c630s& drive) : sim::c630s{drive} {}
    std::uint8_t read(u16 address, std::span<u16> to) {
        const std::uint8_t exception = sim::c630s::read(address, to);
        const bool shows = address == virtual_output_levels.address && is_early();
        if (shows) to[0] = static_cast<u16>(to[0] & ~unsigned{status_flags::brake_bit});
        return exception;
    }
    void advance(instant now) {
        sim::c630s::advance(now);
        now_ = now;
        if (!enabled()) enabled_at_ = now;
    }

  private:
    bool is_early() const { return since(enabled_at_, now_) < milliseconds(delay_ms); }
    instant now_{};
    instant enabled_at_{};
};

} // namespace

TEST_CASE("before any command no terminal is in conflict") {
    const simulated::driven_c630s r;
    CHECK(r.drive.conflicting_terminal() == 0);
    CHECK_FALSE(r.drive.needs_power_cycle());
    CHECK(r.drive.arrival().how == arrival_state::none);
    CHECK(r.drive.current_word_order() == word_order::unknown);
}

TEST_CASE("an enable waits until the brake shows that the motor is energised") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    simulated::frame_port<slow_brake> port{slow_brake{r.model}};
    servobus::line line{port, modbus::timing_at(port.baud)};
    c630s::drive drive{line, 1, unsupervised};
    REQUIRE(drive.run(init{}));
    const std::uint64_t start = port.time_us();
    REQUIRE(drive.run(enable_in{control_mode::speed}));
    CHECK(port.time_us() - start > slow_brake::delay_ms * 1000u);
    CHECK(drive.state() == drive_state::enabled);
}

TEST_CASE("S4: after a start without a response a motor that turns by 2 r/min or less, within 20 units, has "
          "not moved") {
    const auto seen = [](int pace, int way) {
        const auto end = static_cast<u32>(way);
        std::array<u16, 16> words{};
        words[routines::inputs_word] = terminal::marker;
        words[routines::speed_word] = static_cast<u16>(pace);
        words[routines::after_word] = static_cast<u16>(end >> 16);
        words[routines::after_word + 1] = static_cast<u16>(end & 0xFFFF);
        return motion_under_way{}.compared(slice<const u16>{words.data(), words.size()},
                                           word_order::high_first);
    };
    for (const int sign : {1, -1}) {
        CHECK(seen(2 * sign, 20 * sign) == motion_check::not_seen);
        CHECK(seen(3 * sign, 0) == motion_check::seen);
        CHECK(seen(0, 21 * sign) == motion_check::seen);
    }
}

TEST_CASE("7.11: an entry of the fault history has the words of P0B-34 to P0B-42, each in its place") {
    const std::array<u16, 9> words{0x620, 0x0001, 0x0002, 300, 150, static_cast<u16>(-75),
                                   3105,  0x0001, 0x0002};
    const fault_entry e =
        fault_entry::from_words(slice<const u16>{words.data(), words.size()}, word_order::high_first);
    CHECK(e.alarm_code == 0x620);
    CHECK(e.time == 0x1'0002 * second);
    CHECK(e.speed == 300 * r_per_min);
    CHECK(e.u_current == 1500 * milliampere);
    CHECK(e.v_current == -750 * milliampere);
    CHECK(e.bus_voltage == 3105 * part<10>(volt));
    CHECK(e.wired_inputs.to_word() == 0x0001);
    CHECK(e.wired_outputs.to_word() == 0x0002);
}

TEST_CASE("the feedback has the wired inputs as P0B-03 shows them") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    const result<feedback> before = r.drive.read();
    r.model.set_input(2, true);
    r.run(50);
    const result<feedback> after = r.drive.read();
    REQUIRE(before);
    REQUIRE(after);
    CHECK(before->wired_inputs.has(2) != after->wired_inputs.has(2));
    CHECK(before->wired_inputs.has(1) == after->wired_inputs.has(1));
    CHECK(after->wired_inputs.to_word() == r.model.peek(input_state.address));
}

TEST_CASE("the feedback is in position once a move is completed, and not while it is under way") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(segment{1, 20'000 * reference_unit, 60 * r_per_min}));
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.run(start_segment{1}));
    r.run(100);
    const result<feedback> under_way = r.drive.read();
    REQUIRE(r.drive.run(wait_reached{}));
    const result<feedback> there = r.drive.read();
    REQUIRE(under_way);
    REQUIRE(there);
    CHECK(under_way->is_moving());
    CHECK_FALSE(under_way->is_in_position());
    CHECK_FALSE(there->is_moving());
    CHECK(there->is_in_position());
}

TEST_CASE("a segment of which no times are given has the factory's") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    const auto ramp = r.model.peek(at<position_segment_acceleration_times, 0>.address);
    const auto wait = r.model.peek(at<position_segment_wait_times, 0>.address);
    REQUIRE(r.drive.run(segment{1, 5000 * reference_unit, 600 * r_per_min}));
    CHECK(r.model.peek(at<position_segment_acceleration_times, 0>.address) == ramp);
    CHECK(r.model.peek(at<position_segment_wait_times, 0>.address) == wait);
}

TEST_CASE("a homing of which only the mode is given keeps the factory's speeds, ramp and time limit") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    const auto held = [&] {
        return std::array{r.model.peek(homing_high_speed.address), r.model.peek(homing_low_speed.address),
                          r.model.peek(homing_acceleration_time.address),
                          r.model.peek(homing_time_limit.address)};
    };
    const auto before = held();
    REQUIRE(r.drive.run(homing_by{homing_mode::forward_z}));
    CHECK(r.model.peek(homing_method.address) == static_cast<u16>(homing_mode::forward_z));
    CHECK(held() == before);
}

TEST_CASE(
    "G34: a motor that presses when a move is first looked at counts as blocked since the move's start") {
    const status_flags pressing{0x0040}; // VDO7, limited torque, at standstill
    const std::array<u16, 16> words{};
    motion_under_way m;
    CHECK(m.confirm(status_flags{status_flags::rotating_bit}, milliseconds(5000)) ==
          errc::busy); // the move before
    m.begin(1000, false, slice<const u16>{words.data(), words.size()}, word_order::high_first);
    CHECK(m.confirm(pressing, milliseconds(99)) == errc::busy);
    CHECK(m.confirm(pressing, milliseconds(100)) == errc::ok);
}

TEST_CASE("G34: after an init there is no move to wait for, since a restart before it may have changed the "
          "position") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    REQUIRE(r.drive.run(segment{1, 5000 * reference_unit, 600 * r_per_min}));
    REQUIRE(r.drive.run(start_segment{1}, wait_reached{}).how == arrival_state::reached);
    r.model.power_cycle();
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.arrival().how == arrival_state::none);
    CHECK(r.drive.run(wait_reached{}).error() == errc::wrong_state);
}

TEST_CASE("G34: a short move has reached its target within half of its way and 2 units, a long one within 20 "
          "units") {
    struct move {
        std::int32_t way;
        std::int32_t most_missing;
    };
    for (const move of : {move{10, 7}, move{40, 22}, move{41, 20}, move{100'000, 20}}) {
        for (const std::int32_t sign : {1, -1}) {
            for (const std::int32_t beyond : {0, 1}) {
                CAPTURE(of.way);
                CAPTURE(beyond);
                std::array<u16, 16> words{};
                motion_under_way m;
                m.begin(sign * of.way, false, slice<const u16>{words.data(), words.size()},
                        word_order::high_first);
                const auto place = static_cast<u32>(sign * (of.way - of.most_missing - beyond));
                words[routines::place_word] = static_cast<u16>(place >> 16);
                words[routines::place_word + 1] = static_cast<u16>(place & 0xFFFF);
                CHECK(m.conclude(slice<const u16>{words.data(), words.size()}, word_order::high_first) ==
                      (beyond == 0));
            }
        }
    }
}

TEST_CASE("G34: after a run of segments, a homing, a start without a response, an init and an enable there "
          "is no move of "
          "which the end could be told") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    r.model.attach(
        {.home_from = 2000, .home_to = 40'000, .negative_limit = -900'000, .positive_limit = 900'000});
    const auto move = [&] {
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(
            homing_by{homing_mode::forward_home_switch, 100 * r_per_min, 30 * r_per_min, 10 * millisecond}));
        REQUIRE(r.drive.run(position_segments{}));
        REQUIRE(r.drive.run(segment{1, 300 * reference_unit, 60 * r_per_min}));
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_reached{}));
        REQUIRE(r.drive.arrival().how == arrival_state::reached);
    };
    const auto has_none = [&] {
        CHECK(r.drive.arrival().how == arrival_state::none);
        CHECK(r.drive.begin(wait_reached{}) != errc::ok);
    };
    move();
    SUBCASE("an init") { REQUIRE(r.drive.run(init{})); }
    SUBCASE("an enable") {
        REQUIRE(r.drive.run(disable{}));
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
    }
    SUBCASE("a homing") { REQUIRE(r.drive.run(home{5 * second})); }
    SUBCASE("a run of segments") {
        REQUIRE(r.drive.run(disable{}));
        REQUIRE(r.drive.run(
            enable_in{control_mode::position, position_source::segments, segment_mode::sequential}));
        REQUIRE(r.drive.run(start_segments{}));
    }
    SUBCASE("a start without a response") {
        r.wire.faults().lost_response = 1000;
        CHECK_FALSE(r.drive.run(start_segment{1}));
        CHECK(r.wire.struck() != 0);
        r.wire.faults() = {};
    }
    has_none();
}

TEST_CASE("S5: a position that is more than 20 units nearer to zero has fallen, in either direction and word "
          "order") {
    for (const word_order order : {word_order::high_first, word_order::low_first}) {
        cached_settings known{};
        known.word_order = order;
        const auto words = [&](std::int64_t position) {
            const auto bits = static_cast<std::uint32_t>(position & 0xFFFF'FFFF);
            const auto high = static_cast<u16>(bits >> 16);
            const auto low = static_cast<u16>(bits & 0xFFFF);
            return order == word_order::high_first ? std::array<u16, 2>{high, low}
                                                   : std::array<u16, 2>{low, high};
        };
        constexpr std::int64_t places[]{0,
                                        1,
                                        19,
                                        20,
                                        21,
                                        22,
                                        100,
                                        -1,
                                        -20,
                                        -21,
                                        -22,
                                        -100,
                                        65'535,
                                        65'556,
                                        -65'536,
                                        5'000,
                                        -5'000,
                                        100'000,
                                        -100'000,
                                        2'147'483'647,
                                        -2'147'483'648,
                                        -2'147'483'628,
                                        -2'147'483'627};
        for (const std::int64_t before : places) {
            for (const std::int64_t now : places) {
                CAPTURE(before);
                CAPTURE(now);
                const auto then = words(before);
                const auto here = words(now);
                const block_feedback r{
                    .block = model::position_block, .words = here.data(), .before = then.data()};
                CHECK(model::has_fallen(r, known) == (std::llabs(before) - std::llabs(now) > 20));
            }
        }
    }
}

TEST_CASE("G35: a brake that is applied although the servo is on ends the state enabled, and outputs count "
          "once set up") {
    const std::array<u16, model::blocks.image().words> released{status_flags::brake_bit |
                                                                status_flags::ready_bit};
    const std::array<u16, model::blocks.image().words> applied{status_flags::ready_bit};
    const std::array<u16, model::blocks.image().words> faulted{status_flags::fault_bit};
    cached_settings known{};
    known.state = drive_state::enabled;
    CHECK(model::judge(released.data(), known) == verdict::as_expected);
    CHECK(model::judge(applied.data(), known) == verdict::disabled);
    CHECK(model::judge(faulted.data(), known) == verdict::faulted);
    for (const drive_state s :
         {drive_state::needs_init, drive_state::needs_set_up, drive_state::needs_power_cycle}) {
        known.state = s;
        CHECK_FALSE(model::is_faulted(faulted.data(), known));
    }
    for (const drive_state s : {drive_state::disabled, drive_state::enabled}) {
        known.state = s;
        CHECK(model::is_faulted(faulted.data(), known));
        CHECK_FALSE(model::is_faulted(released.data(), known));
    }
}

TEST_CASE("G34: COIN within 50 ms of a start is that of the move before") {
    const auto completed = status_flags::from_word(status_flags::completed_bit);
    motion_under_way m;
    CHECK(m.confirm(completed, {}) == errc::busy);
    CHECK(m.confirm(completed, microseconds(49'999)) == errc::busy);
    CHECK(m.confirm(completed, milliseconds(50)) == errc::ok);
    CHECK(m.confirm(status_flags::from_word(0), milliseconds(900)) == errc::busy);
}

TEST_CASE(
    "an enable waits for the delay after the brake's release, a disable for the one after its application") {
    const std::array<u16, model::blocks.image().words> released{status_flags::brake_bit |
                                                                status_flags::ready_bit};
    cached_settings known{};
    known.state = drive_state::disabled;
    known.brake_delay_ms = 300;
    known.power_off_delay_ms = 80;
    model m;
    const auto confirmed_after = [&](effect then, std::uint32_t ms) {
        const prepared_command c{.steps = no_steps, .then = then};
        return m.confirm(c, {.image = released.data(), .words = {}, .waited = milliseconds(ms)}, known);
    };
    for (const effect e : {effect::enabled, effect::runs_speed_segments}) {
        CHECK(confirmed_after(e, 309) == errc::busy);
        CHECK(confirmed_after(e, 310) == errc::ok);
    }
    for (const effect e : {effect::disabled, effect::quick_stopped}) {
        CHECK(confirmed_after(e, 89) == errc::busy);
        CHECK(confirmed_after(e, 90) == errc::ok);
    }
}

TEST_CASE(
    "G34: a relative way counts from where the move before was to end, not from where the motor rests") {
    using namespace routines;
    std::uint16_t words[steps::max_words]{};
    words[before_word] = 1000; // low first
    words[deviation_before_word] = 30;
    motion_under_way m;
    m.begin(500, false, words, word_order::low_first);
    CHECK(m.missing_at(1000).count() == 530);
    m.begin(500, true, words, word_order::low_first);
    CHECK(m.missing_at(1000).count() == -500);
}

TEST_CASE("G34: a motor that is blocked is short of its target, though its deviation makes up the rest") {
    std::array<u16, 16> words{};
    const slice<const u16> read{words.data(), words.size()};
    motion_under_way m;
    m.begin(5000, false, read, word_order::high_first);
    const status_flags pressing{0x0040}; // VDO7, limited torque, at standstill
    REQUIRE(m.confirm(pressing, milliseconds(300)) == errc::ok);
    words[routines::place_word + 1u] = 3000;
    words[routines::deviation_word + 1u] = 2000;
    CHECK_FALSE(m.conclude(read, word_order::high_first));
    CHECK(m.how() == arrival_state::stopped_short);
    CHECK(m.cause() == stop_cause::blocked);
}

} // namespace model_c630s_tests
