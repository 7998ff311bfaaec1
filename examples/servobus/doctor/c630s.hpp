// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The table of what keeps a C630S from turning, or makes it turn otherwise than meant. A row refuses an enable exactly
// where the facade's `init` and `enable` do not succeed. Source: manual V24.111, chapters 5 to 9; [errata Cn] are in
// device/errata_c630s.md.
#pragma once

#include <servobus/device/c630s/advice.hpp>
#include <servobus/device/c630s/alarms.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/c630s/terminals.hpp>

#include "c630s_terminals.hpp"
#include "examination.hpp"

namespace tool::diagnosis {
namespace c630s_rules {

using c630s::status_flags;

// The set-up

constexpr std::size_t set_up_size = c630s::detail::set_up_block_count * c630s::detail::block_size;
constexpr u16 set_up_register(std::size_t i) {
    const std::size_t block = i / c630s::detail::block_size;
    return static_cast<u16>(c630s::detail::set_up_blocks[block] + i % c630s::detail::block_size);
}
constexpr std::array<u16, set_up_size> all_of_set_up() {
    std::array<u16, set_up_size> all{};
    for (std::size_t i = 0; i < set_up_size; ++i) all[i] = set_up_register(i);
    return all;
}
inline constexpr std::array<u16, set_up_size> set_up_registers = all_of_set_up();

inline bool is_other(const held_registers& r, u16 address) {
    return r.has(address) && c630s::detail::set_up_word(address, r.word(address)) != r.word(address);
}
/// The registers that differ and what the set-up has there, each once: two blocks share one.
inline std::vector<new_value> others(const held_registers& r) {
    std::vector<new_value> found;
    for (const u16 address : set_up_registers) {
        const new_value wanted{address, c630s::detail::set_up_word(address, r.word(address))};
        bool is_new = is_other(r, address);
        for (const new_value& before : found) is_new = is_new && before != wanted;
        if (is_new) found.push_back(wanted);
    }
    return found;
}
inline bool is_set_up(const held_registers& r) { return others(r).empty(); }
inline bool is_not_set_up(const held_registers& r, const check&) { return !is_set_up(r); }
inline std::vector<new_value> other_registers(const held_registers& r, const check&) { return others(r); }
// The switch of the virtual inputs, unless it is on already.
inline watched first_other(const held_registers& r, const check& c) {
    return is_other(r, c.of[0]) ? c.of : watched::at({others(r).front().address});
}

// Alarms

// Er.xxx with the record that P0B-33 selects; only record 0 is the present alarm.
inline const c630s::alarm* present_alarm(const held_registers& r) {
    return r.word(c630s::selected_fault_record) == 0 ? c630s::find_alarm(r.word(c630s::recorded_alarm))
                                                     : nullptr;
}
inline std::string alarm_in_words(const held_registers& r, const check&) {
    const c630s::alarm* const a = present_alarm(r);
    if (a == nullptr) return "P0B-33 selects an old record, so P0B-34 does not say which.";
    const servobus::advice what = c630s::advice_for(a->code);
    std::string words = "Er." + hex_of(a->code).substr(3) + ", " + a->name + ':';
    for (const char* part : {what.cause, what.remedy, what.reset}) {
        if (part != servobus::not_in_manual) words += std::string{" "} + part;
    }
    return words;
}
inline bool has_kind(const held_registers& r, c630s::alarm_class kind) {
    const c630s::alarm* const a = present_alarm(r);
    return a != nullptr && a->kind == kind;
}
inline status_flags outputs_of(const held_registers& r) {
    return status_flags::from_word(r.word(c630s::virtual_output_levels));
}
// The outputs tell of a fault once the drive is set up; before that the record does.
inline bool has_fault(const held_registers& r, const check&) {
    return is_set_up(r) ? outputs_of(r).has_fault() : has_kind(r, c630s::alarm_class::fault);
}
inline bool turns(const held_registers& r) {
    const int speed = r.number(c630s::actual_speed);
    return speed > 2 || speed < -2;
}
// The warning Er.900 stays until a reset: of a motor that turns, the emergency stop is over.
inline bool has_warning(const held_registers& r, const check&) {
    constexpr u16 stopped_by_input = 0x900;
    return has_kind(r, c630s::alarm_class::warning) &&
           !(turns(r) && r.word(c630s::recorded_alarm) == stopped_by_input);
}
// A motor that turns does not obey the input: another finding says that it turns.
inline bool is_stopped_by_input(const held_registers& r, const check& c) {
    return is_given(r, c) && !turns(r);
}
inline bool is_unready(const held_registers& r, const check&) {
    return is_set_up(r) && !outputs_of(r).is_ready() && !outputs_of(r).has_fault();
}
// The servo-on of the bus releases the brake, and an enable takes that back first.
inline bool is_brake_open(const held_registers& r, const check&) {
    const bool is_on = (r.word(c630s::virtual_input_levels) & c630s::terminal::servo_on) != 0;
    return is_set_up(r) && outputs_of(r).is_brake_released() && !is_on && r.number(c630s::actual_speed) == 0;
}
inline bool awaits_power(const held_registers& r, const check& c) {
    return r.word(c.of[0]) == static_cast<u16>(c630s::fault_record::ninth_last);
}
inline bool is_none_of_two(const held_registers& r, const check& c) { return r.word(c.of[0]) > 1; }

// Outputs

inline constexpr u16 outputs[] = {c630s::do1_function.address, c630s::do2_function.address,
                                  c630s::do3_function.address, c630s::do4_function.address,
                                  c630s::do5_function.address, c630s::do6_function.address};
// Matters once the drive is set up: before, no program enables it.
inline bool has_no_wired_brake(const held_registers& r, const check&) {
    if (!is_set_up(r)) return false;
    for (const u16 address : outputs) {
        if (r.word(address) == static_cast<u16>(c630s::output_function::brake)) return false;
    }
    return true;
}

// Others

inline bool is_turning(const held_registers& r, const check&) { return turns(r); }
inline bool has_unused_gear(const held_registers& r, const check& c) {
    const bool is_factory = r.pair(c.of[1]) == c630s::gear_1_numerator.initial &&
                            r.pair(c.of[2]) == c630s::gear_1_denominator.initial;
    return r.pair(c.of[0]) != 0 && !is_factory;
}
inline bool is_slow_to_respond(const held_registers& r, const check& c) {
    return r.word(c.of[0]) > r.on.response_ms / 2;
}

// P08-05 is in force where P08-08 and P08-09 switch to the second gains.
inline bool has_second_gain_of_zero(const held_registers& r, const check& c) {
    return is_zero(r, c) && r.word(c.of[1]) == static_cast<u16>(c630s::gain_mode::switched) &&
           r.word(c.of[2]) != static_cast<u16>(c630s::gain_condition::first_set);
}

constexpr u16 as_word(input_function f) { return static_cast<u16>(f); }

// clang-format off
inline constexpr const char* no_position_gain =
    "the position loop has no gain: in position mode the motor neither moves as commanded nor holds";
inline constexpr const char* gain_of_machine = "set it for the machine; from the factory";
inline constexpr mend run_set_up {
    .act = "a program runs set_up{} once, as examples/servo does; then switch the drive off and on"};
inline constexpr mend switch_on       {.act = "switch the drive off and on"};
inline constexpr mend no_servo_on_bit {.compose = without_servo_on_bit};
inline constexpr mend leave_it        {.act = "move away from it; or, if the input is wrongly active", .compose = inactive};
inline constexpr mend release_stop    {.act = "release the stop; or, if the input is wrongly active", .compose = inactive};

inline constexpr check table[] = {
    // Severity, registers, condition, why it matters, what mends it
    {refuses, {c630s::virtual_inputs_enable}, is_not_set_up,
     "the terminals are not set up: the bus reaches servo-on and the drive's state through virtual terminals only",
     run_set_up, nullptr, 0, first_other, other_registers},
    {refuses, {c630s::selected_fault_record}, awaits_power,
     "a set-up has marked the drive: what it has kept works from the next power cycle on", switch_on},
    {refuses, {c630s::pair_word_order}, is_none_of_two,
     "it is neither 0 nor 1, so no 32-bit value can be read", {.write = "pair_word_order=low_first"}},
    {refuses, {c630s::recorded_alarm, c630s::selected_fault_record, c630s::virtual_output_levels}, has_fault,
     "the servo is not enabled while the drive has a fault",
     {.act = "mend the cause", .write = "alarm_reset=execute"}, alarm_in_words},
    {refuses, {c630s::virtual_output_levels}, is_unready,
     "S-RDY is not active: the drive does not accept servo-on", {.act = "check the main supply"}},
    {refuses, {c630s::virtual_output_levels, c630s::virtual_input_levels, c630s::actual_speed}, is_brake_open,
     "the brake is released though the bus has not switched the servo on: something else has, or BK does not show "
     "the brake", {.act = "find what switches the servo on; or give a DO the function BK"}},

    {matters, {c630s::recorded_alarm, c630s::selected_fault_record}, has_warning,
     "the drive has a warning", {.act = "mend the cause", .write = "alarm_reset=execute"}, alarm_in_words},
    {matters, {c630s::actual_speed}, is_turning,
     "the motor turns: another program or a terminal commands it",
     {.write = "target_speed=0 virtual_input_levels=0"}},
    {matters, {c630s::virtual_input_levels}, has_servo_on_bit,
     "another program has switched the servo on", no_servo_on_bit},
    {matters, {c630s::di1_function}, has_wired_servo_on,
     "a wired servo-on energises the motor, whatever the bus commands", {.compose = no_servo_on}, nullptr, 0,
     servo_on_registers},
    {matters, {c630s::virtual_inputs_at_power_on}, has_servo_on_bit,
     "virtual input 1, which is servo-on after a set-up, is active at power-on: the motor is energised then",
     no_servo_on_bit},
    {matters, {c630s::power_on_functions_1_to_16}, has_servo_on_bit,
     "servo-on is active at power-on: the motor is energised then", no_servo_on_bit},
    {matters, {c630s::do6_function}, has_no_wired_brake,
     "no wired output has the function BK; an enable is refused if the drive shows its brake on a wired one only, or "
     "as always released", {.act = "if an enable is not confirmed", .write = "do6_function=brake"}},
    {matters, {c630s::virtual_inputs_enable}, has_doubled,
     "two inputs have one function, which is Er.130", {.compose = free_one}, nullptr, 0, doubled_registers},
    {matters, {c630s::input_conduction}, is_given,
     "the positive limit switch is active: the motor does not turn forward",
     leave_it, which_is_active, as_word(input_function::positive_overtravel), active_registers},
    {matters, {c630s::input_conduction}, is_given,
     "the negative limit switch is active: the motor does not turn in reverse",
     leave_it, which_is_active, as_word(input_function::negative_overtravel), active_registers},
    {matters, {c630s::input_conduction}, is_stopped_by_input,
     "the emergency stop is active: the motor is energised and stays where it is",
     release_stop, which_is_active, as_word(input_function::emergency_stop), active_registers},
    {matters, {c630s::emergency_stop}, is_set,
     "an emergency stop by the bus lasts: the motor obeys no other command", {.write = "emergency_stop=none"}},
    {matters, {c630s::terminal_forcing}, is_set,
     "terminals are forced: limit switches and stops may have no effect", {.write = "terminal_forcing=none"}},
    {matters, {c630s::max_speed}, is_zero,
     "the motor does not turn, since this limits its speed", {.act = "set it for the machine; from the factory", .write = "max_speed=5000"}},
    {matters, {c630s::max_forward_speed}, is_zero,
     "the motor does not turn forward, since this limits its speed", {.act = "set it for the machine; from the factory", .write = "max_forward_speed=5000"}},
    {matters, {c630s::max_reverse_speed}, is_zero,
     "the motor does not turn in reverse, since this limits its speed", {.act = "set it for the machine; from the factory", .write = "max_reverse_speed=5000"}},
    {matters, {c630s::positive_internal_torque_limit}, is_zero,
     "the motor has no torque forward",
     {.act = "set it for the machine; from the factory", .write = "positive_internal_torque_limit=300.0"}},
    {matters, {c630s::negative_internal_torque_limit}, is_zero,
     "the motor has no torque in reverse",
     {.act = "set it for the machine; from the factory", .write = "negative_internal_torque_limit=300.0"}},
    {matters, {c630s::position_loop_gain}, is_zero,
     no_position_gain, {.act = gain_of_machine, .write = "position_loop_gain=40.0"}},
    {matters, {c630s::second_position_loop_gain, c630s::second_gain_mode, c630s::gain_switching_condition},
     has_second_gain_of_zero,
     no_position_gain, {.act = gain_of_machine, .write = "second_position_loop_gain=64.0"}},
    {matters, {c630s::torque_limit_source}, is_set,
     "terminals or an analogue input limit the torque: the motor may have none without them",
     {.write = "torque_limit_source=internal"}},
    {matters, {c630s::eeprom_update}, is_set,
     "each write over the bus goes into the EEPROM, which frequent writes destroy; so from the factory", {.act = "once all that is to be kept is written", .write = "eeprom_update=off"}},
    {matters, {c630s::response_delay}, is_slow_to_respond,
     "the drive waits so long before each response, of the time that one may take", {.write = "response_delay=1"}},
    {matters, {c630s::pulses_per_revolution, c630s::gear_1_numerator, c630s::gear_1_denominator}, has_unused_gear,
     "the electronic gear has no effect while P05-02 is not 0: the motor moves other ways than the gear says",
     {.act = "set P05-02 to 0 to use the gear, with the servo off, and switch the drive off and on",
      .write = "pulses_per_revolution=0"}},
};
// clang-format on

inline constexpr u16 status[] = {c630s::actual_speed.address};

} // namespace c630s_rules

inline constexpr check_list c630s_checks{c630s_rules::table, c630s_rules::outputs,
                                         c630s_rules::set_up_registers};
inline constexpr examination c630s_examination{c630s_checks, c630s_rules::status};

} // namespace tool::diagnosis
