// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The frames of the commands, in the order of the manuals' procedures and of the rules in the `routines.hpp` of each
// device. Each word that a command reads decides: those of registers that it relies on, and what it reads back.
#include <string>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/single_parameters.hpp>
#include <servobus/device/yako/single_parameters.hpp>
#include <servobus/device/zlac8015d/single_parameters.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/watched_drives.hpp>

namespace frames_of_commands_tests {

using namespace servobus;
using namespace servobus::units;
using namespace frames_of_commands;

namespace {

constexpr auto in_any_state = [](auto&) { return true; };

} // namespace

TEST_CASE("the frames of a YAKO's commands, and what each word that they read decides") {
    using namespace servobus::yako;
    namespace cl = closed_loop;
    simulated::driven_yako<watched<sim::yako_closed_loop>, cl::drive> a;
    simulated::driven_yako<watched<sim::yako_open_loop>, open_loop::drive> o;
    a.model.status_bits = motion_status::moving_bit | motion_status::released_bit | motion_status::alarm_bit;
    const auto released = [](auto& r) { return r.drive.run(init{}) && r.drive.run(disable{}); };
    const auto enabled = [](auto& r) { return r.drive.run(init{}) && r.drive.run(enable{}); };
    const motion_profile slow{10 * r_per_min, 90 * millisecond, 80 * millisecond, 60 * r_per_min};
    expect(
        frames_of(a, in_any_state, init{}),
        "0027=0100, 0006: again \" \" \" \" \" \", 0018: unexpected_value \" \", 0011: again, "
        "0006: again \" \" \" \" \" -, 0020: again \" \" \", 0032: again \", 00BA: again \", 00BA=0000 0001, "
        "00BA: unexpected_value \"");
    expect(
        frames_of(o, in_any_state, init{}),
        "0027=0100, 0006: again \" \" \" \" \" \", 0018: unexpected_value \", 0011: again, "
        "0006: again \" \" \" \" \" -, 0020: again \" \" \", 0032: again \", 00BA: again \", 00BA=0000 0001, "
        "00BA: unexpected_value \"");
    expect(frames_of(a, released, enable{}),
           "00BA: needs_init \", 0006: - faulted|busy - \" again \" -, 002D=0012, "
           "0006: - again - \" \" \" \"");
    expect(frames_of(a, enabled, disable{}),
           "0027=0100, 0006: - again - \" again \" -, 002D=0011, 0006: - again - \" \" \" \"");
    expect(frames_of(a, enabled, halt{}), "0027=0100, 0006: - again - \" \" \" \"");
    expect(frames_of(a, enabled, quick_stop{}), "0027=0200, 0006: - again - \" \" \" \"");
    expect(frames_of(a, released, fault_reset{}),
           "00BA: needs_init \", 0006: - busy - \" again \" -, 002D=0021, 0006: - again - \" \" \" \"");
    expect(frames_of(a, enabled, clear_position{}),
           "00BA: needs_init \", 0006: - busy - \" \" \" \", 002D=0031, 0006: - \" \" \" not_executed \" -");
    expect(frames_of(a, released, save{}),
           "0006: - busy - \" needs_init \" -, 00BA: needs_init \", 00BA=0000 0000, "
           "00BA: unexpected_value \", 002D=0042, 0006: - not_executed - \" \" \" \", 00BA=0000 0001, "
           "00BA: unexpected_value \"");
    expect(frames_of(a, enabled, set_profile{slow}),
           "00BA: needs_init \", 0006: - \" \" \" \" \" \", 0020=000A 005A 0050 003C, "
           "0020: unexpected_value \" \" \"");
    expect(
        frames_of(a, enabled, (set_homing_profile{90 * r_per_min, 20 * r_per_min})),
        "00BA: needs_init \", 0006: - \" \" \" \" \" \", 0032=005A 0014 0064, 0032: unexpected_value \" \"");
    expect(frames_of(a, enabled, (set_position_segment{2, 70'000 * pulse, 90 * r_per_min})),
           "00BA: needs_init \", 0006: - faulted - \" \" \" \", 0066=0001 1170 005A 0064 0064 0000, "
           "0066: unexpected_value \" \" \" \" \"");
    expect(frames_of(a, enabled, (set_speed_segment{2, 90 * r_per_min})),
           "00BA: needs_init \", 0006: - faulted - \" \" \" \", 00C3=005A 0064 0064, "
           "00C3: unexpected_value \" \"");
    expect(frames_of(a, enabled, set_pv_trigger{pv_trigger::rising_edge}),
           "00BA: needs_init \", 0006: - faulted - \" \" \" \", 0051=0001, 0051: unexpected_value");
    expect(frames_of(a, released, (set_input{input_terminal::x2, input_function::stop})),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" \" \" \", 0043=0005, "
           "0043: unexpected_value");
    expect(frames_of(a, released, (set_output{output_terminal::y1, output_function::alarm})),
           "00BA: needs_init \", 0006: - \" \" \" \" \" \", 004D=0001, 004D: unexpected_value");
    expect(frames_of(a, enabled, (limit_travel{-70'000 * pulse, 70'000 * pulse})),
           "00BA: needs_init \", 0006: - busy - \" \" \" \", 0037=0001 1170 FFFE EE90, "
           "0037: unexpected_value \" \" \", 0018=0001, 0018: unexpected_value");
    expect(frames_of(a, enabled, unlimit_travel{}),
           "00BA: needs_init \", 0006: - \" \" \" \" \" \", 0018=0000, 0018: unexpected_value");
    expect(frames_of(a, enabled, set_over_travel_stop{over_travel_stop::emergency_stop}),
           "00BA: needs_init \", 0006: - faulted - \" \" \" \", 0017=0001, 0017: unexpected_value");
    expect(frames_of(a, enabled, set_word_order{word_order_setting::high_first}),
           "00BA: needs_init \", 0006: - busy - \" \" \" \", 0019=0000, 0019: unexpected_value");
    expect(frames_of(a, enabled, set_speed_resolution{speed_count::one_r_per_min}),
           "00BA: needs_init \", 0006: - busy - \" \" \" \", 001A=0000, 001A: unexpected_value");
    expect(frames_of(a, released, set_direction{direction::normal}),
           "00BA: needs_init \", 0006: - wrong_state - \" \" \" \", 0010=0000, 0010: unexpected_value");
    expect(frames_of(a, released, set_microsteps{1000}),
           "00BA: needs_init \", 0006: - wrong_state - \" \" \" \", 0011=03E8, 0011: unexpected_value");
    expect(frames_of(a, enabled, (set_current_loop{1, 2, 3, 4})),
           "00BA: needs_init \", 0006: - faulted - \" \" \" \", 010E=0001 0002 0003 0004, "
           "010E: unexpected_value \" \" \"");
    expect(frames_of(a, enabled, set_baud_rate{baud_rate::baud_115200}),
           "00BA: needs_init \", 0006: - faulted|busy - \" \" \" \", 0014=0000, 0014: unexpected_value");
    expect(frames_of(a, enabled, set_serial_format{serial_format::n81}),
           "00BA: needs_init \", 0006: - faulted|busy - \" \" \" \", 0015=0000, 0015: unexpected_value");
    expect(frames_of(a, enabled, (move_by{20 * pulse, slow})),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" again \" -, "
           "0020=000A 005A 0050 003C 0000 0014, 0027=0001, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \"");
    expect(frames_of(a, enabled, (move_by{20 * pulse})),
           "0020: needs_init \" \" \", 00BA: needs_init \", "
           "0006: - faulted|busy|wrong_state - \" again \" -, 0024=0000 0014, 0027=0001, "
           "00BA: needs_init \", 0006: - faulted - \" \" \" \"");
    expect(frames_of(a, enabled, (velocity{30 * r_per_min})),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" again \" -, 001D=001E 0064 0064, "
           "0027=0002, 00BA: needs_init \", 0006: - faulted - \" \" \" \"");
    expect(frames_of(a, enabled, declare_position{0 * pulse}),
           "0032: needs_init \", 00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" \" \" \", "
           "0030=0006 0023, 0035=0000 0000, 00BA: needs_init \", 0027=0010, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \", 0006: - faulted - \" again \" -, 00BA: needs_init \"");
    expect(frames_of(a, enabled, (set_input_move{300 * pulse, slow})),
           "00BA: needs_init \", 0006: - \" \" \" \" \" \", 0020=0000 0000 0000 0000 0000 0000, 0050=0000, "
           "0020=000A 005A 0050 003C 0000 012C");
    expect(frames_of(a, enabled, wait_standstill{}), "0006: - faulted - \" \" \" \", 00BA: needs_init \"");
    expect(frames_of(a, enabled, read_feedback{}), "0006: - \" \" \" \" \" \"");
    const auto placed = [&](auto& r) { return enabled(r) && r.drive.run(declare_position{0 * pulse}); };
    expect(frames_of(a, placed, (move_to{20 * pulse, slow})),
           "00BA: needs_init \", 0006: - needs_init - \" again \" -, 0020=000A 005A 0050 003C 0000 0014, "
           "0027=0005, 00BA: needs_init \", 0006: - needs_init - \" \" \" \"");
    expect(frames_of(a, placed, (move_to{20 * pulse, {}, while_moving::interrupt})),
           "0020: needs_init \" \" \", 00BA: needs_init \", 0006: - needs_init - \" again \" -, "
           "0024=0000 0014, 0027=000D, 00BA: needs_init \", 0006: - needs_init - \" \" \" \"");
    expect(frames_of(a, enabled, (move_by{20 * pulse, slow, while_moving::interrupt})),
           "00BA: needs_init \", 0006: - faulted|wrong_state - \" again \" -, "
           "0020=000A 005A 0050 003C 0000 0014, 0027=0009, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \"");
    expect(frames_of(a, placed, declare_position{70'000 * pulse}),
           "0032: needs_init \", 00BA: needs_init \", 0006: - needs_init - \" \" \" \", 0030=0006 0023, "
           "0035=0001 1170, 00BA: needs_init \", 0027=0010, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \", 0006: - faulted - \" again \" -, 00BA: needs_init \"");
    expect(frames_of(a, released, cl::set_input_polarity{{.x1 = true}}),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" \" \" \", 0040=0002, "
           "0040: unexpected_value");
}

TEST_CASE("the frames of a C630S's commands, and what each word that they read decides") {
    using namespace servobus::c630s;
    servo r;
    r.model.status_bits = status_flags::fault_bit | status_flags::brake_bit | status_flags::ready_bit;
    const auto off = [](auto& d) { return bool{d.drive.run(init{})}; };
    const auto on = [](control_mode m) {
        return [m](auto& d) { return d.drive.run(init{}) && d.drive.run(enable_in{m}); };
    };
    expect(
        frames_of(r, in_any_state, init{}),
        "0603=0000 0000, 3100=0000, 0703=0000, 0C0D=0000, 0C0D: unexpected_value, "
        "0B00: again - \" \", 3100: unexpected_value, 0C19: again unexpected_value, 0200: -, "
        "0607: - \" \", 0709: - \", 0B21: - \", 0209: - \", 0300: again \" - \", 0304: - \" \" \", "
        "0308: - \" \" \", 030C: - \" \" \", 030E: - \" \" \", 051E: again - \" \", 1700: again \" \" \", "
        "1704: again \" \" \", 1708: again \" \" \", 170C: again \" \" \", 1710: again \" \" \", "
        "1714: again \" \" \", 1718: again \" \" \", 171C: again \" \" \", 1721: again \" \" \", "
        "1725: again \" \" \", 1729: again \" \" \", 172D: again \" \" \", 1731: again \" \" \", "
        "1735: again \" \" \", 1739: again \" \" \", 173D: again \" \" \", 0C09: again \" \" -, 0B21=0000, "
        "0C0D: needs_init, 3100=8000, 3100: unexpected_value, 1720: -");
    expect(frames_of(r, off, (ramps{100 * millisecond, 200 * millisecond})),
           "0C0D: needs_init, 0605=0064 00C8, 0605: unexpected_value \"");
    expect(frames_of(r, off, (torque_limits{90 * percent, 80 * percent})),
           "0C0D: needs_init, 0709=0384 0320, 0709: unexpected_value \"");
    expect(frames_of(r, off, (torque_speed_limits{900 * r_per_min, 800 * r_per_min})),
           "0C0D: needs_init, 0713=0384 0320, 0713: unexpected_value \"");
    expect(frames_of(r, off, (top_speeds{3000 * r_per_min, 2000 * r_per_min, 1000 * r_per_min})),
           "0C0D: needs_init, 0607=0BB8 07D0 03E8, 0607: unexpected_value \" \"");
    expect(frames_of(r, off, (segment{2, 70'000 * reference_unit, 600 * r_per_min})),
           "0C0D: needs_init, 0C1A: needs_init, 1103: wrong_state, 1111=1170 0001 0258 000A 000A, "
           "1111: unexpected_value \" \" \" \"");
    expect(frames_of(r, off, position_segments{}),
           "0C0D: needs_init, 3100: needs_init, 1101=0001 0001 0000 0000 0000, "
           "1101: unexpected_value \" \" \" \"");
    expect(frames_of(r, off, (speed_segment{2, 90 * r_per_min, 500 * millisecond})),
           "0C0D: needs_init, 3100: needs_init, 1202: wrong_state, 1217=005A 0005 0000, "
           "1217: unexpected_value \" \"");
    expect(
        frames_of(r, off, (segment_ramp_times{segment_ramp::ramp_2, 100 * millisecond, 200 * millisecond})),
        "0C0D: needs_init, 3100: needs_init, 1205=0064 00C8, 1205: unexpected_value \"");
    expect(frames_of(r, off, step_size{500 * reference_unit}),
           "0C0D: needs_init, 3100: needs_init, 0505=01F4, 0505: unexpected_value");
    expect(frames_of(r, off, (gear{131'072, 10'000})),
           "0C0D: needs_init, 0C1A: needs_init, 0507=0000 0002 2710 0000, "
           "0507: unexpected_value \" \" \"");
    expect(frames_of(r, off, homing_by{homing_mode::forward_z}),
           "0C0D: needs_init, 3100: needs_init, 051F=0002 0064 000A 03E8 2710, "
           "051F: unexpected_value \" \" \" \"");
    expect(frames_of(r, off, set<home_offset>{-70'000}),
           "0C0D: needs_init, 0C1A: needs_init, 0524=EE90 FFFE, 0524: unexpected_value \"");
    expect(frames_of(r, off, set<positioning_completed_threshold>{500}),
           "0C0D: needs_init, 0515=01F4, 0515: unexpected_value");
    expect(frames_of(r, off, keep<home_offset>{-70'000}),
           "0C1A: needs_init, 3100: needs_init, 0B00: busy - \" \", 0C0D=0001, 0C0D: unexpected_value, "
           "0524=EE90 FFFE, 0524: unexpected_value \", 0C0D: unexpected_value, 0C0D=0000, "
           "0C0D: unexpected_value");
    expect(frames_of(r, off, keep<max_speed>{1500}),
           "3100: needs_init, 0B00: busy - \" \", 0C0D=0001, 0C0D: unexpected_value, 0607=05DC, "
           "0607: unexpected_value, 0C0D: unexpected_value, 0C0D=0000, 0C0D: unexpected_value");
    expect(frames_of(r, off, set_home{}),
           "0C0D: needs_init, 3100: needs_init, 0B00: busy - \" \", 051E=0006, 051E=0000, "
           "051E: unexpected_value");
    expect(frames_of(r, off, clear_fault_history{}),
           "0C0D: needs_init, 3100: needs_init, 0B00: busy - \" \", 021F=0002");
    expect(frames_of(r, off, reset_encoder{}),
           "3100: needs_init, 0B00: busy - \" \", 0D14=0002, 0D01=0000, 0D01=0001, 1720: again, "
           "0D01=0000");
    expect(frames_of(r, off, fault_reset{}),
           "0603=0000 0000, 3100: needs_init, 3100=8000, 3100: unexpected_value, 0B00: again - \" \", "
           "1720: -, 3100: needs_init, 0603=0000 0000, 0703=0000, 0D05=0000, 0D01=0000, 0D01=0001, "
           "1720: again, 0D01=0000, 3100: needs_init, 3100=8000");
    expect(frames_of(r, off, enable_in{control_mode::speed}),
           "0C0D: needs_init, 0C1A: needs_init, 3100: needs_init, 0B00: busy - \" \", 1720: faulted, "
           "0603=0000 0000, 0703=0000, 1100=0002, 1100: unexpected_value, 1200=0002, "
           "1200: unexpected_value, 051E=0000, 051E: unexpected_value, 0D05=0000, "
           "0D05: unexpected_value, 0C0A: wrong_state, 0300: wrong_state, 0200=0000, "
           "0200: unexpected_value, 0600=0000, 0600: unexpected_value, 0602=0000, "
           "0602: unexpected_value, 1720: wrong_state, 0603: unexpected_value \", "
           "0703: unexpected_value, 3100: needs_init, 3100=8001, 3100: needs_init, "
           "0603: needs_init \", 0703: needs_init, 0C0D: needs_init, 0200: needs_init, 1720: again, "
           "1720: faulted|needs_init");
    expect(frames_of(r, off, enable_in{control_mode::torque}),
           "0C0D: needs_init, 0C1A: needs_init, 3100: needs_init, 0B00: busy - \" \", 1720: faulted, "
           "0603=0000 0000, 0703=0000, 1100=0002, 1100: unexpected_value, 1200=0002, "
           "1200: unexpected_value, 051E=0000, 051E: unexpected_value, 0D05=0000, "
           "0D05: unexpected_value, 0C0A: wrong_state, 0300: wrong_state, 0200=0002, "
           "0200: unexpected_value, 0700=0000, 0700: unexpected_value, 0702=0000, "
           "0702: unexpected_value, 1720: wrong_state, 0603: unexpected_value \", "
           "0703: unexpected_value, 3100: needs_init, 3100=8001, 3100: needs_init, "
           "0603: needs_init \", 0703: needs_init, 0C0D: needs_init, 0200: needs_init, 1720: again, "
           "1720: faulted|needs_init");
    expect(frames_of(r, off, enable_in{control_mode::position}),
           "0C0D: needs_init, 0C1A: needs_init, 3100: needs_init, 0B00: busy - \" \", 1720: faulted, "
           "0603=0000 0000, 0703=0000, 1100=0002, 1100: unexpected_value, 1200=0002, "
           "1200: unexpected_value, 051E=0000, 051E: unexpected_value, 0D05=0000, "
           "0D05: unexpected_value, 0C0A: wrong_state, 0300: wrong_state, 0200=0001, "
           "0200: unexpected_value, 0500=0002, 0500: unexpected_value, 0514=0002, "
           "0514: unexpected_value, 1104: -, 1720: wrong_state, 0603: unexpected_value \", "
           "0703: unexpected_value, 3100: needs_init, 3100=8001, 3100: needs_init, "
           "0603: needs_init \", 0703: needs_init, 0C0D: needs_init, 0200: needs_init, 1720: again, "
           "1720: faulted|needs_init");
    expect(frames_of(r, off, run_speed_segments{}),
           "0C0D: needs_init, 0C1A: needs_init, 3100: needs_init, 0B00: busy - \" \", 1720: faulted, "
           "0603=0000 0000, 0703=0000, 1100=0002, 1100: unexpected_value, 1200=0002, "
           "1200: unexpected_value, 051E=0000, 051E: unexpected_value, 0D05=0000, "
           "0D05: unexpected_value, 0C0A: wrong_state, 0300: wrong_state, 0200=0000, "
           "0200: unexpected_value, 0601=0005, 0601: unexpected_value, 0602=0001, "
           "0602: unexpected_value, 1201=0010, 1201: unexpected_value, 1720: wrong_state, "
           "0603: unexpected_value \", 0703: unexpected_value, 3100: needs_init, 3100=8001, "
           "3100: needs_init, 0603: needs_init \", 0703: needs_init, 0C0D: needs_init, "
           "0200: needs_init, 1720: again, 1720: faulted|needs_init");
    expect(frames_of(r, on(control_mode::speed), disable{}),
           "0603=0000 0000, 3100: again, 3100=8000, 3100: again, 0B00: again - \" \", 1720: -");
    expect(frames_of(r, on(control_mode::torque), disable{}),
           "0703=0000, 3100: again, 3100=8000, 3100: again, 0B00: again - \" \", 1720: -");
    expect(frames_of(r, on(control_mode::position), disable{}),
           "0D05=0001, 3100: again, 3100=8000, 3100: again, 0B00: again - \" \", 1720: -");
    expect(frames_of(r, on(control_mode::speed), halt{}),
           "0603=0000 0000, 0603: again \", 0B00: again - \" \"");
    expect(frames_of(r, on(control_mode::torque), halt{}), "0703=0000, 0703: again, 0B00: again - \" \"");
    expect(frames_of(r, on(control_mode::speed), quick_stop{}),
           "0D05=0001, 0603=0000 0000, 0703=0000, 0B00: again - \" \"");
    expect(frames_of(r, on(control_mode::speed), velocity{30 * r_per_min}),
           "1720: faulted|needs_init, 0603=001E");
    expect(frames_of(r, on(control_mode::torque), c630s::torque{5 * percent}),
           "1720: faulted|needs_init, 0703=0032");
    expect(frames_of(r, on(control_mode::speed), jog{30 * r_per_min}),
           "0C0D: needs_init, 1720: faulted|needs_init, 0B00: busy - \" \", 0604=001E, "
           "0604: unexpected_value, 3100: needs_init, 3100=8201, 3100: needs_init, 0604: needs_init, "
           "0C0D: needs_init");
    expect(frames_of(r, on(control_mode::position), start_segment{1}),
           "0C0D: needs_init, 1720: faulted|needs_init, 0B00: busy - \" \", 0B07: - \", 0B35: - \" \" \", "
           "110C: - \", 0B21: - \", 1720: faulted|needs_init, 3100: needs_init, 3100=8001, "
           "3100: needs_init, 3100=8041, 3100: needs_init, 3100=8001, 0500: needs_init, "
           "0C0D: needs_init");
    expect(frames_of(r, off, keep<pulses_per_revolution>{10'000}),
           "0C1A: needs_init, 3100: needs_init, 0B00: busy - \" \", 0B21=0009, 0C0D=0001, "
           "0C0D: unexpected_value, 0502=2710 0000, 0502: unexpected_value \", 0C0D: unexpected_value, "
           "0C0D=0000, 0C0D: unexpected_value");
    expect(frames_of(r, off, c630s::restart{}), "3100: needs_init, 0B00: busy - \" \", 0D00=0001");
    expect(frames_of(
               r,
               [](auto& d) {
                   return d.drive.run(init{}) &&
                          d.drive.run(enable_in{control_mode::position, position_source::step});
               },
               make_step{}),
           "0C0D: needs_init, 1720: faulted|needs_init, 0B00: busy - \" \", 0B07: - \", 0B35: - \" \" \", "
           "0505: -, 0B21: - \", 1720: faulted|needs_init, 3100: needs_init, 3100=8001, "
           "3100: needs_init, 3100=8081, 3100: needs_init, 3100=8001, 0500: needs_init, "
           "0C0D: needs_init");
    expect(frames_of(r, on(control_mode::speed), wait_standstill{}), "0B00: again - \" \", 3100: needs_init");
    const auto jogging = [&](auto& d) {
        return on(control_mode::speed)(d) && d.drive.run(jog{30 * r_per_min});
    };
    expect(frames_of(r, jogging, halt{}),
           "0603=0000 0000, 0603: again \", 3100: again, 3100=8001, 3100: again, 0603: again \", "
           "0B00: again - \" \", 0C0D: again");
    const auto running = [](auto& d) { return d.drive.run(init{}) && d.drive.run(run_speed_segments{}); };
    expect(frames_of(r, running, select_speed_segment{2}),
           "0C0D: needs_init, 1720: faulted|needs_init, 3100: needs_init, 3100=8005, "
           "3100: needs_init, 0602: needs_init, 0C0D: needs_init");
    expect(frames_of(r, running, quick_stop{}),
           "0D05=0001, 0B00: again - \" \", 3100: again, 3100=8000, 3100: again, 1720: -");
    expect(frames_of(r, off, read_wide_position{wide_position::mechanical}),
           "0C1A: needs_init, 0B3A: - \" \" \"");
    expect(frames_of(r, off, read_wide_position{wide_position::encoder}),
           "0C1A: needs_init, 0B4D: - \" \" \"");
    expect(frames_of(r, off, read_fault{1}),
           "0C1A: needs_init, 0B21=0001, 0B21: unexpected_value -, 0B22: - \" \" \" \" \" \" \" \", "
           "0B21=0000");
    expect(frames_of(r, off, read_feedback{}),
           "0B00: - \" \" \", 0B35: - \" \" \", 0B21: - \", 0B07: - \", 1720: -");
}

TEST_CASE("the frames of a ZLAC8015D's commands, and what each word that they read decides") {
    using namespace servobus::zlac8015d;
    dual_servo r;
    const auto off = [](auto& d) { return bool{d.drive.run(init{})}; };
    const auto in = [](operating_mode m, synchronisation s) {
        return [=](auto& d) { return d.drive.run(init{}) && d.drive.run(enable_in{checked(m), s}); };
    };
    using enum synchronisation;
    expect(frames_of(r, in_any_state, init{}),
           "2088=0000 0000, 200E=0007, 2090=0000 0000, 20A2: again - \" \" \" \" \" \" \" again \", 2000: -, "
           "2008: -, 2022: unexpected_value");
    expect(frames_of(r, off, enable{}),
           "20A2: busy - \" faulted \" - \" \" \" busy \", 2088=0000 0000, 2088: unexpected_value \", "
           "2090=0000 0000, 2090: unexpected_value \", 200D=0003, 200D: unexpected_value, "
           "2022: needs_init, 2000: needs_init, 200E=0008, 20A2: again - \" \" \" \" \" \" \" \" \", "
           "200D: needs_init");
    expect(frames_of(r, off, enable_in{operating_mode::torque}),
           "20A2: busy - \" faulted \" - \" \" \" busy \", 2088=0000 0000, 2088: unexpected_value \", "
           "2090=0000 0000, 2090: unexpected_value \", 200D=0004, 200D: unexpected_value, "
           "2022: needs_init, 2000: needs_init, 200E=0008, 20A2: again - \" \" \" \" \" \" \" \" \", "
           "200D: needs_init");
    expect(frames_of(r, off, enable_in{operating_mode::relative_position}),
           "20A2: busy - \" faulted \" - \" \" \" busy \", 2088=0000 0000, 2088: unexpected_value \", "
           "2090=0000 0000, 2090: unexpected_value \", 208A=0000 0000 0000 0000, "
           "208A: unexpected_value \" \" \", 200D=0001, 200D: unexpected_value, 200F=0001, "
           "200F: unexpected_value, 2022: needs_init, 2000: needs_init, 200E=0008, "
           "20A2: again - \" \" \" \" \" \" \" \" \", 200D: needs_init");
    expect(frames_of(r, off, (enable_in{operating_mode::absolute_position, asynchronous})),
           "20A2: busy - \" faulted \" - \" \" \" busy \", 2088=0000 0000, 2088: unexpected_value \", "
           "2090=0000 0000, 2090: unexpected_value \", 200D=0002, 200D: unexpected_value, 200F=0000, "
           "200F: unexpected_value, 2022: needs_init, 2000: needs_init, 200E=0008, "
           "20A2: again - \" \" \" \" \" \" \" \" \", 200D: needs_init");
    expect(frames_of(r, in(operating_mode::velocity, synchronous), disable{}),
           "200E=0007, 20A2: again - \" \" \" \" \" \" \" again \"");
    expect(frames_of(r, in(operating_mode::velocity, synchronous), halt{}),
           "2088=0000 0000, 2088: again \", 20A2: again - \" again \" - \" \" \" again \"");
    expect(frames_of(r, in(operating_mode::torque, synchronous), halt{}),
           "2090=0000 0000, 2090: again \", 20A2: again - \" again \" - \" \" \" again \"");
    expect(frames_of(r, in(operating_mode::velocity, synchronous), quick_stop{}),
           "200E=0005, 20A2: again - \" \" \" \" \" \" \" again \"");
    expect(frames_of(r, off, fault_reset{}), "20A2: busy - \" \" \" \" \" \" \" \" \", 200E=0007, 200E=0006, "
                                             "20A2: - \" \" again \" - \" \" \" \" \"");
    expect(
        frames_of(r, in(operating_mode::relative_position, synchronous), (move_by{40 * pulse, -50 * pulse})),
        "200D: needs_init, 20A2: busy - \" faulted \" - \" \" \" \" \", 208A=0000 0028 FFFF FFCE, "
        "200E=0010, 200D: needs_init");
    expect(frames_of(r, in(operating_mode::relative_position, asynchronous), move_left_by{40 * pulse}),
           "200D: needs_init, 20A2: busy - \" faulted \" - \" \" \" \" \", 208A=0000 0028, 200E=0011, "
           "200D: needs_init");
    expect(frames_of(r, in(operating_mode::relative_position, asynchronous), move_right_by{40 * pulse}),
           "200D: needs_init, 20A2: busy - \" faulted \" - \" \" \" \" \", 208C=0000 0028, 200E=0012, "
           "200D: needs_init");
    expect(
        frames_of(r, off, save{}),
        "20A2: busy - \" \" \" \" \" \" \" busy \", 200D=0000, 200D: unexpected_value, 2010=0001, 2010=0000");
    expect(frames_of(r, off, zlac8015d::watchdog{800 * millisecond}), "2000=0320, 2000: unexpected_value");
    const auto off_with_1_r_per_min = [](auto& d) {
        for (int i = 0; i < 2; ++i) { // one that has failed in the middle sets its mark once more
            d.model.store(0x2022, 1);
            d.model.power_cycle();
            if (!d.drive.run(init{})) return false;
        }
        return d.drive.state() == drive_state::disabled;
    };
    expect(
        frames_of(r, off_with_1_r_per_min, resolution{10}),
        "20A2: busy - \" \" \" \" \" \" \" busy \", 2022=000A, 2022: unexpected_value, 200D=0000, "
        "200D: unexpected_value, 2010=0001, 2010=0000, 200D=0003, 200D: unexpected_value, 2022: needs_init");
    REQUIRE(off_with_1_r_per_min(r));
    expect(frames_of(r, off, clear_position{}), "20A2: busy - \" \" \" \" \" \" \" \" \", 2005=0003 0003");
    expect(
        frames_of(r, off, (current_limits{3000 * milliampere, 4000 * milliampere})),
        "20A2: busy - \" \" \" \" \" \" \" \" \", 2033=001E 0028, 2033: unexpected_value \", 2063=001E 0028, "
        "2063: unexpected_value \"");
    expect(frames_of(r, off, (ramps{100 * millisecond, 200 * millisecond})), "2080=0064 0064 00C8 00C8");
    expect(frames_of(r, off, quick_stop_ramp{50 * millisecond}), "2084=0032 0032");
    expect(frames_of(r, in(operating_mode::velocity, synchronous), wait_standstill{}),
           "20A2: again - \" faulted \" - \" \" \" again \", 200D: needs_init");
    expect(frames_of(r, off, read_feedback{}), "20A2: - \" \" \" \" \" \" \" \" \" \"");
    expect(frames_of(r, off, set<max_motor_speed>{300}),
           "20A2: busy - \" \" \" \" \" \" \" \" \", 2008=012C, 2008: unexpected_value");
}

} // namespace frames_of_commands_tests
