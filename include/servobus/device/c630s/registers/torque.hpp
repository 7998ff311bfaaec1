// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: torque control, group P07. c630s/registers.hpp includes it; row.hpp explains
// the comments of its rows. Source: manual V24.111, section 7.7; [errata Cn] are in device/errata_c630s.md.
//
//     auto limit_torque(auto& servo) { // a client; the writes go into the EEPROM
//         return store<c630s::positive_internal_torque_limit, c630s::negative_internal_torque_limit>(
//             servo, 120 * units::percent, 120 * units::percent);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P07-00 主转矩指令A来源  0..2, default 0, stopped, immediate, T
inline constexpr rw<torque_source>     main_torque_source             {"P07-00"_p, {0, 2},        no_unit,           0,    stopped_now | torque_mode};
/// P07-01 辅助转矩指令B来源  0..2, default 1, stopped, immediate, T
inline constexpr rw<torque_source>     auxiliary_torque_source        {"P07-01"_p, {0, 2},        no_unit,           1,    stopped_now | torque_mode};
/// P07-02 转矩指令选择  0..4, default 0, stopped, immediate, T [errata C13]
inline constexpr rw<command_selection> torque_command_selection       {"P07-02"_p, {0, 4},        no_unit,           0,    stopped_now | torque_mode};
/// P07-03 转矩指令键盘设定值  -300.0..300.0 %, default 0, running, immediate, T
inline constexpr rw<i16>               target_torque                  {"P07-03"_p, {-3000, 3000}, percent / 10,      0,    running_now | torque_mode | motion};
/// P07-05 转矩指令滤波时间常数  0..30.00 ms, default 0.79, running, immediate, PST
inline constexpr rw<u16>               torque_filter_time             {"P07-05"_p, {0, 3000},     millisecond / 100, 79,   running_now | pst_modes};
/// P07-06 第二转矩指令滤波时间常数  0..30.00 ms, default 0.79, running, immediate, PST
inline constexpr rw<u16>               second_torque_filter_time      {"P07-06"_p, {0, 3000},     millisecond / 100, 79,   running_now | pst_modes};
/// P07-07 转矩限制来源  0..4, default 0, stopped, immediate, PST
inline constexpr rw<torque_limit>      torque_limit_source            {"P07-07"_p, {0, 4},        no_unit,           0,    stopped_now | pst_modes};
/// P07-08 T-LMT选择  1..2, default 2, stopped, immediate, PST
inline constexpr rw<analogue_input>    torque_limit_input             {"P07-08"_p, {1, 2},        no_unit,           2,    stopped_now | pst_modes};
/// P07-09 正内部转矩限制  0.0..300.0 %, default 300.0, running, immediate, PST
inline constexpr rw<u16>               positive_internal_torque_limit {"P07-09"_p, {0, 3000},     percent / 10,      3000, running_now | pst_modes};
/// P07-10 负内部转矩限制  0.0..300.0 %, default 300.0, running, immediate, PST
inline constexpr rw<u16>               negative_internal_torque_limit {"P07-10"_p, {0, 3000},     percent / 10,      3000, running_now | pst_modes};
/// P07-11 正外部转矩限制  0.0..300.0 %, default 300.0, running, immediate, PST
inline constexpr rw<u16>               positive_external_torque_limit {"P07-11"_p, {0, 3000},     percent / 10,      3000, running_now | pst_modes};
/// P07-12 负外部转矩限制  0.0..300.0 %, default 300.0, running, immediate, PST
inline constexpr rw<u16>               negative_external_torque_limit {"P07-12"_p, {0, 3000},     percent / 10,      3000, running_now | pst_modes};
/// P07-17 速度限制来源选择  0..2, default 0, running, immediate, T
inline constexpr rw<speed_limit>       speed_limit_source             {"P07-17"_p, {0, 2},        no_unit,           0,    running_now | torque_mode};
/// P07-18 V-LMT选择  1..2, default 1, running, immediate, T
inline constexpr rw<analogue_input>    speed_limit_input              {"P07-18"_p, {1, 2},        no_unit,           1,    running_now | torque_mode};
/// P07-19 转矩控制正向速度限制/转矩控制速度限制1  0..6000 rpm, default 3000, running, immediate, T
inline constexpr rw<u16>               forward_speed_limit            {"P07-19"_p, {0, 6000},     r_per_min,         3000, running_now | torque_mode};
/// P07-20 转矩控制负向速度限制/转矩控制速度限制2  0..6000 rpm, default 3000, running, immediate, T
inline constexpr rw<u16>               reverse_speed_limit            {"P07-20"_p, {0, 6000},     r_per_min,         3000, running_now | torque_mode};
/// P07-21 转矩到达基准值  0.0..300.0 %, default 0.0, running, immediate, PST
inline constexpr rw<u16>               torque_reached_base            {"P07-21"_p, {0, 3000},     percent / 10,      0,    running_now | pst_modes};
/// P07-22 转矩到达有效值  0.0..300.0 %, default 20.0, running, immediate, PST
inline constexpr rw<u16>               torque_reached_on_offset       {"P07-22"_p, {0, 3000},     percent / 10,      200,  running_now | pst_modes};
/// P07-23 转矩到达无效值  0.0..300.0 %, default 10.0, running, immediate, PST
inline constexpr rw<u16>               torque_reached_off_offset      {"P07-23"_p, {0, 3000},     percent / 10,      100,  running_now | pst_modes};
/// P07-40 转矩模式下速度受限窗口  0.5..30.0 ms, default 1.0, running, immediate, T
inline constexpr rw<u16>               speed_limited_window           {"P07-40"_p, {5, 300},      millisecond / 10,  10,   running_now | torque_mode};
// clang-format on

} // namespace servobus::c630s
