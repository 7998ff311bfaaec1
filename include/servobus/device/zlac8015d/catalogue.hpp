// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D dual hub servo: its registers with their names. Tools and tests include it; programs on a
// target do not. Source: the rows of zlac8015d/registers.hpp.
//
//     inline void print_map() {
//         for (const entry& e : zlac8015d::catalogue.entries)
//             std::printf("%04Xh %s\n", unsigned{e.address}, static_cast<const char*>(e.name));
//     }
#pragma once

#include <servobus/device/zlac8015d/descriptions.hpp>
#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/registers/catalogue.hpp>

namespace servobus::zlac8015d {

namespace names {
// clang-format off
inline constexpr named_value baud_rate_names[] = {
    code(1, "128000 Bd"), code(2, "115200 Bd"), code(3, "57600 Bd"), code(4, "38400 Bd"),
    code(5, "19200 Bd"), code(6, "9600 Bd"),
};
inline constexpr named_value can_baud_rate_names[] = {
    code(0, "1000 kbit/s"), code(1, "500 kbit/s"), code(2, "250 kbit/s"), code(3, "125 kbit/s"),
    code(4, "100 kbit/s"),
};
inline constexpr named_value wheels_names[] = {
    code(0, "none"), code(1, "left"), code(2, "right"), code(3, "both"),
};
inline constexpr named_value power_on_shaft_names[] = {
    code(0, "unlocked"), code(1, "locked"),
};
inline constexpr named_value parameter_reset_names[] = {
    code(0, "none"), code(1, "factory defaults"),
};
inline constexpr named_value off_on_names[] = {
    code(0, "off"), code(1, "on"),
};
inline constexpr named_value operating_mode_names[] = {
    code(0, "undefined"), code(1, "relative position"), code(2, "absolute position"), code(3, "velocity"),
    code(4, "torque"),
};
inline constexpr named_value command_names[] = {
    code(0x00, "undefined"), code(0x05, "quick stop"), code(0x06, "fault reset"), code(0x07, "stop"),
    code(0x08, "enable"), code(0x10, "start both"), code(0x11, "start left"), code(0x12, "start right"),
};
inline constexpr named_value synchronisation_names[] = {
    code(0, "asynchronous"), code(1, "synchronous"),
};
inline constexpr named_value parameter_save_names[] = {
    code(0, "none"), code(1, "save all"),
};
inline constexpr named_value quick_stop_option_names[] = {
    code(5, "deceleration"), code(6, "fast deceleration"), code(7, "immediate"),
};
inline constexpr named_value stop_option_names[] = {
    code(0, "none"), code(1, "deceleration"),
};
inline constexpr named_value halt_option_names[] = {
    code(1, "deceleration"), code(2, "fast deceleration"), code(3, "immediate"),
};
inline constexpr named_value input_function_names[] = {
    code(0, "undefined"), code(9, "emergency stop"),
};
inline constexpr named_value brake_names[] = {
    code(0, "code 0"), code(1, "code 1"),
};
inline constexpr named_value output_function_names[] = {
    code(0, "undefined"), code(1, "alarm"), code(2, "driver status"), code(3, "in position"),
};
inline constexpr named_value input_stop_action_names[] = {
    code(0, "lock shaft"), code(1, "free shaft"),
};
inline constexpr named_value fault_names[] = {
    code(0, "none"),
    named_bit(0x0001, "overvoltage"), named_bit(0x0002, "undervoltage"), named_bit(0x0004, "overcurrent"),
    named_bit(0x0008, "overload"), named_bit(0x0010, "current deviation"), named_bit(0x0020, "following error"),
    named_bit(0x0040, "speed deviation"), named_bit(0x0080, "reference voltage"), named_bit(0x0100, "eeprom"),
    named_bit(0x0200, "hall"), named_bit(0x0400, "motor overtemperature"), named_bit(0x0800, "encoder"),
    named_bit(0x2000, "speed command"),
};
inline constexpr named_value inputs_names[] = {
    named_bit(1, "x0"), named_bit(2, "x1"),
};
inline constexpr named_value outputs_names[] = {
    named_bit(1, "y0"), named_bit(2, "y1"),
};
inline constexpr named_value output_polarity_names[] = {
    named_bit(1, "y0"), named_bit(2, "y1"), named_bit(4, "b0"), named_bit(8, "b1"),
};
inline constexpr named_value status_names[] = {
    field(0xC000, 0x0000, "left released"), field(0xC000, 0x4000, "left locked"),
    field(0xC000, 0x8000, "left emergency stop"), field(0xC000, 0xC000, "left alarm"), named_bit(0x0100, "left running"),
    field(0x00C0, 0x0000, "right released"), field(0x00C0, 0x0040, "right locked"),
    field(0x00C0, 0x0080, "right emergency stop"), field(0x00C0, 0x00C0, "right alarm"), named_bit(0x0001, "right running"),
};

inline constexpr entry entries[] = {
    list("host_timeout", zlac8015d::host_timeout),
    list("node_address", zlac8015d::node_address),
    list("rs485_baud_rate", zlac8015d::rs485_baud_rate, naming::names, baud_rate_names),
    list("input_state", zlac8015d::input_state, naming::names, inputs_names),
    list("output_state", zlac8015d::output_state, naming::names, outputs_names),
    list("clear_feedback_position", zlac8015d::clear_feedback_position, naming::names, wheels_names),
    list("clear_absolute_position", zlac8015d::clear_absolute_position, naming::names, wheels_names),
    list("shaft_at_power_on", zlac8015d::shaft_at_power_on, naming::names, power_on_shaft_names),
    list("max_motor_speed", zlac8015d::max_motor_speed),
    list("restore_parameters", zlac8015d::restore_parameters, naming::names, parameter_reset_names),
    list("can_node_address", zlac8015d::can_node_address),
    list("can_baud", zlac8015d::can_baud, naming::names, can_baud_rate_names),
    list("parking_mode", zlac8015d::parking_mode, naming::names, off_on_names),
    list("mode_of_operation", zlac8015d::mode_of_operation, naming::names, operating_mode_names),
    list("control_word", zlac8015d::control_word, naming::names, command_names),
    list("position_synchronisation", zlac8015d::position_synchronisation, naming::names, synchronisation_names),
    list("save_parameters", zlac8015d::save_parameters, naming::names, parameter_save_names),
    list("quick_stop_option_code", zlac8015d::quick_stop_option_code, naming::names, quick_stop_option_names),
    list("shutdown_option_code", zlac8015d::shutdown_option_code, naming::names, stop_option_names),
    list("disable_option_code", zlac8015d::disable_option_code, naming::names, stop_option_names),
    list("halt_option_code", zlac8015d::halt_option_code, naming::names, halt_option_names),
    list("input_polarity", zlac8015d::input_polarity, naming::names, inputs_names),
    list("x0_function", zlac8015d::x0_function, naming::names, input_function_names),
    list("x1_function", zlac8015d::x1_function, naming::names, input_function_names),
    list("output_polarities", zlac8015d::output_polarities, naming::names, output_polarity_names),
    list("left_brake", zlac8015d::left_brake, naming::names, brake_names),
    list("right_brake", zlac8015d::right_brake, naming::names, brake_names),
    list("y0_function", zlac8015d::y0_function, naming::names, output_function_names),
    list("y1_function", zlac8015d::y1_function, naming::names, output_function_names),
    list("driver_temperature_limit", zlac8015d::driver_temperature_limit),
    list("pwm_on_alarm", zlac8015d::pwm_on_alarm, naming::names, off_on_names),
    list("overload_handling", zlac8015d::overload_handling, naming::names, off_on_names),
    list("input_stop", zlac8015d::input_stop, naming::names, input_stop_action_names),
    list("speed_resolution", zlac8015d::speed_resolution),
    list("speed_deviation_monitoring", zlac8015d::speed_deviation_monitoring, naming::names, off_on_names),
    list("left_encoder_lines", zlac8015d::left_encoder_lines),
    list("left_hall_offset_angle", zlac8015d::left_hall_offset_angle),
    list("left_overload_factor", zlac8015d::left_overload_factor),
    list("left_rated_current", zlac8015d::left_rated_current),
    list("left_max_current", zlac8015d::left_max_current),
    list("left_overload_time", zlac8015d::left_overload_time),
    list("left_following_error_limit", zlac8015d::left_following_error_limit),
    list("left_speed_smoothing", zlac8015d::left_speed_smoothing),
    list("left_current_loop_kp", zlac8015d::left_current_loop_kp),
    list("left_current_loop_ki", zlac8015d::left_current_loop_ki),
    list("left_feedforward_smoothing", zlac8015d::left_feedforward_smoothing),
    list("left_torque_smoothing", zlac8015d::left_torque_smoothing),
    list("left_speed_kp", zlac8015d::left_speed_kp),
    list("left_speed_ki", zlac8015d::left_speed_ki),
    list("left_speed_kf", zlac8015d::left_speed_kf),
    list("left_position_kp", zlac8015d::left_position_kp),
    list("left_position_kf", zlac8015d::left_position_kf),
    list("left_start_speed", zlac8015d::left_start_speed),
    list("left_position_start_speed", zlac8015d::left_position_start_speed),
    list("left_pole_pairs", zlac8015d::left_pole_pairs),
    list("left_motor_temperature_limit", zlac8015d::left_motor_temperature_limit),
    list("left_speed_observer_1", zlac8015d::left_speed_observer_1),
    list("left_speed_observer_2", zlac8015d::left_speed_observer_2),
    list("left_speed_observer_3", zlac8015d::left_speed_observer_3),
    list("left_speed_observer_4", zlac8015d::left_speed_observer_4),
    list("right_encoder_lines", zlac8015d::right_encoder_lines),
    list("right_hall_offset_angle", zlac8015d::right_hall_offset_angle),
    list("right_overload_factor", zlac8015d::right_overload_factor),
    list("right_rated_current", zlac8015d::right_rated_current),
    list("right_max_current", zlac8015d::right_max_current),
    list("right_overload_time", zlac8015d::right_overload_time),
    list("right_following_error_limit", zlac8015d::right_following_error_limit),
    list("right_speed_smoothing", zlac8015d::right_speed_smoothing),
    list("right_current_loop_kp", zlac8015d::right_current_loop_kp),
    list("right_current_loop_ki", zlac8015d::right_current_loop_ki),
    list("right_feedforward_smoothing", zlac8015d::right_feedforward_smoothing),
    list("right_torque_smoothing", zlac8015d::right_torque_smoothing),
    list("right_speed_kp", zlac8015d::right_speed_kp),
    list("right_speed_ki", zlac8015d::right_speed_ki),
    list("right_speed_kf", zlac8015d::right_speed_kf),
    list("right_position_kp", zlac8015d::right_position_kp),
    list("right_position_kf", zlac8015d::right_position_kf),
    list("right_start_speed", zlac8015d::right_start_speed),
    list("right_position_start_speed", zlac8015d::right_position_start_speed),
    list("right_pole_pairs", zlac8015d::right_pole_pairs),
    list("right_motor_temperature_limit", zlac8015d::right_motor_temperature_limit),
    list("right_speed_observer_1", zlac8015d::right_speed_observer_1),
    list("right_speed_observer_2", zlac8015d::right_speed_observer_2),
    list("right_speed_observer_3", zlac8015d::right_speed_observer_3),
    list("right_speed_observer_4", zlac8015d::right_speed_observer_4),
    list("left_acceleration_time", zlac8015d::left_acceleration_time),
    list("right_acceleration_time", zlac8015d::right_acceleration_time),
    list("left_deceleration_time", zlac8015d::left_deceleration_time),
    list("right_deceleration_time", zlac8015d::right_deceleration_time),
    list("left_quick_stop_time", zlac8015d::left_quick_stop_time),
    list("right_quick_stop_time", zlac8015d::right_quick_stop_time),
    list("left_torque_slope", zlac8015d::left_torque_slope),
    list("right_torque_slope", zlac8015d::right_torque_slope),
    list("left_target_speed", zlac8015d::left_target_speed),
    list("right_target_speed", zlac8015d::right_target_speed),
    list("left_target_position", zlac8015d::left_target_position),
    list("right_target_position", zlac8015d::right_target_position),
    list("left_max_speed", zlac8015d::left_max_speed),
    list("right_max_speed", zlac8015d::right_max_speed),
    list("left_target_torque", zlac8015d::left_target_torque),
    list("right_target_torque", zlac8015d::right_target_torque),
    list("software_version", zlac8015d::software_version),
    list("bus_voltage", zlac8015d::bus_voltage),
    list("status_word", zlac8015d::status_word, naming::names, status_names),
    list("hall_state", zlac8015d::hall_state, naming::halves),
    list("motor_temperature", zlac8015d::motor_temperature, naming::halves),
    list("left_faults", zlac8015d::left_faults, naming::names, fault_names),
    list("right_faults", zlac8015d::right_faults, naming::names, fault_names),
    list("left_actual_position", zlac8015d::left_actual_position),
    list("right_actual_position", zlac8015d::right_actual_position),
    list("left_actual_speed", zlac8015d::left_actual_speed),
    list("right_actual_speed", zlac8015d::right_actual_speed),
    list("left_actual_torque", zlac8015d::left_actual_torque),
    list("right_actual_torque", zlac8015d::right_actual_torque),
    list("host_connected", zlac8015d::host_connected),
    list("driver_temperature", zlac8015d::driver_temperature),
};
// clang-format on
} // namespace names

static_assert(is_in_order(names::entries));
static_assert(is_described(names::entries, descriptions));

/// All 116 registers.
inline constexpr servobus::catalogue catalogue{&device::facts, names::entries, descriptions};

} // namespace servobus::zlac8015d
