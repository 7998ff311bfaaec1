// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the control routines that operate it, as tables of steps. c630s/setting_routines.hpp
// includes it; programs include it to list what a command sends. Source: manual V24.111, chapters 5 to 9,
// with the safety rules of this library: stop before anything else, zero targets before every enable, no
// repeated writes while writes wear the EEPROM, P31-00 read back before each of its bits is set.
//
//     for (const step& s : routine{c630s::routines::init})
//         std::printf("%s %04Xh\n", s.what == step::kind::write ? "writes" : "reads", unsigned{s.address});
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/steps.hpp>
#include <servobus/device/c630s/terminals.hpp>

namespace servobus {
template <> inline constexpr auto stop_words<c630s::target_speed> = words_that_stop(0);
template <> inline constexpr auto stop_words<c630s::target_torque> = words_that_stop(0);
/// All inputs off, with or without the marker that shows a restart.
template <>
inline constexpr auto stop_words<c630s::virtual_input_levels> = words_that_stop(0, c630s::terminal::marker);
template <> inline constexpr auto stop_words<c630s::emergency_stop> = words_that_stop(c630s::action::execute);
} // namespace servobus

namespace servobus::c630s::routines {

// clang-format off

/// The manual gives no time for a stop: the longest ramp is 65.5 s, if it is meant for the whole way.
inline constexpr std::uint16_t longest_stop_ms = 60'000;
/// The brake may take 500 ms (P02-09), servo-on a filter of 64 ms (P02-18).
inline constexpr std::uint16_t state_change_ms = 2'000;
/// r/min: a servo at standstill moves by a few counts.
inline constexpr std::uint16_t stillness = 2;

// Before an enable they are sent once: a drive that does not respond may be restarting.
inline constexpr step clear_speed      = steps::write_zero<target_speed, jog_speed>();
inline constexpr step clear_torque     = steps::write_zero<target_torque>();
inline constexpr step stop_by_targets  = steps::repeatable(clear_speed);
inline constexpr step zero_torque      = steps::repeatable(clear_torque);
inline constexpr step servo_off        = steps::repeatable(steps::write_zero<virtual_input_levels>());
/// The same for a drive that is set up and has its marker.
inline constexpr step servo_off_marked = steps::repeatable(steps::write<virtual_input_levels>(virtual_inputs::from_word(terminal::marker)));
inline constexpr step stop_at_once     = steps::repeatable(steps::write<emergency_stop>(action::execute));
inline constexpr step read_back_speed  = steps::expect_zero<target_speed, jog_speed>();
inline constexpr step read_back_torque = steps::expect_zero<target_torque>();
inline constexpr std::uint16_t all_but_marker = 0xFFFF & ~terminal::marker;
inline constexpr step read_back_inputs = steps::expect_zero<virtual_input_levels>(errc::unexpected_value, all_but_marker);
inline constexpr step must_stand       = steps::expect_within<actual_speed>(stillness, errc::busy);
inline constexpr step until_standstill = steps::until_within<actual_speed>(stillness, longest_stop_ms);
inline constexpr step must_be_healthy  = steps::expect_zero<virtual_output_levels>(errc::faulted, status_flags::fault_bit);
/// Ready, and the brake applied: one that is released already could not confirm the enabling (errata C77).
inline constexpr step must_be_ready    = steps::expect_bits<virtual_output_levels>(status_flags::ready_bit | status_flags::brake_bit,
                                                                                  status_flags::ready_bit, errc::wrong_state);
inline constexpr step until_healthy    = steps::until_bits<virtual_output_levels>(status_flags::fault_bit, 0, state_change_ms, errc::faulted);
/// No output shows that the motor is energised. The brake is released then, and applied otherwise.
inline constexpr step until_enabled    = steps::until_bits<virtual_output_levels>(status_flags::brake_bit | status_flags::fault_bit,
                                                                                  status_flags::brake_bit, state_change_ms);
inline constexpr step same_inputs[]    = {steps::expect_arguments<virtual_input_levels>(0, errc::needs_init)};
/// P02-09: before it is over, a command is not obeyed and an edge is lost.
inline constexpr step until_obeyed     = steps::confirm(state_change_ms);
/// P02-10: until then the brake is being applied and the motor is energised; the drive refuses writes for which it
/// must be stopped.
inline constexpr step until_power_off  = steps::confirm(state_change_ms);
inline constexpr step still_enabled    = steps::expect_bits<virtual_output_levels>(status_flags::brake_bit, status_flags::brake_bit, errc::needs_init);
// As `init` has left it; otherwise the drive has restarted.
inline constexpr step wears_nothing    = steps::expect<eeprom_update>(off_on::off, errc::needs_init);
inline constexpr step inputs_are_off   = steps::expect_zero<virtual_input_levels>(errc::needs_init, all_but_marker);
inline constexpr step inputs_are_known = steps::expect_arguments<virtual_input_levels>(0, errc::needs_init);
inline constexpr step same_word_order       = steps::expect_arguments<pair_word_order>(5, errc::needs_init);

/// Words that `init` reads.
enum init_word : std::uint8_t {
    response_delay_word, pair_word_order_word,
    mode_word,
    max_speed_word, max_forward_word, max_reverse_word,
    positive_torque_word, negative_torque_word,
    record_word,
    brake_delay_word, power_off_delay_word,
};

constexpr step* copied(const step* part, std::size_t size, step* to) {
    for (std::size_t i = 0; i < size; ++i) to[i] = part[i];
    return to + size;
}
/// Joins the parts of a table.
template <std::size_t... N> constexpr auto joined(const step (&... parts)[N]) {
    joined_steps<(N + ...)> table{};
    step* end = table.all;
    ((end = copied(parts, N, end)), ...);
    return table;
}

/// Sent and repeated whether or not anything responds: what follows wears nothing if both arrive.
inline constexpr step spare_first[] = {steps::repeatable(steps::write<eeprom_update>(off_on::off))};
/// The motor may still run from a program that crashed: zero targets, servo off. The EEPROM is spared after them and
/// repeated with them, so that a second round wears nothing. Then what the facade must know is read. Nothing moves and
/// nothing is enabled.
inline constexpr step init[] = {
    stop_by_targets,
    servo_off,
    zero_torque,
    spare_first[0],
    steps::expect<eeprom_update>(off_on::off),
    until_standstill,
    read_back_inputs,
    steps::fetch<response_delay, pair_word_order>(response_delay_word),
    steps::fetch<mode_of_operation>(mode_word),
    steps::fetch<max_speed, max_forward_speed, max_reverse_speed>(max_speed_word),
    steps::fetch<positive_internal_torque_limit, negative_internal_torque_limit>(positive_torque_word),
    steps::fetch<selected_fault_record>(record_word),
    steps::fetch<brake_on_to_command_delay, brake_off_to_power_off_delay>(brake_delay_word),
};

/// After an `init` without a response, whose stops the EEPROM would keep once more. Servo off goes first and is kept:
/// it takes back a servo-on that a restart has let into the EEPROM.
inline constexpr step servo_off_first[] = {servo_off};
inline constexpr auto init_again = joined(servo_off_first, spare_first, init);

/// The set-up, block by block: the shift chooses the block.
inline constexpr step look_at_block[] = {
    steps::element(steps::fetch<at<virtual_input_functions, 0>, at<virtual_input_logics, 0>,
                                at<virtual_input_functions, 1>, at<virtual_input_logics, 1>>(0))};
inline constexpr step set_block[] = {
    steps::element(steps::write_arguments<at<virtual_input_functions, 0>, at<virtual_input_logics, 0>,
                                          at<virtual_input_functions, 1>, at<virtual_input_logics, 1>>()),
    steps::element(steps::expect_arguments<at<virtual_input_functions, 0>, at<virtual_input_logics, 0>,
                                           at<virtual_input_functions, 1>, at<virtual_input_logics, 1>>())};
inline constexpr std::uint16_t first_of_blocks = virtual_input_functions.first.address;

/// The end of `init` for a drive that is set up: the present alarm is shown, and the marker is set.
inline constexpr step present_alarm = steps::write<selected_fault_record>(fault_record::current);
inline constexpr step set_marker    = steps::write<virtual_input_levels>(virtual_inputs::from_word(terminal::marker));
inline constexpr step has_marker    = steps::expect<virtual_input_levels>(virtual_inputs::from_word(terminal::marker));
/// The status at the end says whether the drive has a fault. After a restart during the init P0C-13 may be 1, and the
/// EEPROM would keep the marker.
inline constexpr step mark_session[]         = {present_alarm, wears_nothing, set_marker, has_marker, steps::fetch<virtual_output_levels>(0)};
inline constexpr step choose_present_alarm[] = {present_alarm};

/// With P0C-13 = 1 writes go into the EEPROM, with 0 they do not.
inline constexpr step keep      = steps::write<eeprom_update>(off_on::on);
inline constexpr step are_kept  = steps::expect<eeprom_update>(off_on::on);
inline constexpr step spare     = steps::write<eeprom_update>(off_on::off);
inline constexpr step are_spared = steps::expect<eeprom_update>(off_on::off);
/// P0B-33 is not in the EEPROM: the record that is chosen there shows whether the power has been off.
inline constexpr step mark      = steps::write<selected_fault_record>(fault_record::ninth_last);

inline constexpr step begin_keeping[] = {inputs_are_off, must_stand, mark, keep, are_kept};
inline constexpr step end_keeping[]   = {are_kept, spare, are_spared};
inline constexpr step give_up_keeping[] = {spare, are_spared};

/// One parameter of one or two words, kept: the shift chooses it. P0C-13 is read after it too: after a
/// restart the write would not go into the EEPROM.
inline constexpr step keep_one[] = {
    inputs_are_off, must_stand, keep, are_kept,
    steps::element(steps::write_arguments<target_speed>()), steps::element(steps::expect_arguments<target_speed>()),
    are_kept, spare, are_spared,
};
inline constexpr step keep_two[] = {
    same_word_order, inputs_are_off, must_stand, keep, are_kept,
    steps::element(steps::write_arguments<home_offset>()), steps::element(steps::expect_arguments<home_offset>()),
    are_kept, spare, are_spared,
};
inline constexpr step keep_one_for_later[] = {
    inputs_are_off, must_stand, mark, keep, are_kept,
    steps::element(steps::write_arguments<target_speed>()), steps::element(steps::expect_arguments<target_speed>()),
    are_kept, spare, are_spared,
};
inline constexpr step keep_two_for_later[] = {
    same_word_order, inputs_are_off, must_stand, mark, keep, are_kept,
    steps::element(steps::write_arguments<home_offset>()), steps::element(steps::expect_arguments<home_offset>()),
    are_kept, spare, are_spared,
};
/// One parameter until the power goes.
inline constexpr step set_one[] = {
    wears_nothing,
    steps::element(steps::write_arguments<target_speed>()), steps::element(steps::expect_arguments<target_speed>()),
};
inline constexpr step set_two[] = {
    wears_nothing, same_word_order,
    steps::element(steps::write_arguments<home_offset>()), steps::element(steps::expect_arguments<home_offset>()),
};

// Enabling

/// Section 6.1..6.3. Targets are zeroed and read back, and whatever the factory's values would start by
/// themselves: cyclic segments (arguments 1 and 2), homing, servo-on at power-on.
inline constexpr step before_enable[] = {
    wears_nothing, same_word_order, inputs_are_known, must_stand, must_be_healthy,
    clear_speed, clear_torque,
    steps::write_arguments<position_segment_mode>(1), steps::expect_arguments<position_segment_mode>(1),
    steps::write_arguments<speed_segment_mode>(2),    steps::expect_arguments<speed_segment_mode>(2),
    steps::write<homing_control>(homing::off),        steps::expect<homing_control>(homing::off),
    steps::write<emergency_stop>(action::none),       steps::expect<emergency_stop>(action::none),
    steps::expect_zero<virtual_inputs_at_power_on>(errc::wrong_state, terminal::servo_on),
    steps::expect_zero<power_on_functions_1_to_16>(errc::wrong_state, terminal::servo_on),
};
/// Argument 0: P31-00 as it is; 4: with servo-on, and with a segment where one is chosen by inputs. A restart in
/// between would bring back the targets and the mode that the EEPROM holds, so they are read last, and once more.
inline constexpr step enable_now[] = {
    must_be_ready, read_back_speed, read_back_torque, inputs_are_known,
    steps::write_arguments<virtual_input_levels>(4),
    steps::expect_arguments<virtual_input_levels>(4, errc::needs_init),
    steps::expect_zero<target_speed, jog_speed>(errc::needs_init),
    steps::expect_zero<target_torque>(errc::needs_init),
    wears_nothing, // a restart may have made the EEPROM keep servo-on: then it is taken back
};
inline constexpr step until_in_speed[]    = {steps::expect<mode_of_operation>(control_mode::speed, errc::needs_init), until_enabled, until_obeyed};
inline constexpr step until_in_torque[]   = {steps::expect<mode_of_operation>(control_mode::torque, errc::needs_init), until_enabled, until_obeyed};
inline constexpr step until_in_position[] = {steps::expect<mode_of_operation>(control_mode::position, errc::needs_init), until_enabled, until_obeyed};

inline constexpr step speed_by_bus[] = {
    steps::write<mode_of_operation>(control_mode::speed),           steps::expect<mode_of_operation>(control_mode::speed),
    steps::write<main_speed_source>(speed_source::digital),         steps::expect<main_speed_source>(speed_source::digital),
    steps::write<speed_command_selection>(command_selection::main), steps::expect<speed_command_selection>(command_selection::main),
};
inline constexpr auto enable_speed = joined(before_enable, speed_by_bus, enable_now, until_in_speed);

/// Section 6.2.3. The motor runs as soon as it is energised. Argument 3: the last segment.
inline constexpr step speed_by_segments[] = {
    steps::write<mode_of_operation>(control_mode::speed),                steps::expect<mode_of_operation>(control_mode::speed),
    steps::write<auxiliary_speed_source>(speed_source::segments),        steps::expect<auxiliary_speed_source>(speed_source::segments),
    steps::write<speed_command_selection>(command_selection::auxiliary), steps::expect<speed_command_selection>(command_selection::auxiliary),
    steps::write_arguments<last_speed_segment>(3),                       steps::expect_arguments<last_speed_segment>(3),
};
inline constexpr auto enable_speed_segments = joined(before_enable, speed_by_segments, enable_now, until_in_speed);

inline constexpr step torque_by_bus[] = {
    steps::write<mode_of_operation>(control_mode::torque),           steps::expect<mode_of_operation>(control_mode::torque),
    steps::write<main_torque_source>(torque_source::digital),        steps::expect<main_torque_source>(torque_source::digital),
    steps::write<torque_command_selection>(command_selection::main), steps::expect<torque_command_selection>(command_selection::main),
};
inline constexpr auto enable_torque = joined(before_enable, torque_by_bus, enable_now, until_in_torque);

/// Argument 3: where the positions come from. "Completed" shall need a command that has ended, not only a
/// small deviation, which a move that has hardly begun has as well.
inline constexpr step position_by_bus_or_segments[] = {
    steps::write<mode_of_operation>(control_mode::position), steps::expect<mode_of_operation>(control_mode::position),
    steps::write_arguments<position_command_source>(3),      steps::expect_arguments<position_command_source>(3),
    steps::write<positioning_completed_condition>(completed_condition::deviation_and_command),
    steps::expect<positioning_completed_condition>(completed_condition::deviation_and_command),
    steps::fetch<position_segment_type>(0),
};
inline constexpr auto enable_position = joined(before_enable, position_by_bus_or_segments, enable_now, until_in_position);

// Stopping

inline constexpr step disable[] = {servo_off, read_back_inputs, until_standstill, until_power_off};
/// Writing the marker hides a restart before it, so that it is read first, as the frame before. Meanwhile another stop
/// acts, by the mode. A drive without the marker has restarted: it is stopped as one of which nothing is known. Read
/// back is the marker too: a stop without it begins again.
inline constexpr step has_kept_marker = steps::expect_bits<virtual_input_levels>(terminal::marker, terminal::marker, errc::needs_init);
inline constexpr step disable_marked[]         = {stop_by_targets, has_kept_marker, servo_off_marked, has_marker, until_standstill, until_power_off};
inline constexpr step disable_marked_torque[]  = {zero_torque, has_kept_marker, servo_off_marked, has_marker, until_standstill, until_power_off};
inline constexpr step disable_marked_at_once[] = {stop_at_once, has_kept_marker, servo_off_marked, has_marker, until_standstill, until_power_off};
// Read back, since a late acknowledgement of the speed before it looks like the stop's own.
inline constexpr step halt_speed[]  = {stop_by_targets, read_back_speed, until_standstill};
inline constexpr step halt_torque[] = {zero_torque, read_back_torque, until_standstill};
/// A jog also loses its input; with targets of zero it stands before. Argument 0: P31-00 as it is; 1:
/// without.
inline constexpr step halt_jog[] = {
    stop_by_targets, read_back_speed, inputs_are_known,
    steps::write_arguments<virtual_input_levels>(1), steps::expect_arguments<virtual_input_levels>(1),
    steps::expect_zero<target_speed, jog_speed>(errc::needs_init), // a restart brings others back
    until_standstill, wears_nothing,
};
/// Every means, for a drive of which nothing is known, or that has a fault.
inline constexpr step stop_all[]   = {servo_off, stop_by_targets, zero_torque, read_back_inputs, until_standstill, until_power_off};
/// The same where no program asks for it. P0D-05 wears nothing, servo off is kept once, and P0C-13 spares the rest.
inline constexpr step stop_all_sparing[] = {
    stop_at_once, servo_off, spare_first[0], stop_by_targets, zero_torque, read_back_inputs, until_standstill, until_power_off};
inline constexpr step stop_all_marked[] = {stop_at_once, stop_by_targets, zero_torque, has_kept_marker, servo_off_marked, has_marker, until_standstill, until_power_off};
/// Whether P0D-05 goes back to 0 by itself is not stated: no old target may be left then.
inline constexpr step quick_stop[] = {stop_at_once, stop_by_targets, zero_torque, until_standstill};
/// Segments would go on by themselves: they end with the servo off.
inline constexpr step quick_stop_of_segments[]  = {stop_at_once, until_standstill, servo_off, read_back_inputs, until_power_off};
inline constexpr step quick_stop_of_marked_segments[] = {stop_at_once, until_standstill, has_kept_marker, servo_off_marked, has_marker, until_power_off};

/// Section 5.2.4, once the power is off: what an emergency stop by the bus leaves ends, then the reset.
inline constexpr step fault_reset[] = {
    inputs_are_off, stop_by_targets, zero_torque,
    steps::write<emergency_stop>(action::none),
    // Whether P0D-01 falls back by itself is not stated, and a 1 left there might be no command.
    steps::write<alarm_reset>(action::none),
    steps::write<alarm_reset>(action::execute), until_healthy,
    steps::write<alarm_reset>(action::none),
    inputs_are_known, set_marker, // a restart has lost the marker
};
/// Before the set-up no output tells of a fault: the alarm code does, and of a warning too.
inline constexpr step until_no_alarm = steps::until_bits<recorded_alarm>(0xFFFF, 0, state_change_ms, errc::faulted);
inline constexpr step fault_reset_before_set_up[] = {
    inputs_are_off, stop_by_targets, zero_torque, present_alarm,
    steps::write<emergency_stop>(action::none),
    steps::write<alarm_reset>(action::none),
    steps::write<alarm_reset>(action::execute), until_no_alarm,
    steps::write<alarm_reset>(action::none),
};

// Moving

/// The feedback first: a drive that has a fault, or that something else has switched off, does not obey.
inline constexpr step velocity[] = {must_be_healthy, still_enabled, steps::set_arguments<target_speed>(1)};
inline constexpr step torque[]   = {must_be_healthy, still_enabled, steps::set_arguments<target_torque>(1)};

/// Words that a move reads before its start: the position, its deviation from the command, and how far the
/// move goes; and after a start that got no response.
enum move_word : std::uint8_t { before_word, deviation_before_word = 2, after_word = 4, speed_word = 6, inputs_word, way_word, alarm_before_word = 10 };
inline constexpr step post_check[] = {
    steps::fetch<virtual_input_levels>(inputs_word), steps::fetch<actual_speed>(speed_word),
    steps::fetch<absolute_position>(after_word)};

inline constexpr step before_start[] = {
    wears_nothing, must_be_healthy, still_enabled, must_stand, steps::fetch<absolute_position>(before_word),
    steps::fetch<following_error>(deviation_before_word)};
/// Section 6.1.3. Argument 0: P31-00 as it is; 1: with the segment; 2: with the start too; 3: P05-00. A level
/// holds for an exchange that reads it back, 6 ms at least at 57600 Bd.
inline constexpr step start_now[] = {
    inputs_are_known,
    steps::write_arguments<virtual_input_levels>(1), steps::expect_arguments<virtual_input_levels>(1, errc::needs_init),
    steps::write_arguments<virtual_input_levels>(2), steps::expect_arguments<virtual_input_levels>(2, errc::needs_init),
    steps::write_arguments<virtual_input_levels>(1),
    // As `enable` has set it, and not as from the factory: the drive was not restarted between two frames.
    steps::expect_arguments<position_command_source>(3, errc::needs_init),
    wears_nothing,
};
/// The start is so many steps before the end of each of the tables below.
inline constexpr std::size_t steps_from_start = 5;
/// How far segment n goes; the shift chooses it.
inline constexpr step way_of_segment[] = {
    steps::element(steps::fetch<at<position_segment_displacements, 0>>(way_word))};
inline constexpr step way_of_step[] = {steps::fetch<position_step>(way_word)};
/// A limit switch that is active may stand in the way.
inline constexpr step look_at_limits[] = {steps::fetch<selected_fault_record, recorded_alarm>(alarm_before_word), steps::permit()};
inline constexpr auto start         = joined(before_start, way_of_segment, look_at_limits, start_now);
inline constexpr auto start_step    = joined(before_start, way_of_step, look_at_limits, start_now);
/// A run of several segments: its end is not known.
inline constexpr auto start_run     = joined(before_start, start_now);

/// Segments of speed: P31-00 from argument 0 to argument 1 while the motor is energised.
inline constexpr step change_inputs[] = {
    wears_nothing, must_be_healthy, still_enabled, inputs_are_known,
    steps::write_arguments<virtual_input_levels>(1), steps::expect_arguments<virtual_input_levels>(1, errc::needs_init),
    // As `run_speed_segments` has set it, and not as from the factory: no restart.
    steps::expect<speed_command_selection>(command_selection::auxiliary, errc::needs_init),
    wears_nothing,
};
/// Argument 2: the speed.
inline constexpr step jog[] = {
    wears_nothing, must_be_healthy, still_enabled, must_stand,
    steps::write_arguments<jog_speed>(2), steps::expect_arguments<jog_speed>(2), inputs_are_known,
    steps::write_arguments<virtual_input_levels>(1), steps::expect_arguments<virtual_input_levels>(1, errc::needs_init),
    steps::expect_arguments<jog_speed>(2, errc::needs_init), // a restart brings another one back
    wears_nothing,
};

/// Words that show where a move has ended, and why.
enum arrival_word : std::uint8_t { place_word = 10, deviation_word = 12, cause_word = 14 };
inline constexpr step look_at_place[] = {
    steps::fetch<absolute_position>(place_word), steps::fetch<following_error>(deviation_word),
    steps::fetch<selected_fault_record, recorded_alarm>(cause_word)};
/// Completed by the drive's own judgement (P05-20, P05-21), or pressed at its torque limit; and standing.
inline constexpr step until_ended[] = {
    steps::confirm(), steps::until_within<actual_speed>(stillness, step::commanded_limit)};
inline constexpr step same_at_end[] = {steps::same_drive()};
inline constexpr auto wait_reached  = joined(until_ended, look_at_place, same_at_end);
inline constexpr step stand_still[] = {steps::until_within<actual_speed>(stillness, step::commanded_limit), steps::same_drive()};

/// The outputs as they are before a homing: they may show an earlier one.
inline constexpr step look_before_home[] = {steps::fetch<virtual_output_levels>(0)};
inline constexpr step until_homed[]      = {steps::until_bits<virtual_output_levels>(status_flags::homed_bit, status_flags::homed_bit, step::commanded_limit)};
inline constexpr step until_electrical[] = {steps::until_bits<virtual_output_levels>(status_flags::electrical_bit, status_flags::electrical_bit, step::commanded_limit)};
/// The output of the homing before has to fall first.
inline constexpr step until_homed_again[] = {
    steps::until_bits<virtual_output_levels>(status_flags::homed_bit, 0, state_change_ms), until_homed[0]};
inline constexpr step until_electrical_again[] = {
    steps::until_bits<virtual_output_levels>(status_flags::electrical_bit, 0, state_change_ms), until_electrical[0]};
/// Argument 0: P31-00; 1: what to do, P05-30.
inline constexpr step begin_home[] = {
    wears_nothing, must_be_healthy, still_enabled, must_stand, inputs_are_known,
    steps::write_arguments<homing_control>(1)};
inline constexpr std::uint8_t home_step = 5;
inline constexpr step end_home[] = {
    until_standstill, steps::write<homing_control>(homing::off), steps::expect<homing_control>(homing::off),
    still_enabled, steps::same_drive()};
inline constexpr auto home                    = joined(begin_home, until_homed, end_home);
inline constexpr auto home_electrically       = joined(begin_home, until_electrical, end_home);
inline constexpr auto home_again              = joined(begin_home, until_homed_again, end_home);
inline constexpr auto home_electrically_again = joined(begin_home, until_electrical_again, end_home);
/// How the drive shows it is not stated: it is acknowledged, not confirmed.
inline constexpr step set_home[] = {
    wears_nothing, inputs_are_known, must_stand, steps::write<homing_control>(homing::set_home),
    steps::write<homing_control>(homing::off), steps::expect<homing_control>(homing::off),
};

// clang-format on

} // namespace servobus::c630s::routines
