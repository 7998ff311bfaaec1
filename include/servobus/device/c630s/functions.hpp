// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: the functions of its inputs (FunIN) and outputs (FunOUT), the logic of terminals,
// and words with a bit for each terminal or for each function. A virtual terminal (VDI, VDO) is one that the
// bus sets or reads. registers/row.hpp includes it, and the headers beside that include row.hpp. Source: manual
// V24.111, sections 6.4, 7.3, 7.4, 7.12 and 7.16 to 7.18; [errata Cn] are in device/errata_c630s.md.
//
//     constexpr auto levels = c630s::inputs::from_word(0x0005); // P0B-03 as read
//     static_assert(levels.has(1) && !levels.has(2) && levels.has(3));
#pragma once

#include <cstdint>

#include <servobus/registers/wire.hpp>

namespace servobus::c630s {

/// FunIN.n: P03-02, 04 .. 16 and, except for the last, P17-00, 02 .. 30. 29 and 30 do not exist [errata C28].
enum class input_function : std::uint16_t {
    none = 0,
    servo_on = 1,            ///< S-ON; a level. A new terminal or logic takes effect at the next power-on
    alarm_reset = 2,         ///< ALM-RST; an edge. It resets faults only while the servo is off
    gain_selection = 3,      ///< GAIN-SEL [errata C21]
    command_selection = 4,   ///< CMD-SEL: main or auxiliary command
    segment_direction = 5,   ///< DIR-SEL: reverses the speed segments
    segment_selection_1 = 6, ///< CMD1, the lowest of the four bits of segment - 1
    segment_selection_2 = 7,
    segment_selection_3 = 8,
    segment_selection_4 = 9,
    mode_selection_1 = 10,         ///< M1-SEL: between two control modes; which level is which is not stated
    mode_selection_2 = 11,         ///< M2-SEL: between three control modes; the levels are not stated
    zero_clamp = 12,               ///< ZCLAMP
    position_command_inhibit = 13, ///< INHIBIT; a level
    positive_overtravel = 14,      ///< P-OT, the positive limit switch
    negative_overtravel = 15,      ///< N-OT, the negative limit switch
    positive_torque_limit = 16,    ///< P-CL: the external limit, see P07-07
    negative_torque_limit = 17,    ///< N-CL
    jog_forward = 18,              ///< JOGCMD+
    jog_reverse = 19,              ///< JOGCMD-
    step_enable = 20,              ///< POSSTEP: makes the step of P05-05; an edge
    handwheel_multiplier_1 = 21,   ///< HX1: 10 times
    handwheel_multiplier_2 = 22,   ///< HX2: 100 times
    handwheel_enable = 23,         ///< HX_EN
    gear_selection = 24,           ///< GEAR_SEL: the second electronic gear
    torque_direction = 25,         ///< TOQDirSel
    speed_direction = 26,          ///< SPDDirSel
    position_direction = 27,       ///< POSDirSel
    position_segment_start = 28,   ///< PosInSen: starts the position segments [errata C23]
    home_switch = 31,              ///< HomeSwitch; a level
    homing_start = 32,             ///< HomingStart; an edge
    interrupt_inhibit = 33,        ///< XintInhibit: no interrupt positioning; a level
    emergency_stop = 34,           ///< EmergencyStop: zero speed, then the position is held
    clear_following_error = 35,    ///< ClrPosErr; an edge [errata C25]
    speed_limit_selection = 36,    ///< V_LmtSel: P07-19 instead of P07-20, if P07-17 is 2
    pulse_inhibit = 37,            ///< PulseInhibit
    set_home = 38,                 ///< the current position is home; an edge [errata C14, C24]
};

/// FunOUT.n: P04-00, 02 .. 10 and P17-33, 35 .. 63. 15, 21 and 22 do not exist [errata C14, C28].
enum class output_function : std::uint16_t {
    none = 0,
    servo_ready = 1,               ///< S-RDY: the drive would accept S-ON
    rotating = 2,                  ///< TGON: at or above P06-16
    zero_speed = 3,                ///< ZERO: at or below P06-19 [errata C22]
    speed_coincidence = 4,         ///< V-CMP: the speed deviates by less than P06-17
    positioning_completed = 5,     ///< COIN: within P05-21
    positioning_near = 6,          ///< NEAR: within P05-22
    torque_limited = 7,            ///< C-LT
    speed_limited = 8,             ///< V-LT
    brake = 9,                     ///< BK: active releases the brake
    warning = 10,                  ///< WARN
    fault = 11,                    ///< ALM
    alarm_code_1 = 12,             ///< ALMO1; the manual does not state the code of the three outputs
    alarm_code_2 = 13,             ///< ALMO2
    alarm_code_3 = 14,             ///< ALMO3
    home_attained = 16,            ///< HomeAttain
    electrical_home_attained = 17, ///< ElecHomeAttain
    torque_reached = 18,           ///< ToqReach
    speed_reached = 19,            ///< V-Arr
    angle_identified = 20,         ///< AngIntRdy
};

/// P03-03, 05 .. 17: what makes an input active.
enum class input_logic : std::uint16_t {
    low_level = 0,
    high_level = 1,
    rising_edge = 2,
    falling_edge = 3,
    both_edges = 4,
};

/// P04-01, 03 .. 11: the level of an active output.
enum class output_logic : std::uint16_t {
    low = 0,  ///< the optocoupler conducts
    high = 1, ///< the optocoupler does not conduct
};

/// P17-01, 03 .. 31: what makes a virtual input active.
enum class virtual_input_logic : std::uint16_t { one = 0, rising_edge = 1 };

/// P17-34, 36 .. 64: the value of an active virtual output.
enum class virtual_output_logic : std::uint16_t { one = 0, zero = 1 };

/// A set of terminals of one kind. Terminal n, counted from 1, is bit n - 1.
template <class Kind> struct terminal_set {
    std::uint16_t bits = 0;

    static constexpr terminal_set from_word(std::uint16_t word) { return {word}; }
    constexpr std::uint16_t to_word() const { return bits; }

    /// True if terminal `number`, 1..16, is set.
    constexpr bool has(unsigned number) const { return (bits & bit_of(number)) != 0; }
    /// This set with terminal `number`, 1..16, added; any other number adds nothing.
    constexpr terminal_set with(unsigned number) const {
        return {static_cast<std::uint16_t>(bits | bit_of(number))};
    }
    /// This set without terminal `number`, 1..16; any other number removes nothing.
    constexpr terminal_set without(unsigned number) const {
        return {static_cast<std::uint16_t>(bits & ~bit_of(number))};
    }
    friend constexpr bool operator==(terminal_set, terminal_set) = default;

  private:
    static constexpr unsigned bit_of(unsigned number) {
        return number >= 1 && number <= 16 ? 1u << (number - 1) : 0u;
    }
};

/// P0B-03, P0B-41, P0D-18, P30-04: DI1 to DI8. Some ranges have a ninth bit [errata C11].
using inputs = terminal_set<struct input_terminal>;
/// P0B-05, P0B-42, P0D-19, P31-04: DO1 to DO6. Some ranges have five bits only [errata C11].
using outputs = terminal_set<struct output_terminal>;
/// P0C-10, P31-00: VDI1 to VDI16.
using virtual_inputs = terminal_set<struct virtual_input>;
/// P0C-12, P17-32: VDO1 to VDO16.
using virtual_outputs = terminal_set<struct virtual_output>;

/// A set of functions, of the sixteen from number `First` on. Function n is bit n - `First`.
template <class Function, unsigned First> struct function_set {
    std::uint16_t bits = 0;

    static constexpr function_set from_word(std::uint16_t word) { return {word}; }
    constexpr std::uint16_t to_word() const { return bits; }

    /// True if `one` is in the set; false for a function of another word.
    constexpr bool has(Function one) const { return (bits & bit_of(one)) != 0; }
    /// This set with `one` added; a function of another word adds nothing.
    constexpr function_set with(Function one) const {
        return {static_cast<std::uint16_t>(bits | bit_of(one))};
    }
    /// This set without `one`.
    constexpr function_set without(Function one) const {
        return {static_cast<std::uint16_t>(bits & ~bit_of(one))};
    }
    friend constexpr bool operator==(function_set, function_set) = default;

  private:
    static constexpr unsigned bit_of(Function one) {
        const auto number = static_cast<unsigned>(one);
        return number >= First && number < First + 16 ? 1u << (number - First) : 0u;
    }
};

/// P03-00, P03-01, P03-34, P03-35: FunIN.1 to 16, 17 to 32 and so on.
template <unsigned First> using input_functions = function_set<input_function, First>;
/// P30-01, P30-02: FunOUT.1 to 16 and 17 to 32. The manual gives no coding [errata C18].
template <unsigned First> using output_functions = function_set<output_function, First>;

} // namespace servobus::c630s
