// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: names of the values and bits of the C630S's registers. c630s/catalogue.hpp includes it;
// programs on a target do not. Source: the enumerations of c630s/values.hpp and c630s/functions.hpp, and
// c630s/alarms.hpp.
//
//     for (const named_value& choice : c630s::names::control_mode_names) // P02-00
//         std::printf("%2d %s\n", choice.value, choice.name);
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <servobus/device/c630s/alarms.hpp>
#include <servobus/registers/catalogue.hpp>

namespace servobus::c630s::names {

// clang-format off
inline constexpr named_value off_on_names[] = {
    code(0, "off"), code(1, "on"),
};
inline constexpr named_value action_names[] = {
    code(0, "none"), code(1, "execute"),
};
inline constexpr named_value control_mode_names[] = {
    code(0, "speed"), code(1, "position"), code(2, "torque"), code(3, "torque or speed"),
    code(4, "speed or position"), code(5, "torque or position"), code(6, "torque or speed or position"),
};
inline constexpr named_value encoder_kind_names[] = {
    code(0, "incremental"), code(1, "absolute"),
};
inline constexpr named_value forward_rotation_names[] = {
    code(0, "counterclockwise"), code(1, "clockwise"),
};
inline constexpr named_value pulse_phase_names[] = {
    code(0, "a leads b"), code(1, "a lags b"),
};
inline constexpr named_value stop_mode_names[] = {
    code(0, "coast"), code(1, "zero speed"),
};
inline constexpr named_value overtravel_stop_names[] = {
    code(0, "coast"), code(1, "zero speed and lock"), code(2, "zero speed"),
};
inline constexpr named_value warning_display_names[] = {
    code(0, "shown"), code(1, "hidden"),
};
inline constexpr named_value braking_resistor_names[] = {
    code(0, "internal"), code(1, "external natural cooling"), code(2, "external forced cooling"),
    code(3, "none"),
};
inline constexpr named_value initialisation_names[] = {
    code(0, "none"), code(1, "factory defaults"), code(2, "clear fault records"),
};
inline constexpr named_value position_source_names[] = {
    code(0, "pulses"), code(1, "step"), code(2, "segments"),
};
inline constexpr named_value pulse_form_names[] = {
    code(0, "pulse and direction positive"), code(1, "pulse and direction negative"),
    code(2, "quadrature by 7.5"), code(3, "quadrature by 6.1.2"), code(4, "cw and ccw"),
};
inline constexpr named_value deviation_clearing_names[] = {
    code(0, "servo off or fault"), code(1, "fault or warning"), code(2, "servo off or input"),
};
inline constexpr named_value speed_feedforward_names[] = {
    code(0, "none"), code(1, "internal"), code(2, "ai1"), code(3, "ai2"),
};
inline constexpr named_value completed_condition_names[] = {
    code(0, "deviation"), code(1, "deviation and filtered command"), code(2, "deviation and command"),
    code(3, "deviation held"),
};
inline constexpr named_value homing_names[] = {
    code(0, "off"), code(1, "by input"), code(2, "electrical by input"), code(3, "at power on"),
    code(4, "start"), code(5, "start electrical"), code(6, "set home"), code(8, "set home by input"),
};
inline constexpr named_value homing_mode_names[] = {
    code(0, "forward home switch"), code(1, "reverse home switch"), code(2, "forward z"),
    code(3, "reverse z"), code(4, "forward home switch then z"), code(5, "reverse home switch then z"),
    code(6, "forward positive limit"), code(7, "reverse negative limit"),
    code(8, "forward positive limit then z"), code(9, "reverse negative limit then z"),
};
inline constexpr named_value pulse_output_names[] = {
    code(0, "divided encoder"), code(1, "pulse command"), code(2, "none"),
};
inline constexpr named_value gear_switching_names[] = {
    code(0, "at zero command"), code(1, "at once"),
};
inline constexpr named_value pulse_edge_names[] = {
    code(0, "falling"), code(1, "rising"),
};
inline constexpr named_value speed_source_names[] = {
    code(0, "digital"), code(1, "ai1"), code(2, "ai2"), code(5, "segments"),
};
inline constexpr named_value torque_source_names[] = {
    code(0, "digital"), code(1, "ai1"), code(2, "ai2"),
};
inline constexpr named_value command_selection_names[] = {
    code(0, "main"), code(1, "auxiliary"), code(2, "sum"), code(3, "switched"), code(4, "bus"),
};
inline constexpr named_value torque_feedforward_names[] = {
    code(0, "none"), code(1, "internal"),
};
inline constexpr named_value torque_limit_names[] = {
    code(0, "internal"), code(1, "external"), code(2, "analogue"), code(3, "external or analogue"),
    code(4, "internal or analogue"),
};
inline constexpr named_value analogue_input_names[] = {
    code(1, "ai1"), code(2, "ai2"),
};
inline constexpr named_value speed_limit_names[] = {
    code(0, "internal"), code(1, "analogue"), code(2, "by input"),
};
inline constexpr named_value gain_mode_names[] = {
    code(0, "first set"), code(1, "switched"),
};
inline constexpr named_value gain_condition_names[] = {
    code(0, "first set"), code(1, "by input"), code(2, "torque command"), code(3, "speed command"),
    code(4, "speed command change"), code(5, "speed command thresholds"), code(6, "following error"),
    code(7, "position command"), code(8, "positioning completed"), code(9, "actual speed"),
    code(10, "position command and actual speed"),
};
inline constexpr named_value averaging_names[] = {
    code(0, "none"), code(1, "of 2"), code(2, "of 4"), code(3, "of 8"), code(4, "of 16"),
};
inline constexpr named_value adaptive_notch_names[] = {
    code(0, "fixed"), code(1, "third"), code(2, "third and fourth"), code(3, "test only"),
    code(4, "restore"),
};
inline constexpr named_value vibration_frequency_names[] = {
    code(0, "manual"), code(1, "automatic"),
};
inline constexpr named_value inertia_motion_names[] = {
    code(0, "triangular wave"), code(1, "jog"),
};
inline constexpr named_value phase_loss_names[] = {
    code(0, "fault"), code(1, "fault and warning"), code(2, "off"),
};
inline constexpr named_value position_unit_names[] = {
    code(0, "encoder"), code(1, "reference"),
};
inline constexpr named_value masking_names[] = {
    code(0, "unmasked"), code(1, "masked"),
};
inline constexpr named_value fault_record_names[] = {
    code(0, "current"), code(1, "last"), code(2, "second last"), code(3, "third last"),
    code(4, "fourth last"), code(5, "fifth last"), code(6, "sixth last"), code(7, "seventh last"),
    code(8, "eighth last"), code(9, "ninth last"),
};
inline constexpr named_value baud_rate_names[] = {
    code(0, "2400 Bd"), code(1, "4800 Bd"), code(2, "9600 Bd"), code(3, "19200 Bd"), code(4, "38400 Bd"),
    code(5, "57600 Bd"),
};
inline constexpr named_value serial_format_names[] = {
    code(0, "8N2"), code(1, "8E1"), code(2, "8O1"), code(3, "8N1"),
};
inline constexpr named_value bus_error_names[] = {
    code(1, "illegal command"), code(2, "illegal data address"), code(3, "illegal data"),
    code(4, "device failure"),
};
inline constexpr named_value word_order_setting_names[] = {
    code(0, "high first"), code(1, "low first"),
};
inline constexpr named_value error_frame_names[] = {
    code(0, "old protocol"), code(1, "new protocol"),
};
inline constexpr named_value forcing_names[] = {
    code(0, "none"), code(1, "inputs only"), code(2, "outputs only"), code(3, "both"),
};
inline constexpr named_value encoder_reset_names[] = {
    code(0, "none"), code(1, "fault perhaps turns"), code(2, "fault and turns"),
};
inline constexpr named_value segment_mode_names[] = {
    code(0, "single"), code(1, "cyclic"), code(2, "by input"), code(3, "sequential"),
};
inline constexpr named_value segment_remainder_names[] = {
    code(0, "finish"), code(1, "restart"),
};
inline constexpr named_value position_time_unit_names[] = {
    code(0, "milliseconds"), code(1, "seconds"),
};
inline constexpr named_value displacement_type_names[] = {
    code(0, "relative"), code(1, "absolute"),
};
inline constexpr named_value speed_time_unit_names[] = {
    code(0, "seconds"), code(1, "minutes"),
};
inline constexpr named_value segment_ramp_names[] = {
    code(0, "none"), code(1, "ramp 1"), code(2, "ramp 2"), code(3, "ramp 3"), code(4, "ramp 4"),
};
inline constexpr named_value input_function_names[] = {
    code(0, "none"), code(1, "servo on"), code(2, "alarm reset"), code(3, "gain selection"),
    code(4, "command selection"), code(5, "segment direction"), code(6, "segment selection 1"),
    code(7, "segment selection 2"), code(8, "segment selection 3"), code(9, "segment selection 4"),
    code(10, "mode selection 1"), code(11, "mode selection 2"), code(12, "zero clamp"),
    code(13, "position command inhibit"), code(14, "positive overtravel"), code(15, "negative overtravel"),
    code(16, "positive torque limit"), code(17, "negative torque limit"), code(18, "jog forward"),
    code(19, "jog reverse"), code(20, "step enable"), code(21, "handwheel multiplier 1"),
    code(22, "handwheel multiplier 2"), code(23, "handwheel enable"), code(24, "gear selection"),
    code(25, "torque direction"), code(26, "speed direction"), code(27, "position direction"),
    code(28, "position segment start"), code(31, "home switch"), code(32, "homing start"),
    code(33, "interrupt inhibit"), code(34, "emergency stop"), code(35, "clear following error"),
    code(36, "speed limit selection"), code(37, "pulse inhibit"), code(38, "set home"),
};
inline constexpr named_value output_function_names[] = {
    code(0, "none"), code(1, "servo ready"), code(2, "rotating"), code(3, "zero speed"),
    code(4, "speed coincidence"), code(5, "positioning completed"), code(6, "positioning near"),
    code(7, "torque limited"), code(8, "speed limited"), code(9, "brake"), code(10, "warning"),
    code(11, "fault"), code(12, "alarm code 1"), code(13, "alarm code 2"), code(14, "alarm code 3"),
    code(16, "home attained"), code(17, "electrical home attained"), code(18, "torque reached"),
    code(19, "speed reached"), code(20, "angle identified"),
};
inline constexpr named_value input_logic_names[] = {
    code(0, "low level"), code(1, "high level"), code(2, "rising edge"), code(3, "falling edge"),
    code(4, "both edges"),
};
inline constexpr named_value output_logic_names[] = {
    code(0, "low"), code(1, "high"),
};
inline constexpr named_value virtual_input_logic_names[] = {
    code(0, "one"), code(1, "rising edge"),
};
inline constexpr named_value virtual_output_logic_names[] = {
    code(0, "one"), code(1, "zero"),
};
inline constexpr named_value input_function_bits_1_to_16[] = {
    named_bit(0x0001, "servo on"), named_bit(0x0002, "alarm reset"), named_bit(0x0004, "gain selection"),
    named_bit(0x0008, "command selection"), named_bit(0x0010, "segment direction"), named_bit(0x0020, "segment selection 1"),
    named_bit(0x0040, "segment selection 2"), named_bit(0x0080, "segment selection 3"),
    named_bit(0x0100, "segment selection 4"), named_bit(0x0200, "mode selection 1"), named_bit(0x0400, "mode selection 2"),
    named_bit(0x0800, "zero clamp"), named_bit(0x1000, "position command inhibit"), named_bit(0x2000, "positive overtravel"),
    named_bit(0x4000, "negative overtravel"), named_bit(0x8000, "positive torque limit"),
};
inline constexpr named_value input_function_bits_17_to_32[] = {
    named_bit(0x0001, "negative torque limit"), named_bit(0x0002, "jog forward"), named_bit(0x0004, "jog reverse"),
    named_bit(0x0008, "step enable"), named_bit(0x0010, "handwheel multiplier 1"),
    named_bit(0x0020, "handwheel multiplier 2"), named_bit(0x0040, "handwheel enable"), named_bit(0x0080, "gear selection"),
    named_bit(0x0100, "torque direction"), named_bit(0x0200, "speed direction"), named_bit(0x0400, "position direction"),
    named_bit(0x0800, "position segment start"), named_bit(0x4000, "home switch"), named_bit(0x8000, "homing start"),
};
inline constexpr named_value input_function_bits_33_to_48[] = {
    named_bit(0x0001, "interrupt inhibit"), named_bit(0x0002, "emergency stop"),
    named_bit(0x0004, "clear following error"), named_bit(0x0008, "speed limit selection"),
    named_bit(0x0010, "pulse inhibit"), named_bit(0x0020, "set home"),
};
inline constexpr named_value output_function_bits_1_to_16[] = {
    named_bit(0x0001, "servo ready"), named_bit(0x0002, "rotating"), named_bit(0x0004, "zero speed"),
    named_bit(0x0008, "speed coincidence"), named_bit(0x0010, "positioning completed"), named_bit(0x0020, "positioning near"),
    named_bit(0x0040, "torque limited"), named_bit(0x0080, "speed limited"), named_bit(0x0100, "brake"),
    named_bit(0x0200, "warning"), named_bit(0x0400, "fault"), named_bit(0x0800, "alarm code 1"), named_bit(0x1000, "alarm code 2"),
    named_bit(0x2000, "alarm code 3"), named_bit(0x8000, "home attained"),
};
inline constexpr named_value output_function_bits_17_to_32[] = {
    named_bit(0x0001, "electrical home attained"), named_bit(0x0002, "torque reached"), named_bit(0x0004, "speed reached"),
    named_bit(0x0008, "angle identified"),
};
inline constexpr named_value input_bits[] = {
    named_bit(0x0001, "di1"), named_bit(0x0002, "di2"), named_bit(0x0004, "di3"), named_bit(0x0008, "di4"), named_bit(0x0010, "di5"),
    named_bit(0x0020, "di6"), named_bit(0x0040, "di7"), named_bit(0x0080, "di8"),
};
inline constexpr named_value output_bits[] = {
    named_bit(0x0001, "do1"), named_bit(0x0002, "do2"), named_bit(0x0004, "do3"), named_bit(0x0008, "do4"), named_bit(0x0010, "do5"),
    named_bit(0x0020, "do6"),
};
inline constexpr named_value virtual_input_bits[] = {
    named_bit(0x0001, "vdi1"), named_bit(0x0002, "vdi2"), named_bit(0x0004, "vdi3"), named_bit(0x0008, "vdi4"), named_bit(0x0010, "vdi5"),
    named_bit(0x0020, "vdi6"), named_bit(0x0040, "vdi7"), named_bit(0x0080, "vdi8"), named_bit(0x0100, "vdi9"),
    named_bit(0x0200, "vdi10"), named_bit(0x0400, "vdi11"), named_bit(0x0800, "vdi12"), named_bit(0x1000, "vdi13"),
    named_bit(0x2000, "vdi14"), named_bit(0x4000, "vdi15"), named_bit(0x8000, "vdi16"),
};
inline constexpr named_value virtual_output_bits[] = {
    named_bit(0x0001, "vdo1"), named_bit(0x0002, "vdo2"), named_bit(0x0004, "vdo3"), named_bit(0x0008, "vdo4"), named_bit(0x0010, "vdo5"),
    named_bit(0x0020, "vdo6"), named_bit(0x0040, "vdo7"), named_bit(0x0080, "vdo8"), named_bit(0x0100, "vdo9"),
    named_bit(0x0200, "vdo10"), named_bit(0x0400, "vdo11"), named_bit(0x0800, "vdo12"), named_bit(0x1000, "vdo13"),
    named_bit(0x2000, "vdo14"), named_bit(0x4000, "vdo15"), named_bit(0x8000, "vdo16"),
};
// clang-format on

/// The names of P0B-34: all alarms, and 0 for none.
inline constexpr auto alarm_names = [] {
    std::array<named_value, std::size(alarms) + 1> all{code(0, "none")};
    std::size_t used = 1;
    for (const alarm& a : alarms) all[used++] = code(a.code, a.name);
    return all;
}();

} // namespace servobus::c630s::names
