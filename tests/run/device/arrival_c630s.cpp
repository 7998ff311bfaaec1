// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G34, G35: how a move of a C630S ends, judged by the simulated motor and by arithmetic on what was commanded;
// what the drive's state says after a fault or a restart, and how soon; what is read, and how often.
#include <cstdint>
#include <cstdlib>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>

namespace arrival_c630s_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

namespace {

/// A drive that is set up, and a facade of it that is polled.
struct polled : simulated::simulated_c630s {
    c630s::drive<line_type> servo;

    explicit polled(supervision by = without_watchdog, sim::c630s_options options = {})
        : simulated_model{options}, servo{line, 1, by} {
        REQUIRE(servo.run(init{}));
        REQUIRE(servo.run(set_up{}));
        model.power_cycle();
        REQUIRE(servo.run(init{}));
    }
    void be_enabled_in(control_mode mode, position_source from = position_source::segments) {
        REQUIRE(servo.run(enable_in{mode, from}));
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) {
            const duration idle = servo.step();
            wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    }
    /// Steps until the facade says so; returns the time it took in milliseconds.
    template <class F> std::uint64_t loop_until(const F& so, std::uint32_t most_ms = 5000) {
        const std::uint64_t start = wire.time_us();
        while (!so() && wire.time_us() < start + std::uint64_t{most_ms} * 1000u) loop(1);
        return (wire.time_us() - start) / 1000;
    }
    /// Where the motor is, in reference units from where it was at construction.
    std::int64_t place() const { return model.position() * 10'000 / 131'072; }
    bool is_near(std::int64_t wanted) const { return std::llabs(place() - wanted) <= 60; } // P05-21
};

constexpr speed brisk = 600 * r_per_min;
constexpr c630s::time ramp = 20 * millisecond;

} // namespace

TEST_CASE("G34: a move that reaches its target says so, whatever its way and kind") {
    polled p{unsupervised};
    CHECK(p.servo.arrival().how == arrival_state::none);
    CHECK(p.servo.run(wait_reached{}).error() == errc::wrong_state);
    for (const displacement_type type : {displacement_type::relative, displacement_type::absolute}) {
        REQUIRE(p.servo.run(position_segments{.type = type}));
        p.be_enabled_in(control_mode::position);
        for (const std::int32_t way : {10'000, -3000, 700, 7, -1, 60'000}) {
            CAPTURE(way);
            const bool is_absolute = type == displacement_type::absolute;
            const std::int64_t target = is_absolute ? way : p.place() + way;
            REQUIRE(p.servo.run(segment{3, way * reference_unit, brisk, ramp}));
            const arrival there = p.servo.run(start_segment{3}, wait_reached{});
            CHECK(there.how == arrival_state::reached);
            CHECK(std::abs(there.missing.count()) <= 60);
            CHECK(p.is_near(target));
            CHECK(p.model.stands_still());
            CHECK(p.servo.run(wait_standstill{}));
        }
        REQUIRE(p.servo.run(disable{}));
    }
    REQUIRE(p.servo.run(step_size{-500 * reference_unit}));
    p.be_enabled_in(control_mode::position, position_source::step);
    const std::int64_t before = p.place();
    CHECK(p.servo.run(make_step{}, wait_reached{}).how == arrival_state::reached);
    CHECK(p.is_near(before - 500));
}

