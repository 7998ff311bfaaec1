// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, open loop (ESD2205PR, ESD2505PR, YKE2405PR and YKE2608PR): the registers in which
// it differs from closed loop. yako/common.hpp has the others and explains a row's comment.
// servobus/device/yako.hpp includes it. Source: manual V2.6.0, appendix 3; [errata An] are in
// device/errata.md. Element i of an array is segment i + 1.
//
//     auto slow_segment_3(auto& axis) { // a client
//         return axis.template write<yako::open_loop::position_segment_speeds>(2, 90 * units::r_per_min);
//     }
#pragma once

#include <servobus/device/yako/common.hpp>

namespace servobus::yako::open_loop {

/// A stepper with open loop: it has the registers of its family, in yako/common.hpp, and those below.
struct device : yako::device {
    // cppcheck-suppress duplInheritedMember ; a variant has a name of its own
    static constexpr profile facts = detail::under_the_name("yako-open-loop");
};

template <class T> using ro = reg<T, access::ro, device>;
template <class T> using rw = reg<T, access::rw, device>;
template <class T> using segments = reg_array<rw<T>, 16>;

using namespace yako; // so that `open_loop::target_position` names the family's register

// clang-format off

// Status

/// 0008h 输入端子状态标志位  X0..X6, RO
inline constexpr ro<inputs>          input_state                         {0x0008, unstated,      no_unit,     no_default};
/// 0009h 输出端子状态标志位  Y0..Y2, RO [errata A27]
inline constexpr ro<outputs>         output_state                        {0x0009, unstated,      no_unit,     no_default};
/// 000Ch 当前速度  r/min, RO [errata A51]
inline constexpr ro<i16>             actual_speed                        {0x000C, full<i16>,     r_per_min,   no_default};

// Motion

/// 001Dh Jog模式运行速度  -3000..3000 r/min, default 120, RW [errata A13]
inline constexpr rw<i16>             jog_speed                           {0x001D, {-3000, 3000}, r_per_min,   120};
/// 0020h 起始速度  0..3000 r/min, default 0, RW [errata A48]
inline constexpr rw<u16>             start_speed                         {0x0020, {0, 3000},     r_per_min,   0};
/// 0023h 定位运动速度  0..3000 r/min, default 60, RW [errata A45]
inline constexpr rw<u16>             positioning_speed                   {0x0023, {0, 3000},     r_per_min,   60};

// Homing

/// 0031h 回原点模式  17..35 with gaps, see `is_valid`, default 24, RW [errata A16, A17]
inline constexpr rw<u16>             homing_method                       {0x0031, {17, 35},      no_unit,     24};
/// 0032h 回原点速度  5..3000 r/min, default 120, RW; to the switch [errata A39]
inline constexpr rw<u16>             homing_fast_speed                   {0x0032, {5, 3000},     r_per_min,   120};
/// 0033h 回原点查询速度  5..300 r/min, default 60, RW; back to its edge [errata A39]
inline constexpr rw<u16>             homing_slow_speed                   {0x0033, {5, 300},      r_per_min,   60};

// Terminals

/// 0040h 输入端子有效电平  0..65535, X0..X6, default 0, RW
inline constexpr rw<inputs>          input_polarity                      {0x0040, {0, 65535},    no_unit,     0};
/// 0045h 输入端子X4端子功能选择  0..18, default 0, RW [errata A24]
inline constexpr rw<input_function>  x4_function                         {0x0045, {0, 18},       no_unit,     0};
/// 0046h 输入端子X5端子功能选择  0..18, default 0, RW [errata A24]
inline constexpr rw<input_function>  x5_function                         {0x0046, {0, 18},       no_unit,     0};
/// 0047h 输入端子X6端子功能选择  0..18, default 0, RW [errata A24]
inline constexpr rw<input_function>  x6_function                         {0x0047, {0, 18},       no_unit,     0};
/// 004Bh 输出端子有效电平  0..65535, Y0..Y2, default 0, RW [errata A27]
inline constexpr rw<outputs>         output_polarity                     {0x004B, {0, 65535},    no_unit,     0};
/// 004Eh 输出端子Y2端子功能选择  0..11, default 0, RW [errata A25]
inline constexpr rw<output_function> y2_function                         {0x004E, {0, 11},       no_unit,     0};
/// 004Fh Y组端子自定义输出  0..65535, Y0..Y2, default 0, RW [errata A28]
inline constexpr rw<outputs>         user_outputs                        {0x004F, {0, 65535},    no_unit,     0};

// Segments, started by inputs

/// 0062h, 68h .. BCh 第1..16段位置定位运动速度  0..3000 r/min, default 120, RW/S
inline constexpr segments<u16>       position_segment_speeds             {{0x0062, {0, 3000},     r_per_min,   120,        saved}, 6};
/// 0063h, 69h .. BDh 第1..16段位置定位运动加速度  0..2000 ms, default 100, RW/S [errata A32, A48]
inline constexpr segments<u16>       position_segment_acceleration_times {{0x0063, {0, 2000},     millisecond, 100,        saved}, 6};
/// 0064h, 6Ah .. BEh 第1..16段位置定位运动减速度  0..2000 ms, default 100, RW/S [errata A32, A48]
inline constexpr segments<u16>       position_segment_deceleration_times {{0x0064, {0, 2000},     millisecond, 100,        saved}, 6};
/// 00C0h, C3h .. EDh 第1..16段速度段运行速度  -3000..3000 r/min, default 100, RW/S
inline constexpr segments<i16>       speed_segment_speeds                {{0x00C0, {-3000, 3000}, r_per_min,   100,        saved}, 3};
/// 00C1h, C4h .. EEh 第1..16段速度段加速时间  0..2000 ms, default 100, RW/S [errata A32, A48]
inline constexpr segments<u16>       speed_segment_acceleration_times    {{0x00C1, {0, 2000},     millisecond, 100,        saved}, 3};
/// 00C2h, C5h .. EFh 第1..16段速度段减速时间  0..2000 ms, default 100, RW/S [errata A32, A48]
inline constexpr segments<u16>       speed_segment_deceleration_times    {{0x00C2, {0, 2000},     millisecond, 100,        saved}, 3};
/// 0130h, 31h .. 3Fh 多段运动起始速度  -180..180 r/min, default 0, RW/S; of position and speed segments [errata A49]
inline constexpr segments<i16>       segment_start_speeds                {{0x0130, {-180, 180},   r_per_min,   0,          saved}, 1};

// Performance

/// 0102h 最大有效电流  0..7700 mA, the motor's rated current, RW/S [errata A48]
inline constexpr rw<u16>             max_current                         {0x0102, {0, 7700},     milliampere, no_default, saved};
/// 0106h 锁机电流百分比  0..100 % of 0102h, default 40, RW/S; at standstill [errata A48]
inline constexpr rw<u16>             holding_current                     {0x0106, {0, 100},      percent,     40,         saved};
/// 0107h 锁机时间  0..2000 ms, default 200, RW/S; from standstill to the holding current [errata A48]
inline constexpr rw<u16>             holding_delay                       {0x0107, {0, 2000},     millisecond, 200,        saved};
// clang-format on

} // namespace servobus::yako::open_loop
