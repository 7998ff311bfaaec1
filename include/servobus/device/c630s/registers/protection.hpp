// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: faults and protection, group P0A. c630s/registers.hpp includes it; row.hpp
// explains the comments of its rows. Source: manual V24.111, section 7.10; [errata Cn] are in
// device/errata_c630s.md.
//
//     auto guard_speed(auto& servo) { // a client; the write goes into the EEPROM
//         return store_if_different<c630s::overspeed_threshold>(servo, 3500 * units::r_per_min);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P0A-00 电源输入缺相保护选择  0..2, default 0, running, immediate
inline constexpr rw<phase_loss>    input_phase_loss_protection       {"P0A-00"_p, {0, 2},          no_unit,                  0,       running_now};
/// P0A-03 掉电保存功能使能选择  0..1, default 0, running, immediate
inline constexpr rw<off_on>        save_at_power_off                 {"P0A-03"_p, {0, 1},          no_unit,                  0,       running_now};
/// P0A-04 电机过载保护增益  50..300 %, default 100, stopped, immediate
inline constexpr rw<u16>           motor_overload_gain               {"P0A-04"_p, {50, 300},       percent,                  100,     stopped_now};
/// P0A-08 过速故障阀值  0..10000 rpm, default 0, running, immediate, PST
inline constexpr rw<u16>           overspeed_threshold               {"P0A-08"_p, {0, 10000},      r_per_min,                0,       running_now | pst_modes};
/// P0A-09 最大位置脉冲频率  100..4000 kHz, default 4000, stopped, immediate, P [errata C51]
inline constexpr rw<u16>           max_pulse_frequency               {"P0A-09"_p, {100, 4000},     kilohertz,                4000,    stopped_now | position_mode};
/// P0A-10 位置偏差过大故障阈值  1..1073741824 encoder counts / reference units, default 3145728, running, immediate, P; P0A-17 sets the unit [errata C34, C74]
inline constexpr rw<u32>           following_error_limit             {"P0A-10"_p, {1, 1073741824}, count,                    3145728, running_now | position_mode | scaled_elsewhere};
/// P0A-12 飞车保护功能使能  0..1, default 1, running, immediate, PST
inline constexpr rw<off_on>        runaway_protection                {"P0A-12"_p, {0, 1},          no_unit,                  1,       running_now | pst_modes};
/// P0A-16 低频共振位置偏差判断阈值  1..1000 encoder counts, default 5, running, immediate, P
inline constexpr rw<u16>           low_frequency_resonance_threshold {"P0A-16"_p, {1, 1000},       count,                    5,       running_now | position_mode};
/// P0A-17 位置设定单位选择  0..1, default 0, stopped, immediate, P
inline constexpr rw<position_unit> position_setting_unit             {"P0A-17"_p, {0, 1},          no_unit,                  0,       stopped_now | position_mode};
/// P0A-24 脉冲输入滤波时间常数  0..255 25 ns, default 0, stopped, power cycle, P [errata C57]
inline constexpr rw<u16>           pulse_input_filter_time           {"P0A-24"_p, {0, 255},        multiple<25>(nanosecond), 0,       stopped_from_power_on | position_mode};
/// P0A-25 速度反馈显示值滤波时间常数  0..5000 ms, default 50, stopped, immediate
inline constexpr rw<u16>           speed_display_filter_time         {"P0A-25"_p, {0, 5000},       millisecond,              50,      stopped_now};
/// P0A-26 电机过载屏蔽使能  0..1, default 0, stopped, immediate
inline constexpr rw<masking>       motor_overload_masking            {"P0A-26"_p, {0, 1},          no_unit,                  0,       stopped_now};
/// P0A-27 速度DO滤波时间常数  0..5000 ms, default 10, stopped, immediate
inline constexpr rw<u16>           speed_output_filter_time          {"P0A-27"_p, {0, 5000},       millisecond,              10,      stopped_now};
/// P0A-28 正交编码器滤波时间常数  0..255 25 ns, default 30, stopped, power cycle [errata C57]
inline constexpr rw<u16>           quadrature_filter_time            {"P0A-28"_p, {0, 255},        multiple<25>(nanosecond), 30,      stopped_from_power_on};
/// P0A-30 高速脉冲输入管脚滤波时间常数  0..255 25 ns, default 3, stopped, power cycle, P [errata C57]
inline constexpr rw<u16>           fast_pulse_input_filter_time      {"P0A-30"_p, {0, 255},        multiple<25>(nanosecond), 3,       stopped_from_power_on | position_mode};
/// P0A-32 堵转过温保护时间窗口  10..65535 ms, default 200, running, immediate
inline constexpr rw<u16>           stall_protection_time             {"P0A-32"_p, {10, 65535},     millisecond,              200,     running_now};
/// P0A-33 堵转过温保护使能  0..1, default 1, running, immediate
inline constexpr rw<off_on>        stall_protection                  {"P0A-33"_p, {0, 1},          no_unit,                  1,       running_now};
/// P0A-36 编码器多圈溢出故障选择  0..1, default 0, stopped, immediate, ALL
inline constexpr rw<masking>       multiturn_overflow_masking        {"P0A-36"_p, {0, 1},          no_unit,                  0,       stopped_now | every_mode};
// clang-format on

} // namespace servobus::c630s
