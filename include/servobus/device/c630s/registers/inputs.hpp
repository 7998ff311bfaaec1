// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: digital and analogue inputs, group P03. c630s/registers.hpp includes it;
// row.hpp explains the comments of its rows. Source: manual V24.111, section 7.3; [errata Cn] are in
// device/errata_c630s.md.
//
//     auto wired_inputs(auto& servo) { // a client
//         return read<c630s::di1_function, c630s::di1_logic, c630s::di2_function, c630s::di2_logic>(servo);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P03-00 上电有效的DI功能分配  0..0xFFFF, default 0, running, power cycle; FunIN.1 to 16, bit 0 enables the motor at power-on
inline constexpr rw<input_functions<1>>  power_on_functions_1_to_16  {"P03-00"_p, {0, 0xFFFF},   no_unit,           0,    running_from_power_on};
/// P03-01 上电有效的DI功能分配  0..0xFFFF, default 0, running, power cycle; FunIN.17 to 32 [errata C28]
inline constexpr rw<input_functions<17>> power_on_functions_17_to_32 {"P03-01"_p, {0, 0xFFFF},   no_unit,           0,    running_from_power_on};
/// P03-02 DI1端子功能选择  0..38, default 14, running, at stop [errata C19]
inline constexpr rw<input_function>      di1_function                {"P03-02"_p, {0, 38},       no_unit,           1,    running_from_stop};
/// P03-03 DI1端子逻辑选择  0..4, default 0, running, at stop [errata C27]
inline constexpr rw<input_logic>         di1_logic                   {"P03-03"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-04 DI2端子功能选择  0..38, default 15, running, at stop [errata C19]
inline constexpr rw<input_function>      di2_function                {"P03-04"_p, {0, 38},       no_unit,           14,   running_from_stop};
/// P03-05 DI2端子逻辑选择  0..4, default 0, running, at stop
inline constexpr rw<input_logic>         di2_logic                   {"P03-05"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-06 DI3端子功能选择  0..38, default 13, running, at stop [errata C19]
inline constexpr rw<input_function>      di3_function                {"P03-06"_p, {0, 38},       no_unit,           15,   running_from_stop};
/// P03-07 DI3端子逻辑选择  0..4, default 0, running, at stop
inline constexpr rw<input_logic>         di3_logic                   {"P03-07"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-08 DI4端子功能选择  0..38, default 2, running, at stop [errata C19]
inline constexpr rw<input_function>      di4_function                {"P03-08"_p, {0, 38},       no_unit,           2,    running_from_stop};
/// P03-09 DI4端子逻辑选择  0..4, default 0, running, at stop
inline constexpr rw<input_logic>         di4_logic                   {"P03-09"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-10 DI5端子功能选择  0..38, default 1, running, at stop [errata C19]
inline constexpr rw<input_function>      di5_function                {"P03-10"_p, {0, 38},       no_unit,           26,   running_from_stop};
/// P03-11 DI5端子逻辑选择  0..4, default 0, running, at stop
inline constexpr rw<input_logic>         di5_logic                   {"P03-11"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-12 DI6端子功能选择  0..38, default 12, running, at stop [errata C19]
inline constexpr rw<input_function>      di6_function                {"P03-12"_p, {0, 38},       no_unit,           34,   running_from_stop};
/// P03-13 DI6端子逻辑选择  0..4, default 0, running, at stop
inline constexpr rw<input_logic>         di6_logic                   {"P03-13"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-14 DI7端子功能选择  0..38, default 3, running, at stop [errata C19]
inline constexpr rw<input_function>      di7_function                {"P03-14"_p, {0, 38},       no_unit,           31,   running_from_stop};
/// P03-15 DI7端子逻辑选择  0..4, default 0, running, at stop
inline constexpr rw<input_logic>         di7_logic                   {"P03-15"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-16 DI8端子功能选择  0..38, default 31, running, at stop [errata C19]
inline constexpr rw<input_function>      di8_function                {"P03-16"_p, {0, 38},       no_unit,           32,   running_from_stop};
/// P03-17 DI8端子逻辑选择  0..4, default 0, running, at stop
inline constexpr rw<input_logic>         di8_logic                   {"P03-17"_p, {0, 4},        no_unit,           0,    running_from_stop};
/// P03-34 上电有效的DI功能分配  0..0xFFFF, default 0, running, power cycle; FunIN.33 to 48 [errata C28, C30]
inline constexpr rw<input_functions<33>> power_on_functions_33_to_48 {"P03-34"_p, {0, 0xFFFF},   no_unit,           0,    running_from_power_on};
/// P03-35 上电有效的DI功能分配  0..0xFFFF, default 0, running, power cycle; FunIN.49 to 64, none of which exists [errata C28, C30]
inline constexpr rw<input_functions<49>> power_on_functions_49_to_64 {"P03-35"_p, {0, 0xFFFF},   no_unit,           0,    running_from_power_on};
/// P03-36 AI1偏置  -5000..5000 mV, default 0, running, immediate
inline constexpr rw<i16>                 ai1_offset                  {"P03-36"_p, {-5000, 5000}, millivolt,         0,    running_now};
/// P03-37 AI1输入滤波时间常数  0..655.35 ms, default 2.00, running, immediate
inline constexpr rw<u16>                 ai1_filter_time             {"P03-37"_p, {0, 65535},    millisecond / 100, 200,  running_now};
/// P03-38 AI1输入中值滤波使能  0..1, default 0, running, immediate
inline constexpr rw<off_on>              ai1_median_filter           {"P03-38"_p, {0, 1},        no_unit,           0,    running_now};
/// P03-39 AI1死区  0..1000.0 mV, default 10.0, running, immediate
inline constexpr rw<u16>                 ai1_dead_zone               {"P03-39"_p, {0, 10000},    millivolt / 10,    100,  running_now};
/// P03-40 AI1零漂  -500.0..500.0 mV, default 0.0, running, immediate
inline constexpr rw<i16>                 ai1_zero_drift              {"P03-40"_p, {-5000, 5000}, millivolt / 10,    0,    running_now};
/// P03-41 AI2偏置  -5000..5000 mV, default 0, running, immediate [errata C29]
inline constexpr rw<i16>                 ai2_offset                  {"P03-41"_p, {-5000, 5000}, millivolt,         0,    running_now};
/// P03-42 AI2输入滤波时间常数  0..655.35 ms, default 2.00, running, immediate [errata C29]
inline constexpr rw<u16>                 ai2_filter_time             {"P03-42"_p, {0, 65535},    millisecond / 100, 200,  running_now};
/// P03-43 AI1输入中值滤波使能  0..1, default 0, running, immediate [errata C29]
inline constexpr rw<off_on>              ai2_median_filter           {"P03-43"_p, {0, 1},        no_unit,           0,    running_now};
/// P03-44 AI2死区  0..1000.0 mV, default 10.0, running, immediate [errata C29]
inline constexpr rw<u16>                 ai2_dead_zone               {"P03-44"_p, {0, 10000},    millivolt / 10,    100,  running_now};
/// P03-45 AI2零漂  -500.0..500.0 mV, default 0.0, running, immediate [errata C29]
inline constexpr rw<i16>                 ai2_zero_drift              {"P03-45"_p, {-5000, 5000}, millivolt / 10,    0,    running_now};
/// P03-51 模拟量10V对应速度值  0..9000 rpm, default 3000rpm, stopped, immediate [errata C52]
inline constexpr rw<u16>                 speed_at_10_v               {"P03-51"_p, {0, 9000},     r_per_min,         3000, stopped_now};
/// P03-52 模拟量10V对应转矩值  1.00..8.00, default 1.00, stopped, immediate; of the rated torque [errata C73]
inline constexpr rw<u16>                 torque_at_10_v              {"P03-52"_p, {100, 800},    times / 100,       100,  stopped_now};
// clang-format on

} // namespace servobus::c630s
