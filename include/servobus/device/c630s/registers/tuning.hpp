// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: tuning, inertia identification and notches, group P09. c630s/registers.hpp includes
// it; row.hpp explains the comments of its rows. Source: manual V24.111, section 7.9; [errata Cn] are
// in device/errata_c630s.md.
//
//     auto stiffen(auto& servo, ram_only token) { // a client; the write does not wear the EEPROM
//         return write<c630s::stiffness_level>(servo, 15, token);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P09-01 刚性等级选择  0..31, default 12, running, immediate, PST
inline constexpr rw<u16>                 stiffness_level                          {"P09-01"_p, {0, 31},     no_unit,           12,         running_now | pst_modes};
/// P09-02 自适应陷波器模式选择  0..4, default 0, running, immediate, PST
inline constexpr rw<adaptive_notch>      adaptive_notch_mode                      {"P09-02"_p, {0, 4},      no_unit,           0,          running_now | pst_modes};
/// P09-04 低频共振抑制模式选择  0..1, default 0, running, immediate, P
inline constexpr rw<vibration_frequency> low_frequency_suppression                {"P09-04"_p, {0, 1},      no_unit,           0,          running_now | position_mode};
/// P09-05 离线惯量辨识模式选择  0..1, default 0, stopped, immediate, PST
inline constexpr rw<inertia_motion>      inertia_identification_mode              {"P09-05"_p, {0, 1},      no_unit,           0,          stopped_now | pst_modes};
/// P09-06 惯量辨识最大速度  100..1000 rpm, default 500, stopped, immediate, PST
inline constexpr rw<u16>                 inertia_identification_max_speed         {"P09-06"_p, {100, 1000}, r_per_min,         500,        stopped_now | pst_modes};
/// P09-07 惯量辨识时加速至最大速度时间常数  20..800 ms, default 125, stopped, immediate, PST
inline constexpr rw<u16>                 inertia_identification_acceleration_time {"P09-07"_p, {20, 800},   millisecond,       125,        stopped_now | pst_modes};
/// P09-08 单次惯量辨识完成后等待时间  50..10000 ms, default 800, stopped, immediate, PST
inline constexpr rw<u16>                 inertia_identification_wait_time         {"P09-08"_p, {50, 10000}, millisecond,       800,        stopped_now | pst_modes};
/// P09-09 完成单次惯量辨识电机转动圈数  0.00..2.00 r, shown, PST
inline constexpr ro<u16>                 inertia_identification_revolutions       {"P09-09"_p, {0, 200},    revolution / 100,  no_default, pst_modes};
/// P09-12 第1组陷波器频率  50..4000 Hz, default 4000, running, immediate, PS
inline constexpr rw<u16>                 notch_1_frequency                        {"P09-12"_p, {50, 4000},  hertz,             4000,       running_now | ps_modes};
/// P09-13 第1组陷波器宽度等级  0..20, default 2, running, immediate, PS
inline constexpr rw<u16>                 notch_1_width                            {"P09-13"_p, {0, 20},     no_unit,           2,          running_now | ps_modes};
/// P09-14 第1组陷波器深度等级  0..99, default 0, running, immediate, PS
inline constexpr rw<u16>                 notch_1_depth                            {"P09-14"_p, {0, 99},     no_unit,           0,          running_now | ps_modes};
/// P09-15 第2组陷波器频率  50..4000 Hz, default 4000, running, immediate, PS
inline constexpr rw<u16>                 notch_2_frequency                        {"P09-15"_p, {50, 4000},  hertz,             4000,       running_now | ps_modes};
/// P09-16 第2组陷波器宽度等级  0..20, default 2, running, immediate, PS
inline constexpr rw<u16>                 notch_2_width                            {"P09-16"_p, {0, 20},     no_unit,           2,          running_now | ps_modes};
/// P09-17 第2组陷波器深度等级  0..99, default 0, running, immediate, PS
inline constexpr rw<u16>                 notch_2_depth                            {"P09-17"_p, {0, 99},     no_unit,           0,          running_now | ps_modes};
/// P09-18 第3组陷波器频率  50..4000 Hz, default 4000, running, immediate, PS
inline constexpr rw<u16>                 notch_3_frequency                        {"P09-18"_p, {50, 4000},  hertz,             4000,       running_now | ps_modes};
/// P09-19 第3组陷波器宽度等级  0..20, default 2, running, immediate, PS
inline constexpr rw<u16>                 notch_3_width                            {"P09-19"_p, {0, 20},     no_unit,           2,          running_now | ps_modes};
/// P09-20 第3组陷波器深度等级  0..99, default 0, running, immediate, PS
inline constexpr rw<u16>                 notch_3_depth                            {"P09-20"_p, {0, 99},     no_unit,           0,          running_now | ps_modes};
/// P09-21 第4组陷波器频率  50..4000 Hz, default 4000, running, immediate, PS
inline constexpr rw<u16>                 notch_4_frequency                        {"P09-21"_p, {50, 4000},  hertz,             4000,       running_now | ps_modes};
/// P09-22 第4组陷波器宽度等级  0..20, default 2, running, immediate, PS
inline constexpr rw<u16>                 notch_4_width                            {"P09-22"_p, {0, 20},     no_unit,           2,          running_now | ps_modes};
/// P09-23 第4组陷波器深度等级  0..99, default 0, running, immediate, PS
inline constexpr rw<u16>                 notch_4_depth                            {"P09-23"_p, {0, 99},     no_unit,           0,          running_now | ps_modes};
/// P09-24 共振频率辨识结果  0..2 Hz, default 0, shown, PS [errata C49]
inline constexpr ro<u16>                 resonance_frequency                      {"P09-24"_p, full<u16>,   hertz,             0,          ps_modes};
/// P09-30 转矩扰动补偿增益  0.0..100.0 %, default 0.0, running, immediate, PS
inline constexpr rw<u16>                 disturbance_compensation_gain            {"P09-30"_p, {0, 1000},   percent / 10,      0,          running_now | ps_modes};
/// P09-31 转矩扰动观测器滤波时间常数  0.00..25.00 ms, default 0.50, running, immediate, PS
inline constexpr rw<u16>                 disturbance_observer_filter_time         {"P09-31"_p, {0, 2500},   millisecond / 100, 50,         running_now | ps_modes};
/// P09-38 低频共振频率  1.0..100.0 Hz, default 100.0, running, immediate, P
inline constexpr rw<u16>                 low_frequency_resonance                  {"P09-38"_p, {10, 1000},  hertz / 10,        1000,       running_now | position_mode};
/// P09-39 低频共振频率滤波设定  0..10, default 2, running, immediate, P
inline constexpr rw<u16>                 low_frequency_resonance_filter           {"P09-39"_p, {0, 10},     no_unit,           2,          running_now | position_mode};
// clang-format on

} // namespace servobus::c630s
