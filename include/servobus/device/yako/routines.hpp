// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: their control routines as tables of steps. yako/prepared_command.hpp includes it.
// Source: manual V2.6.0, chapters 4 and 5, with the safety rules of this library: stop before anything
// else; read the drive's state and its marker before every routine that may move it, change it or write a
// speed, and after every start. [errata An] are in device/errata.md. Both variants have these registers at the same
// addresses, so one table serves both; of a row that differs the closed loop's is named.
//
//     inline constexpr step set_position_clear[] = { // of a facade of your own
//         yako::routines::stop_now, yako::routines::until_standstill,
//         steps::write<yako::auxiliary_command>(yako::auxiliary::clear_position),
//     };
#pragma once

#include <servobus/control/steps.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/open_loop.hpp>

namespace servobus {
template <>
inline constexpr auto stop_words<yako::motion_command> = words_that_stop(yako::motion_code::stop(),
                                                                         yako::motion_code::emergency_stop());
template <>
inline constexpr auto stop_words<yako::auxiliary_command> = words_that_stop(yako::auxiliary::release);
} // namespace servobus

namespace servobus::yako::routines {

namespace cl = closed_loop;

// clang-format off

/// Ramps are set up to 2000 ms, but from which speed to which is not stated [errata A32].
inline constexpr std::uint16_t longest_ramp_ms = 8'000;
inline constexpr std::uint16_t state_change_ms = 1'000;

/// Words of the feedback: where the status and the position are.
enum feedback_word : std::uint8_t { status_at = 1, inputs_at = 2, position_at = 4 };

/// The drive is as the command requires, by its feedback, and has not restarted since.
inline constexpr step may_act    = steps::permit();
inline constexpr step same_drive = steps::same_drive();
inline constexpr step stop_now         = steps::repeatable(steps::write<motion_command>(motion_code::stop()));
inline constexpr step quick_stop_now   = steps::repeatable(steps::write<motion_command>(motion_code::emergency_stop()));
inline constexpr step release_now      = steps::repeatable(steps::write<auxiliary_command>(auxiliary::release));
inline constexpr step until_standstill = steps::until_bits<status_word>(motion_status::moving_bit, 0, longest_ramp_ms);
inline constexpr step until_stopped    = steps::until_bits<status_word>(motion_status::moving_bit, 0, state_change_ms);
inline constexpr step until_released   = steps::until_bits<status_word>(motion_status::released_bit, motion_status::released_bit, state_change_ms);
inline constexpr step until_enabled    = steps::until_bits<status_word>(motion_status::released_bit, 0, state_change_ms);
/// By the feedback: carried out, and not just acknowledged.
inline constexpr step must_be_confirmed = steps::confirm(1'000);
inline constexpr step until_healthy    = steps::until_bits<status_word>(motion_status::alarm_bit, 0, state_change_ms, errc::faulted);
inline constexpr step must_be_healthy  = steps::expect_zero<status_word>(errc::faulted, motion_status::alarm_bit);

/// 0006h..000Ch in one frame: error, status, terminals, position and speed.
inline constexpr step feedback[] = {
    steps::fetch<error_code, status_word, cl::input_state, cl::output_state, actual_position, cl::actual_speed>(0)};

/// What a restart loses, of a drive that has no marker.
inline constexpr step same_in_closed_loop[] = {steps::expect_arguments<pair_word_order, cl::speed_resolution>(0, errc::needs_init)};
inline constexpr step same_in_open_loop[]   = {steps::expect_arguments<pair_word_order>(0, errc::needs_init)};

/// The marker: the target of position segment 16, which inputs can start on open loop drives only, by the five
/// functions PT and PIN0 to PIN3. It is not among the rows that the appendices mark as saved.
inline constexpr step mark[]        = {steps::write_arguments<at<position_segment_targets, 15>>(), steps::expect_arguments<at<position_segment_targets, 15>>()};
inline constexpr step same_marker[] = {steps::expect_arguments<at<position_segment_targets, 15>>(0, errc::needs_init)};

/// Words that `init` reads.
enum init_word : std::uint8_t {
    limits_word, word_order_word, resolution_word, microsteps_word, error_word, status_word_at, profile_at, homing_speeds_at = 10,
    marker_at = 12 };
inline constexpr step fetch_profile =
    steps::fetch<cl::start_speed, acceleration_time, deceleration_time, cl::positioning_speed>(profile_at);
inline constexpr step fetch_marker = steps::fetch<at<position_segment_targets, 15>>(marker_at);
inline constexpr step fetch_homing_speeds = steps::fetch<cl::homing_fast_speed, cl::homing_slow_speed>(homing_speeds_at);

/// The motor may still run from a program that crashed: stop, wait; then read what the facade must know.
/// Nothing moves and nothing is enabled.
inline constexpr step init_closed_loop[] = {
    stop_now, until_standstill,
    steps::fetch<yako::software_limits, pair_word_order, cl::speed_resolution>(limits_word),
    steps::fetch<microstep_resolution>(microsteps_word),
    steps::fetch<error_code, status_word>(error_word),
    fetch_profile, fetch_homing_speeds, fetch_marker,
};
inline constexpr step init_open_loop[] = {
    stop_now, until_standstill,
    steps::fetch<yako::software_limits, pair_word_order>(limits_word),
    steps::fetch<microstep_resolution>(microsteps_word),
    steps::fetch<error_code, status_word>(error_word),
    fetch_profile, fetch_homing_speeds, fetch_marker,
};

/// Section 4.6.
inline constexpr step stop[]       = {stop_now, until_standstill};
inline constexpr step quick_stop[] = {quick_stop_now, until_stopped};
inline constexpr step release[]    = {stop_now, until_standstill, release_now, until_released};

/// Section 5.1. Each command goes out once.
inline constexpr step enable[]         = {same_drive, may_act, steps::write<auxiliary_command>(auxiliary::enable), until_enabled};
inline constexpr step fault_reset[]    = {same_drive, may_act, steps::write<auxiliary_command>(auxiliary::clear_alarm), until_healthy, feedback[0]};
inline constexpr step clear_position[] = {same_drive, may_act, steps::write<auxiliary_command>(auxiliary::clear_position), must_be_confirmed};
/// Without the marker, so that a restart shows whatever is saved. It is read in the frame before it is cleared, since
/// that hides a restart.
inline constexpr step clear_marker     = steps::write_zero<at<position_segment_targets, 15>>();
inline constexpr step save[]           = {
    may_act, same_drive, clear_marker, steps::expect_zero<at<position_segment_targets, 15>>(),
    steps::write<auxiliary_command>(auxiliary::save_parameters), must_be_confirmed};
inline constexpr step factory_reset[]  = {same_drive, may_act, steps::write<auxiliary_command>(auxiliary::restore_parameters), must_be_confirmed};

/// Section 4.1: start speed, ramps, speed and target in one frame, 0020h..0025h [errata A2]; or the target
/// alone.
inline constexpr step write_move =
    steps::write_arguments<cl::start_speed, acceleration_time, deceleration_time, cl::positioning_speed, target_position>();
inline constexpr step write_target = steps::write_arguments<target_position>();
inline constexpr step start_relative      = steps::write<motion_command>(motion_code::move(positioning::relative));
inline constexpr step start_absolute      = steps::write<motion_command>(motion_code::move(positioning::absolute));
inline constexpr step start_relative_now  = steps::write<motion_command>(motion_code::move(positioning::relative, while_moving::interrupt));
inline constexpr step start_absolute_now  = steps::write<motion_command>(motion_code::move(positioning::absolute, while_moving::interrupt));
template <positioning From, while_moving Then>
inline constexpr step start_move = From == positioning::relative
                                       ? (Then == while_moving::ignore ? start_relative : start_relative_now)
                                       : (Then == while_moving::ignore ? start_absolute : start_absolute_now);

template <positioning From, while_moving Then> inline constexpr step move[] = {
    same_drive, may_act, write_move, start_move<From, Then>, same_drive, must_be_confirmed};
/// Arguments from number 2 on: the profile that the drive should hold; another one shows a restart.
inline constexpr step same_profile =
    steps::expect_arguments<cl::start_speed, acceleration_time, deceleration_time, cl::positioning_speed>(2, errc::needs_init);
template <positioning From, while_moving Then> inline constexpr step stored_move[] = {
    same_profile, same_drive, may_act, write_target, start_move<From, Then>, same_drive, must_be_confirmed};

/// Section 4.2.
inline constexpr step jog[] = {
    same_drive, may_act,
    steps::write_arguments<cl::jog_speed, jog_acceleration_time, jog_deceleration_time>(),
    steps::write<motion_command>(motion_code::jog()), same_drive, must_be_confirmed,
};
inline constexpr std::uint8_t start_step = 3; ///< in the routines of a move with a profile and of a jog
inline constexpr std::uint8_t stored_start_step = 4;

/// Section 4.3. Arguments: offset mode, method, offset, and the speeds that the drive should hold. A drive that
/// restarts after the method was written would look for home by the factory's method.
inline constexpr step home[] = {
    steps::expect_arguments<cl::homing_fast_speed, cl::homing_slow_speed>(4, errc::needs_init),
    same_drive, may_act,
    steps::write_arguments<homing_offset_mode, cl::homing_method>(0),
    steps::write_arguments<home_offset>(2), same_drive,
    steps::write<motion_command>(motion_code::home()), same_drive, steps::confirm(), same_drive,
};
inline constexpr std::uint8_t home_start_step = 6;

/// Section 5.4: what an input's start, or its interruption of a jog, does. 0020h..0025h and 0050h are far
/// apart: between a target and the kind that it is for, it is a way of zero at a speed of zero.
inline constexpr step clear_move =
    steps::write_zero<cl::start_speed, acceleration_time, deceleration_time, cl::positioning_speed, target_position>();
inline constexpr step relative_input_move[] = {same_drive, may_act, clear_move, steps::write<io_positioning>(positioning::relative), write_move};
inline constexpr step absolute_input_move[] = {same_drive, may_act, clear_move, steps::write<io_positioning>(positioning::absolute), write_move};

inline constexpr step set_profile[] = {
    same_drive, may_act, 
    steps::write_arguments<cl::start_speed, acceleration_time, deceleration_time, cl::positioning_speed>(),
    steps::expect_arguments<cl::start_speed, acceleration_time, deceleration_time, cl::positioning_speed>()};
inline constexpr step set_homing_profile[] = {
    same_drive, may_act, 
    steps::write_arguments<cl::homing_fast_speed, cl::homing_slow_speed, homing_ramp_time>(),
    steps::expect_arguments<cl::homing_fast_speed, cl::homing_slow_speed, homing_ramp_time>()};

/// Sections 4.4 and 4.5: a segment is one frame, read back.
inline constexpr step set_position_segment[] = {
    same_drive, may_act, 
    steps::element(steps::write_arguments<
        at<position_segment_targets, 0>, at<cl::position_segment_speeds, 0>, at<cl::position_segment_acceleration_times, 0>,
        at<cl::position_segment_deceleration_times, 0>, at<position_segment_positionings, 0>>()),
    steps::element(steps::expect_arguments<
        at<position_segment_targets, 0>, at<cl::position_segment_speeds, 0>, at<cl::position_segment_acceleration_times, 0>,
        at<cl::position_segment_deceleration_times, 0>, at<position_segment_positionings, 0>>())};
inline constexpr step set_speed_segment[] = {
    same_drive, may_act, 
    steps::element(steps::write_arguments<
        at<cl::speed_segment_speeds, 0>, at<cl::speed_segment_acceleration_times, 0>, at<cl::speed_segment_deceleration_times, 0>>()),
    steps::element(steps::expect_arguments<
        at<cl::speed_segment_speeds, 0>, at<cl::speed_segment_acceleration_times, 0>, at<cl::speed_segment_deceleration_times, 0>>())};
inline constexpr step set_pv_trigger[] = {same_drive, may_act, steps::write_arguments<pv_trigger_mode>(), steps::expect_arguments<pv_trigger_mode>()};

/// Section 5.2; the element is the terminal.
inline constexpr step set_input[]  = {same_drive, may_act, steps::element(steps::write_arguments<x0_function>()), steps::element(steps::expect_arguments<x0_function>())};
inline constexpr step set_output[] = {same_drive, may_act, steps::element(steps::write_arguments<y0_function>()), steps::element(steps::expect_arguments<y0_function>())};
inline constexpr step set_input_polarity[]  = {same_drive, may_act, steps::write_arguments<cl::input_polarity>(), steps::expect_arguments<cl::input_polarity>()};
inline constexpr step set_output_polarity[] = {same_drive, may_act, steps::write_arguments<cl::output_polarity>(), steps::expect_arguments<cl::output_polarity>()};
inline constexpr step set_outputs[]         = {same_drive, may_act, steps::write_arguments<cl::user_outputs>()};

/// What a start that got no response has done. Arguments: the marker.
inline constexpr step after_start[]          = {feedback[0], same_marker[0]};
inline constexpr step after_start_unmarked[] = {feedback[0]};

/// Section 5.3. The limits go before the switch that puts them into force.
inline constexpr step limit_travel[] = {
    same_drive, may_act, 
    steps::write_arguments<positive_software_limit, negative_software_limit>(),
    steps::expect_arguments<positive_software_limit, negative_software_limit>(),
    steps::write<yako::software_limits>(limit_enable::after_homing), steps::expect<yako::software_limits>(limit_enable::after_homing)};
inline constexpr step unlimit_travel[] = {
    same_drive, may_act, 
    steps::write<yako::software_limits>(limit_enable::disabled), steps::expect<yako::software_limits>(limit_enable::disabled)};
inline constexpr step set_over_travel_stop[] = {same_drive, may_act, steps::write_arguments<over_travel_stop_mode>(), steps::expect_arguments<over_travel_stop_mode>()};

/// Section 5.5.
inline constexpr step set_word_order[]       = {same_drive, may_act, steps::write_arguments<pair_word_order>(), steps::expect_arguments<pair_word_order>()};
inline constexpr step set_speed_resolution[] = {same_drive, may_act, steps::write_arguments<cl::speed_resolution>(), steps::expect_arguments<cl::speed_resolution>()};

/// Section 2. A new address may be in use at once, so it is not read back.
inline constexpr step set_node_address[]  = {same_drive, may_act, steps::write_arguments<node_address>()};
inline constexpr step set_baud_rate[]     = {same_drive, may_act, steps::write_arguments<rs485_baud_rate>(), steps::expect_arguments<rs485_baud_rate>()};
inline constexpr step set_serial_format[] = {same_drive, may_act, steps::write_arguments<rs485_format>(), steps::expect_arguments<rs485_format>()};

/// A restart may put the position where a move would end: the drive must be the same at the end.
inline constexpr step wait_standstill[] = {
    steps::until_bits<status_word>(motion_status::moving_bit, 0, step::commanded_limit), must_be_healthy, must_be_confirmed, same_drive};
inline constexpr step wait_reached[]   = {steps::confirm(), same_drive};
/// Why a move has ended elsewhere: the feedback, and from word 7 on the functions of the inputs.
inline constexpr std::uint8_t functions_word = 7;
inline constexpr step examine_stop_in_closed_loop[] = {
    same_drive, feedback[0], steps::fetch<x0_function, x1_function, x2_function, x3_function>(functions_word)};
inline constexpr step examine_stop_in_open_loop[] = {
    same_drive, feedback[0],
    steps::fetch<x0_function, x1_function, x2_function, x3_function, open_loop::x4_function, open_loop::x5_function,
                 open_loop::x6_function>(functions_word)};
/// The feedback, by a drive that is as the command requires.
inline constexpr step accept_position[] = {same_drive, may_act, feedback[0]};

// clang-format on

} // namespace servobus::yako::routines
