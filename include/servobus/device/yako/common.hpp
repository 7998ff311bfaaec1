// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the registers that closed loop and open loop have alike, in the order of the
// manual's tables. yako/closed_loop.hpp and yako/open_loop.hpp include it and add the registers that differ.
// Source: manual V2.6.0, appendices 2 and 3; [errata An] are in device/errata.md.
//
// A row's comment has the printed name, range, unit, default and access; of a pair it has the lower address.
// RW/S: a save (002Dh) keeps the value in the EEPROM. The manual does not state what happens to an RW value
// [errata A53]. Element i of an array is segment i + 1.
//
//     auto ramp_gently(auto& axis) { // a client of either variant; both registers in one frame
//         return write<yako::acceleration_time, yako::deceleration_time>(axis, 300 * units::millisecond,
//                                                                        300 * units::millisecond);
//     }
#pragma once

#include <servobus/device/yako/homing.hpp>
#include <servobus/device/yako/values.hpp>
#include <servobus/registers/reg.hpp>

namespace servobus::yako {

template <class T> using ro = reg<T, access::ro, device>;
template <class T> using rw = reg<T, access::rw, device>;
template <class T> using segments = reg_array<rw<T>, 16>;

using units::milliampere, units::millisecond, units::percent, units::pulse, units::r_per_min;

// clang-format off

// Status

/// 0000h 驱动器型号  a code, RO
inline constexpr ro<u16>               drive_model                   {0x0000, full<u16>,                 no_unit,     no_default};
/// 0001h 驱动器版本  RO
inline constexpr ro<u16>               drive_version                 {0x0001, full<u16>,                 no_unit,     no_default};
/// 0002h 驱动器节点号  the address in use, RO
inline constexpr ro<u16>               actual_node_address           {0x0002, full<u16>,                 no_unit,     no_default};
/// 0003h 拨码状态码  SW1..SW7, RO
inline constexpr ro<switches>          dip_switches                  {0x0003, unstated,                  no_unit,     no_default};
/// 0006h 当前错误码  0..5, 0 is none, RO [errata A36]
inline constexpr ro<u16>               error_code                    {0x0006, {0, 5},                    no_unit,     no_default};
/// 0007h 运动状态位  RO [errata A35]
inline constexpr ro<motion_status>     status_word                   {0x0007, unstated,                  no_unit,     no_default};
/// 000Ah 当前位置  pulses, RO; closed loop: the encoder's feedback in pulses, open loop: the commanded position [errata A22, A50, A51]
inline constexpr ro<i32>               actual_position               {0x000A, full<i32>,                 pulse,       no_default};

// Basic control

/// 0010h 默认运动方向  0..1, default 0, RW
inline constexpr rw<direction>         motion_direction              {0x0010, {0, 1},                    no_unit,     0};
/// 0011h 细分设置  400..51200, default 1000, RW [errata A40, A52]
inline constexpr rw<u16>               microstep_resolution          {0x0011, {400, 51200},              no_unit,     1000};
/// 0013h 自定义驱动器节点号  0..255, default 0, RW; in effect while all address switches are off [errata A38]
inline constexpr rw<u16>               node_address                  {0x0013, {0, 255},                  no_unit,     0,          communication};
/// 0014h 自定义通讯波特率  0..3, default 0, RW; takes effect from the next power-on [errata A53]
inline constexpr rw<baud_rate>         rs485_baud_rate               {0x0014, {0, 3},                    no_unit,     0,          communication | after_power_cycle};
/// 0015h 串口数据格式  0..3, default 0, RW; takes effect from the next power-on [errata A53]
inline constexpr rw<serial_format>     rs485_format                  {0x0015, {0, 3},                    no_unit,     0,          communication | after_power_cycle};
/// 0017h 超限位停车方式  0..1, default 0, RW
inline constexpr rw<over_travel_stop>  over_travel_stop_mode         {0x0017, {0, 1},                    no_unit,     0};
/// 0018h 内部软限位开关  0..1, default 0, RW [errata A9]
inline constexpr rw<limit_enable>      software_limits               {0x0018, {0, 1},                    no_unit,     0};
/// 0019h 32位寄存器大小端配置  0..1, default 0, RW [errata A9, A23]
inline constexpr rw<word_order_setting>        pair_word_order               {0x0019, {0, 1},                    no_unit,     0,          communication};

// Motion

/// 001Eh Jog模式加速时间  0..2000 ms, default 100, RW
inline constexpr rw<u16>               jog_acceleration_time         {0x001E, {0, 2000},                 millisecond, 100};
/// 001Fh Jog模式减速时间  0..2000 ms, default 100, RW
inline constexpr rw<u16>               jog_deceleration_time         {0x001F, {0, 2000},                 millisecond, 100};
/// 0021h 加速时间  0..2000 ms, default 100, RW
inline constexpr rw<u16>               acceleration_time             {0x0021, {0, 2000},                 millisecond, 100};
/// 0022h 减速时间  0..2000 ms, default 100, RW
inline constexpr rw<u16>               deceleration_time             {0x0022, {0, 2000},                 millisecond, 100};
/// 0024h 总脉冲数  -2147483648..2147483647 pulses, default 5000, RW [errata A15, A29, A50]
inline constexpr rw<i32>               target_position               {0x0024, {-2147483648, 2147483647}, pulse,       5000,       motion};
/// 0027h 运动控制命令  0..65535, RW [errata A10, A11, A47]
inline constexpr rw<motion_code>           motion_command                {0x0027, {0, 65535},                no_unit,     no_default, trigger};
/// 002Dh 辅助控制指令  0..65535, RW [errata A47]
inline constexpr rw<auxiliary>         auxiliary_command             {0x002D, {0, 65535},                no_unit,     no_default, trigger};

// Homing

/// 0030h 回零辅助设置  0..11, default 0, RW
inline constexpr rw<offset_handling>   homing_offset_mode            {0x0030, {0, 11},                   no_unit,     0};
/// 0034h 回原点加减速时间  30..2000 ms, default 100, RW
inline constexpr rw<u16>               homing_ramp_time              {0x0034, {30, 2000},                millisecond, 100};
/// 0035h 原点偏置值  -2147483648..2147483647 pulses, default 0, RW [errata A15, A22, A50]
inline constexpr rw<i32>               home_offset                   {0x0035, {-2147483648, 2147483647}, pulse,       0};
/// 0037h 软限位正向  -2147483648..2147483647 pulses, default 0, RW [errata A15, A50]
inline constexpr rw<i32>               positive_software_limit       {0x0037, {-2147483648, 2147483647}, pulse,       0};
/// 0039h 软限位负向  -2147483648..2147483647 pulses, default 0, RW [errata A15, A50]
inline constexpr rw<i32>               negative_software_limit       {0x0039, {-2147483648, 2147483647}, pulse,       0};

// Terminals

/// 0041h 输入端子X0端子功能选择  0..18, default 1, RW [errata A24]
inline constexpr rw<input_function>    x0_function                   {0x0041, {0, 18},                   no_unit,     1};
/// 0042h 输入端子X1端子功能选择  0..18, default 2, RW [errata A24]
inline constexpr rw<input_function>    x1_function                   {0x0042, {0, 18},                   no_unit,     2};
/// 0043h 输入端子X2端子功能选择  0..18, default 3, RW [errata A24]
inline constexpr rw<input_function>    x2_function                   {0x0043, {0, 18},                   no_unit,     3};
/// 0044h 输入端子X3端子功能选择  0..18, default 0, RW [errata A24]
inline constexpr rw<input_function>    x3_function                   {0x0044, {0, 18},                   no_unit,     0};
/// 004Ch 输出端子Y0端子功能选择  0..11, default 0, RW [errata A25]
inline constexpr rw<output_function>   y0_function                   {0x004C, {0, 11},                   no_unit,     0};
/// 004Dh 输出端子Y1端子功能选择  0..11, default 0, RW [errata A25]
inline constexpr rw<output_function>   y1_function                   {0x004D, {0, 11},                   no_unit,     0};

// Segments, started by inputs

/// 0050h 相对位置/绝对位置  0..1, default 0, RW; of moves that an input starts [errata A31]
inline constexpr rw<positioning>       io_positioning                {0x0050, {0, 1},                    no_unit,     0};
/// 0051h PV触发信号电平选择  0..1, default 0, RW [errata A34]
inline constexpr rw<pv_trigger>        pv_trigger_mode               {0x0051, {0, 1},                    no_unit,     0};
/// 0060h, 66h .. BAh 第1..16段运动脉冲指令  -2147483648..2147483647 pulses, default 5000, RW [errata A15, A29, A30, A50]
inline constexpr segments<i32>         position_segment_targets      {{0x0060, {-2147483648, 2147483647}, pulse,       5000}, 6};
/// 0065h, 6Bh .. BFh 第1..16段位置定位运动相对/绝对定位  0..1, default 0, RW/S [errata A31]
inline constexpr segments<positioning> position_segment_positionings {{0x0065, {0, 1},                    no_unit,     0,          saved}, 6};

// Performance

/// 0104h 基础电流百分比  0..100 % of 0102h, default 40, RW/S [errata A41]
inline constexpr rw<u16>               base_current                  {0x0104, {0, 100},                  percent,     40,         saved};
/// 0105h 开环最大电流百分比  0..100 % of 0102h, default 100, RW/S
inline constexpr rw<u16>               open_loop_max_current         {0x0105, {0, 100},                  percent,     100,        saved};
/// 0108h IO端子滤波系数  0..65535, default 2, RW/S
inline constexpr rw<u16>               io_filter_factor              {0x0108, {0, 65535},                no_unit,     2,          saved};
/// 0109h 脉冲低通滤波系数  0..1024, default 5, RW/S; a lower value filters more
inline constexpr rw<u16>               pulse_low_pass_factor         {0x0109, {0, 1024},                 no_unit,     5,          saved};
/// 010Ch 到位结束时间  0..200, default 10, RW/S [errata A52]
inline constexpr rw<u16>               in_position_time              {0x010C, {0, 200},                  no_unit,     10,         saved};
/// 010Dh 脉冲均值滤波系数  0..512, default 512, RW/S; a higher value filters more
inline constexpr rw<u16>               pulse_averaging_factor        {0x010D, {0, 512},                  no_unit,     512,        saved};
/// 010Eh 电流环Kp增益倍数  0..65535, RW/S
inline constexpr rw<u16>               current_loop_kp_multiplier    {0x010E, {0, 65535},                no_unit,     no_default, saved};
/// 010Fh 电流环Kp增益  0..65535, RW/S
inline constexpr rw<u16>               current_loop_kp               {0x010F, {0, 65535},                no_unit,     no_default, saved};
/// 0110h 电流环Ki增益  0..65535, RW/S
inline constexpr rw<u16>               current_loop_ki               {0x0110, {0, 65535},                no_unit,     no_default, saved};
/// 0111h 电流环Kc增益  0..65535, RW/S
inline constexpr rw<u16>               current_loop_kc               {0x0111, {0, 65535},                no_unit,     no_default, saved};
// clang-format on

} // namespace servobus::yako
