// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: speed control, group P06. c630s/registers.hpp includes it; row.hpp explains
// the comments of its rows. Source: manual V24.111, section 7.6; [errata Cn] are in device/errata_c630s.md.
//
//     auto run_at_300(auto& servo, ram_only token) { // a client; the write does not wear the EEPROM
//         return write<c630s::target_speed>(servo, 300 * units::r_per_min, token);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P06-00 主速度指令A来源  0..2, default 0, stopped, immediate, S
inline constexpr rw<speed_source>       main_speed_source           {"P06-00"_p, {0, 2},        no_unit,     0,    stopped_now | speed_mode};
/// P06-01 辅助速度指令B来源  0, 1, 2, 5, default 1, stopped, immediate, S [errata C38]
inline constexpr rw<speed_source>       auxiliary_speed_source      {"P06-01"_p, {0, 5},        no_unit,     1,    stopped_now | speed_mode};
/// P06-02 速度指令选择  0..3, default 0, stopped, immediate, S [errata C38]
inline constexpr rw<command_selection>  speed_command_selection     {"P06-02"_p, {0, 3},        no_unit,     0,    stopped_now | speed_mode};
/// P06-03 速度指令键盘设定值  -6000..6000 rpm, default 200, running, immediate, S
inline constexpr rw<i16>                target_speed                {"P06-03"_p, {-6000, 6000}, r_per_min,   200,  running_now | speed_mode | motion};
/// P06-04 点动速度设定值  0..6000 rpm, default 100, running, immediate, S
inline constexpr rw<u16>                jog_speed                   {"P06-04"_p, {0, 6000},     r_per_min,   100,  running_now | speed_mode};
/// P06-05 速度指令加速斜坡时间常数  0..65535 ms, default 200, running, immediate, S
inline constexpr rw<u16>                acceleration_time           {"P06-05"_p, {0, 65535},    millisecond, 200,  running_now | speed_mode};
/// P06-06 速度指令减速斜坡时间常数  0..65535 ms, default 200, running, immediate, S
inline constexpr rw<u16>                deceleration_time           {"P06-06"_p, {0, 65535},    millisecond, 200,  running_now | speed_mode};
/// P06-07 最大转速阈值  0..6000 rpm, default 5000, running, immediate, S
inline constexpr rw<u16>                max_speed                   {"P06-07"_p, {0, 6000},     r_per_min,   5000, running_now | speed_mode};
/// P06-08 正向速度阈值  0..6000 rpm, default 5000, running, immediate, S
inline constexpr rw<u16>                max_forward_speed           {"P06-08"_p, {0, 6000},     r_per_min,   5000, running_now | speed_mode};
/// P06-09 反向速度阈值  0..6000 rpm, default 5000, running, immediate, S
inline constexpr rw<u16>                max_reverse_speed           {"P06-09"_p, {0, 6000},     r_per_min,   5000, running_now | speed_mode};
/// P06-11 转矩前馈控制选择  0..1, default 1, running, immediate, PS
inline constexpr rw<torque_feedforward> torque_feedforward_source   {"P06-11"_p, {0, 1},        no_unit,     1,    running_now | ps_modes};
/// P06-15 零位固定转速阈值  0..6000 rpm, default 10, running, immediate, S [errata C55]
inline constexpr rw<u16>                zero_clamp_threshold        {"P06-15"_p, {0, 6000},     r_per_min,   10,   running_now | speed_mode};
/// P06-16 电机旋转速度阈值  0..1000 rpm, default 20, running, immediate, S [errata C55]
inline constexpr rw<u16>                rotation_threshold          {"P06-16"_p, {0, 1000},     r_per_min,   20,   running_now | speed_mode};
/// P06-17 速度一致信号阈值  0..100 rpm, default 10, running, immediate, S
inline constexpr rw<u16>                speed_coincidence_threshold {"P06-17"_p, {0, 100},      r_per_min,   10,   running_now | speed_mode};
/// P06-18 速度到达信号阀值  10..6000 rpm, default 1000, running, immediate, S
inline constexpr rw<u16>                speed_reached_threshold     {"P06-18"_p, {10, 6000},    r_per_min,   1000, running_now | speed_mode};
/// P06-19 零速输出信号阀值  1..6000 rpm, default 10, running, immediate, S [errata C22]
inline constexpr rw<u16>                zero_speed_threshold        {"P06-19"_p, {1, 6000},     r_per_min,   10,   running_now | speed_mode};
// clang-format on

} // namespace servobus::c630s