TEST_CASE("G34: a move that ends short of its target says so, with its cause and what is missing") {
    enum class end { quick_stop, disable, fault, emergency_input, limit_switch, blocked };
    for (const end how :
         {end::quick_stop, end::disable, end::fault, end::emergency_input, end::limit_switch, end::blocked}) {
        for (const bool is_waiting : {false, true}) {
            CAPTURE(static_cast<int>(how));
            CAPTURE(is_waiting);
            polled p;
            p.be_enabled_in(control_mode::position);
            const std::int64_t target = p.place() + 50'000;
            REQUIRE(p.servo.run(segment{1, 50'000 * reference_unit, brisk, ramp}));
            REQUIRE(p.servo.run(start_segment{1}));
            CHECK(p.servo.arrival().how == arrival_state::under_way);
            if (is_waiting) REQUIRE(p.servo.begin(wait_reached{}) == errc::ok);
            p.loop(200);
            stop_cause cause = stop_cause::command;
            switch (how) {
            case end::quick_stop: REQUIRE(p.servo.begin(quick_stop{}) == errc::ok); break;
            case end::disable: REQUIRE(p.servo.begin(disable{}) == errc::ok); break;
            case end::fault:
                p.model.raise(0x620);
                cause = stop_cause::fault;
                break;
            case end::emergency_input:
                p.model.set_input(6, true);
                cause = stop_cause::input;
                break;
            case end::limit_switch:
                p.model.set_input(2, true); // DI2 is the positive limit from the factory
                cause = stop_cause::input;
                break;
            case end::blocked:
                p.model.block_shaft(true);
                cause = stop_cause::blocked;
                break;
            }
            // Without a stop or a fault the facade finds the end when it is asked to wait for it.
            const bool is_found_by_wait = how >= end::emergency_input;
            if (!is_waiting && is_found_by_wait)
                CHECK(p.servo.run(wait_reached{}).error() == errc::stopped_short);
            p.loop(50);
            while (!p.servo.is_idle()) p.loop(1);
            if (is_waiting && is_found_by_wait) CHECK(p.servo.last().error() == errc::stopped_short);
            if (how == end::blocked) CHECK_FALSE(p.model.has_alarm(0x630)); // seen before it
            p.loop(300);
            const arrival there = p.servo.arrival();
            CHECK(there.how == arrival_state::stopped_short);
            CHECK(there.cause == cause);
            CHECK(std::llabs(there.missing.count() - (target - p.place())) <= 60);
            CHECK(std::abs(there.missing.count()) > 1000);
            CHECK_FALSE(p.servo.run(wait_reached{}));
        }
    }
}

TEST_CASE("G34, G35: while the stop for a fault is under way the move has ended short, with the fault as its "
          "cause") {
    polled p;
    p.be_enabled_in(control_mode::position);
    REQUIRE(p.servo.run(segment{1, 50'000 * reference_unit, brisk, ramp}));
    REQUIRE(p.servo.run(start_segment{1}));
    p.loop(200);
    REQUIRE(p.servo.arrival().how == arrival_state::under_way);
    p.model.raise(0x620);
    p.loop_until([&] { return !p.servo.is_idle(); }); // its stop begins
    CHECK(p.servo.arrival().how == arrival_state::stopped_short);
    CHECK(p.servo.arrival().cause == stop_cause::fault);
    while (!p.servo.is_idle()) p.loop(1);
    CHECK(p.servo.arrival().how == arrival_state::stopped_short);
    CHECK(p.servo.arrival().cause == stop_cause::fault);
}

TEST_CASE(
    "G34: a wait after a move that was stopped ends immediately, and nothing is known after a restart") {
    polled p;
    p.be_enabled_in(control_mode::position);
    REQUIRE(p.servo.run(segment{1, 50'000 * reference_unit, brisk, ramp}));
    REQUIRE(p.servo.run(start_segment{1}));
    REQUIRE(p.servo.run(quick_stop{}));
    const std::uint64_t start = p.wire.time_us();
    CHECK(p.servo.run(wait_reached{}).error() == errc::stopped_short);
    CHECK(p.wire.time_us() - start < 100'000);
    p.model.power_cycle();
    p.loop(600);
    CHECK(p.servo.state() == drive_state::needs_init);
    CHECK(p.servo.arrival().how == arrival_state::none);
}

TEST_CASE("G34: a start that the drive does not carry out is no arrival") {
    polled p{unsupervised, {.segment_start_is_level = true}};
    p.be_enabled_in(control_mode::position);
    REQUIRE(p.servo.run(segment{1, 5000 * reference_unit, brisk, ramp}));
    const arrival there = p.servo.run(start_segment{1}, wait_reached{});
    CHECK(there.how == arrival_state::stopped_short);
    CHECK(there.missing == 5000 * reference_unit);
}

TEST_CASE("G35: a fault shows in the state within a feedback period and two frames, with its alarm; commands "
          "fail") {
    for (const bool is_idle : {false, true}) {
        polled p;
        p.be_enabled_in(control_mode::speed);
        REQUIRE(p.servo.run(velocity{300 * r_per_min}));
        p.loop(300);
        if (!is_idle) REQUIRE(p.servo.begin(wait_standstill{}) == errc::ok);
        p.model.raise(0x620, true);
        CHECK(p.loop_until([&] { return p.servo.state() == drive_state::faulted; }) <= 20 + 2 * 10);
        CHECK(p.servo.cause() == stop_cause::fault);
        while (!p.servo.is_idle()) p.loop(1);
        if (!is_idle) CHECK(p.servo.last().error() == errc::faulted);
        CHECK(p.servo.feedback(milliseconds(2000))->alarm_code == 0x620);
        CHECK(p.servo.run(velocity{100 * r_per_min}).error() == errc::faulted);
        CHECK((p.model.peek(virtual_input_levels.address) & ~terminal::marker) == 0);
        p.model.end_causes();
        REQUIRE(p.servo.run(fault_reset{}));
        CHECK(p.servo.state() == drive_state::disabled);
        CHECK(p.servo.restart_visible());
    }
}

TEST_CASE("G35: a velocity that is commanded right after a fault or a loss of power fails, polled or not") {
    for (const bool is_polled : {false, true}) {
        for (const bool is_fault : {false, true}) {
            CAPTURE(is_polled);
            CAPTURE(is_fault);
            polled p{is_polled ? without_watchdog : unsupervised};
            p.be_enabled_in(control_mode::speed);
            if (is_fault)
                p.model.raise(0x620);
            else
                p.model.power_cycle();
            const command_status got = p.servo.run(velocity{100 * r_per_min});
            CHECK(got.error() == (is_fault ? errc::faulted : errc::needs_init));
            CHECK(p.model.peek(target_speed.address) == 0);
            CHECK_FALSE(p.model.enabled());
        }
    }
}

TEST_CASE("S5: a restart of an enabled drive is found within 500 ms and two frames, of a disabled one too") {
    for (const bool is_enabled : {false, true}) {
        CAPTURE(is_enabled);
        polled p;
        CHECK(p.servo.restart_visible());
        if (is_enabled) p.be_enabled_in(control_mode::torque);
        p.loop(733);
        p.model.power_cycle();
        CHECK(p.loop_until([&] { return p.servo.state() == drive_state::needs_init; }) <= 500 + 2 * 10);
        CHECK(p.servo.cause() == stop_cause::restart);
        while (!p.servo.is_idle()) p.loop(1);
        CHECK_FALSE(p.servo.restart_visible());
        CHECK(p.servo.begin(enable{}) == errc::needs_init);
        REQUIRE(p.servo.run(init{}));
        CHECK(p.servo.restart_visible());
    }
}

TEST_CASE(
    "the status is read in one frame, all of the feedback in five, and in the background part by part") {
    polled p{unsupervised};
    const std::size_t start = p.requests.size();
    const result<status_flags> light = p.servo.read_status();
    REQUIRE(light);
    CHECK(light->is_ready());
    CHECK(p.requests.size() - start == 1);
    REQUIRE(p.servo.read());
    CHECK(p.requests.size() - start == 6);
    p.loop(1000);
    CHECK(p.requests.size() - start == 6); // nothing that was not commanded

    polled q;
    q.be_enabled_in(control_mode::speed);
    REQUIRE(q.servo.run(velocity{120 * r_per_min}));
    const std::size_t before = q.requests.size();
    q.loop(2000);
    const feedback seen = *q.servo.feedback(milliseconds(2000));
    CHECK(seen.speed.count() == 120);
    CHECK(std::llabs(seen.position.count() - q.place()) <=
          3600); // 20 units a millisecond, at most eight periods
    CHECK(std::llabs(seen.fine_speed.count() - 1200) <= 10);
    CHECK(seen.state.is_brake_released());
    std::size_t status = 0;
    std::size_t others = 0;
    for (std::size_t i = before; i < q.requests.size(); ++i)
        (load_word(q.requests[i], 2) == virtual_output_levels.address ? status : others) += 1;
    CHECK(status >= 90); // every 20 ms
    CHECK(status <= 101);
    CHECK(others >= 45); // one for two of them, and the witness twice a second
    CHECK(others <= 56);
}

TEST_CASE("G21: a velocity whose response is lost is read back, and the drive stays enabled") {
    for (const bool is_request : {false, true}) {
        CAPTURE(is_request);
        polled p{unsupervised};
        p.be_enabled_in(control_mode::speed);
        REQUIRE(p.servo.run(velocity{100 * r_per_min}));
        const std::size_t start = p.wire.requests();
        REQUIRE(p.servo.begin(velocity{200 * r_per_min}) == errc::ok);
        while (!p.servo.is_idle()) {
            const bool is_write = p.wire.requests() - start == (is_request ? 1u : 2u);
            p.wire.faults().lost_request = is_write && is_request ? 1000 : 0;
            p.wire.faults().lost_response = is_write && !is_request ? 1000 : 0;
            p.loop(1);
        }
        CHECK(p.wire.struck() != 0);
        p.wire.faults() = {};
        CHECK(p.servo.last().error() == (is_request ? errc::not_executed : errc::ok));
        CHECK(p.model.peek(target_speed.address) == (is_request ? 100 : 200));
        CHECK(p.servo.state() == drive_state::enabled);
    }
}

TEST_CASE("a drive that responds later than the feedback period is polled as often as it can be, and obeys") {
    polled p;
    {
        client direct{p.line, node<device>{1}};
        REQUIRE(direct.store<response_delay>(80));
    }
    REQUIRE(p.servo.run(init{}));
    p.be_enabled_in(control_mode::speed);
    REQUIRE(p.servo.run(velocity{100 * r_per_min}));
    REQUIRE(p.servo.run(read_feedback{}));
    p.loop(3000);
    CHECK(p.servo.feedback(milliseconds(2000))->speed.count() == 100);
    p.model.raise(0x620);
    CHECK(p.loop_until([&] { return p.servo.state() == drive_state::faulted; }) <= 300);
    while (!p.servo.is_idle()) p.loop(1);
    REQUIRE(p.servo.run(disable{}));
    CHECK(p.model.stands_still());
}

TEST_CASE(
    "a stated feedback period that is shorter than the status takes is refused before anything is sent") {
    // 8 bytes and 7 bytes of 11 bits at 57600 Bd: 2865 us.
    for (const std::uint32_t us : {2500u, 3000u}) {
        CAPTURE(us);
        simulated::simulated_c630s r;
        c630s::drive servo{r.line, 1, {.feedback = microseconds(us), .command_timeout = no_command_timeout}};
        CHECK(servo.run(init{}).error() == (us < 2865 ? errc::bad_argument : errc::ok));
        CHECK(r.requests.empty() == (us < 2865));
    }
}

TEST_CASE("by default a line that is too slow for the feedback period is polled as often as it allows") {
    sim::c630s model;
    const std::uint8_t slowest[] = {0, 0};
    REQUIRE(model.write(rs485_baud_rate.address, words_view{slowest}) == 0);
    REQUIRE(model.baud() == 2400); // the status takes 69 ms
    sim::station station{model};
    sim::virtual_line wire{2400};
    wire.attach(station);
    line on{wire, modbus::timing_at(2400)};
    c630s::drive servo{on, 1};
    REQUIRE(servo.run(init{}));
    REQUIRE(servo.run(set_up{}));
    model.power_cycle();
    REQUIRE(servo.run(init{}));
    REQUIRE(servo.run(enable_in{control_mode::speed}));
    REQUIRE(servo.run(velocity{100 * r_per_min}));
    CHECK(model.peek(target_speed.address) == 100);
    REQUIRE(servo.run(disable{}));
    CHECK(model.stands_still());
}

// A disable writes P31-00 with the marker, which a restart had cleared: nothing would show the restart any more, and
// what was set without the EEPROM would be taken to be still set.
TEST_CASE("G21, G35: a restart of a disabled drive shows also if a stop follows before its inputs are read") {
    for (const bool is_quick_stop : {false, true}) {
        polled p;
        p.loop(600);
        REQUIRE(p.servo.restart_visible());
        p.model.power_cycle();
        if (is_quick_stop) REQUIRE(p.servo.run(quick_stop{}));
        if (!is_quick_stop) REQUIRE(p.servo.run(disable{}));
        CHECK(p.servo.state() == drive_state::needs_init);
        CHECK(p.servo.run(enable_in{control_mode::speed}).error() == errc::needs_init);
        REQUIRE(p.servo.run(init{}));
        REQUIRE(p.servo.run(disable{}));
        CHECK(p.servo.state() == drive_state::disabled); // it had not restarted
    }
}

TEST_CASE(
    "G21, G35: a restart of an enabled drive that missed a request shows although a disable comes next") {
    for (const bool is_restarted : {false, true}) {
        CAPTURE(is_restarted);
        polled p;
        p.be_enabled_in(control_mode::speed);
        REQUIRE(p.servo.run(velocity{100 * r_per_min}));
        p.wire.set_connected(0, false);
        if (is_restarted) p.model.power_cycle();
        const std::uint16_t misses = p.servo.line().epoch(1).misses;
        while (p.servo.line().epoch(1).misses == misses) p.loop(1);
        p.wire.set_connected(0, true);
        REQUIRE(p.servo.run(disable{}));
        CHECK(p.model.stands_still());
        CHECK((p.servo.state() == drive_state::needs_init) == is_restarted);
    }
}

TEST_CASE("G34: a move towards a limit switch that is active is refused before anything is written, and one "
          "away from "
          "it is not") {
    for (const bool is_negative : {false, true}) {
        CAPTURE(is_negative);
        polled p;
        REQUIRE(p.servo.run(segment{1, 20'000 * reference_unit, brisk, ramp}));
        REQUIRE(p.servo.run(segment{2, -20'000 * reference_unit, brisk, ramp}));
        p.be_enabled_in(control_mode::position);
        p.model.set_input(is_negative ? 3 : 2, true); // DI2 and DI3 are the limits from the factory
        p.loop(100);
        const start_segment towards = is_negative ? start_segment{2} : start_segment{1};
        const start_segment away = is_negative ? start_segment{1} : start_segment{2};
        const std::uint32_t starts = p.model.starts();
        const command_status refused = p.servo.run(towards);
        CHECK(refused.error() == errc::wrong_state);
        CHECK(refused.outcome() == outcome::not_sent);
        CHECK(p.model.starts() == starts);
        CHECK(p.servo.state() == drive_state::enabled);
        CHECK(p.servo.run(towards, wait_reached{}).how == arrival_state::none);
        CHECK(p.servo.run(away, wait_reached{}).how == arrival_state::reached);
        CHECK(p.servo.run(towards, wait_reached{}).how == arrival_state::none); // nor that of the move before
        CHECK(p.servo.last().error() == errc::wrong_state);
        p.model.set_input(is_negative ? 3 : 2, false);
        p.loop(100);
        CHECK(p.servo.run(towards, wait_reached{}).how == arrival_state::reached);
    }
}

TEST_CASE("G36: feedback of before a restart is not delivered after the init that follows it") {
    polled p;
    p.be_enabled_in(control_mode::position);
    REQUIRE(p.servo.run(segment{1, 20'000 * reference_unit, brisk, ramp}));
    REQUIRE(p.servo.run(start_segment{1}, wait_reached{}).how == arrival_state::reached);
    p.loop(500);
    REQUIRE(p.servo.feedback(milliseconds(500)));
    p.model.power_cycle();
    while (p.servo.state() != drive_state::needs_init) p.loop(1);
    CHECK(p.servo.feedback(milliseconds(100'000)).error() == errc::needs_init);
    REQUIRE(p.servo.run(init{}));
    CHECK(p.servo.feedback(milliseconds(100'000)).error() == errc::timeout); // not all of it was read since
    p.loop(500);
    CHECK(p.servo.feedback(milliseconds(500)));
}

TEST_CASE("G21, G35: a restart of a drive that is not polled shows although a stop comes next") {
    for (const bool is_reset : {false, true}) {
        CAPTURE(is_reset);
        polled p{unsupervised};
        p.be_enabled_in(control_mode::speed);
        REQUIRE(p.servo.run(velocity{100 * r_per_min}));
        p.loop(2000);
        p.model.power_cycle();
        p.loop(10'000);
        if (is_reset) CHECK(p.servo.run(fault_reset{}).error() == errc::needs_init);
        if (!is_reset) REQUIRE(p.servo.run(disable{}));
        CHECK(p.servo.state() == drive_state::needs_init);
        CHECK(p.servo.run(enable_in{control_mode::speed}).error() == errc::needs_init);
        CHECK_FALSE(p.model.enabled());
    }
}

TEST_CASE("G20, G35: a restart before the stop of the command timeout shows") {
    polled p{unsupervised};
    REQUIRE(p.servo.run(run_speed_segments{.run = segment_mode::cyclic}));
    p.servo.set_command_timeout(milliseconds(3000));
    p.loop(1000);
    p.model.power_cycle();
    p.loop(10'000);
    CHECK(p.servo.state() == drive_state::needs_init);
    CHECK_FALSE(p.model.enabled());
}

TEST_CASE(
    "G34: a motor is blocked after a tenth of a second, also where the time since the start goes back") {
    motion_under_way m;
    const status_flags turning{status_flags::rotating_bit};
    const status_flags pressing{0x0040}; // VDO7, limited torque, at standstill
    CHECK(m.confirm(turning, milliseconds(119'990)) == errc::busy);
    CHECK(m.confirm(pressing, milliseconds(60'000)) == errc::busy);
    CHECK(m.confirm(pressing, milliseconds(60'099)) == errc::busy);
    CHECK(m.confirm(pressing, milliseconds(60'100)) == errc::ok);
    const status_flags accelerating{status_flags::rotating_bit | 0x0040}; // at the limit, and it turns
    CHECK(m.confirm(accelerating, milliseconds(60'200)) == errc::busy);
    CHECK(m.confirm(accelerating, milliseconds(60'400)) == errc::busy);
}

TEST_CASE("G34: a move has the cause of its own end, and none while it is under way or has arrived") {
    polled p{unsupervised};
    p.be_enabled_in(control_mode::position);
    REQUIRE(p.servo.run(segment{1, 20'000 * reference_unit, brisk, ramp}));
    p.model.block_shaft(true);
    const arrival blocked = p.servo.run(start_segment{1}, wait_reached{});
    REQUIRE(blocked.how == arrival_state::stopped_short);
    REQUIRE(blocked.cause == stop_cause::blocked);
    p.model.block_shaft(false);
    p.wire.pass(milliseconds(2000));
    REQUIRE(p.servo.run(start_segment{1}));
    CHECK(p.servo.arrival().how == arrival_state::under_way);
    CHECK(p.servo.arrival().cause == stop_cause::unknown);
    REQUIRE(p.servo.run(wait_reached{}));
    CHECK(p.servo.arrival().how == arrival_state::reached);
    CHECK(p.servo.arrival().cause == stop_cause::unknown);
}

} // namespace arrival_c630s_tests
