// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the registers of yako/common.hpp with their names, and the names of values. The catalogues of
// closed loop and open loop include it; programs on a target do not.
//
//     for (const named_value& choice : yako::names::input_function_names) // what x0_function may be set to
//         std::printf("%2d %s\n", choice.value, choice.name);
#pragma once

#include <servobus/device/yako/common.hpp>
#include <servobus/registers/catalogue.hpp>

namespace servobus::yako::names {

// clang-format off
inline constexpr named_value switches_names[] = {
    named_bit(0x01, "sw1"), named_bit(0x02, "sw2"), named_bit(0x04, "sw3"), named_bit(0x08, "sw4"), named_bit(0x10, "sw5"), named_bit(0x20, "sw6"),
    named_bit(0x40, "sw7"),
};
inline constexpr named_value error_names[] = { // the manual does not state what 1..5 mean [errata A36]
    code(0, "none"), code(1, "error 1"), code(2, "error 2"), code(3, "error 3"), code(4, "error 4"),
    code(5, "error 5"),
};
inline constexpr named_value motion_status_names[] = {
    field(0x0010, 0x0000, "enabled"), field(0x0010, 0x0010, "released"),
    named_bit(0x0001, "in position"), named_bit(0x0002, "homed"), named_bit(0x0004, "moving"), named_bit(0x0008, "alarm"),
    named_bit(0x0020, "positive limit"), named_bit(0x0040, "negative limit"),
};
inline constexpr named_value direction_names[] = {
    code(0, "normal"), code(1, "reversed"),
};
inline constexpr named_value baud_rate_names[] = {
    code(0, "115200 Bd"), code(1, "38400 Bd"), code(2, "19200 Bd"), code(3, "9600 Bd"),
};
inline constexpr named_value serial_format_names[] = {
    code(0, "8N1"), code(1, "8N2"), code(2, "8E1"), code(3, "8O1"),
};
inline constexpr named_value over_travel_stop_names[] = {
    code(0, "coast"), code(1, "emergency stop"),
};
inline constexpr named_value limit_enable_names[] = {
    code(0, "disabled"), code(1, "after homing"),
};
inline constexpr named_value word_order_setting_names[] = {
    code(0, "high first"), code(1, "low first"),
};
inline constexpr named_value command_names[] = {
    code(0, "none"),
    named_bit(0x0001, "start position"), named_bit(0x0002, "start speed"), named_bit(0x0004, "absolute"), named_bit(0x0008, "interrupt"),
    named_bit(0x0010, "start homing"), named_bit(0x0100, "stop"), named_bit(0x0200, "emergency stop"),
};
inline constexpr named_value auxiliary_names[] = {
    code(0x0000, "none"), code(0x0011, "release"), code(0x0012, "enable"), code(0x0021, "clear alarm"),
    code(0x0031, "clear position"), code(0x0041, "restore parameters"), code(0x0042, "save parameters"),
};
inline constexpr named_value offset_handling_names[] = {
    code(0, "move position offset"), code(1, "move position zero"), code(2, "move position negative offset"),
    code(3, "move position actual"), code(4, "move position actual plus offset"),
    code(5, "move position actual minus offset"), code(6, "stay position offset"), code(7, "stay position zero"),
    code(8, "stay position negative offset"), code(9, "stay position actual"),
    code(10, "stay position actual plus offset"), code(11, "stay position actual minus offset"),
};
inline constexpr named_value input_function_names[] = {
    code(0, "undefined"), code(1, "home"), code(2, "positive limit"), code(3, "negative limit"),
    code(4, "motor free"), code(5, "stop"), code(6, "emergency stop"), code(7, "position move"),
    code(8, "speed move"), code(9, "jog positive"), code(10, "jog negative"), code(11, "homing"),
    code(12, "pt trigger"), code(13, "pv trigger"), code(14, "pin0"), code(15, "pin1"), code(16, "pin2"),
    code(17, "pin3"), code(18, "speed segment direction"),
};
inline constexpr named_value output_function_names[] = {
    code(0, "undefined"), code(1, "alarm"), code(2, "driver status"), code(3, "homing complete"),
    code(4, "in position"), code(5, "brake"), code(9, "user 0"), code(10, "user 1"), code(11, "user 2"),
};
inline constexpr named_value positioning_names[] = {
    code(0, "relative"), code(1, "absolute"),
};
inline constexpr named_value pv_trigger_names[] = {
    code(0, "level"), code(1, "rising edge"),
};

/// The registers of common.hpp. The catalogue of a variant merges its own registers into them.
inline constexpr auto family = in_address_order(
    list("drive_model", yako::drive_model),
    list("drive_version", yako::drive_version),
    list("actual_node_address", yako::actual_node_address),
    list("dip_switches", yako::dip_switches, naming::names, switches_names),
    list("error_code", yako::error_code, naming::names, error_names),
    list("status_word", yako::status_word, naming::names, motion_status_names),
    list("actual_position", yako::actual_position),
    list("motion_direction", yako::motion_direction, naming::names, direction_names),
    list("microstep_resolution", yako::microstep_resolution),
    list("node_address", yako::node_address),
    list("rs485_baud_rate", yako::rs485_baud_rate, naming::names, baud_rate_names),
    list("rs485_format", yako::rs485_format, naming::names, serial_format_names),
    list("over_travel_stop_mode", yako::over_travel_stop_mode, naming::names, over_travel_stop_names),
    list("software_limits", yako::software_limits, naming::names, limit_enable_names),
    list("pair_word_order", yako::pair_word_order, naming::names, word_order_setting_names),
    list("jog_acceleration_time", yako::jog_acceleration_time),
    list("jog_deceleration_time", yako::jog_deceleration_time),
    list("acceleration_time", yako::acceleration_time),
    list("deceleration_time", yako::deceleration_time),
    list("target_position", yako::target_position),
    list("motion_command", yako::motion_command, naming::names, command_names),
    list("auxiliary_command", yako::auxiliary_command, naming::names, auxiliary_names),
    list("homing_offset_mode", yako::homing_offset_mode, naming::names, offset_handling_names),
    list("homing_ramp_time", yako::homing_ramp_time),
    list("home_offset", yako::home_offset),
    list("positive_software_limit", yako::positive_software_limit),
    list("negative_software_limit", yako::negative_software_limit),
    list("x0_function", yako::x0_function, naming::names, input_function_names),
    list("x1_function", yako::x1_function, naming::names, input_function_names),
    list("x2_function", yako::x2_function, naming::names, input_function_names),
    list("x3_function", yako::x3_function, naming::names, input_function_names),
    list("y0_function", yako::y0_function, naming::names, output_function_names),
    list("y1_function", yako::y1_function, naming::names, output_function_names),
    list("io_positioning", yako::io_positioning, naming::names, positioning_names),
    list("pv_trigger_mode", yako::pv_trigger_mode, naming::names, pv_trigger_names),
    list("position_segment_", yako::position_segment_targets, "_target"),
    list("position_segment_", yako::position_segment_positionings, "_positioning", naming::names, positioning_names),
    list("base_current", yako::base_current),
    list("open_loop_max_current", yako::open_loop_max_current),
    list("io_filter_factor", yako::io_filter_factor),
    list("pulse_low_pass_factor", yako::pulse_low_pass_factor),
    list("in_position_time", yako::in_position_time),
    list("pulse_averaging_factor", yako::pulse_averaging_factor),
    list("current_loop_kp_multiplier", yako::current_loop_kp_multiplier),
    list("current_loop_kp", yako::current_loop_kp),
    list("current_loop_ki", yako::current_loop_ki),
    list("current_loop_kc", yako::current_loop_kc));
// clang-format on

} // namespace servobus::yako::names
