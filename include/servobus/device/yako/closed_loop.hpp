// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, closed loop (ESS242-, ESS257- and ESS286-Rx1): the registers in which it differs
// from open loop. yako/common.hpp has the others and explains a row's comment. servobus/device/yako.hpp
// includes it. Source: manual V2.6.0, appendix 2; [errata An] are in device/errata.md.
//
// Register 001Ah, `speed_resolution`, rescales speeds; the manual does not state which [errata A37]. The row
// of every speed is therefore `scaled_elsewhere`: range, unit and default are those at 1 r/min, and values
// are written as counts, by `raw`. Element i of an array is segment i + 1.
//
//     auto home_slowly(auto& axis) { // a client; counts of 1 r/min, if 001Ah is 0
//         return write<yako::closed_loop::homing_fast_speed, yako::closed_loop::homing_slow_speed>(
//             axis, raw(60), raw(20));
//     }
#pragma once

#include <servobus/device/yako/common.hpp>

namespace servobus::yako::closed_loop {

/// A stepper with closed loop: it has the registers of its family, in yako/common.hpp, and those below.
struct device : yako::device {
    // cppcheck-suppress duplInheritedMember ; a variant has a name of its own
    static constexpr profile facts = detail::under_the_name("yako-closed-loop");
};

template <class T> using ro = reg<T, access::ro, device>;
template <class T> using rw = reg<T, access::rw, device>;
template <class T> using segments = reg_array<rw<T>, 16>;

using namespace yako; // so that `closed_loop::target_position` names the family's register

// clang-format off

// Status

/// 0008h 输入端子状态标志位  X0..X3, RO [errata A24]
inline constexpr ro<inputs>            input_state                         {0x0008, unstated,      no_unit,     no_default};
/// 0009h 输出端子状态标志位  Y0, Y1, RO [errata A25]
inline constexpr ro<outputs>           output_state                        {0x0009, unstated,      no_unit,     no_default};
/// 000Ch 当前速度  r/min, RO [errata A37, A51]
inline constexpr ro<i16>               actual_speed                        {0x000C, full<i16>,     r_per_min,   no_default, scaled_elsewhere};

// Basic control

/// 001Ah 速度精度  0..1, default 0, RW [errata A37]
inline constexpr rw<speed_count>       speed_resolution                    {0x001A, {0, 1},        no_unit,     0};

// Motion

/// 001Dh Jog模式运行速度  -3000..3000 r/min, default 120, RW [errata A13, A37]
inline constexpr rw<i16>               jog_speed                           {0x001D, {-3000, 3000}, r_per_min,   120,        scaled_elsewhere};
/// 0020h 起始速度  0..3000 r/min, default 30, RW [errata A37, A48]
inline constexpr rw<u16>               start_speed                         {0x0020, {0, 3000},     r_per_min,   30,         scaled_elsewhere};
/// 0023h 定位运动速度  0..3000 r/min, default 60, RW [errata A37, A45]
inline constexpr rw<u16>               positioning_speed                   {0x0023, {0, 3000},     r_per_min,   60,         scaled_elsewhere};

// Homing

/// 0031h 回原点模式  -4..35 with gaps, see `is_valid`, default 24, RW [errata A16, A17, A18]
inline constexpr rw<i16>               homing_method                       {0x0031, {-4, 35},      no_unit,     24};
/// 0032h 回原点速度  5..3000 r/min, default 120, RW; to the switch [errata A37, A39]
inline constexpr rw<u16>               homing_fast_speed                   {0x0032, {5, 3000},     r_per_min,   120,        scaled_elsewhere};
/// 0033h 回原点查询速度  5..300 r/min, default 60, RW; back to its edge [errata A37, A39]
inline constexpr rw<u16>               homing_slow_speed                   {0x0033, {5, 300},      r_per_min,   60,         scaled_elsewhere};
/// 003Bh 碰撞回原阈值  50..4000 of following error, default 200, RW; methods -1..-4 [errata A7, A46, A52]
inline constexpr rw<u16>               collision_threshold                 {0x003B, {50, 4000},    no_unit,     200};
/// 003Ch 碰撞回原电流百分比  20..100 %, default 50, RW; methods -1..-4 [errata A7, A46]
inline constexpr rw<u16>               collision_current                   {0x003C, {20, 100},     percent,     50};

// Terminals

/// 0040h 输入端子有效电平  0..65535, X0..X3, default 0, RW
inline constexpr rw<inputs>            input_polarity                      {0x0040, {0, 65535},    no_unit,     0};
/// 004Bh 输出端子有效电平  0..65535, Y0, Y1, default 0, RW
inline constexpr rw<outputs>           output_polarity                     {0x004B, {0, 65535},    no_unit,     0};
/// 004Fh Y组端子自定义输出  0..65535, Y0, Y1, default 0, RW [errata A28]
inline constexpr rw<outputs>           user_outputs                        {0x004F, {0, 65535},    no_unit,     0};

// Segments, started by inputs

/// 0062h, 68h .. BCh 第1..16段位置定位运动速度  0..3000 r/min, default 120, RW/S [errata A37]
inline constexpr segments<u16>         position_segment_speeds             {{0x0062, {0, 3000},     r_per_min,   120,        saved | scaled_elsewhere}, 6};
/// 0063h, 69h .. BDh 第1..16段位置定位运动加速度  0..2000 ms, default 50, RW/S [errata A32, A48]
inline constexpr segments<u16>         position_segment_acceleration_times {{0x0063, {0, 2000},     millisecond, 50,         saved}, 6};
/// 0064h, 6Ah .. BEh 第1..16段位置定位运动减速度  0..2000 ms, default 50, RW/S [errata A32, A48]
inline constexpr segments<u16>         position_segment_deceleration_times {{0x0064, {0, 2000},     millisecond, 50,         saved}, 6};
/// 00C0h, C3h .. EDh 第1..16段速度段运行速度  -3000..3000 r/min, default 100, RW/S [errata A37]
inline constexpr segments<i16>         speed_segment_speeds                {{0x00C0, {-3000, 3000}, r_per_min,   100,        saved | scaled_elsewhere}, 3};
/// 00C1h, C4h .. EEh 第1..16段速度段加速时间  0..2000 ms, default 50, RW/S [errata A32, A48]
inline constexpr segments<u16>         speed_segment_acceleration_times    {{0x00C1, {0, 2000},     millisecond, 50,         saved}, 3};
/// 00C2h, C5h .. EFh 第1..16段速度段减速时间  0..2000 ms, default 50, RW/S [errata A32, A48]
inline constexpr segments<u16>         speed_segment_deceleration_times    {{0x00C2, {0, 2000},     millisecond, 50,         saved}, 3};

// Performance

/// 0100h 闭环算法  1..3, default 3, RW/S
inline constexpr rw<control_algorithm> closed_loop_algorithm               {0x0100, {1, 3},        no_unit,     3,          saved};
/// 0101h 编码器分辨率  0..65535, four counts a line, default 4000, RW/S
inline constexpr rw<u16>               encoder_resolution                  {0x0101, {0, 65535},    no_unit,     4000,       saved};
/// 0102h 最大有效电流  0..5600 mA, the motor's rated current, RW/S [errata A48]
inline constexpr rw<u16>               max_current                         {0x0102, {0, 5600},     milliampere, no_default, saved};
/// 0103h 闭环最大电流百分比  0..150 % of 0102h, default 100, RW/S
inline constexpr rw<u16>               closed_loop_max_current             {0x0103, {0, 150},      percent,     100,        saved};
/// 0106h 锁机电流百分比  0..100 % of 0102h, default 100, RW/S; at standstill [errata A48]
inline constexpr rw<u16>               holding_current                     {0x0106, {0, 100},      percent,     100,        saved};
/// 0107h 锁机时间  0..20000 ms, default 200, RW/S; from standstill to the holding current [errata A48]
inline constexpr rw<u16>               holding_delay                       {0x0107, {0, 20000},    millisecond, 200,        saved};
/// 010Ah 位置超差报警阈值  1..65535, default 4000, RW/S [errata A52]
inline constexpr rw<u16>               following_error_limit               {0x010A, {1, 65535},    no_unit,     4000,       saved};
/// 010Bh 定位误差范围  1..256, default 5, RW/S [errata A52]
inline constexpr rw<u16>               position_window                     {0x010B, {1, 256},      no_unit,     5,          saved};
/// 0112h LA速度Kp1  0..65535, RW/S
inline constexpr rw<u16>               la_speed_kp_1                       {0x0112, {0, 65535},    no_unit,     no_default, saved};
/// 0113h LA速度Kv1  0..65535, RW/S
inline constexpr rw<u16>               la_speed_kv_1                       {0x0113, {0, 65535},    no_unit,     no_default, saved};
/// 0114h LA速度节点1  0..65535, RW/S
inline constexpr rw<u16>               la_speed_node_1                     {0x0114, {0, 65535},    no_unit,     no_default, saved};
/// 0115h LA速度Kp2  0..65535, RW/S
inline constexpr rw<u16>               la_speed_kp_2                       {0x0115, {0, 65535},    no_unit,     no_default, saved};
/// 0116h LA速度Kv2  0..65535, RW/S
inline constexpr rw<u16>               la_speed_kv_2                       {0x0116, {0, 65535},    no_unit,     no_default, saved};
/// 0117h LA速度节点2  0..65535, RW/S
inline constexpr rw<u16>               la_speed_node_2                     {0x0117, {0, 65535},    no_unit,     no_default, saved};
/// 0118h LA速度前馈Kvf增益  0..65535, RW/S
inline constexpr rw<u16>               la_speed_feedforward_kvf            {0x0118, {0, 65535},    no_unit,     no_default, saved};
/// 0119h LA位置环Ki增益  0..65535, RW/S
inline constexpr rw<u16>               la_position_ki                      {0x0119, {0, 65535},    no_unit,     no_default, saved};
// clang-format on

} // namespace servobus::yako::closed_loop
