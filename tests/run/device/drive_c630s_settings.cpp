// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade against its simulator: taking over and setting up, every routine of the manual that the
// bus reaches, and the promises of machine safety.
#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using rig = simulated::driven_c630s;

namespace {

constexpr u16 p31 = virtual_input_levels.address;

void enable_in(rig& r, control_mode mode, position_source from = position_source::segments) {
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable{mode, from}));
    REQUIRE(r.model.enabled());
    REQUIRE(r.drive.state() == drive_state::enabled);
}

// Frames that set servo-on, a trigger of P31-00, a target or homing.
bool is_motion_or_enable(const rig::frame& f) {
    if (!modbus::is_write(f[1])) return false;
    const unsigned first = load_word(f, 2);
    const unsigned count = f[1] == 0x06 ? 1u : load_word(f, 4);
    for (unsigned i = 0; i < count; ++i) {
        const unsigned value = load_word(f, f[1] == 0x06 ? 4u : 7u + 2u * i);
        const unsigned at = first + i;
        const bool is_target = at == p31 || at == target_speed.address || at == target_torque.address ||
                               at == homing_control.address || at == jog_speed.address;
        if (is_target && value != 0) return true;
    }
    return false;
}

// The model's gear rounds a position to one unit.
bool is_about(std::int64_t a, std::int64_t b) { return a - b <= 3 && b - a <= 3; }

} // namespace

TEST_CASE("the call site: set up, power cycle, speed, halt, disable, fault reset") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.state() == drive_state::needs_set_up);
    CHECK(r.drive.run(enable{control_mode::speed}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(set_up{}));
    CHECK(r.drive.needs_power_cycle());
    CHECK(r.drive.run(enable{control_mode::speed}).error() == errc::wrong_state);
    r.model.power_cycle();
    REQUIRE(r.drive.run(init{}));
    CHECK_FALSE(r.drive.needs_power_cycle());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable{control_mode::speed}));
    REQUIRE(r.drive.run(velocity{300 * r_per_min}));
    REQUIRE(r.live(milliseconds(1000)));
    CHECK(r.r_per_min() == 300);
    CHECK(r.drive.seen().speed == 300 * r_per_min);
    CHECK(r.drive.seen().fine_speed == 300 * r_per_min);
    CHECK(r.drive.seen().state.is_at_speed());
    REQUIRE(r.drive.run(halt{}));
    CHECK(r.model.stands_still());
    CHECK(r.model.enabled());
    REQUIRE(r.drive.run(disable{}));
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("set_up: DIs lose what the bus takes over, and it is done once") {
    rig r;
    client direct{r.line, node<device>{1}};
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(set_up{}));
    CHECK(r.model.peek(eeprom_update.address) == 0);
    for (u16 n = 0; n < 8; ++n) {
        const auto function = static_cast<u16>(r.model.peek(static_cast<u16>(di1_function.address + 2 * n)));
        CHECK_FALSE(c630s::detail::is_virtual_input(function));
    }
    CHECK(r.model.stored(virtual_input_functions[0].address) == 1);
    CHECK(r.model.stored(virtual_inputs_enable.address) == 1);
    CHECK(r.model.stored(virtual_outputs_enable.address) == 1);
    // Not before the power has been off, whichever program asks.
    c630s::drive other{r.line, 1};
    REQUIRE(other.run(init{}));
    CHECK(other.needs_power_cycle());
    CHECK(other.run(enable{}).error() == errc::wrong_state);
    r.model.power_cycle();
    REQUIRE(other.run(init{}));
    CHECK(other.state() == drive_state::disabled);
    const auto before = r.model.eeprom_writes();
    REQUIRE(other.run(set_up{}));
    CHECK(r.model.eeprom_writes() == before);
    CHECK(other.state() == drive_state::disabled);
    CHECK(direct.ram_only());
}

