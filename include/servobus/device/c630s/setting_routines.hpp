// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the routines that set it up, read what it reports and restore its factory settings, as
// tables of steps; those that operate it are in routines.hpp. c630s/prepared_command.hpp includes it; programs
// include it to count the requests of a command. Source: manual V24.111, chapters 5 to 9.
//
//     constexpr std::size_t requests_of_a_read = routine{c630s::routines::feedback}.size();
//     static_assert(requests_of_a_read == 5 && routine{c630s::routines::ramps}.size() == 3);
#pragma once

#include <cstdint>

#include <servobus/device/c630s/routines.hpp>

namespace servobus::c630s::routines {

// clang-format off

// Parameters that are set again and again are not kept: each routine reads P0C-13 first.

inline constexpr step ramps[] = {
    wears_nothing, steps::write_arguments<acceleration_time, deceleration_time>(),
    steps::expect_arguments<acceleration_time, deceleration_time>()};
inline constexpr step torque_limits[] = {
    wears_nothing, steps::write_arguments<positive_internal_torque_limit, negative_internal_torque_limit>(),
    steps::expect_arguments<positive_internal_torque_limit, negative_internal_torque_limit>()};
inline constexpr step torque_speed_limits[] = {
    wears_nothing, steps::write_arguments<forward_speed_limit, reverse_speed_limit>(),
    steps::expect_arguments<forward_speed_limit, reverse_speed_limit>()};
inline constexpr step top_speeds[] = {
    wears_nothing, steps::write_arguments<max_speed, max_forward_speed, max_reverse_speed>(),
    steps::expect_arguments<max_speed, max_forward_speed, max_reverse_speed>()};

/// Segment n of P11 in one frame; the shift chooses it. Its times count as milliseconds (P11-03).
inline constexpr step segment[] = {
    wears_nothing, same_word_order,
    steps::expect<position_segment_time_unit>(position_time_unit::milliseconds, errc::wrong_state),
    steps::element(steps::write_arguments<at<position_segment_displacements, 0>, at<position_segment_speeds, 0>,
                                          at<position_segment_acceleration_times, 0>, at<position_segment_wait_times, 0>>()),
    steps::element(steps::expect_arguments<at<position_segment_displacements, 0>, at<position_segment_speeds, 0>,
                                           at<position_segment_acceleration_times, 0>, at<position_segment_wait_times, 0>>()),
};
inline constexpr step position_segments[] = {
    wears_nothing, inputs_are_off,
    steps::write_arguments<last_position_segment, position_segment_remainder, position_segment_time_unit,
                           position_segment_type, first_position_segment>(),
    steps::expect_arguments<last_position_segment, position_segment_remainder, position_segment_time_unit,
                            position_segment_type, first_position_segment>(),
};
/// Segment n of P12, only while the servo is off (errata C58).
inline constexpr step speed_segment[] = {
    wears_nothing, inputs_are_off,
    steps::expect<speed_segment_time_unit>(speed_time_unit::seconds, errc::wrong_state),
    steps::element(steps::write_arguments<at<speed_segment_speeds, 0>, at<speed_segment_run_times, 0>, at<speed_segment_ramps, 0>>()),
    steps::element(steps::expect_arguments<at<speed_segment_speeds, 0>, at<speed_segment_run_times, 0>, at<speed_segment_ramps, 0>>()),
};
inline constexpr step segment_ramp_times[] = {
    wears_nothing, inputs_are_off,
    steps::element(steps::write_arguments<segment_acceleration_time_1, segment_deceleration_time_1>()),
    steps::element(steps::expect_arguments<segment_acceleration_time_1, segment_deceleration_time_1>()),
};

inline constexpr step step_size[] = {
    wears_nothing, inputs_are_off, steps::write_arguments<position_step>(), steps::expect_arguments<position_step>()};
/// The first or, by the shift, the second gear.
inline constexpr step gear[] = {
    wears_nothing, same_word_order,
    steps::element(steps::write_arguments<gear_1_numerator, gear_1_denominator>()),
    steps::element(steps::expect_arguments<gear_1_numerator, gear_1_denominator>()),
};
inline constexpr step homing_by[] = {
    wears_nothing, inputs_are_off,
    steps::write_arguments<homing_method, homing_high_speed, homing_low_speed, homing_acceleration_time, homing_time_limit>(),
    steps::expect_arguments<homing_method, homing_high_speed, homing_low_speed, homing_acceleration_time, homing_time_limit>(),
};

// What is done once, with the servo off

/// Section 5.2.4 and chapter 8, Er.731, 733, 735.
inline constexpr step reset_encoder[] = {
    inputs_are_off, must_stand,
    steps::write<reset_absolute_encoder>(encoder_reset::fault_and_turns),
    steps::write<alarm_reset>(action::none),
    steps::write<alarm_reset>(action::execute), until_healthy,
    steps::write<alarm_reset>(action::none),
};
inline constexpr step reset_encoder_before_set_up[] = {
    inputs_are_off, must_stand, present_alarm,
    steps::write<reset_absolute_encoder>(encoder_reset::fault_and_turns),
    steps::write<alarm_reset>(action::none),
    steps::write<alarm_reset>(action::execute), until_no_alarm,
    steps::write<alarm_reset>(action::none),
};
inline constexpr step clear_fault_records[] = {
    wears_nothing, inputs_are_off, must_stand,
    steps::write<initialise_parameters>(initialisation::clear_fault_records),
};
inline constexpr step restart[]       = {inputs_are_off, must_stand, steps::write<software_reset>(action::execute)};
inline constexpr step factory_reset[] = {inputs_are_off, must_stand, steps::write<initialise_parameters>(initialisation::factory_defaults)};

/// The answer may come in the old or the new setting; P0C-13 stays 1 until `init` finds the drive again.
inline constexpr step change_address[] = {inputs_are_off, must_stand, keep, are_kept, steps::write_arguments<node_address>()};
inline constexpr step change_line[]    = {inputs_are_off, must_stand, keep, are_kept, steps::write_arguments<rs485_baud_rate, data_format>()};

// Looking

/// Words that `feedback` reads.
enum feedback_word : std::uint8_t { status_place, speed_place, position_place = 5, deviation_place = 7, record_place = 11 };

inline constexpr step fetch_status    = steps::fetch<virtual_output_levels>(status_place);
inline constexpr step fetch_motion    = steps::fetch<actual_speed, speed_command, torque_command, input_state>(speed_place);
inline constexpr step fetch_position  = steps::fetch<absolute_position>(position_place);
inline constexpr step fetch_deviation = steps::fetch<following_error, fine_actual_speed>(deviation_place);
inline constexpr step fetch_alarm     = steps::fetch<selected_fault_record, recorded_alarm>(record_place);

/// The status comes last: it shows that the position before it is not of a restarted drive.
inline constexpr step feedback[] = {fetch_motion, fetch_deviation, fetch_alarm, fetch_position, fetch_status};
inline constexpr step status[]   = {fetch_status};
/// All but the status: after a stop for a fault.
inline constexpr step details[]  = {fetch_motion, fetch_position, fetch_deviation, fetch_alarm};

/// 64 bits that belong together come in one frame.
inline constexpr step mechanical_position[] = {same_word_order, steps::fetch<mechanical_position_low, mechanical_position_high>(0)};
inline constexpr step encoder_position[]    = {same_word_order, steps::fetch<encoder_position_low, encoder_position_high>(0)};
inline constexpr step load_position[]       = {same_word_order, steps::fetch<load_position_low, load_position_high>(0)};

/// Section 7.11. Arguments: the record, and the one to be chosen afterwards.
inline constexpr step fault_history[] = {
    same_word_order, steps::write_arguments<selected_fault_record>(0),
    steps::expect_arguments<selected_fault_record>(0),
    steps::fetch<recorded_alarm, recorded_time, recorded_speed, recorded_u_current, recorded_v_current,
                 recorded_bus_voltage, recorded_inputs, recorded_outputs>(0),
    steps::write_arguments<selected_fault_record>(1),
};

// clang-format on

} // namespace servobus::c630s::routines
