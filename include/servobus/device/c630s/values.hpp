// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: its profile and the values of its enumerated parameters. Those of the terminals are
// in functions.hpp. registers/row.hpp includes it, and the headers beside that include row.hpp. Source: manual
// V24.111, chapter 7; [errata Cn] are in device/errata_c630s.md.
//
//     auto serve(auto& port) { // at the factory's baud rate and address
//         line wire{port, modbus::timing_at(c630s::device::facts.baud)};
//         client servo{wire, node<c630s::device>{1}};
//         return store_if_different<c630s::mode_of_operation>(servo, c630s::control_mode::speed);
//     }
#pragma once

#include <cstdint>

#include <servobus/registers/cached_registers.hpp>
#include <servobus/registers/line_choices.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus::c630s {

/// The C630S: Modbus RTU; factory settings: address 1, 57600 Bd, 8N2. P0C-26 switches the word order of
/// 32-bit values and must be read before such a value is read or written. While P0C-13 is 1, every write
/// wears the EEPROM. The manual states no response time except the delay P0C-25, by default 1 ms; the
/// profile has a response limit of 100 ms, which a longer delay exceeds. The manual does not state the
/// longest request either; the profile has 16 registers.
struct device {
    static constexpr exception_meaning exceptions[] = {
        {1, "illegal command"}, {2, "illegal data address"}, {3, "illegal data"}, {4, "refused"}};
    static constexpr profile facts{
        .name = "c630s",
        .max_read = 16,
        .max_write = 16,
        .lowest_address = 1,
        .highest_address = 247,
        .word_order = word_order::unknown,
        .word_order_register = 0x0C1A,
        .eeprom_switch = 0x0C0D,
        .baud = 57600,
        .format = character_format::n82,
        .limits = {.response = milliseconds(100), .echoes_byte_count = true}, // [errata C2]
        .exceptions = exceptions};
    /// Lists what the facade relies on, by groups: P02 brake delays and factory settings; P03 wired inputs; P05 gears;
    /// P06 and P07 limits; P0C virtual terminals, EEPROM switch, response delay, word order; P0D-00 restart; P17 and
    /// P31 virtual terminals. Modes, their sources and P05-30 are not among them: each enable sets them.
    static constexpr address_range cached_by_facade[] = {
        {0x0209, 0x020A}, {0x021F, 0x021F}, {0x0300, 0x0311}, {0x0322, 0x0323}, {0x0502, 0x0503},
        {0x0507, 0x050E}, {0x0607, 0x0609}, {0x0709, 0x070A}, {0x0C09, 0x0C0D}, {0x0C19, 0x0C1A},
        {0x0D00, 0x0D00}, {0x1700, 0x1740}, {0x3100, 0x3100}};
    /// P0C-02 and P0C-03, immediately; kept while P0C-13 is 1, as by `change_line`.
    static constexpr rate_choice rates[] = {{2'400, 0},  {4'800, 1},  {9'600, 2},
                                            {19'200, 3}, {38'400, 4}, {57'600, 5}};
    static constexpr format_choice formats[] = {{character_format::n82, 0},
                                                {character_format::e81, 1},
                                                {character_format::o81, 2},
                                                {character_format::n81, 3}};
    static constexpr line_choices on_line{
        .rates = rates, .formats = formats, .rate_register = 0x0C02, .format_register = 0x0C03};
};

/// P03-38, P03-43, P0A-03, P0A-12, P0A-33, P0C-09, P0C-11, P0C-13
enum class off_on : std::uint16_t { off = 0, on = 1 };

/// P0D-00, P0D-01, P0D-03, P0D-05
enum class action : std::uint16_t { none = 0, execute = 1 };

// Control: P02

/// P02-00. Inputs switch between modes that are joined by "or": FunIN.10 between two, FunIN.11 between three.
enum class control_mode : std::uint16_t {
    speed = 0,
    position = 1,
    torque = 2,
    torque_or_speed = 3,
    speed_or_position = 4,
    torque_or_position = 5,
    torque_or_speed_or_position = 6,
};

/// P02-01. Another table of the manual has a value 2 without an explanation [errata C32].
enum class encoder_kind : std::uint16_t { incremental = 0, absolute = 1 };

/// P02-02: the direction of rotation that counts as forward.
enum class forward_rotation : std::uint16_t { counterclockwise = 0, clockwise = 1 };

/// P02-03: the phase of the pulse output while the motor turns forward [errata C54].
enum class pulse_phase : std::uint16_t { a_leads_b = 0, a_lags_b = 1 };

/// P02-05, P02-06, P02-08: how the motor stops; the shaft is free afterwards.
enum class stop_mode : std::uint16_t { coast = 0, zero_speed = 1 };

/// P02-07: how the motor stops at a limit switch.
enum class overtravel_stop : std::uint16_t {
    coast = 0,               ///< the shaft is free afterwards
    zero_speed_and_lock = 1, ///< the position is held
    zero_speed = 2,          ///< the shaft is free afterwards
};

/// P02-15
enum class warning_display : std::uint16_t { shown = 0, hidden = 1 };

/// P02-25
enum class braking_resistor : std::uint16_t {
    internal = 0,
    external_natural_cooling = 1,
    external_forced_cooling = 2,
    none = 3, ///< the capacitors alone take the energy
};

/// P02-31. The factory defaults include address 1, 57600 Bd and 8N2, and take effect after a restart
/// [errata C39].
enum class initialisation : std::uint16_t { none = 0, factory_defaults = 1, clear_fault_records = 2 };

// Position: P05

/// P05-00
enum class position_source : std::uint16_t { pulses = 0, step = 1, segments = 2 };

/// P05-15. The manual gives two different numbers for the quadrature signal [errata C31].
enum class pulse_form : std::uint16_t {
    pulse_and_direction_positive = 0,
    pulse_and_direction_negative = 1,
    quadrature_by_7_5 = 2,
    quadrature_by_6_1_2 = 3,
    cw_and_ccw = 4,
};

/// P05-16: when the following error is cleared.
enum class deviation_clearing : std::uint16_t {
    servo_off_or_fault = 0,
    fault_or_warning = 1,
    servo_off_or_input = 2, ///< FunIN.35
};

/// P05-19
enum class speed_feedforward : std::uint16_t { none = 0, internal = 1, ai1 = 2, ai2 = 3 };

/// P05-20: when FunOUT.5 is active: while the deviation is below P05-21 and a further condition holds.
enum class completed_condition : std::uint16_t {
    deviation = 0,                      ///< no further condition
    deviation_and_filtered_command = 1, ///< the filtered command is zero
    deviation_and_command = 2,          ///< the command before the filter is zero
    deviation_held = 3,                 ///< the filtered command is zero; then active for at least P05-60
};

/// P05-30. 1, 2, 3 and 8 choose what starts homing later; 4, 5 and 6 act immediately.
enum class homing : std::uint16_t {
    off = 0,
    by_input = 1,            ///< FunIN.32
    electrical_by_input = 2, ///< FunIN.32
    at_power_on = 3,
    start = 4,
    start_electrical = 5,
    set_home = 6,          ///< the current position is home
    set_home_by_input = 8, ///< FunIN.38
};

/// P05-31: the direction of the search, the signal that slows the motor down, and home.
enum class homing_mode : std::uint16_t {
    forward_home_switch = 0,
    reverse_home_switch = 1,
    forward_z = 2,
    reverse_z = 3,
    forward_home_switch_then_z = 4,
    reverse_home_switch_then_z = 5,
    forward_positive_limit = 6,
    reverse_negative_limit = 7,
    forward_positive_limit_then_z = 8,
    reverse_negative_limit_then_z = 9,
};

/// P05-38
enum class pulse_output : std::uint16_t { divided_encoder = 0, pulse_command = 1, none = 2 };

/// P05-39: when a change of the electronic gear takes effect.
enum class gear_switching : std::uint16_t {
    at_zero_command = 0, ///< after the command has been zero for 2.5 ms
    at_once = 1,
};

/// P05-43
enum class pulse_edge : std::uint16_t { falling = 0, rising = 1 };

// Speed and torque: P06, P07

/// P06-00 (without the segments), P06-01
enum class speed_source : std::uint16_t { digital = 0, ai1 = 1, ai2 = 2, segments = 5 };

/// P07-00, P07-01
enum class torque_source : std::uint16_t { digital = 0, ai1 = 1, ai2 = 2 };

/// P06-02 (without the bus), P07-02
enum class command_selection : std::uint16_t {
    main = 0,
    auxiliary = 1,
    sum = 2,
    switched = 3, ///< by FunIN.4
    bus = 4,      ///< no parameter for a command by the bus is documented [errata C13]
};

/// P06-11
enum class torque_feedforward : std::uint16_t { none = 0, internal = 1 };

/// P07-07
enum class torque_limit : std::uint16_t {
    internal = 0,
    external = 1,             ///< by FunIN.16 and FunIN.17
    analogue = 2,             ///< the input of P07-08
    external_or_analogue = 3, ///< the smaller of both; by FunIN.16 and FunIN.17
    internal_or_analogue = 4, ///< by FunIN.16 and FunIN.17
};

/// P07-08, P07-18
enum class analogue_input : std::uint16_t { ai1 = 1, ai2 = 2 };

/// P07-17
enum class speed_limit : std::uint16_t {
    internal = 0,
    analogue = 1, ///< the input of P07-18
    by_input = 2, ///< FunIN.36 chooses between P07-19 and P07-20
};

// Gains and tuning: P08, P09

/// P08-08
enum class gain_mode : std::uint16_t {
    first_set = 0, ///< a terminal switches between P and PI [errata C21]
    switched = 1,  ///< by the condition of P08-09
};

/// P08-09. 6 to 10 are for position control only.
enum class gain_condition : std::uint16_t {
    first_set = 0,
    by_input = 1, ///< FunIN.3
    torque_command = 2,
    speed_command = 3,
    speed_command_change = 4,
    speed_command_thresholds = 5,
    following_error = 6,
    position_command = 7,
    positioning_completed = 8,
    actual_speed = 9,
    position_command_and_actual_speed = 10,
};

/// P08-22: the number of values that are averaged.
enum class averaging : std::uint16_t { none = 0, of_2 = 1, of_4 = 2, of_8 = 3, of_16 = 4 };

/// P09-02
enum class adaptive_notch : std::uint16_t {
    fixed = 0,
    third = 1,
    third_and_fourth = 2,
    test_only = 3, ///< the resonance is shown in P09-24
    restore = 4,   ///< sets the third and fourth notch to the factory defaults
};

/// P09-04: how the frequency of low-frequency suppression is set.
enum class vibration_frequency : std::uint16_t { manual = 0, automatic = 1 };

/// P09-05
enum class inertia_motion : std::uint16_t { triangular_wave = 0, jog = 1 };

// Protection: P0A

/// P0A-00
enum class phase_loss : std::uint16_t { fault = 0, fault_and_warning = 1, off = 2 };

/// P0A-17
enum class position_unit : std::uint16_t { encoder = 0, reference = 1 };

/// P0A-26, P0A-36
enum class masking : std::uint16_t { unmasked = 0, masked = 1 };

// Monitoring, communication, auxiliary functions: P0B, P0C, P0D

/// P0B-33
enum class fault_record : std::uint16_t {
    current = 0,
    last = 1,
    second_last = 2,
    third_last = 3,
    fourth_last = 4,
    fifth_last = 5,
    sixth_last = 6,
    seventh_last = 7,
    eighth_last = 8,
    ninth_last = 9,
};

/// P0C-02
enum class baud_rate : std::uint16_t {
    baud_2400 = 0,
    baud_4800 = 1,
    baud_9600 = 2,
    baud_19200 = 3,
    baud_38400 = 4,
    baud_57600 = 5,
};

/// P0C-03: parity and stop bits.
enum class serial_format : std::uint16_t { n82 = 0, e81 = 1, o81 = 2, n81 = 3 };

/// P0C-14. The manual does not state what the register holds without an error.
enum class bus_error : std::uint16_t {
    illegal_command = 1,
    illegal_data_address = 2,
    illegal_data = 3,
    device_failure = 4, ///< "refused" in another table [errata C6]
};

/// P0C-26
enum class word_order_setting : std::uint16_t { high_first = 0, low_first = 1 };

/// P0C-30. The manual does not describe the error frame of the old protocol [errata C7].
enum class error_frame : std::uint16_t { old_protocol = 0, new_protocol = 1 };

/// P0D-17
enum class forcing : std::uint16_t { none = 0, inputs_only = 1, outputs_only = 2, both = 3 };

/// P0D-20. The manual describes 1 and 2 in the same words [errata C40].
enum class encoder_reset : std::uint16_t { none = 0, fault_perhaps_turns = 1, fault_and_turns = 2 };

// Segments: P11, P12

/// P11-00, P12-00 (without `sequential`)
enum class segment_mode : std::uint16_t {
    single = 0, ///< runs the segments once, then stops
    cyclic = 1,
    by_input = 2, ///< FunIN.6 to FunIN.9 choose the segment
    sequential = 3,
};

/// P11-02: what happens to the segments that a stop left incomplete. No effect in `segment_mode::by_input`.
enum class segment_remainder : std::uint16_t { finish = 0, restart = 1 };

/// P11-03
enum class position_time_unit : std::uint16_t { milliseconds = 0, seconds = 1 };

/// P11-04
enum class displacement_type : std::uint16_t { relative = 0, absolute = 1 };

/// P12-02
enum class speed_time_unit : std::uint16_t { seconds = 0, minutes = 1 };

/// P12-22, 25 .. 67: which of the four pairs of ramp times of P12-03 to P12-10 applies.
enum class segment_ramp : std::uint16_t { none = 0, ramp_1 = 1, ramp_2 = 2, ramp_3 = 3, ramp_4 = 4 };

} // namespace servobus::c630s
