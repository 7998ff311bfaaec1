// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: values that the drive measures and records, group P0B. A 64-bit value has a
// register for each half. The low half comes first, whatever the word order. The halves belong together only
// if one request reads both. c630s/registers.hpp includes it; row.hpp explains the comments of its
// rows. Source: manual V24.111, sections 5.1.6 and 7.11; [errata Cn] are in device/errata_c630s.md.
//
//     auto position(auto& servo) { // a client whose word order is known; both halves in one request
//         return read<c630s::mechanical_position_low, c630s::mechanical_position_high>(servo);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P0B-00 实际电机转速  rpm, shown, PST
inline constexpr ro<i16>          actual_speed                   {"P0B-00"_p, full<i16>, r_per_min,      no_default, pst_modes};
/// P0B-01 速度指令  rpm, shown, PS
inline constexpr ro<i16>          speed_command                  {"P0B-01"_p, full<i16>, r_per_min,      no_default, ps_modes};
/// P0B-02 内部转矩指令(相对于额定转矩)  %, shown, PST [errata C42]
inline constexpr ro<i16>          torque_command                 {"P0B-02"_p, full<i16>, percent / 10,   no_default, pst_modes};
/// P0B-03 输入信号(DI信号)监视  shown, PST
inline constexpr ro<inputs>       input_state                    {"P0B-03"_p, unstated,  no_unit,        no_default, pst_modes};
/// P0B-05 输出信号(DO信号)监视  shown, PST
inline constexpr ro<outputs>      output_state                   {"P0B-05"_p, unstated,  no_unit,        no_default, pst_modes};
/// P0B-07 绝对位置计数器  reference units, shown, PST
inline constexpr ro<i32>          absolute_position              {"P0B-07"_p, full<i32>, reference_unit, no_default, pst_modes};
/// P0B-09 机械角度  65536 a turn on an ancestor of the drive, shown, PST [errata C45]
inline constexpr ro<u16>          mechanical_angle               {"P0B-09"_p, full<u16>, count,          no_default, pst_modes};
/// P0B-10 电气角度  deg, shown, PST [errata C44]
inline constexpr ro<u16>          electrical_angle               {"P0B-10"_p, full<u16>, degree,         no_default, pst_modes};
/// P0B-11 输入位置指令对应速度信息  rpm, shown, P
inline constexpr ro<i16>          position_command_speed         {"P0B-11"_p, full<i16>, r_per_min,      no_default, position_mode};
/// P0B-12 平均负载率  %, shown, PST [errata C44]
inline constexpr ro<u16>          average_load                   {"P0B-12"_p, full<u16>, percent,        no_default, pst_modes};
/// P0B-13 输入指令脉冲计数器  reference units, shown, P
inline constexpr ro<i32>          command_pulses                 {"P0B-13"_p, full<i32>, reference_unit, no_default, position_mode};
/// P0B-15 编码器位置偏差计数器  encoder counts, shown, P [errata C42, C47]
inline constexpr ro<i32>          encoder_following_error        {"P0B-15"_p, full<i32>, count,          no_default, position_mode};
/// P0B-17 反馈脉冲计数器  encoder counts, shown, PST [errata C42]
inline constexpr ro<i32>          feedback_pulses                {"P0B-17"_p, full<i32>, count,          no_default, pst_modes};
/// P0B-19 总上电时间  s, shown, PST [errata C44]
inline constexpr ro<u32>          power_on_time                  {"P0B-19"_p, full<u32>, second,         no_default, pst_modes};
/// P0B-21 AI1采样电压值  V, shown, PST [errata C42]
inline constexpr ro<i16>          ai1_voltage                    {"P0B-21"_p, full<i16>, volt / 100,     no_default, pst_modes};
/// P0B-22 AI2采样电压值  V, shown, PST [errata C42]
inline constexpr ro<i16>          ai2_voltage                    {"P0B-22"_p, full<i16>, volt / 100,     no_default, pst_modes};
/// P0B-24 相电流有效值  A, shown, PST [errata C42]
inline constexpr ro<u16>          phase_current                  {"P0B-24"_p, full<u16>, ampere / 100,   no_default, pst_modes};
/// P0B-26 母线电压值  V, shown, PST [errata C42]
inline constexpr ro<u16>          bus_voltage                    {"P0B-26"_p, full<u16>, volt / 10,      no_default, pst_modes};
/// P0B-27 模块温度值  degC, shown, PST
inline constexpr ro<i16>          module_temperature             {"P0B-27"_p, full<i16>, degree_celsius, no_default, pst_modes};
/// P0B-33 故障记录  0..9, default 0, running, immediate, PST
inline constexpr rw<fault_record> selected_fault_record          {"P0B-33"_p, {0, 9},    no_unit,        0,          when_running | immediate | pst_modes};
/// P0B-34 所选次数故障码  shown, PST [errata C17]
inline constexpr ro<u16>          recorded_alarm                 {"P0B-34"_p, full<u16>, no_unit,        no_default, pst_modes};
/// P0B-35 所选故障时间戳  s, shown, PST
inline constexpr ro<u32>          recorded_time                  {"P0B-35"_p, full<u32>, second,         no_default, pst_modes};
/// P0B-37 所选故障时电机转速  rpm, shown, PST
inline constexpr ro<i16>          recorded_speed                 {"P0B-37"_p, full<i16>, r_per_min,      no_default, pst_modes};
/// P0B-38 所选故障时电机U相电流  A, shown, PST [errata C42, C48]
inline constexpr ro<i16>          recorded_u_current             {"P0B-38"_p, full<i16>, ampere / 100,   no_default, pst_modes};
/// P0B-39 所选故障时电机V相电流  A, shown, PST [errata C42, C48]
inline constexpr ro<i16>          recorded_v_current             {"P0B-39"_p, full<i16>, ampere / 100,   no_default, pst_modes};
/// P0B-40 所选故障时母线电压  V, shown, PST [errata C43]
inline constexpr ro<u16>          recorded_bus_voltage           {"P0B-40"_p, full<u16>, volt / 10,      no_default, pst_modes};
/// P0B-41 所选故障时输入端子状态  shown, PST
inline constexpr ro<inputs>       recorded_inputs                {"P0B-41"_p, unstated,  no_unit,        no_default, pst_modes};
/// P0B-42 所选故障时输出端子状态  shown, PST
inline constexpr ro<outputs>      recorded_outputs               {"P0B-42"_p, unstated,  no_unit,        no_default, pst_modes};
/// P0B-53 位置偏差计数器  reference units, shown, P [errata C47]
inline constexpr ro<i32>          following_error                {"P0B-53"_p, full<i32>, reference_unit, no_default, position_mode};
/// P0B-55 实际电机转速  0.1 rpm, shown, PST [errata C46]
inline constexpr ro<i32>          fine_actual_speed              {"P0B-55"_p, full<i32>, r_per_min / 10, no_default, pst_modes};
/// P0B-58 机械绝对位置(低32位)  encoder counts, default 0, shown, ALL
inline constexpr ro<u32>          mechanical_position_low        {"P0B-58"_p, full<u32>, count,          0,          every_mode};
/// P0B-60 机械绝对位置(高32位)  encoder counts, default 0, shown, ALL
inline constexpr ro<i32>          mechanical_position_high       {"P0B-60"_p, full<i32>, count,          0,          every_mode};
/// P0B-64 实时输入位置指令计数器  reference units, shown, PST
inline constexpr ro<i32>          input_position_command         {"P0B-64"_p, full<i32>, reference_unit, no_default, pst_modes};
/// P0B-70 绝对值编码器旋转圈数数据  r, default 0, shown, ALL
inline constexpr ro<u16>          encoder_revolutions            {"P0B-70"_p, full<u16>, revolution,     0,          every_mode};
/// P0B-71 绝对值编码器的1圈内位置  encoder counts, default 0, shown, ALL
inline constexpr ro<u32>          encoder_position_in_revolution {"P0B-71"_p, full<u32>, count,          0,          every_mode};
/// P0B-77 绝对值编码器绝对位置(低32位)  encoder counts, default 0, shown, ALL
inline constexpr ro<u32>          encoder_position_low           {"P0B-77"_p, full<u32>, count,          0,          every_mode};
/// P0B-79 绝对值编码器绝对位置(高32位)  encoder counts, default 0, shown, ALL
inline constexpr ro<i32>          encoder_position_high          {"P0B-79"_p, full<i32>, count,          0,          every_mode};
/// P0B-81 旋转负载单圈位置(低32位)  encoder counts, default 0, shown, ALL
inline constexpr ro<u32>          load_position_low              {"P0B-81"_p, full<u32>, count,          0,          every_mode};
/// P0B-83 旋转负载单圈位置(高32位)  encoder counts, default 0, shown, ALL
inline constexpr ro<i32>          load_position_high             {"P0B-83"_p, full<i32>, count,          0,          every_mode};
/// P0B-85 旋转负载单圈位置  reference units, default 0, shown, ALL
inline constexpr ro<i32>          load_position                  {"P0B-85"_p, full<i32>, reference_unit, 0,          every_mode};
// clang-format on

} // namespace servobus::c630s
