// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The tables of what keeps a YAKOTEC stepper from turning, or makes it turn otherwise than meant, one a variant. A row
// refuses an enable exactly where the facade's `init` and `enable` do not succeed. Source: manual V2.6.0, chapters 4
// and 5, appendices 2 and 3; [errata An] are in device/errata.md.
#pragma once

#include <servobus/device/yako/advice.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/open_loop.hpp>

#include "examination.hpp"

namespace tool::diagnosis {
namespace yako_rules {

namespace yako = servobus::yako;
namespace closed = servobus::yako::closed_loop;
namespace open = servobus::yako::open_loop;
using yako::input_function;
using yako::motion_status;

inline bool has_bit(const held_registers& r, const check& c) { return (r.word(c.of[0]) & c.value) != 0; }
inline std::string alarm_in_words(const held_registers& r, const check& c) {
    return yako::advice_for(r.word(c.of[1])).cause;
}

// Inputs. `value`: a function; the first register: that of an input; the second one: 0008h.
inline unsigned place_of(u16 function_register) {
    return static_cast<unsigned>(function_register - yako::x0_function.address);
}
inline bool is_on(const held_registers& r, u16 function_register) {
    return (static_cast<unsigned>(r.word(closed::input_state)) >> place_of(function_register) & 1u) != 0;
}
inline bool is_active_as(const held_registers& r, const check& c) {
    return r.word(c.of[0]) == c.value && is_on(r, c.of[0]);
}
inline std::vector<new_value> without_function(const held_registers&, const check& c) {
    return {{c.of[0], static_cast<u16>(input_function::undefined)}};
}
inline std::vector<new_value> other_polarity(const held_registers& r, const check& c) {
    const u16 address = closed::input_polarity.address;
    return {{address, static_cast<u16>(r.word(address) ^ 1u << place_of(c.of[0]))}};
}
inline bool is_doubled(const held_registers& r, const check& c) {
    const u16 function = r.word(c.of[0]);
    if (function == 0) return false;
    for (u16 other = yako::x0_function.address; other < c.of[0]; ++other) {
        if (r.has(other) && r.word(other) == function) return true;
    }
    return false;
}

// 0051h: an edge runs a speed segment, not the level.
inline bool is_active_level(const held_registers& r, const check& c) {
    return is_active_as(r, c) && r.word(yako::pv_trigger_mode) == static_cast<u16>(yako::pv_trigger::level);
}

inline bool is_none_of_two(const held_registers& r, const check& c) { return r.word(c.of[0]) > 1; }

// Software limits
inline bool has_limits(const held_registers& r) {
    return r.word(yako::software_limits) == static_cast<u16>(yako::limit_enable::after_homing);
}
inline bool is_limited_without_home(const held_registers& r, const check& c) {
    return has_limits(r) && (r.word(c.of[1]) & motion_status::homed_bit) == 0;
}
inline bool has_exchanged_limits(const held_registers& r, const check& c) {
    const auto highest = static_cast<std::int32_t>(r.pair(c.of[1]));
    const auto lowest = static_cast<std::int32_t>(r.pair(c.of[2]));
    return has_limits(r) && highest < lowest;
}
inline std::vector<new_value> exchanged_limits(const held_registers& r, const check& c) {
    return {{c.of[1], r.pair(c.of[2])}, {c.of[2], r.pair(c.of[1])}};
}
inline bool has_equal_limits(const held_registers& r, const check& c) {
    return has_limits(r) && r.pair(c.of[1]) == r.pair(c.of[2]);
}
inline std::vector<new_value> limit_at_position(const held_registers& r, const check& c) {
    return {{c.of[2], r.pair(c.of[1])}};
}
// 0017h matters to who has limits.
inline bool coasts_at_a_limit(const held_registers& r, const check& c) {
    bool has_limit = has_limits(r);
    for (u16 x = yako::x0_function.address; x < yako::x0_function.address + 7; ++x) {
        const auto does = static_cast<input_function>(r.word(x));
        has_limit =
            has_limit || does == input_function::positive_limit || does == input_function::negative_limit;
    }
    return has_limit && is_zero(r, c);
}

struct input_rule {
    input_function does;
    severity is;
    const char* why;
    mend by;
    condition applies = is_active_as;
};

// clang-format off
inline constexpr mend open_it {.act = "open the input; or, if nothing is wired to it", .compose = without_function};
inline constexpr mend leave_it {.act = "move away from it; or, if its contact opens there", .compose = other_polarity};
inline constexpr const char* no_current =
    "the motor gets no current and does not turn; the manual states no value from the factory";
inline constexpr const char* runs_at_once =
    "the input is active: the motor runs as soon as it stands and is enabled; an enable is refused if it starts "
    "before, or runs into a limit";
inline constexpr input_rule input_rules[] = {
    {input_function::motor_free, refuses,
     "the input is active and releases the motor, whatever the bus commands", open_it},
    {input_function::stop, matters,
     "the input is active: the drive ignores every start", open_it},
    {input_function::emergency_stop, matters,
     "the input is active: the drive ignores every start", open_it},
    {input_function::positive_limit, matters,
     "the limit switch is active: the motor does not move forward", leave_it},
    {input_function::negative_limit, matters,
     "the limit switch is active: the motor does not move backward", leave_it},
    {input_function::speed_move, matters,
     runs_at_once, open_it},
    {input_function::jog_positive, matters,
     runs_at_once, open_it},
    {input_function::jog_negative, matters,
     runs_at_once, open_it},
    {input_function::pv_trigger, matters,
     runs_at_once, open_it, is_active_level},
};

inline constexpr check both[] = {
    // Severity, registers, condition, why it matters, what mends it
    {refuses, {yako::status_word, yako::error_code}, has_bit,
     "the motor is not enabled while the drive has an alarm",
     {.act = "mend the cause", .write = "auxiliary_command=clear_alarm"}, alarm_in_words, motion_status::alarm_bit},
    {refuses, {yako::pair_word_order}, is_none_of_two,
     "it is neither 0 nor 1, so no 32-bit value can be read", {.write = "pair_word_order=high_first"}},
    {refuses, {yako::software_limits}, is_none_of_two,
     "it is neither 0 nor 1, so it is not known whether limits are in force", {.write = "software_limits=disabled"}},

    {matters, {yako::status_word}, has_bit,
     "the motor is released: it holds nothing, and a start is ignored", {.act = "once nothing else releases it", .write = "auxiliary_command=enable"}, nullptr,
     motion_status::released_bit},
    {matters, {yako::status_word}, has_bit,
     "the motor moves: another program or an input commands it", {.write = "motion_command=stop"}, nullptr,
     motion_status::moving_bit},
    {matters, {yako::status_word, yako::actual_position, yako::positive_software_limit}, has_bit,
     "the position is beyond the positive software limit: the motor does not move forward",
     {.act = "move back; or, if the machine has the room", .compose = limit_at_position}, nullptr,
     motion_status::positive_limit_bit},
    {matters, {yako::status_word, yako::actual_position, yako::negative_software_limit}, has_bit,
     "the position is beyond the negative software limit: the motor does not move backward",
     {.act = "move forward; or, if the machine has the room", .compose = limit_at_position}, nullptr,
     motion_status::negative_limit_bit},
    {matters, {yako::pair_word_order}, is_value,
     "32-bit values have their low word first; programs that do not read 0019h take positions for others",
     {.write = "pair_word_order=high_first"}, nullptr, 1},
    {matters,
     {yako::software_limits, yako::status_word, yako::positive_software_limit, yako::negative_software_limit},
     is_limited_without_home,
     "the drive is not homed, so its software limits do not hold it",
     {.act = "home it: set homing_method for the machine, then motion_command=start_homing, which moves the motor"}},
    {matters, {yako::software_limits, yako::positive_software_limit, yako::negative_software_limit},
     has_exchanged_limits,
     "the positive limit is below the negative one: a homed drive cannot move",
     {.act = "if they are exchanged", .compose = exchanged_limits}},
    {matters, {yako::software_limits, yako::positive_software_limit, yako::negative_software_limit}, has_equal_limits,
     "both limits are the same position: a homed drive cannot move",
     {.act = "write positive_software_limit above negative_software_limit, in pulses; until then",
      .write = "software_limits=disabled"}},
    {matters, {yako::over_travel_stop_mode}, coasts_at_a_limit,
     "at a limit the motor is released and coasts, and a load that hangs falls; so from the factory",
     {.write = "over_travel_stop_mode=emergency_stop"}},
    {matters, {yako::base_current}, is_zero,
     "the motor has no base current: it may have no torque", {.write = "base_current=40"}},
    {matters, {yako::open_loop_max_current}, is_zero,
     "the motor gets no current and does not turn", {.write = "open_loop_max_current=100"}},
    {matters, {yako::rs485_baud_rate}, has_other_rate<yako::device>,
     "the drive has another rate than it responds at, from the next power cycle on",
     {.act = "give the rate that it has by --baud then; or, to keep the one in use",
      .compose = rate_in_use<yako::device>}},
    {matters, {yako::rs485_format}, has_other_format<yako::device>,
     "the drive has another format than it responds with, from the next power cycle on",
     {.act = "give the format that it has by --format then; or, to keep the one in use",
      .compose = format_in_use<yako::device>}},
};
inline constexpr check of_closed_loop[] = {
    {refuses, {closed::speed_resolution}, is_none_of_two,
     "it is neither 0 nor 1, so the worth of a speed is unknown", {.write = "speed_resolution=1_r/min"}},
    {matters, {closed::speed_resolution}, is_value,
     "speeds count 0.1 r/min: a program that counts r/min moves the motor ten times slower",
     {.write = "speed_resolution=1_r/min"}, nullptr, 1},
    {matters, {closed::max_current}, is_zero,
     no_current, {.act = "set it to the motor's rated current"}},
    {matters, {closed::closed_loop_max_current}, is_zero,
     "the motor gets no current and does not turn", {.write = "closed_loop_max_current=100"}},
    {matters, {closed::holding_current}, is_zero,
     "at standstill the motor holds nothing", {.write = "holding_current=100"}},
};
inline constexpr check of_open_loop[] = {
    {matters, {open::max_current}, is_zero,
     no_current, {.act = "set it to the motor's rated current"}},
    {matters, {open::holding_current}, is_zero,
     "at standstill the motor holds nothing, and may lose its position", {.write = "holding_current=40"}},
};
// clang-format on

// The rows of each input, after the others.
template <std::size_t Inputs, std::size_t Own> constexpr auto table_of(const check (&own)[Own]) {
    constexpr std::size_t rules = std::size(input_rules) + 1;
    std::array<check, std::size(both) + Own + Inputs * rules - 1> all{};
    std::size_t at = 0;
    for (const check& c : both) all[at++] = c;
    for (const check& c : own) all[at++] = c;
    for (std::size_t input = 0; input < Inputs; ++input) {
        const auto function = static_cast<u16>(yako::x0_function.address + input);
        for (const input_rule& rule : input_rules)
            all[at++] = {rule.is,
                         watched::at({function, closed::input_state.address}),
                         rule.applies,
                         rule.why,
                         rule.by,
                         nullptr,
                         static_cast<u16>(rule.does)};
        if (input == 0) continue;
        all[at++] = {matters,
                     watched::at({function}),
                     is_doubled,
                     "an input before it has the same function, and which of them acts is not stated",
                     {.compose = without_function}};
    }
    return all;
}
inline constexpr u16 also[] = {yako::pv_trigger_mode.address, closed::input_polarity.address};
inline constexpr auto closed_loop_table = table_of<4>(of_closed_loop);
inline constexpr auto open_loop_table = table_of<7>(of_open_loop);

inline constexpr u16 status[] = {yako::status_word.address};

} // namespace yako_rules

inline constexpr check_list yako_closed_loop_checks{yako_rules::closed_loop_table, yako_rules::also};
inline constexpr check_list yako_open_loop_checks{yako_rules::open_loop_table, yako_rules::also};
inline constexpr examination yako_closed_loop_examination{yako_closed_loop_checks, yako_rules::status};
inline constexpr examination yako_open_loop_examination{yako_open_loop_checks, yako_rules::status};

} // namespace tool::diagnosis
