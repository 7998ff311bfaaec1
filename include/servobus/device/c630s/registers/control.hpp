// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: the drive itself and basic control, groups P01 and P02. c630s/registers.hpp
// includes it; row.hpp explains the comments of its rows. Source: manual V24.111, sections 7.1 and 7.2;
// [errata Cn] are in device/errata_c630s.md.
//
//     auto hold_at_limit_switch(auto& servo) { // a client; the write goes into the EEPROM
//         constexpr auto hold = c630s::overtravel_stop::zero_speed_and_lock;
//         return store_if_different<c630s::stop_at_overtravel>(servo, hold);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P01-00 MCU软件版本号  0..65535, shown
inline constexpr ro<u16>              software_version                  {"P01-00"_p, {0, 65535}, no_unit,      no_default};
/// P01-02 伺服驱动器编号  0..65535, stopped, power cycle
inline constexpr rw<u16>              drive_number                      {"P01-02"_p, {0, 65535}, no_unit,      no_default, stopped_from_power_on};
/// P02-00 控制模式选择  0..6, default 1, stopped, immediate
inline constexpr rw<control_mode>     mode_of_operation                 {"P02-00"_p, {0, 6},     no_unit,      1,          stopped_now};
/// P02-01 编码器类型选择  0..1, default 0, stopped, power cycle, ALL [errata C32]
inline constexpr rw<encoder_kind>     encoder_type                      {"P02-01"_p, {0, 1},     no_unit,      0,          stopped_from_power_on | every_mode};
/// P02-02 旋转方向选择  0..1, default 0, stopped, power cycle, PST
inline constexpr rw<forward_rotation> direction_of_rotation             {"P02-02"_p, {0, 1},     no_unit,      0,          stopped_from_power_on | pst_modes};
/// P02-03 输出脉冲相位  0..1, default 0, stopped, power cycle, PST [errata C54]
inline constexpr rw<pulse_phase>      output_pulse_phase                {"P02-03"_p, {0, 1},     no_unit,      0,          stopped_from_power_on | pst_modes};
/// P02-05 伺服使能OFF停机方式选择  0..1, default 0, stopped, immediate, PST
inline constexpr rw<stop_mode>        stop_at_servo_off                 {"P02-05"_p, {0, 1},     no_unit,      0,          stopped_now | pst_modes};
/// P02-06 故障No.2停机方式选择  0..1, default 0, stopped, immediate, PST [errata C41]
inline constexpr rw<stop_mode>        stop_at_fault_no_2                {"P02-06"_p, {0, 1},     no_unit,      0,          stopped_now | pst_modes};
/// P02-07 超程停机方式选择  0..2, default 1, stopped, immediate, PST
inline constexpr rw<overtravel_stop>  stop_at_overtravel                {"P02-07"_p, {0, 2},     no_unit,      1,          stopped_now | pst_modes};
/// P02-08 故障No.1停机方式选择  0, default 0, stopped, immediate, PST [errata C41]
inline constexpr rw<stop_mode>        stop_at_fault_no_1                {"P02-08"_p, {0, 0},     no_unit,      0,          stopped_now | pst_modes};
/// P02-09 抱闸输出ON至指令接收延时  0..500 ms, default 250, running, immediate, PS
inline constexpr rw<u16>              brake_on_to_command_delay         {"P02-09"_p, {0, 500},   millisecond,  250,        running_now | ps_modes};
/// P02-10 静止状态,抱闸输出OFF至电机不通电延时  1..1000 ms, default 150, running, immediate, PS
inline constexpr rw<u16>              brake_off_to_power_off_delay      {"P02-10"_p, {1, 1000},  millisecond,  150,        running_now | ps_modes};
/// P02-11 旋转状态,抱闸输出OFF时转速阈值  0..3000 rpm, default 30, running, immediate, PS
inline constexpr rw<u16>              brake_off_speed                   {"P02-11"_p, {0, 3000},  r_per_min,    30,         running_now | ps_modes};
/// P02-12 旋转状态,伺服使能OFF至抱闸输出OFF延时  1..1000 ms, default 500, running, immediate, PS
inline constexpr rw<u16>              servo_off_to_brake_off_delay      {"P02-12"_p, {1, 1000},  millisecond,  500,        running_now | ps_modes};
/// P02-15 LED警告显示选择  0..1, default 0, stopped, immediate, PST
inline constexpr rw<warning_display>  warnings_on_panel                 {"P02-15"_p, {0, 1},     no_unit,      0,          stopped_now | pst_modes};
/// P02-18 伺服使能(S-ON)滤波时间常数  0..64 ms, default 0, stopped, immediate, PST
inline constexpr rw<u16>              servo_on_filter_time              {"P02-18"_p, {0, 64},    millisecond,  0,          stopped_now | pst_modes};
/// P02-21 驱动器允许的制动电阻最小值  ohm, shown, PST [errata C65]
inline constexpr ro<u16>              min_braking_resistance            {"P02-21"_p, full<u16>,  ohm,          no_default, pst_modes};
/// P02-22 内置制动电阻功率  W, shown, PST
inline constexpr ro<u16>              internal_braking_resistor_power   {"P02-22"_p, full<u16>,  watt,         no_default, pst_modes};
/// P02-23 内置制动电阻阻值  ohm, shown, PST
inline constexpr ro<u16>              internal_braking_resistance       {"P02-23"_p, full<u16>,  ohm,          no_default, pst_modes};
/// P02-24 电阻散热系数  10..100 %, default 30, stopped, immediate, PST
inline constexpr rw<u16>              braking_resistor_heat_dissipation {"P02-24"_p, {10, 100},  percent,      30,         stopped_now | pst_modes};
/// P02-25 制动电阻设置  0..3, default 0, stopped, immediate, PST
inline constexpr rw<braking_resistor> braking_resistor_type             {"P02-25"_p, {0, 3},     no_unit,      0,          stopped_now | pst_modes};
/// P02-26 外接制动电阻功率  1..65535 W, stopped, immediate, PST
inline constexpr rw<u16>              external_braking_resistor_power   {"P02-26"_p, {1, 65535}, watt,         no_default, stopped_now | pst_modes};
/// P02-27 外接制动电阻阻值  1..1000 ohm, stopped, immediate, PST [errata C65]
inline constexpr rw<u16>              external_braking_resistance       {"P02-27"_p, {1, 1000},  ohm,          no_default, stopped_now | pst_modes};
/// P02-31 系统参数初始化  0..2, default 0, stopped, immediate, PST; restart the drive afterwards [errata C39]
inline constexpr rw<initialisation>   initialise_parameters             {"P02-31"_p, {0, 2},     no_unit,      0,          stopped_now | pst_modes | trigger};
/// P02-32 面板默认显示功能  0..99, default 50, running, immediate [errata C50]
inline constexpr rw<u16>              default_display                   {"P02-32"_p, {0, 99},    no_unit,      50,         running_now};
/// P02-38 故障短路制动时间  0..30000 ms, default 5000, running, immediate, PST
inline constexpr rw<u16>              short_circuit_braking_time        {"P02-38"_p, {0, 30000}, millisecond,  5000,       running_now | pst_modes};
/// P02-39 故障短路制动阈值  0..3000 0.1 %, default 1000, running, immediate, PST [errata C56]
inline constexpr rw<u16>              short_circuit_braking_threshold   {"P02-39"_p, {0, 3000},  percent / 10, 1000,       running_now | pst_modes};
// clang-format on

} // namespace servobus::c630s