TEST_CASE("set_up disarms what acts at power-on: homing, servo-on by a bit of P03-00 or P0C-10") {
    rig r;
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.store<homing_control>(homing::at_power_on));
    REQUIRE(direct.store<virtual_inputs_at_power_on>(virtual_inputs{}.with(1)));
    REQUIRE(direct.store<power_on_functions_1_to_16>(
        input_functions<1>{}.with(input_function::servo_on).with(input_function::gain_selection)));
    REQUIRE(r.make_ready());
    CHECK(r.model.stored(homing_control.address) == 0);
    CHECK(r.model.stored(virtual_inputs_at_power_on.address) == 0);
    CHECK(r.model.stored(power_on_functions_1_to_16.address) == 4); // the gain stays
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("S1: init stops what runs from a crashed program first, and neither moves nor enables") {
    for (const control_mode mode : {control_mode::speed, control_mode::torque, control_mode::position}) {
        CAPTURE(static_cast<int>(mode));
        rig r;
        enable_in(r, mode);
        if (mode == control_mode::speed) REQUIRE(r.drive.run(velocity{300 * r_per_min}));
        if (mode == control_mode::torque) REQUIRE(r.drive.run(torque{20 * percent}));
        if (mode == control_mode::position) {
            REQUIRE(r.drive.run(segment{1, 500'000 * reference_unit, 300 * r_per_min}));
            REQUIRE(r.drive.run(start_segment{1}));
        }
        r.wire.pass(milliseconds(500));
        REQUIRE_FALSE(r.model.stands_still());
        r.requests.clear();
        rig::drive_type successor{r.line, 1};
        REQUIRE(successor.run(init{}));
        CHECK(same_bytes(r.requests[0],
                         modbus::write_frame(1, target_speed.address, std::array<u16, 2>{0, 0})));
        CHECK(same_bytes(r.requests[1], modbus::write_frame(1, p31, 0)));
        for (const auto& f : r.requests) CHECK_FALSE(is_motion_or_enable(f));
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        CHECK(successor.state() == drive_state::disabled);
    }
}

TEST_CASE("S2: what the factory's values would start does not: speed 200, cyclic segments, homing") {
    rig r;
    REQUIRE(r.make_ready());
    client direct{r.line, node<device>{1}};
    const auto token = direct.ram_only();
    REQUIRE(token);
    REQUIRE(direct.write<target_speed>(200, *token));
    REQUIRE(direct.write<target_torque>(50 * percent, *token));
    REQUIRE(direct.write<position_segment_mode>(segment_mode::cyclic, *token));
    REQUIRE(direct.write<speed_segment_mode>(segment_mode::cyclic, *token));
    REQUIRE(direct.write<speed_command_selection>(command_selection::auxiliary, *token));
    REQUIRE(direct.write<auxiliary_speed_source>(speed_source::segments, *token));
    SUBCASE("speed") { REQUIRE(r.drive.run(enable{control_mode::speed})); }
    SUBCASE("torque") { REQUIRE(r.drive.run(enable{control_mode::torque})); }
    SUBCASE("position") { REQUIRE(r.drive.run(enable{control_mode::position})); }
    CHECK(r.model.enabled());
    REQUIRE(r.live(milliseconds(1500)));
    CHECK(r.model.stands_still());
    CHECK(r.model.peek(target_speed.address) == 0);
    CHECK(r.model.peek(target_torque.address) == 0);
    CHECK(r.model.peek(position_segment_mode.address) == 2);
    CHECK(r.model.peek(speed_segment_mode.address) == 2);
}

TEST_CASE("S2: a cyclic run is made if it is asked for by name") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(segment{1, 1000 * reference_unit, 300 * r_per_min}));
    REQUIRE(r.drive.run(position_segments{}));
    REQUIRE(r.drive.run(enable{control_mode::position, position_source::segments, segment_mode::cyclic}));
    REQUIRE(r.drive.run(start_segments{}));
    r.wire.pass(milliseconds(3000));
    REQUIRE(r.drive.read());
    CHECK(r.drive.seen().position.count() > 3000);
    REQUIRE(r.drive.run(quick_stop{}));
    CHECK(r.model.stands_still());
    CHECK(r.drive.state() == drive_state::disabled); // the run would go on by itself
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.run(start_segments{}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(enable{control_mode::speed}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.stands_still());
}

TEST_CASE("speed: limits of the drive, its ramps, either way") {
    rig r;
    enable_in(r, control_mode::speed);
    CHECK(r.drive.run(velocity{5001 * r_per_min}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(top_speeds{1000 * r_per_min, 800 * r_per_min, 200 * r_per_min}));
    const auto frames = r.requests.size();
    CHECK(r.drive.run(velocity{801 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{-201 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{2'000'000'000 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.requests.size() == frames);
    REQUIRE(r.drive.run(ramps{100 * millisecond, 100 * millisecond}));
    REQUIRE(r.drive.run(velocity{-200 * r_per_min}));
    REQUIRE(r.live(milliseconds(800)));
    CHECK(r.r_per_min() == -200);
    CHECK(r.drive.run(torque{1 * percent}).error() == errc::wrong_state);
    CHECK(r.drive.run(start_segment{1}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.model.stands_still());
}

TEST_CASE("torque: within its limits, the speed bounded") {
    rig r;
    enable_in(r, control_mode::torque);
    REQUIRE(r.drive.run(torque_speed_limits{100 * r_per_min, 100 * r_per_min}));
    REQUIRE(r.drive.run(torque_limits{30 * percent, 20 * percent}));
    CHECK(r.drive.run(torque{31 * percent}).error() == errc::out_of_range);
    CHECK(r.drive.run(torque{-21 * percent}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(torque{255 * part<10>(percent)}));
    CHECK(r.model.peek(target_torque.address) == 255);
    REQUIRE(r.live(milliseconds(1000)));
    CHECK(r.r_per_min() == 100);
    REQUIRE(r.drive.run(halt{}));
    CHECK(r.r_per_min() <= 2); // it rolls out without torque
    CHECK(r.model.enabled());
}

TEST_CASE("6.1.3 positions: the manual's 80000 units, and each of the sixteen segments") {
    rig r;
    enable_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{1, 80'000 * reference_unit, 3000 * r_per_min}));
    CHECK(r.model.peek(position_segment_displacements[0].address) == 80'000);
    std::int64_t at = 0;
    for (int n = 1; n <= 16; ++n) {
        CAPTURE(n);
        const distance way = (n % 2 == 0 ? -100 : 300) * n * reference_unit;
        REQUIRE(r.drive.run(segment{checked(n), way, 600 * r_per_min, 10 * millisecond, 0 * millisecond}));
        REQUIRE(r.drive.run(start_segment{checked(n)}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.drive.read());
        at += way.count();
        CHECK(is_about(r.drive.seen().position.count(), at));
        CHECK(r.drive.seen().deviation.count() == 0);
    }
    CHECK(r.model.starts() == 16);
    CHECK(r.drive.run(segment{checked(17), 1 * reference_unit, 1 * r_per_min}).error() == errc::bad_argument);
    CHECK(r.drive.run(start_segment{checked(0)}).error() == errc::bad_argument);
    CHECK(r.drive.run(start_segment{checked(-1)}).error() == errc::bad_argument);
    CHECK(r.drive.run(segment{1, 1 * reference_unit, 0 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(segment{1, 1 * reference_unit, 1 * r_per_min, 0 * millisecond, 10'001 * millisecond})
              .error() == errc::out_of_range);
    CHECK(r.drive.run(segment{1, 1'073'741'825 * reference_unit, 1 * r_per_min}).error() ==
          errc::out_of_range);
}

TEST_CASE("6.1.3 a start while the motor moves is refused; absolute segments are places") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(position_segments{displacement_type::absolute}));
    REQUIRE(r.drive.run(enable{control_mode::position}));
    REQUIRE(r.drive.run(segment{2, 50'000 * reference_unit, 600 * r_per_min, 100 * millisecond}));
    REQUIRE(r.drive.run(segment{3, 1000 * reference_unit, 600 * r_per_min, 100 * millisecond}));
    REQUIRE(r.drive.run(start_segment{2}));
    r.wire.pass(milliseconds(200));
    CHECK(r.drive.run(start_segment{3}).error() == errc::busy);
    CHECK(r.drive.run(halt{}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.run(start_segment{3}));
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.read());
    CHECK(is_about(r.drive.seen().position.count(), 1000));
    CHECK(r.model.starts() == 2);
    CHECK(r.drive.run(position_segments{}).error() == errc::wrong_state); // only with the servo off
}

TEST_CASE("a level holds for 5 ms at least before the start, and the start too") {
    rig r;
    enable_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{5, 100 * reference_unit, 60 * r_per_min}));
    struct watcher {
        std::vector<std::uint64_t> times; // when a write of P31-00 has passed
        rig::frame open;
    } seen;
    r.wire.set_hook(
        [](void* self, const sim::wire_byte& b) {
            if (!b.is_from_client) return;
            auto& w = *static_cast<watcher*>(self);
            w.open.push_back(b.value);
            if (w.open.size() != modbus::request_length(w.open)) return;
            if (w.open[1] == 0x06 && load_word(w.open, 2) == p31) w.times.push_back(b.at_us);
            w.open.clear();
        },
        &seen);
    REQUIRE(r.drive.run(start_segment{5}));
    REQUIRE(seen.times.size() == 3);
    CHECK(seen.times[1] - seen.times[0] >= 5000);
    CHECK(seen.times[2] - seen.times[1] >= 5000);
}

TEST_CASE("steps by the edge of FunIN.20") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(step_size{-1234 * reference_unit}));
    CHECK(r.drive.run(step_size{10'000 * reference_unit}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(enable{control_mode::position, position_source::step}));
    CHECK(r.drive.run(start_segment{1}).error() == errc::wrong_state);
    for (int i = 0; i < 3; ++i) {
        REQUIRE(r.drive.run(make_step{}));
        REQUIRE(r.drive.run(wait_standstill{}));
    }
    REQUIRE(r.drive.read());
    CHECK(is_about(r.drive.seen().position.count(), -3702));
    CHECK(r.drive.run(step_size{5 * reference_unit}).error() == errc::wrong_state);
}

TEST_CASE("6.2.3 speed segments run by name only, and change by inputs") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(speed_segment{3, 120 * r_per_min, 5 * second}));
    REQUIRE(r.drive.run(speed_segment{4, -60 * r_per_min, 5 * second, segment_ramp::ramp_2}));
    REQUIRE(r.drive.run(segment_ramp_times{segment_ramp::ramp_2, 20 * millisecond, 20 * millisecond}));
    CHECK(r.model.peek(segment_acceleration_time_2.address) == 20);
    CHECK(r.drive.run(speed_segment{3, 1 * r_per_min, 50 * millisecond}).error() == errc::inexact);
    CHECK(r.drive.run(select_speed_segment{4}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(run_speed_segments{segment_mode::by_input, 3}));
    REQUIRE(r.live(milliseconds(800)));
    CHECK(r.r_per_min() == 120);
    CHECK(r.drive.run(velocity{1 * r_per_min}).error() == errc::wrong_state);
    CHECK(r.drive.run(halt{}).error() == errc::wrong_state);
    CHECK(r.drive.run(speed_segment{3, 1 * r_per_min, 1 * second}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(select_speed_segment{4}));
    REQUIRE(r.live(milliseconds(800)));
    CHECK(r.r_per_min() == -60);
    SUBCASE("disable") { REQUIRE(r.drive.run(disable{})); }
    SUBCASE("emergency stop") { REQUIRE(r.drive.run(quick_stop{})); }
    CHECK(r.model.stands_still());
    CHECK_FALSE(r.model.enabled());
    REQUIRE(r.drive.run(enable{control_mode::speed}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.stands_still());
}

TEST_CASE("6.2.3 a speed segment is selected only where inputs choose it") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(run_speed_segments{segment_mode::cyclic, 1, 2}));
    const std::uint16_t inputs = r.drive.known().inputs;
    CHECK(r.drive.run(select_speed_segment{3}).error() == errc::wrong_state);
    CHECK(r.model.peek(virtual_input_levels.address) == inputs);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(run_speed_segments{segment_mode::by_input, 1}));
    REQUIRE(r.drive.run(select_speed_segment{3}));
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable{control_mode::speed}));
    CHECK(r.drive.run(select_speed_segment{3}).error() == errc::wrong_state);
}

TEST_CASE("jog until halt, either way") {
    rig r;
    enable_in(r, control_mode::speed);
    CHECK(r.drive.run(jog{5001 * r_per_min}).error() == errc::out_of_range);
    for (const int way : {30, -20}) {
        REQUIRE(r.drive.run(jog{way * r_per_min}));
        REQUIRE(r.live(milliseconds(600)));
        CHECK(r.r_per_min() == way);
        REQUIRE(r.drive.run(halt{}));
        CHECK(r.model.stands_still());
        CHECK(r.model.enabled());
        CHECK(r.model.peek(p31) == 1);
    }
    REQUIRE(r.drive.run(velocity{10 * r_per_min}));
    REQUIRE(r.live(milliseconds(300)));
    CHECK(r.r_per_min() == 10);
}

TEST_CASE("homing on a switch: waits, confirms, and is switched off where it does not end") {
    rig r;
    REQUIRE(r.make_ready());
    r.model.attach(
        {.home_from = 200'000, .home_to = 260'000, .negative_limit = -900'000, .positive_limit = 900'000});
    REQUIRE(r.drive.run(homing_by{homing_mode::forward_home_switch, 300 * r_per_min, 60 * r_per_min,
                                  100 * millisecond, 30'000}));
    CHECK(r.drive.run(home{10 * second}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(enable{control_mode::position}));
    SUBCASE("found") {
        REQUIRE(r.drive.run(home{30 * second}));
        REQUIRE(r.drive.read());
        CHECK(r.drive.seen().state.is_home());
        CHECK(r.drive.seen().position.count() == 0);
        CHECK(r.model.homings() == 1);
        CHECK(r.model.peek(homing_control.address) == 0);
        REQUIRE(r.drive.run(segment{1, 300 * reference_unit, 60 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.drive.run(home_electrically{10 * second}));
        REQUIRE(r.drive.read());
        CHECK(r.drive.seen().state.is_electrically_home());
    }
    SUBCASE("not found in time") {
        CHECK(r.drive.run(home{200 * millisecond}).error() == errc::not_reached);
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        CHECK(r.drive.state() == drive_state::needs_init);
    }
    SUBCASE("the present position") {
        REQUIRE(r.drive.run(segment{1, 300 * reference_unit, 60 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        REQUIRE(r.drive.run(set_home{}));
        REQUIRE(r.drive.read());
        CHECK(r.drive.seen().position.count() == 0);
    }
    CHECK(r.drive.run(home{0 * second}).outcome() == outcome::not_sent);
}

TEST_CASE("faults: one switches the servo off; reset in the manual's order, and it stays off") {
    rig r;
    enable_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{100 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    r.model.raise(0x620, true);
    const auto seen = r.drive.read();
    REQUIRE(seen);
    CHECK(seen->has_fault());
    CHECK(seen->alarm_code == 0x620);
    REQUIRE(seen->alarm() != nullptr);
    CHECK(seen->alarm()->is_resettable);
    CHECK(r.model.peek(p31) == 0);
    CHECK(r.drive.state() == drive_state::disabled);
    CHECK(r.drive.run(enable{}).error() == errc::faulted);
    CHECK(r.drive.run(fault_reset{}).error() == errc::faulted);
    r.model.end_causes();
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.has_fault());
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable{control_mode::speed}));
    REQUIRE(r.live(milliseconds(300)));
    CHECK(r.model.stands_still());
}

TEST_CASE("the fault history, and it is cleared") {
    rig r;
    REQUIRE(r.make_ready());
    r.model.raise(0x400);
    REQUIRE(r.drive.run(fault_reset{}));
    r.model.raise(0x610);
    REQUIRE(r.drive.run(fault_reset{}));
    const auto last = r.drive.fault(1);
    REQUIRE(last);
    CHECK(last->alarm_code == 0x610);
    CHECK(last->bus_voltage == 310 * volt);
    REQUIRE(r.drive.fault(2));
    CHECK(r.drive.fault(2)->alarm_code == 0x400);
    CHECK(r.drive.fault(0)->alarm_code == 0);
    CHECK(r.drive.fault(10).error() == errc::bad_argument);
    REQUIRE(r.drive.fault(9));
    CHECK(r.model.peek(selected_fault_record.address) == 0);
    REQUIRE(r.drive.run(clear_fault_history{}));
    CHECK(r.drive.fault(1)->alarm_code == 0);
}

TEST_CASE("emergency stop at speed; from the factory's unknown, too") {
    rig r;
    enable_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{500 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    SUBCASE("known") {
        REQUIRE(r.drive.run(quick_stop{}));
        CHECK(r.drive.state() == drive_state::quick_stopped);
        CHECK(r.model.peek(target_speed.address) == 0);
        CHECK(r.drive.run(velocity{1 * r_per_min}).error() == errc::wrong_state);
        CHECK(r.drive.run(enable{}).error() == errc::wrong_state);
    }
    SUBCASE("unknown") {
        rig::drive_type other{r.line, 1};
        REQUIRE(other.run(quick_stop{}));
        CHECK(other.state() == drive_state::needs_init);
    }
    CHECK(r.model.stands_still());
    CHECK(r.model.peek(emergency_stop.address) == 1);
    REQUIRE(r.drive.run(init{}));
    CHECK(r.model.has_warning()); // Er.900
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.has_warning());
    CHECK(r.model.peek(emergency_stop.address) == 0);
}

TEST_CASE("a fault reset cut short by a stop does not go on behind it") {
    rig r;
    enable_in(r, control_mode::speed);
    r.model.raise(0x620);
    REQUIRE(r.drive.begin(fault_reset{}) == errc::ok);
    for (int i = 0; i < 6; ++i) r.turn();
    REQUIRE(r.drive.begin(quick_stop{}) == errc::ok);
    r.loop(1000);
    CHECK(r.model.has_fault());
    CHECK(r.written_to(alarm_reset.address).empty());
}

TEST_CASE("64-bit positions come from one frame, in either word order") {
    for (const pair_order order : {pair_order::low_first, pair_order::high_first}) {
        rig r;
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.store<pair_word_order>(checked(order)));
        enable_in(r, control_mode::position);
        REQUIRE(r.drive.run(segment{1, -25'000 * reference_unit, 3000 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.run(wait_standstill{}));
        const auto frames = r.requests.size();
        const auto there = r.drive.read(wide_position::mechanical);
        REQUIRE(there);
        CHECK(r.requests.size() == frames + 2); // the word order is looked at
        CHECK(*there == r.model.position());
        CHECK(*there < 0);
        REQUIRE(r.drive.read(wide_position::encoder));
        REQUIRE(r.drive.read(wide_position::load));
        REQUIRE(r.drive.read());
        CHECK(is_about(r.drive.seen().position.count(), -25'000));
    }
}

TEST_CASE("parameters for now and for good") {
    rig r;
    REQUIRE(r.make_ready());
    const auto before = r.model.eeprom_writes();
    REQUIRE(r.drive.run(set<positioning_completed_threshold>{500}));
    REQUIRE(r.drive.run(set<home_offset>{-70'000}));
    REQUIRE(r.drive.run(set<position_average_time>{15 * millisecond}));
    REQUIRE(r.drive.run(gear{131'072, 10'000}));
    REQUIRE(r.drive.run(gear{131'072, 3600, 2}));
    CHECK(r.model.peek(gear_2_denominator.address) == 3600);
    CHECK(r.drive.run(gear{0, 1}).error() == errc::out_of_range);
    CHECK(r.drive.run(gear{1, 1, 3}).error() == errc::bad_argument);
    CHECK(r.model.peek(positioning_completed_threshold.address) == 500);
    CHECK(r.model.peek(home_offset.address) == -70'000);
    CHECK(r.model.eeprom_writes() == before);
    REQUIRE(r.drive.run(keep<max_speed>{1500}));
    CHECK(r.drive.known().max_speed == 1500);
    CHECK(r.model.stored(max_speed.address) == 1500);
    CHECK(r.model.peek(eeprom_update.address) == 0);
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(keep<pulses_per_revolution>{0}));
    CHECK(r.drive.needs_power_cycle());
    CHECK(r.model.stored(pulses_per_revolution.address) == 0);
    r.model.power_cycle();
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable{}));
    CHECK(r.drive.run(keep<max_speed>{1000}).error() == errc::wrong_state);
    CHECK(r.drive.run(set<position_average_time>{15 * millisecond}).error() == errc::wrong_state);
    CHECK(r.drive.run(set<positioning_completed_threshold>{checked(0)}).error() == errc::out_of_range);
}

TEST_CASE("absolute encoder, restart, factory reset") {
    rig r;
    REQUIRE(r.make_ready());
    SUBCASE("the encoder's battery was empty") {
        r.model.raise(0x731);
        CHECK(r.drive.run(fault_reset{}).error() == errc::faulted);
        REQUIRE(r.drive.run(reset_encoder{}));
        CHECK_FALSE(r.model.has_fault());
        CHECK(r.drive.state() == drive_state::disabled);
    }
    SUBCASE("restart") {
        (void)r.drive.run(restart{});
        CHECK(r.drive.state() == drive_state::needs_init);
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.state() == drive_state::disabled);
    }
    SUBCASE("factory") {
        (void)r.drive.run(factory_reset{sole_drive_on_the_line{}});
        CHECK(r.drive.state() == drive_state::needs_init);
        r.model.power_cycle();
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.state() == drive_state::needs_set_up);
    }
    SUBCASE("not while it is enabled") {
        REQUIRE(r.drive.run(enable{}));
        CHECK(r.drive.run(reset_encoder{}).error() == errc::wrong_state);
        CHECK(r.drive.run(restart{}).error() == errc::wrong_state);
        CHECK(r.drive.run(factory_reset{sole_drive_on_the_line{}}).error() == errc::wrong_state);
        CHECK(r.drive.run(set_up{}).error() == errc::wrong_state);
        CHECK(r.drive.run(clear_fault_history{}).error() == errc::wrong_state);
        CHECK(r.drive.run(change_address{9, sole_drive_on_the_line{}}).error() == errc::wrong_state);
    }
}

TEST_CASE("G24: another address or baud rate; a facade there finds it, and spares the EEPROM") {
    rig r;
    REQUIRE(r.make_ready());
    SUBCASE("address") {
        (void)r.drive.run(change_address{9, sole_drive_on_the_line{}});
        CHECK(r.drive.state() == drive_state::needs_init);
        rig::drive_type there{r.line, 9};
        REQUIRE(there.run(init{}));
        CHECK(there.state() == drive_state::disabled);
        CHECK(r.model.stored(node_address.address) == 9);
    }
    SUBCASE("baud rate") {
        (void)r.drive.run(change_line{baud_rate::baud_19200});
        CHECK(r.drive.state() == drive_state::needs_init);
        r.wire.set_baud(19200);
        servobus::line slow{r.wire, modbus::timing_at(19200)};
        c630s::drive there{slow, 1};
        REQUIRE(there.run(init{}));
        CHECK(there.state() == drive_state::disabled);
    }
    CHECK(r.model.peek(eeprom_update.address) == 0);
    CHECK(r.drive.run(change_address{248, sole_drive_on_the_line{}}).outcome() == outcome::not_sent);
}

TEST_CASE("P0C-25: the drive's own delay is granted once it is known") {
    rig r;
    node<device> patient{1};
    patient.limits.response = milliseconds(200);
    client direct{r.line, patient};
    REQUIRE(direct.store<response_delay>(150));
    CHECK(r.drive.run(init{}).error() == errc::timeout);
    rig::drive_type drive{r.line, patient};
    REQUIRE(drive.run(init{}));
    direct.node().limits.response = milliseconds(500);
    REQUIRE(direct.store<response_delay>(300));
    REQUIRE(drive.run(init{})); // 150 ms and what the node grants beside
}

TEST_CASE("a drive that answers 10h with the byte count, as the manual prints it, is understood") {
    rig r{{.echoes_byte_count = true}};
    enable_in(r, control_mode::position);
    REQUIRE(r.drive.run(segment{16, 500 * reference_unit, 60 * r_per_min}));
    REQUIRE(r.drive.run(start_segment{16}));
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.run(disable{}));
}

TEST_CASE("G20: an application that falls silent is stopped: by a halt, or an emergency stop in positions") {
    rig r;
    SUBCASE("speed") {
        enable_in(r, control_mode::speed);
        r.drive.watch_commands(milliseconds(400));
        REQUIRE(r.drive.run(velocity{300 * r_per_min}));
        r.loop(200);
        CHECK_FALSE(r.model.stands_still());
        r.loop(2000);
        CHECK(r.model.enabled());
    }
    SUBCASE("jog") {
        enable_in(r, control_mode::speed);
        r.drive.watch_commands(milliseconds(400));
        REQUIRE(r.drive.run(jog{50 * r_per_min}));
        r.loop(200);
        CHECK_FALSE(r.model.stands_still());
        r.loop(2000);
        CHECK(r.model.peek(p31) == 1);
    }
    SUBCASE("position") {
        enable_in(r, control_mode::position);
        r.drive.watch_commands(milliseconds(400));
        REQUIRE(r.drive.run(segment{1, 500'000 * reference_unit, 300 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        r.loop(200);
        CHECK_FALSE(r.model.stands_still());
        r.loop(2000);
        CHECK(r.drive.state() == drive_state::quick_stopped);
    }
    CHECK(r.model.stands_still());
    r.loop(1000);
    CHECK(r.model.stands_still());
}

TEST_CASE("codes that an enumeration does not have are refused before anything is sent") {
    rig r;
    REQUIRE(r.make_ready());
    const auto frames = r.requests.size();
    CHECK(r.drive.run(enable{static_cast<control_mode>(9)}).error() == errc::bad_argument);
    CHECK(r.drive.run(enable{control_mode::torque_or_speed}).error() == errc::bad_argument);
    CHECK(r.drive.run(enable{control_mode::position, static_cast<position_source>(3)}).error() ==
          errc::out_of_range);
    CHECK(r.drive.run(homing_by{static_cast<homing_mode>(10)}).error() == errc::out_of_range);
    CHECK(r.drive.run(change_line{static_cast<baud_rate>(6)}).error() == errc::out_of_range);
    CHECK(r.drive.run(speed_segment{1, 1 * r_per_min, 1 * second, static_cast<segment_ramp>(5)}).error() ==
          errc::out_of_range);
    CHECK(r.drive.run(segment_ramp_times{segment_ramp::none, 1 * millisecond, 1 * millisecond}).error() ==
          errc::bad_argument);
    CHECK(r.requests.size() == frames);
}
