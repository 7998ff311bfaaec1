// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: gains of the control loops, group P08. c630s/registers.hpp includes it;
// row.hpp explains the comments of its rows. Source: manual V24.111, section 7.8; [errata Cn] are in
// device/errata_c630s.md.
//
//     auto tune(auto& servo, ram_only token) { // a client; the write does not wear the EEPROM
//         return write<c630s::speed_loop_gain>(servo, 40 * units::hertz, token);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P08-00 速度环增益  0.1..2000.0 Hz, default 25.0, running, immediate, PS
inline constexpr rw<u16>            speed_loop_gain                 {"P08-00"_p, {1, 20000},  hertz / 10,        250,  running_now | ps_modes};
/// P08-01 速度环积分时间常数  0.15..512.00 ms, default 31.83, running, immediate, PS
inline constexpr rw<u16>            speed_loop_integral_time        {"P08-01"_p, {15, 51200}, millisecond / 100, 3183, running_now | ps_modes};
/// P08-02 位置环增益  0.0..2000.0 Hz, default 40.0, running, immediate, P
inline constexpr rw<u16>            position_loop_gain              {"P08-02"_p, {0, 20000},  hertz / 10,        400,  running_now | position_mode};
/// P08-03 第2速度环增益  0.1..2000.0 Hz, default 40.0, running, immediate, PS
inline constexpr rw<u16>            second_speed_loop_gain          {"P08-03"_p, {1, 20000},  hertz / 10,        400,  running_now | ps_modes};
/// P08-04 第2速度环积分时间常数  0.15..512.00 ms, default 40.00, running, immediate, PS
inline constexpr rw<u16>            second_speed_loop_integral_time {"P08-04"_p, {15, 51200}, millisecond / 100, 4000, running_now | ps_modes};
/// P08-05 第2位置环增益  0.0..2000.0 Hz, default 64.0, running, immediate, P
inline constexpr rw<u16>            second_position_loop_gain       {"P08-05"_p, {0, 20000},  hertz / 10,        640,  running_now | position_mode};
/// P08-08 第二增益模式设置  0..1, default 1, running, immediate, PST [errata C21]
inline constexpr rw<gain_mode>      second_gain_mode                {"P08-08"_p, {0, 1},      no_unit,           1,    running_now | pst_modes};
/// P08-09 增益切换条件选择  0..10, default 0, running, immediate, PST [errata C21]
inline constexpr rw<gain_condition> gain_switching_condition        {"P08-09"_p, {0, 10},     no_unit,           0,    running_now | pst_modes};
/// P08-10 增益切换延迟时间  0.0..1000.0 ms, default 5.0, running, immediate, PST
inline constexpr rw<u16>            gain_switching_delay            {"P08-10"_p, {0, 10000},  millisecond / 10,  50,   running_now | pst_modes};
/// P08-11 增益切换等级  0..20000, default 50, running, immediate, PST; P08-09 sets the unit
inline constexpr rw<u16>            gain_switching_level            {"P08-11"_p, {0, 20000},  no_unit,           50,   running_now | pst_modes | scaled_elsewhere};
/// P08-12 增益切换时滞  0..20000, default 30, running, immediate, PST; P08-09 sets the unit
inline constexpr rw<u16>            gain_switching_hysteresis       {"P08-12"_p, {0, 20000},  no_unit,           30,   running_now | pst_modes | scaled_elsewhere};
/// P08-13 位置增益切换时间  0.0..1000.0 ms, default 3.0, running, immediate, P
inline constexpr rw<u16>            position_gain_switching_time    {"P08-13"_p, {0, 10000},  millisecond / 10,  30,   running_now | position_mode};
/// P08-15 负载转动惯量比  0.00..120.00 times, default 1.00, running, immediate, PST
inline constexpr rw<u16>            load_inertia_ratio              {"P08-15"_p, {0, 12000},  times / 100,       100,  running_now | pst_modes};
/// P08-18 速度前馈滤波时间常数  0.00..64.00 ms, default 0.50, running, immediate, P [errata C59]
inline constexpr rw<u16>            speed_feedforward_filter_time   {"P08-18"_p, {0, 6400},   millisecond / 100, 50,   running_now | position_mode};
/// P08-19 速度前馈增益  0.0..100.0 %, default 0.0, running, immediate, P
inline constexpr rw<u16>            speed_feedforward_gain          {"P08-19"_p, {0, 1000},   percent / 10,      0,    running_now | position_mode};
/// P08-20 转矩前馈滤波时间常数  0.00..64.00 ms, default 0.50, stopped, immediate, PS [errata C59]
inline constexpr rw<u16>            torque_feedforward_filter_time  {"P08-20"_p, {0, 6400},   millisecond / 100, 50,   stopped_now | ps_modes};
/// P08-21 转矩前馈增益  0.0..200.0 %, default 0.0, running, immediate, PS
inline constexpr rw<u16>            torque_feedforward_gain         {"P08-21"_p, {0, 2000},   percent / 10,      0,    running_now | ps_modes};
/// P08-22 速度反馈滤波选项  0..4, default 0, stopped, immediate, PS
inline constexpr rw<averaging>      speed_feedback_averaging        {"P08-22"_p, {0, 4},      no_unit,           0,    stopped_now | ps_modes};
/// P08-23 速度反馈低通滤波截止频率  100..4000 Hz, default 4000, running, immediate, PS
inline constexpr rw<u16>            speed_feedback_cutoff_frequency {"P08-23"_p, {100, 4000}, hertz,             4000, running_now | ps_modes};
/// P08-24 伪微分前馈控制系数  0.0..100.0, default 100.0, running, immediate, PS [errata C73]
inline constexpr rw<u16>            pseudo_derivative_feedforward   {"P08-24"_p, {0, 1000},   times / 10,        1000, running_now | ps_modes};
// clang-format on

} // namespace servobus::c630s
