// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: its control routines as tables of steps. zlac8015d/prepared_command.hpp includes it; programs
// include it for a routine of their own. Source: RS485 manual V1.07, chapter 3, with the safety rules of
// this library: stop before anything else, zero targets before every enable, the mode changes only at
// standstill, an acknowledgement is confirmed by status.
//
//     inline constexpr step clear_targets_at_rest[] = { // a command of your own has it as its `steps`
//         zlac8015d::routines::must_stand, zlac8015d::routines::clear_speed,
//         zlac8015d::routines::read_back_speed,
//     };
#pragma once

#include <servobus/control/steps.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

namespace servobus {
template <>
inline constexpr auto stop_words<zlac8015d::control_word> =
    words_that_stop(zlac8015d::control_code::stop, zlac8015d::control_code::quick_stop);
template <> inline constexpr auto stop_words<zlac8015d::left_target_speed> = words_that_stop(0);
template <> inline constexpr auto stop_words<zlac8015d::right_target_speed> = words_that_stop(0);
template <> inline constexpr auto stop_words<zlac8015d::left_target_torque> = words_that_stop(0);
template <> inline constexpr auto stop_words<zlac8015d::right_target_torque> = words_that_stop(0);
} // namespace servobus

namespace servobus::zlac8015d::routines {

// clang-format off

/// The longest ramp that the drive can be set to is 32767 ms.
inline constexpr std::uint16_t longest_ramp_ms = 34'000;
inline constexpr std::uint16_t state_change_ms = 1'000;

// Before an enable they go out once, as all of it does: a drive that does not answer may be restarting.
inline constexpr step clear_speed      = steps::write_zero<left_target_speed, right_target_speed>();
inline constexpr step clear_torque     = steps::write_zero<left_target_torque, right_target_torque>();
inline constexpr step stop_by_targets  = steps::repeatable(clear_speed);
inline constexpr step stop_by_command  = steps::repeatable(steps::write<control_word>(control_code::stop));
inline constexpr step zero_torque      = steps::repeatable(clear_torque);
// The first frame lets wheels go on that the drive's watchdog has stopped: it is zero speeds or a stop.
inline constexpr step zero_torque_too  = steps::after_a_stop(zero_torque);
inline constexpr step read_back_speed  = steps::expect_zero<left_target_speed, right_target_speed>();
inline constexpr step read_back_torque = steps::expect_zero<left_target_torque, right_target_torque>();
inline constexpr step must_stand       = steps::expect_zero<status_word>(errc::busy, status_flags::running_bits);
// Each wheel for itself, in the asynchronous mode.
inline constexpr step left_must_stand  = steps::expect_zero<status_word>(errc::busy, status_flags::left_running_bit);
inline constexpr step right_must_stand = steps::expect_zero<status_word>(errc::busy, status_flags::right_running_bit);
inline constexpr step must_be_enabled  = steps::expect_bits<status_word>(status_flags::shaft_bits, status_flags::both_locked, errc::wrong_state);
inline constexpr step must_be_healthy  = steps::expect_zero<left_faults, right_faults>(errc::faulted);
inline constexpr step until_standstill = steps::until_bits<status_word>(status_flags::running_bits, 0, longest_ramp_ms);
// What the running bits say of a wheel that rolls without power, or slows down after a stop, is open
// [errata B31]: its speed says it too. 0.1 r/min; a servo at rest trembles.
inline constexpr std::uint16_t slowest_speed = 20;
inline constexpr step must_be_slow     = steps::expect_within<left_actual_speed, right_actual_speed>(slowest_speed, errc::busy);
inline constexpr step until_slow       = steps::until_within<left_actual_speed, right_actual_speed>(slowest_speed, longest_ramp_ms);
inline constexpr step until_locked     = steps::until_bits<status_word>(status_flags::shaft_bits, status_flags::both_locked, state_change_ms);
inline constexpr step until_healthy    = steps::until_bits<left_faults, right_faults>(0xFFFF, 0, state_change_ms, errc::faulted);
inline constexpr step enable_now       = steps::write<control_word>(control_code::enable);
// What init() read must still stand; otherwise the drive was restarted since.
inline constexpr step same_scale       = steps::expect_arguments<speed_resolution>(0, errc::needs_init);
inline constexpr step same_timeout     = steps::expect_arguments<host_timeout>(1, errc::needs_init);
// A drive that has lost its mode was restarted.
inline constexpr step still_velocity   = steps::expect<mode_of_operation>(operating_mode::velocity, errc::needs_init);
inline constexpr step still_torque     = steps::expect<mode_of_operation>(operating_mode::torque, errc::needs_init);
inline constexpr step still_relative   = steps::expect<mode_of_operation>(operating_mode::relative_position, errc::needs_init);
inline constexpr step still_absolute   = steps::expect<mode_of_operation>(operating_mode::absolute_position, errc::needs_init);

// The mark of a drive that must be powered off and on: the mode, at rest and disabled. A restart loses it.
inline constexpr step set_mark         = steps::write<mode_of_operation>(operating_mode::velocity);
inline constexpr step expect_mark      = steps::expect<mode_of_operation>(operating_mode::velocity);

/// Words that `init` reads.
enum init_word : std::uint8_t { host_timeout_word, max_speed_word, resolution_word, mode_word };

/// The motor may still run from a program that crashed: zero targets, stop, wait; then read what the facade
/// must know. Nothing moves and nothing is enabled. The steps after `init_size` are for a drive whose 2022h was
/// written. They ask for the mode, which a restart loses, and set it again if it may not be set.
inline constexpr step init[] = {
    stop_by_targets,
    stop_by_command,
    zero_torque_too,
    until_standstill, until_slow,
    steps::fetch<host_timeout>(host_timeout_word),
    steps::fetch<max_motor_speed>(max_speed_word),
    steps::fetch<speed_resolution>(resolution_word),

    steps::fetch<mode_of_operation>(mode_word),
    set_mark, expect_mark,
};
inline constexpr std::uint8_t init_size = 8; ///< the steps of an `init` that asks no more
inline constexpr std::uint8_t to_ask_mark = 1; ///< steps after `init_size`
inline constexpr std::uint8_t to_set_mark = 3; ///< likewise, if it is not known whether the mark was set

/// Section 3.1. All targets are zeroed and read back before the mode is written: on a drive that is still
/// enabled the mode itself would act on an old one. A restart loses the mode: if it still stands at the end,
/// so does what was read and written behind it, and the shafts are not just locked by 2007h.
inline constexpr step enable_velocity[] = {
    must_stand, must_be_slow, must_be_healthy,
    clear_speed, read_back_speed, clear_torque, read_back_torque,
    steps::write<mode_of_operation>(operating_mode::velocity),
    steps::expect<mode_of_operation>(operating_mode::velocity),
    same_scale, same_timeout, enable_now, until_locked, still_velocity,
};

/// Section 3.3.
inline constexpr step enable_torque[] = {
    must_stand, must_be_slow, must_be_healthy,
    clear_speed, read_back_speed, clear_torque, read_back_torque,
    steps::write<mode_of_operation>(operating_mode::torque),
    steps::expect<mode_of_operation>(operating_mode::torque),
    same_scale, same_timeout, enable_now, until_locked, still_torque,
};

/// Section 3.2. Argument 2: synchronous or not. Position targets act only on a start command.
inline constexpr step enable_relative_position[] = {
    must_stand, must_be_slow, must_be_healthy,
    clear_speed, read_back_speed, clear_torque, read_back_torque,
    steps::write_zero<left_target_position, right_target_position>(),
    steps::expect_zero<left_target_position, right_target_position>(),
    steps::write<mode_of_operation>(operating_mode::relative_position),
    steps::expect<mode_of_operation>(operating_mode::relative_position),
    steps::write_arguments<position_synchronisation>(2),
    steps::expect_arguments<position_synchronisation>(2),
    same_scale, same_timeout, enable_now, until_locked, still_relative,
};

/// Section 3.2. No position is zeroed here: zero is a place to which an absolute move would go.
inline constexpr step enable_absolute_position[] = {
    must_stand, must_be_slow, must_be_healthy,
    clear_speed, read_back_speed, clear_torque, read_back_torque,
    steps::write<mode_of_operation>(operating_mode::absolute_position),
    steps::expect<mode_of_operation>(operating_mode::absolute_position),
    steps::write_arguments<position_synchronisation>(2),
    steps::expect_arguments<position_synchronisation>(2),
    same_scale, same_timeout, enable_now, until_locked, still_absolute,
};

inline constexpr step disable[]    = {stop_by_command, until_standstill, until_slow};
// Read back, since a late acknowledgement of the speed before it looks like the stop's own.
inline constexpr step halt_speed[]  = {stop_by_targets, read_back_speed, until_standstill, until_slow};
inline constexpr step halt_torque[] = {zero_torque, read_back_torque, until_standstill, until_slow};

/// Section 3.4. Enable must follow before the next motion.
inline constexpr step quick_stop_now   = steps::repeatable(steps::write<control_word>(control_code::quick_stop));
inline constexpr step until_emergency  = steps::until_bits<status_word>(status_flags::shaft_bits | status_flags::running_bits,
                                                                        status_flags::both_stopped_in_emergency, state_change_ms);
// A drive that stands and does not say so, since it was restarted, is not waited for as long as a ramp.
// After silence the first frame is zero targets: whether a watchdog stop ends with it is not stated.
inline constexpr step quick_stop_after_silence[] = {stop_by_targets, quick_stop_now, until_standstill, until_slow, until_emergency};
inline constexpr steps_of<quick_stop_after_silence, 1, 4> quick_stop;

/// A fault on either wheel: both stop, as an `init` begins.
inline constexpr steps_of<init, 0, 5> stop_both;

/// What a drive is to hear first when it may be there again: one frame that stops it in every mode, and the
/// rest if that was answered.
inline constexpr step stop_after_silence[] = {
    steps::write<control_word>(control_code::stop), stop_by_targets, zero_torque_too, until_standstill, until_slow};

/// Section 3.5, with a stop in front, so that the drive is surely disabled afterwards.
inline constexpr step fault_reset[] = {
    must_stand, stop_by_command, steps::write<control_word>(control_code::fault_reset), until_healthy};

inline constexpr step velocity[]       = {steps::set_arguments<left_target_speed, right_target_speed>()};
inline constexpr step left_velocity[]  = {steps::set_arguments<left_target_speed>()};
inline constexpr step right_velocity[] = {steps::set_arguments<right_target_speed>()};
inline constexpr step torque[]         = {steps::set_arguments<left_target_torque, right_target_torque>()};
inline constexpr step left_torque[]    = {steps::set_arguments<left_target_torque>()};
inline constexpr step right_torque[]   = {steps::set_arguments<right_target_torque>()};

/// Words that a move reads first: status .. positions, 20A2h..20AAh.
inline constexpr step fetch_state = steps::fetch<status_word, hall_state, motor_temperature, left_faults, right_faults,
                                                 left_actual_position, right_actual_position>(0);
/// Positions read again go behind the ones read before: 20A7h..20AAh.
inline constexpr std::uint8_t before_word = 5;
inline constexpr std::uint8_t after_word = 11;
inline constexpr std::uint8_t running_word = 15;
// Argument 0: the mode, without which the positions are those of a restart.
inline constexpr step post_check[] = {
    steps::fetch<left_actual_position, right_actual_position>(after_word),
    steps::fetch<status_word>(running_word),
    steps::expect_arguments<mode_of_operation>(0, errc::needs_init),
};

inline constexpr step start_both  = steps::write<control_word>(control_code::start_both);
inline constexpr step start_left  = steps::write<control_word>(control_code::start_left);
inline constexpr step start_right = steps::write<control_word>(control_code::start_right);
inline constexpr step write_both_positions = steps::write_arguments<left_target_position, right_target_position>();
inline constexpr step write_left_position  = steps::write_arguments<left_target_position>();
inline constexpr step write_right_position = steps::write_arguments<right_target_position>();

// The witness once more after the start: a drive that was restarted before it has acknowledged and ignored it.
inline constexpr step move_both[] = {
    steps::same_drive(), must_stand, must_be_enabled, fetch_state, write_both_positions, start_both, steps::same_drive()};
inline constexpr step move_left[] = {
    steps::same_drive(), left_must_stand, must_be_enabled, fetch_state, write_left_position, start_left, steps::same_drive()};
inline constexpr step move_right[] = {
    steps::same_drive(), right_must_stand, must_be_enabled, fetch_state, write_right_position, start_right, steps::same_drive()};
inline constexpr std::uint8_t start_step = 5; ///< in the routine of each move

inline constexpr step ramps[] = {
    steps::set_arguments<left_acceleration_time, right_acceleration_time, left_deceleration_time, right_deceleration_time>()};
inline constexpr step quick_stop_ramp[] = {steps::set_arguments<left_quick_stop_time, right_quick_stop_time>()};
inline constexpr step torque_slope[]    = {steps::set_arguments<left_torque_slope, right_torque_slope>()};
inline constexpr step position_speed[]  = {steps::set_arguments<left_max_speed, right_max_speed>()};
inline constexpr step brakes[]          = {steps::write_arguments<left_brake, right_brake>()};
inline constexpr step input_stop[]      = {steps::write_arguments<zlac8015d::input_stop>()};
inline constexpr step quick_stop_by[]   = {steps::write_arguments<quick_stop_option_code>()};
inline constexpr step parking[]         = {steps::write_arguments<parking_mode>()};

inline constexpr step clear_positions[] = {
    must_stand, steps::write_arguments<clear_feedback_position, clear_absolute_position>()};

/// Saving and resetting wear the EEPROM, so each goes out once. What the drive keeps is marked RW/S, or it is
/// all that can be written [errata B11]: without a mode a restart is found by the mode either way.
/// 2010h = 1 may be a mode in which each later write is kept too: 0 ends that.
inline constexpr step drop_mode    = steps::write<mode_of_operation>(operating_mode::undefined);
inline constexpr step expect_none  = steps::expect<mode_of_operation>(operating_mode::undefined);
inline constexpr step save_all     = steps::write<save_parameters>(parameter_save::save_all);
inline constexpr step save_no_more = steps::write<save_parameters>(parameter_save::none);
inline constexpr step save[]       = {must_stand, must_be_slow, drop_mode, expect_none, save_all, save_no_more};
inline constexpr step restore_all  = steps::write<restore_parameters>(parameter_reset::factory_defaults);
inline constexpr step factory_reset[] = {must_stand, must_be_slow, restore_all};
/// The factory's resolution is another one. The mark is set before, since a drive may not respond after a reset.
inline constexpr step reset_resolution[] = {must_stand, must_be_slow, set_mark, expect_mark, restore_all};

inline constexpr step set_host_timeout[] = {steps::write_arguments<host_timeout>(), steps::expect_arguments<host_timeout>()};
/// 2022h counts from the next power-on after a save. Read back at the end too: a restart before the save loses it.
inline constexpr step set_resolution[]   = {
    must_stand, must_be_slow, steps::write_arguments<speed_resolution>(), steps::expect_arguments<speed_resolution>(),
    drop_mode, expect_none, save_all, save_no_more, set_mark, expect_mark, same_scale};
inline constexpr step same_resolution[]  = {same_scale};

/// After a move it must also be at its target; a restart may have put the positions where the move would end.
inline constexpr step wait_standstill[] = {
    steps::until_bits<status_word>(status_flags::running_bits, 0, step::commanded_limit), until_slow, steps::confirm(), steps::same_drive()};
inline constexpr step wait_reached[]    = {steps::confirm(), steps::same_drive()};

/// Whether the drive is still in the mode of argument 0.
inline constexpr step same_mode[] = {steps::expect_arguments<mode_of_operation>(0, errc::needs_init)};

/// 20A2h..20ACh in one frame.
inline constexpr step feedback[] = {
    steps::fetch<status_word, hall_state, motor_temperature, left_faults, right_faults, left_actual_position,
                 right_actual_position, left_actual_speed, right_actual_speed>(0)};

// clang-format on

} // namespace servobus::zlac8015d::routines
