// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade against its simulator: init and set-up without motion, faults and the emergency stop,
// parameters, restart and factory reset, another address or baud rate.
#include <array>

#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/enabled_c630s.hpp>

namespace drive_c630s_settings_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using enabled_c630s::be_enabled_in;
using enabled_c630s::p31;
using rig = simulated::driven_c630s;

namespace {

// True for frames that set servo-on, a trigger of P31-00, a target or homing.
bool is_motion_or_enable(const rig::frame& f) {
    if (!modbus::is_write(f[1])) return false;
    const unsigned first = load_word(f, 2);
    const unsigned count = f[1] == 0x06 ? 1u : load_word(f, 4);
    for (unsigned i = 0; i < count; ++i) {
        const unsigned value = load_word(f, f[1] == 0x06 ? 4u : 7u + 2u * i);
        const unsigned at = first + i;
        const bool is_target = at == p31 || at == target_speed.address || at == target_torque.address ||
                               at == homing_control.address || at == jog_speed.address;
        if (is_target && (at == p31 ? value & ~unsigned{terminal::marker} : value) != 0) return true;
    }
    return false;
}

} // namespace

TEST_CASE("the usual sequence works: set-up, power cycle, enable, velocity, halt, disable, fault reset") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.state() == drive_state::needs_set_up);
    CHECK(r.drive.run(enable_in{control_mode::speed}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(set_up{}));
    CHECK(r.drive.needs_power_cycle());
    CHECK(r.drive.run(enable_in{control_mode::speed}).error() == errc::wrong_state);
    r.model.power_cycle();
    REQUIRE(r.drive.run(init{}));
    CHECK_FALSE(r.drive.needs_power_cycle());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.drive.run(velocity{300 * r_per_min}));
    REQUIRE(r.live(milliseconds(1000)));
    CHECK(r.r_per_min() == 300);
    CHECK(r.drive.feedback(milliseconds(2000))->speed == 300 * r_per_min);
    CHECK(r.drive.feedback(milliseconds(2000))->fine_speed == 300 * r_per_min);
    CHECK(r.drive.feedback(milliseconds(2000))->state.is_at_speed());
    REQUIRE(r.drive.run(halt{}));
    CHECK(r.model.stands_still());
    CHECK(r.model.enabled());
    REQUIRE(r.drive.run(disable{}));
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("set_up takes from the DIs the functions that the bus gives, and writes them only once") {
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
    // No program may enable the drive before the power has been off.
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

TEST_CASE("set_up switches off what acts at power-on: homing, and servo-on by a bit of P03-00 or P0C-10") {
    rig r;
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.store<homing_control>(homing::at_power_on));
    REQUIRE(direct.store<virtual_inputs_at_power_on>(virtual_inputs{}.with(1)));
    REQUIRE(direct.store<power_on_functions_1_to_16>(
        input_functions<1>{}.with(input_function::servo_on).with(input_function::gain_selection)));
    REQUIRE(r.make_ready());
    CHECK(r.model.stored(homing_control.address) == 0);
    CHECK(r.model.stored(virtual_inputs_at_power_on.address) == 0);
    CHECK(r.model.stored(power_on_functions_1_to_16.address) == 4); // the gain selection stays
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("S1: init first stops the motion that a crashed program left, and neither moves nor enables the "
          "drive") {
    for (const control_mode mode : {control_mode::speed, control_mode::torque, control_mode::position}) {
        CAPTURE(static_cast<int>(mode));
        rig r;
        be_enabled_in(r, mode);
        if (mode == control_mode::speed) REQUIRE(r.drive.run(velocity{300 * r_per_min}));
        if (mode == control_mode::torque) REQUIRE(r.drive.run(torque{20 * percent}));
        if (mode == control_mode::position) {
            REQUIRE(r.drive.run(segment{1, 500'000 * reference_unit, 300 * r_per_min}));
            REQUIRE(r.drive.run(start_segment{1}));
        }
        r.wire.pass(milliseconds(500));
        REQUIRE_FALSE(r.model.stands_still());
        r.requests.clear();
        rig::drive_type successor{r.line, 1, unsupervised};
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

TEST_CASE("S2: an enable starts nothing that preset registers would start: speed 200, torque, cyclic "
          "segments") {
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
    SUBCASE("speed") { REQUIRE(r.drive.run(enable_in{control_mode::speed})); }
    SUBCASE("torque") { REQUIRE(r.drive.run(enable_in{control_mode::torque})); }
    SUBCASE("position") { REQUIRE(r.drive.run(enable_in{control_mode::position})); }
    CHECK(r.model.enabled());
    REQUIRE(r.live(milliseconds(1500)));
    CHECK(r.model.stands_still());
    CHECK(r.model.peek(target_speed.address) == 0);
    CHECK(r.model.peek(target_torque.address) == 0);
    CHECK(r.model.peek(position_segment_mode.address) == 2);
    CHECK(r.model.peek(speed_segment_mode.address) == 2);
}

TEST_CASE("a fault switches the servo off; after a reset in the manual's order it stays off") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{100 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    r.model.raise(0x620, true);
    const auto seen = r.drive.read();
    REQUIRE(seen);
    CHECK(seen->has_fault());
    CHECK(seen->alarm_code == 0x620);
    REQUIRE(seen->alarm() != nullptr);
    CHECK(seen->alarm()->is_resettable);
    CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
    CHECK(r.drive.state() == drive_state::faulted);
    CHECK(r.drive.run(enable{}).error() == errc::faulted);
    CHECK(r.drive.run(fault_reset{}).error() == errc::faulted);
    r.model.end_causes();
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.has_fault());
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.live(milliseconds(300)));
    CHECK(r.model.stands_still());
}

TEST_CASE("the fault history is read and cleared") {
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

TEST_CASE(
    "while another client has selected an older entry of the fault history the feedback has no alarm code") {
    rig r;
    REQUIRE(r.make_ready());
    r.model.raise(0x400);
    REQUIRE(r.drive.run(fault_reset{}));
    client other{r.line, node<device>{1}};
    REQUIRE(other.write<selected_fault_record>(fault_record::last));
    const auto seen = r.drive.read();
    REQUIRE(seen);
    CHECK(seen->alarm_code == 0);
    CHECK_FALSE(seen->has_fault());
}

TEST_CASE("a quick stop sends an emergency stop at speed, with or without a preceding init") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(velocity{500 * r_per_min}));
    REQUIRE(r.live(milliseconds(500)));
    SUBCASE("after init") {
        REQUIRE(r.drive.run(quick_stop{}));
        CHECK(r.drive.state() == drive_state::quick_stopped);
        CHECK(r.model.peek(target_speed.address) == 0);
        CHECK(r.drive.run(velocity{1 * r_per_min}).error() == errc::wrong_state);
        CHECK(r.drive.run(enable{}).error() == errc::wrong_state);
    }
    SUBCASE("without init") {
        rig::drive_type other{r.line, 1, unsupervised};
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

TEST_CASE("a fault reset that a stop pre-empts does not continue after it") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    r.model.raise(0x620);
    REQUIRE(r.drive.begin(fault_reset{}) == errc::ok);
    for (int i = 0; i < 6; ++i) r.turn();
    REQUIRE(r.drive.begin(quick_stop{}) == errc::ok);
    r.loop(1000);
    CHECK(r.model.has_fault());
    CHECK(r.written_to(alarm_reset.address).empty());
}

TEST_CASE("set changes a parameter until power-off, keep stores it") {
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
    CHECK(r.drive.cached().max_speed == 1500);
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

TEST_CASE("each parameter that a facade has read is the one that was set or kept last") {
    rig r;
    REQUIRE(r.make_ready());
    const auto& known = [&]() -> decltype(auto) { return r.drive.cached(); };
    REQUIRE(r.drive.run(keep<max_speed>{1501}));
    CHECK(known().max_speed == 1501);
    REQUIRE(r.drive.run(keep<max_forward_speed>{1502}));
    CHECK(known().max_forward == 1502);
    REQUIRE(r.drive.run(keep<max_reverse_speed>{1503}));
    CHECK(known().max_reverse == 1503);
    REQUIRE(r.drive.run(keep<positive_internal_torque_limit>{raw(1504)}));
    CHECK(known().positive_torque == 1504);
    REQUIRE(r.drive.run(keep<negative_internal_torque_limit>{raw(1505)}));
    CHECK(known().negative_torque == 1505);
    REQUIRE(r.drive.run(keep<brake_off_to_power_off_delay>{506}));
    CHECK(known().power_off_delay_ms == 506);
    REQUIRE(r.drive.run(keep<brake_on_to_command_delay>{500}));
    CHECK(known().brake_delay_ms == 500);
    REQUIRE(r.drive.run(init{})); // which reads them all
    CHECK(known().max_speed == 1501);
    CHECK(known().max_forward == 1502);
    CHECK(known().max_reverse == 1503);
    CHECK(known().positive_torque == 1504);
    CHECK(known().negative_torque == 1505);
    CHECK(known().power_off_delay_ms == 506);
    CHECK(known().brake_delay_ms == 500);
    const auto before = r.wire.time_us();
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    CHECK(r.wire.time_us() - before >= 500'000); // it returns once the brake is open
}

TEST_CASE("reset_encoder, restart and factory_reset work, and only on a disabled drive") {
    rig r;
    REQUIRE(r.make_ready());
    SUBCASE("an empty encoder battery") {
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
    SUBCASE("factory reset") {
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

TEST_CASE("G24: after a change of address or baud rate a facade with the new setting finds the drive, and "
          "EEPROM writes are off") {
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

TEST_CASE("P0C-25: after init the drive's own response delay is added to the time limit") {
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
    REQUIRE(drive.run(init{})); // the limit is 150 ms plus the limit of the node
}

TEST_CASE("codes outside an enumeration are refused before anything is sent") {
    rig r;
    REQUIRE(r.make_ready());
    const auto frames = r.requests.size();
    CHECK(r.drive.run(enable_in{static_cast<control_mode>(9)}).error() == errc::bad_argument);
    CHECK(r.drive.run(enable_in{control_mode::torque_or_speed}).error() == errc::bad_argument);
    CHECK(r.drive.run(enable_in{control_mode::position, static_cast<position_source>(3)}).error() ==
          errc::out_of_range);
    CHECK(r.drive.run(homing_by{static_cast<homing_mode>(10)}).error() == errc::out_of_range);
    CHECK(r.drive.run(change_line{static_cast<baud_rate>(6)}).error() == errc::out_of_range);
    CHECK(r.drive.run(speed_segment{1, 1 * r_per_min, 1 * second, static_cast<segment_ramp>(5)}).error() ==
          errc::out_of_range);
    CHECK(r.drive.run(segment_ramp_times{segment_ramp::none, 1 * millisecond, 1 * millisecond}).error() ==
          errc::bad_argument);
    CHECK(r.requests.size() == frames);
}

TEST_CASE("a parameter that is set changes no other that the facade knows") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(top_speeds{2000 * r_per_min, 1900 * r_per_min, 1800 * r_per_min}));
    REQUIRE(r.drive.run(set<positive_internal_torque_limit>{raw(1111)}));
    REQUIRE(r.drive.run(set<negative_internal_torque_limit>{raw(1222)}));
    const auto is_as_set = [&] {
        const cached_settings& known = r.drive.cached();
        CHECK(known.max_speed == 2000);
        CHECK(known.max_forward == 1900);
        CHECK(known.max_reverse == 1800);
        CHECK(known.positive_torque == 1111);
        CHECK(known.negative_torque == 1222);
    };
    is_as_set();
    REQUIRE(r.drive.run(set<brake_on_to_command_delay>{300}));
    REQUIRE(r.drive.run(set<brake_off_to_power_off_delay>{300}));
    is_as_set();
    REQUIRE(r.drive.run(init{})); // the drive holds the same
    is_as_set();
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    CHECK(r.drive.begin(velocity{1901 * r_per_min}) == errc::out_of_range);
    CHECK(r.drive.begin(velocity{-1801 * r_per_min}) == errc::out_of_range);
    CHECK(r.drive.run(velocity{1900 * r_per_min}));
    CHECK(r.drive.run(velocity{-1800 * r_per_min}));
}

} // namespace drive_c630s_settings_tests
