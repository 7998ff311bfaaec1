// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The table of what keeps the wheels of a ZLAC8015D from turning, or makes them turn otherwise than meant. A row
// refuses an enable exactly where the facade's `init` and `enable` do not succeed. Source: RS485 manual V1.07,
// chapters 3 and 4; [errata Bn] are in device/errata.md.
#pragma once

#include <servobus/device/zlac8015d/advice.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "examination.hpp"

namespace tool::diagnosis {
namespace zlac8015d_rules {

namespace zlac = servobus::zlac8015d;

inline constexpr auto emergency = static_cast<u16>(zlac::input_function::emergency_stop);

// Every fault of a wheel, with the manual's words.
inline std::string faults_in_words(const held_registers& r, const check& c) {
    std::string all;
    for (unsigned bit = 1; bit < 0x10000u; bit <<= 1) {
        if ((r.word(c.of[0]) & bit) == 0) continue;
        const servobus::advice what = zlac::advice_for(static_cast<zlac::fault>(bit));
        all += std::string{all.empty() ? "" : " "} + what.cause;
        if (what.remedy != servobus::not_in_manual) all += std::string{" "} + what.remedy;
    }
    return all;
}

inline zlac::status_flags status_of(const held_registers& r) {
    return zlac::status_flags::from_word(r.word(zlac::status_word));
}
inline bool is_either(const held_registers& r, zlac::shaft_state s) {
    return status_of(r).left.shaft == s || status_of(r).right.shaft == s;
}
// `value`: 0 for the left wheel, 1 for the right one.
inline bool is_alarmed(const held_registers& r, const check& c) {
    return (c.value == 0 ? status_of(r).left : status_of(r).right).shaft == zlac::shaft_state::alarm;
}
inline bool is_at_fault(const held_registers& r, const check& c) {
    return r.word(c.of[0]) != 0 && is_alarmed(r, c);
}
// The code may stay after the reset [errata B32].
inline bool was_at_fault(const held_registers& r, const check& c) {
    return r.word(c.of[0]) != 0 && !is_alarmed(r, c);
}
// An alarm without a code, which no other row shows.
inline bool is_in_alarm(const held_registers& r, const check& c) {
    const bool has_code = r.word(c.of[1]) != 0 || r.word(c.of[2]) != 0;
    return is_either(r, zlac::shaft_state::alarm) && !has_code;
}

// `value`: the input's bit in 2003h and 2016h.
inline bool is_stop_active(const held_registers& r, const check& c) {
    return r.word(c.of[0]) == emergency && ((r.word(c.of[1]) ^ r.word(c.of[2])) & c.value) != 0;
}
inline std::vector<new_value> other_polarity(const held_registers& r, const check& c) {
    return {{c.of[2], static_cast<u16>(r.word(c.of[2]) ^ c.value)}};
}

inline bool is_no_resolution(const held_registers& r, const check& c) {
    return !zlac::speed_resolution.limits.contains(r.word(c.of[0]));
}
inline bool is_fine_resolution(const held_registers& r, const check& c) {
    return r.word(c.of[0]) > 1 && !is_no_resolution(r, c);
}

// The time of a lost response is its limit and the quarantine. A setpoint every 50 ms is due then.
inline u32 shortest_timeout(const held_registers& r) { return r.on.response_ms + r.on.quarantine_ms + 50; }
inline bool is_short(const held_registers& r, const check& c) {
    return r.word(c.of[0]) != 0 && r.word(c.of[0]) < shortest_timeout(r);
}
inline std::string shortest_in_words(const held_registers& r, const check&) {
    return "A program with the usual limits needs at least " + std::to_string(shortest_timeout(r)) + " ms.";
}

inline bool has_other_address(const held_registers& r, const check& c) {
    return r.word(c.of[0]) != r.on.node;
}
inline std::vector<new_value> address_in_use(const held_registers& r, const check& c) {
    return {{c.of[0], r.on.node}};
}

inline bool is_turning(const held_registers& r, const check&) {
    constexpr int slowest = 20; // 0.1 r/min: a servo at rest trembles
    const auto turns = [&](int count) { return count > slowest || count < -slowest; };
    return status_of(r).is_running() || turns(r.number(zlac::left_actual_speed)) ||
           turns(r.number(zlac::right_actual_speed));
}
inline bool is_held(const held_registers& r, const check& c) {
    const bool is_held_now =
        is_either(r, zlac::shaft_state::locked) || is_either(r, zlac::shaft_state::emergency_stop);
    return is_held_now && !is_turning(r, c);
}

inline bool has_wrong_hall(const held_registers& r, const check&) {
    const auto h = zlac::hall_inputs::from_word(r.word(zlac::hall_state));
    const auto is_wrong = [](unsigned state) { return state == 0 || state >= 7; };
    return is_wrong(h.left) || is_wrong(h.right);
}

constexpr int margin = 10; // degC below the limit
// `value`: 0 for the left motor, 1 for the right one.
inline bool is_motor_hot(const held_registers& r, const check& c) {
    const auto t = zlac::motor_temperatures::from_word(r.word(zlac::motor_temperature));
    return 10 * ((c.value == 0 ? t.left : t.right) + margin) > r.word(c.of[1]);
}
inline bool is_drive_hot(const held_registers& r, const check& c) {
    return r.number(zlac::driver_temperature) + 10 * margin > r.word(c.of[1]);
}

// A ramp begins anew with each changed setpoint, and takes its whole time [errata B36].
inline bool is_longer_than_period(const held_registers& r, const check& c) {
    return r.on.period_ms != 0 && r.word(c.of[0]) > r.on.period_ms;
}
inline std::string ramp_in_words(const held_registers& r, const check& c) {
    return "It takes " + std::to_string(r.word(c.of[0])) + " ms, a setpoint comes every " +
           std::to_string(r.on.period_ms) + " ms.";
}

// The left wheel's value for both; the right one's where the left is 0.
inline std::vector<new_value> alike(const held_registers& r, const check& c) {
    return r.word(c.of[0]) != 0 ? first_to_second(r, c) : second_to_first(r, c);
}
// A maximum of 0 is a finding of its own.
inline bool is_rated_above(const held_registers& r, const check& c) {
    return r.word(c.of[1]) != 0 && exceeds_second(r, c);
}

// clang-format off
inline constexpr const char* fault_refuses   = "the drive is not enabled while a wheel has a fault";
inline constexpr const char* fault_is_over   =
    "the wheel is in no alarm, but the code of a fault is still there, and a program of this library enables nothing then";
inline constexpr const char* x0_refuses =
    "an emergency stop is active, and the drive ignores an enable; X0 has this function from the factory";
inline constexpr const char* x1_refuses      = "an emergency stop is active, and the drive ignores an enable";
inline constexpr const char* unlike =
    "the wheels are unlike: the robot turns where it should run straight, or one wheel stops first";
inline constexpr const char* unlike_ramps =
    "the wheels have unlike ramps: the robot turns as it starts and stops";
inline constexpr const char* long_ramp =
    "the ramp begins anew with each changed setpoint: a wheel that gets one more often crawls";
inline constexpr const char* if_shaped = "if the program shapes its setpoints, as a robot of this library does";
inline constexpr const char* no_speed_gain =
    "the speed loop has no proportional gain: the wheel does not turn as commanded, and holds nothing";
inline constexpr const char* no_position_gain =
    "the position loop has no proportional gain: in a position mode the wheel neither moves as commanded nor holds";
inline constexpr const char* gain_of_motor = "set it for the motor; from the factory";
inline constexpr mend reset_fault            {.act = "mend the cause", .write = "control_word=fault_reset"};
inline constexpr mend switch_off             {.act = "mend the cause, and switch the drive off and on"};
inline constexpr mend release_stop {.act = "release the stop; or, if its contact opens to stop",
                                    .compose = other_polarity};
inline constexpr mend make_alike             {.act = "if the motors are alike, and this value is right for both",
                                              .compose = alike};
inline constexpr mend lower_rated            {.act = "set both from the motor's data sheet; or, if the maximum is right",
                                              .compose = second_to_first};
inline constexpr mend set_current            {.act = "set it to the maximum of the motor's data sheet"};
inline constexpr mend set_lines              {.act = "set it to the lines of the encoder's data sheet"};

inline constexpr check table[] = {
    // Severity, registers, condition, why it matters, what mends it
    {refuses, {zlac::left_faults, zlac::status_word}, is_at_fault,
     fault_refuses, reset_fault, faults_in_words, 0},
    {refuses, {zlac::right_faults, zlac::status_word}, is_at_fault,
     fault_refuses, reset_fault, faults_in_words, 1},
    {refuses, {zlac::left_faults, zlac::status_word}, was_at_fault,
     fault_is_over, switch_off, faults_in_words, 0},
    {refuses, {zlac::right_faults, zlac::status_word}, was_at_fault,
     fault_is_over, switch_off, faults_in_words, 1},
    {refuses, {zlac::status_word, zlac::left_faults, zlac::right_faults}, is_in_alarm,
     "a shaft is in alarm, without a fault code", reset_fault},
    {refuses, {zlac::x0_function, zlac::input_state, zlac::input_polarity}, is_stop_active,
     x0_refuses, release_stop, nullptr, 1},
    {refuses, {zlac::x1_function, zlac::input_state, zlac::input_polarity}, is_stop_active,
     x1_refuses, release_stop, nullptr, 2},
    {refuses, {zlac::speed_resolution}, is_no_resolution,
     "it is outside 1..10, so the worth of a commanded speed is unknown", {.write = "speed_resolution=1"}},

    {matters, {zlac::host_timeout}, is_zero,
     "0 was off on drives that came with it: the wheels run on when the line is lost. The manual does not say so; an "
     "enable is refused if the time is always over",
     {.write = "host_timeout=1000"}},
    {matters, {zlac::host_timeout}, is_short,
     "the drive stops when a single response is lost; an enable is refused if such a stop lasts",
     {.write = "host_timeout=1000"},
     shortest_in_words},
    {matters, {zlac::host_timeout}, is_above,
     "so long the wheels run on when the line is lost", {.write = "host_timeout=1000"}, nullptr, 1000},
    {matters, {zlac::status_word, zlac::left_actual_speed, zlac::right_actual_speed}, is_turning,
     "a wheel turns: another program commands the drive, or it rolls",
     {.write = "left_target_speed=0 right_target_speed=0 control_word=stop"}},
    {matters, {zlac::status_word, zlac::left_actual_speed, zlac::right_actual_speed}, is_held,
     "a shaft is held: the drive is enabled, was stopped in an emergency, or holds it from power-on",
     {.write = "control_word=stop"}},
    {matters, {zlac::left_target_speed}, is_set,
     "an enable in velocity mode by a program that does not zero it turns the wheel",
     {.write = "left_target_speed=0"}},
    {matters, {zlac::right_target_speed}, is_set,
     "an enable in velocity mode by a program that does not zero it turns the wheel",
     {.write = "right_target_speed=0"}},
    {matters, {zlac::left_target_torque}, is_set,
     "an enable in torque mode by a program that does not zero it turns the wheel",
     {.write = "left_target_torque=0"}},
    {matters, {zlac::right_target_torque}, is_set,
     "an enable in torque mode by a program that does not zero it turns the wheel",
     {.write = "right_target_torque=0"}},
    {matters, {zlac::speed_resolution}, is_fine_resolution,
     "a commanded speed counts 1/speed_resolution r/min, if the power was off since that was saved: a program that counts "
     "r/min turns the wheels that much slower; a program that counts on it turns them that much faster before",
     {.act = "for r/min from the next power-on", .write = "speed_resolution=1 save_parameters=save_all"}},
    {matters, {zlac::hall_state}, has_wrong_hall,
     "a Hall state of 0 or 7 is a Hall fault: that motor does not turn", {.act = "check its Hall cable"}},
    {matters, {zlac::motor_temperature, zlac::left_motor_temperature_limit}, is_motor_hot,
     "the left motor is within 10 degC of its limit, where it has a fault",
     {.act = "let it cool, and lower its load"}, nullptr, 0},
    {matters, {zlac::motor_temperature, zlac::right_motor_temperature_limit}, is_motor_hot,
     "the right motor is within 10 degC of its limit, where it has a fault",
     {.act = "let it cool, and lower its load"}, nullptr, 1},
    {matters, {zlac::driver_temperature, zlac::driver_temperature_limit}, is_drive_hot,
     "the drive is within 10 degC of its limit", {.act = "let it cool, and lower its load"}},
    {matters, {zlac::left_brake}, is_set,
     "code 1 may hold the wheel or release it, which the manual leaves open; against a brake it has an overload "
     "fault", {.act = "if it holds the wheel", .write = "left_brake=code_0"}},
    {matters, {zlac::right_brake}, is_set,
     "code 1 may hold the wheel or release it, which the manual leaves open; against a brake it has an overload "
     "fault", {.act = "if it holds the wheel", .write = "right_brake=code_0"}},
    {matters, {zlac::parking_mode}, is_set,
     "wheels that are not enabled are braked and cannot be pushed", {.write = "parking_mode=off"}},
    {matters, {zlac::shaft_at_power_on}, is_set,
     "after power-on the wheels are held, though nothing is enabled", {.write = "shaft_at_power_on=unlocked"}},
    {matters, {zlac::input_stop}, is_set,
     "after an emergency stop by an input the wheels are released, and roll on a slope", {.write = "input_stop=lock_shaft"}},
    {matters, {zlac::left_max_current}, is_zero,
     "the motor gets no current and does not turn", set_current},
    {matters, {zlac::right_max_current}, is_zero,
     "the motor gets no current and does not turn", set_current},
    {matters, {zlac::left_rated_current, zlac::left_max_current}, is_rated_above,
     "the rated current is above the maximum, so the overload protection acts late or never",
     lower_rated},
    {matters, {zlac::right_rated_current, zlac::right_max_current}, is_rated_above,
     "the rated current is above the maximum, so the overload protection acts late or never",
     lower_rated},
    {matters, {zlac::left_speed_kp}, is_zero,
     no_speed_gain, {.act = gain_of_motor, .write = "left_speed_kp=500"}},
    {matters, {zlac::right_speed_kp}, is_zero,
     no_speed_gain, {.act = gain_of_motor, .write = "right_speed_kp=500"}},
    {matters, {zlac::left_position_kp}, is_zero,
     no_position_gain, {.act = gain_of_motor, .write = "left_position_kp=100"}},
    {matters, {zlac::right_position_kp}, is_zero,
     no_position_gain, {.act = gain_of_motor, .write = "right_position_kp=100"}},
    {matters, {zlac::left_encoder_lines}, is_zero,
     "without encoder lines positions and speeds have no scale", set_lines},
    {matters, {zlac::right_encoder_lines}, is_zero,
     "without encoder lines positions and speeds have no scale", set_lines},
    {matters, {zlac::left_encoder_lines, zlac::right_encoder_lines}, differs,
     unlike, make_alike},
    {matters, {zlac::left_pole_pairs, zlac::right_pole_pairs}, differs,
     unlike, make_alike},
    {matters, {zlac::left_rated_current, zlac::right_rated_current}, differs,
     unlike, make_alike},
    {matters, {zlac::left_max_current, zlac::right_max_current}, differs,
     unlike, make_alike},
    {matters, {zlac::left_overload_factor, zlac::right_overload_factor}, differs,
     unlike, make_alike},
    {matters, {zlac::left_overload_time, zlac::right_overload_time}, differs,
     unlike, make_alike},
    {matters, {zlac::left_following_error_limit, zlac::right_following_error_limit}, differs,
     unlike, make_alike},
    {matters, {zlac::left_acceleration_time, zlac::right_acceleration_time}, differs,
     unlike_ramps, make_alike},
    {matters, {zlac::left_deceleration_time, zlac::right_deceleration_time}, differs,
     unlike_ramps, make_alike},
    {matters, {zlac::left_acceleration_time}, is_longer_than_period,
     long_ramp, {.act = if_shaped, .write = "left_acceleration_time=10 right_acceleration_time=10"}, ramp_in_words},
    {matters, {zlac::left_deceleration_time}, is_longer_than_period,
     long_ramp, {.act = if_shaped, .write = "left_deceleration_time=10 right_deceleration_time=10"}, ramp_in_words},
    {matters, {zlac::left_quick_stop_time, zlac::right_quick_stop_time}, differs,
     unlike_ramps, make_alike},
    {matters, {zlac::left_max_speed, zlac::right_max_speed}, differs,
     unlike, make_alike},
    {matters, {zlac::left_max_speed, zlac::max_motor_speed}, exceeds_second,
     "moves are slower than this speed, since max_motor_speed limits them",
     {.act = "raise max_motor_speed; or", .compose = second_to_first}},
    {matters, {zlac::rs485_baud_rate}, has_other_rate<zlac::device>,
     "the drive has another rate than it responds at: after the next power cycle it may not respond here",
     {.act = "give the rate that it has by --baud then; or, to keep the one in use",
      .compose = rate_in_use<zlac::device>}},
    {matters, {zlac::node_address}, has_other_address,
     "the drive has another address than it responds at: after the next power cycle it may not respond here",
     {.act = "name that address then; or, to keep the one in use", .compose = address_in_use}},
};
// clang-format on

// The requests of a doctor would keep the watchdog of a controller that is dead from stopping the wheels. In torque
// mode the shafts of an enabled drive may read as released [errata B30]: there the last command decides, which 200Eh
// keeps. None since power-on, and a stop, leave nothing enabled.
inline bool may_be_enabled_unseen(const held_registers& r) {
    const u16 last = r.word(zlac::control_word);
    return r.word(zlac::mode_of_operation) == static_cast<u16>(zlac::operating_mode::torque) &&
           last != static_cast<u16>(zlac::control_code::undefined) &&
           last != static_cast<u16>(zlac::control_code::stop);
}
inline bool is_watched(const held_registers& r) {
    const auto is_free = [](zlac::shaft_state s) {
        return s == zlac::shaft_state::released || s == zlac::shaft_state::alarm;
    };
    return status_of(r).is_running() || !is_free(status_of(r).left.shaft) ||
           !is_free(status_of(r).right.shaft) || may_be_enabled_unseen(r);
}
inline constexpr u16 status[] = {zlac::status_word.address, zlac::mode_of_operation.address,
                                 zlac::control_word.address};

} // namespace zlac8015d_rules

inline constexpr check_list zlac8015d_checks{zlac8015d_rules::table};
inline constexpr examination zlac8015d_examination{zlac8015d_checks, zlac8015d_rules::status,
                                                   zlac8015d_rules::is_watched};

} // namespace tool::diagnosis
