// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: position control and homing, group P05. c630s/registers.hpp includes it;
// row.hpp explains the comments of its rows. Source: manual V24.111, section 7.5; [errata Cn] are in
// device/errata_c630s.md.
//
//     auto set_up_homing(auto& servo) { // a client; the writes go into the EEPROM
//         return store<c630s::homing_method, c630s::homing_high_speed, c630s::homing_low_speed>(
//             servo, c630s::homing_mode::reverse_home_switch, 60 * units::r_per_min, 10 * units::r_per_min);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P05-00 位置指令来源  0..2, default 0, stopped, immediate, P
inline constexpr rw<position_source>     position_command_source           {"P05-00"_p, {0, 2},                    no_unit,              0,       stopped_now | position_mode};
/// P05-02 电机每旋转1圈脉冲数  0..1048576 P/r, default 10000, stopped, power cycle, P; at 0 the electronic gear applies [errata C35]
inline constexpr rw<u32>                 pulses_per_revolution             {"P05-02"_p, {0, 1048576},              pulse_per_revolution, 10000,   stopped_from_power_on | position_mode};
/// P05-04 一阶低通滤波时间常数  0..6553.5 ms, default 0.0, stopped, immediate, P
inline constexpr rw<u16>                 position_low_pass_time            {"P05-04"_p, {0, 65535},                millisecond / 10,     0,       stopped_now | position_mode};
/// P05-05 步进量  -9999..9999 reference units, default 50, stopped, immediate, P
inline constexpr rw<i16>                 position_step                     {"P05-05"_p, {-9999, 9999},             reference_unit,       50,      stopped_now | position_mode | motion};
/// P05-06 平均值滤波时间常数  0.0..128.0 ms, default 0.0, stopped, immediate, P
inline constexpr rw<u16>                 position_average_time             {"P05-06"_p, {0, 1280},                 millisecond / 10,     0,       stopped_now | position_mode};
/// P05-07 电子齿数比1(分子)  1..1073741824, default 1048576, running, immediate, P [errata C33]
inline constexpr rw<u32>                 gear_1_numerator                  {"P05-07"_p, {1, 1073741824},           no_unit,              1048576, running_now | position_mode};
/// P05-09 电子齿数比1(分母)  1..1073741824, default 10000, running, immediate, P
inline constexpr rw<u32>                 gear_1_denominator                {"P05-09"_p, {1, 1073741824},           no_unit,              10000,   running_now | position_mode};
/// P05-11 电子齿数比2(分子)  1..1073741824, default 1048576, running, immediate, P [errata C33]
inline constexpr rw<u32>                 gear_2_numerator                  {"P05-11"_p, {1, 1073741824},           no_unit,              1048576, running_now | position_mode};
/// P05-13 电子齿数比2(分母)  1..1073741824, default 10000, running, immediate, P
inline constexpr rw<u32>                 gear_2_denominator                {"P05-13"_p, {1, 1073741824},           no_unit,              10000,   running_now | position_mode};
/// P05-15 脉冲指令形态  0, 1, 2, 4, default 0, stopped, power cycle, P [errata C31]
inline constexpr rw<pulse_form>          pulse_command_form                {"P05-15"_p, {0, 4},                    no_unit,              0,       stopped_from_power_on | position_mode};
/// P05-16 清除动作选择  0..2, default 0, stopped, immediate, P
inline constexpr rw<deviation_clearing>  following_error_clearing          {"P05-16"_p, {0, 2},                    no_unit,              0,       stopped_now | position_mode};
/// P05-17 编码器分频脉冲数  35..32767 P/r, default 2500, stopped, power cycle
inline constexpr rw<u16>                 encoder_output_pulses             {"P05-17"_p, {35, 32767},               pulse_per_revolution, 2500,    stopped_from_power_on};
/// P05-19 速度前馈控制选择  0..3, default 1, stopped, immediate, P
inline constexpr rw<speed_feedforward>   speed_feedforward_source          {"P05-19"_p, {0, 3},                    no_unit,              1,       stopped_now | position_mode};
/// P05-20 定位完成输出条件  0..3, default 0, running, immediate, P
inline constexpr rw<completed_condition> positioning_completed_condition   {"P05-20"_p, {0, 3},                    no_unit,              0,       running_now | position_mode};
/// P05-21 定位完成阈值  1..65535 encoder counts, default 734, running, immediate, P [errata C34]
inline constexpr rw<u16>                 positioning_completed_threshold   {"P05-21"_p, {1, 65535},                count,                734,     running_now | position_mode};
/// P05-22 定位接近阈值  1..65535 encoder counts, default 65535, running, immediate, P
inline constexpr rw<u16>                 positioning_near_threshold        {"P05-22"_p, {1, 65535},                count,                65535,   running_now | position_mode};
/// P05-30 原点复归使能控制  0, 1, 2, 3, 4, 5, 6, 8, default 0, running, immediate, P
inline constexpr rw<homing>              homing_control                    {"P05-30"_p, {0, 8},                    no_unit,              0,       running_now | position_mode | trigger | motion};
/// P05-31 原点复归模式  0..9, default 0, stopped, immediate, P
inline constexpr rw<homing_mode>         homing_method                     {"P05-31"_p, {0, 9},                    no_unit,              0,       stopped_now | position_mode};
/// P05-32 高速搜索原点开关信号的速度  0..3000 rpm, default 100, running, immediate, P
inline constexpr rw<u16>                 homing_high_speed                 {"P05-32"_p, {0, 3000},                 r_per_min,            100,     running_now | position_mode};
/// P05-33 低速搜索原点开关信号的速度  0..1000 rpm, default 10, running, immediate, P
inline constexpr rw<u16>                 homing_low_speed                  {"P05-33"_p, {0, 1000},                 r_per_min,            10,      running_now | position_mode};
/// P05-34 搜索原点时的加减速时间  0..1000 ms, default 1000, stopped, immediate, P [errata C37]
inline constexpr rw<u16>                 homing_acceleration_time          {"P05-34"_p, {0, 1000},                 millisecond,          1000,    stopped_now | position_mode};
/// P05-35 限定查找原点的时间  0..65535, default 10000, stopped, immediate, P; P05-61 sets the unit [errata C36, C37]
inline constexpr rw<u16>                 homing_time_limit                 {"P05-35"_p, {0, 65535},                millisecond,          10000,   stopped_now | position_mode | scaled_elsewhere};
/// P05-36 机械原点偏移量  -1073741824..1073741824 reference units, default 0, stopped, immediate, P
inline constexpr rw<i32>                 home_offset                       {"P05-36"_p, {-1073741824, 1073741824}, reference_unit,       0,       stopped_now | position_mode};
/// P05-38 伺服脉冲输出来源选择  0..2, default 0, stopped, power cycle, P
inline constexpr rw<pulse_output>        pulse_output_source               {"P05-38"_p, {0, 2},                    no_unit,              0,       stopped_from_power_on | position_mode};
/// P05-39 电子齿轮比切换条件  0..1, default 0, stopped, immediate, P
inline constexpr rw<gear_switching>      gear_switching_condition          {"P05-39"_p, {0, 1},                    no_unit,              0,       stopped_now | position_mode};
/// P05-43 位置脉冲沿选择  0..1, default 0, running, power cycle, PST [errata C8]
inline constexpr rw<pulse_edge>          position_pulse_edge               {"P05-43"_p, {0, 1},                    no_unit,              0,       running_from_power_on | pst_modes};
/// P05-59 定位完成窗口时间  0..30000 ms, default 1, running, immediate, P
inline constexpr rw<u16>                 positioning_completed_window_time {"P05-59"_p, {0, 30000},                millisecond,          1,       running_now | position_mode};
/// P05-60 定位完成保持时间  0..30000 ms, default 1, running, immediate, P
inline constexpr rw<u16>                 positioning_completed_hold_time   {"P05-60"_p, {0, 30000},                millisecond,          1,       running_now | position_mode};
/// P05-61 限定查找原点的时间单位选择  0..2, default 0, stopped, immediate [errata C36]
inline constexpr rw<u16>                 homing_time_unit                  {"P05-61"_p, {0, 2},                    no_unit,              0,       stopped_now};
// clang-format on

} // namespace servobus::c630s
