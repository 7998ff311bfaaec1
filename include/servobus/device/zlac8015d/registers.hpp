// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D dual hub servo: its register map, 116 registers at 120 addresses, in the order of the
// manual's table. servobus/device/zlac8015d.hpp includes it; so do the catalogue and the drive's own headers.
// Source: RS485 manual V1.07, section 4; [errata Bn] are in device/errata.md.
//
// A row's comment has the printed name, range, unit, default and access. RW/S: a save (2010h) keeps the value
// in the EEPROM.
//
//     auto ramp_up_gently(auto& wheels) { // a client; both registers in one frame
//         return write<zlac8015d::left_acceleration_time, zlac8015d::right_acceleration_time>(
//             wheels, 800 * units::millisecond, 800 * units::millisecond);
//     }
#pragma once

#include <servobus/device/zlac8015d/values.hpp>
#include <servobus/registers/reg.hpp>

namespace servobus::zlac8015d {

template <class T> using ro = reg<T, access::ro, device>;
template <class T> using rw = reg<T, access::rw, device>;

using units::ampere, units::count, units::degree, units::degree_celsius, units::milliampere,
    units::milliampere_per_second, units::millisecond, units::percent, units::pulse, units::r_per_min,
    units::volt;

// clang-format off

// Common to both motors

/// 2000h 通讯掉线保护时间  0..32767 ms, default 1000, RW/S; 0, which is not explained, was off on two drives [errata B28]
inline constexpr rw<u16>                   host_timeout                   {0x2000, {0, 32767},                millisecond,            1000,      saved | zero_by_name};
/// 2001h RS485 自定义驱动器节点号  1..127, default 1, RW/S
inline constexpr rw<u16>                   node_address                   {0x2001, {1, 127},                  no_unit,                1,         saved | communication};
/// 2002h RS485 自定义通讯波特率  1..6, default 2, RW/S [errata B22]
inline constexpr rw<baud_rate>             rs485_baud_rate                {0x2002, {1, 6},                    no_unit,                2,         saved | communication};
/// 2003h 输入信号状态  0..3, default 0, RO
inline constexpr ro<inputs>                input_state                    {0x2003, {0, 3},                    no_unit,                0};
/// 2004h 输出信号状态  0..3, default 0, RO [errata B24]
inline constexpr ro<outputs>               output_state                   {0x2004, {0, 3},                    no_unit,                0};
/// 2005h 反馈位置清零  0..3, default 0, RW
inline constexpr rw<wheels>                clear_feedback_position        {0x2005, {0, 3},                    no_unit,                0,         trigger};
/// 2006h 绝对位置模式时,当前位置清零  0..3, default 0, RW
inline constexpr rw<wheels>                clear_absolute_position        {0x2006, {0, 3},                    no_unit,                0,         trigger};
/// 2007h 上电锁轴方式  0..1, default 0, RW/S
inline constexpr rw<power_on_shaft>        shaft_at_power_on              {0x2007, {0, 1},                    no_unit,                0,         saved};
/// 2008h 电机最大转速  1..1000 r/min, default 1000, RW/S [errata B5]
inline constexpr rw<u16>                   max_motor_speed                {0x2008, {1, 1000},                 r_per_min,              1000,      saved};
/// 2009h 寄存器参数设置  0..1, default 0, RW
inline constexpr rw<parameter_reset>       restore_parameters             {0x2009, {0, 1},                    no_unit,                0,         trigger};
/// 200Ah CAN自定义驱动器节点号  1..127, default 1, RW/S
inline constexpr rw<u16>                   can_node_address               {0x200A, {1, 127},                  no_unit,                1,         saved};
/// 200Bh CAN自定义通讯波特率  0..4, default 1, RW/S
inline constexpr rw<can_baud_rate>         can_baud                       {0x200B, {0, 4},                    no_unit,                1,         saved};
/// 200Ch 驻车模式  0..1, default 0, RW/S
inline constexpr rw<off_on>                parking_mode                   {0x200C, {0, 1},                    no_unit,                0,         saved};
/// 200Dh 运行模式  0..4, default 0, RW
inline constexpr rw<operating_mode>        mode_of_operation              {0x200D, {0, 4},                    no_unit,                0};
/// 200Eh 控制字  0..0x12, default 0, RW
inline constexpr rw<control_code>               control_word                   {0x200E, {0, 0x12},                 no_unit,                0,         trigger};
/// 200Fh 同步/异步控制标志位  0..1, default 0, RW [errata B25]
inline constexpr rw<synchronisation>       position_synchronisation       {0x200F, {0, 1},                    no_unit,                0};
/// 2010h 是否保存参数于EEPROM  0..1, default 0, RW [errata B11]
inline constexpr rw<parameter_save>        save_parameters                {0x2010, {0, 1},                    no_unit,                0,         trigger};
/// 2011h 快速停止代码  5..7, default 5, RW [errata B12]
inline constexpr rw<quick_stop_option>     quick_stop_option_code         {0x2011, {5, 7},                    no_unit,                5};
/// 2012h 关闭操作代码  0..1, default 1, RW [errata B14]
inline constexpr rw<stop_option>           shutdown_option_code           {0x2012, {0, 1},                    no_unit,                1};
/// 2013h 禁用操作代码  0..1, default 1, RW [errata B14]
inline constexpr rw<stop_option>           disable_option_code            {0x2013, {0, 1},                    no_unit,                1};
/// 2014h Halt 控制寄存器  1..3, default 1, RW [errata B14]
inline constexpr rw<halt_option>           halt_option_code               {0x2014, {1, 3},                    no_unit,                1};
/// 2016h 输入端子有效电平  0..3, default 0, RW/S
inline constexpr rw<inputs>                input_polarity                 {0x2016, {0, 3},                    no_unit,                0,         saved};
/// 2017h 输入端子 X0 端子功能选择  0..9, default 9, RW/S
inline constexpr rw<input_function>        x0_function                    {0x2017, {0, 9},                    no_unit,                9,         saved};
/// 2018h 输入端子 X1 端子功能选择  0..9, default 0, RW/S
inline constexpr rw<input_function>        x1_function                    {0x2018, {0, 9},                    no_unit,                0,         saved};
/// 2019h 输出端子有效电平  0..15, default 0, RW/S [errata B17]
inline constexpr rw<output_polarity>       output_polarities              {0x2019, {0, 15},                   no_unit,                0,         saved};
/// 201Ah 输出端子 B0 端子功能选择  0..1, default 0, RW/S [errata B18, B29]
inline constexpr rw<brake>                 left_brake                     {0x201A, {0, 1},                    no_unit,                0,         saved};
/// 201Bh 输出端子 B1 端子功能选择  0..1, default 0, RW/S [errata B18, B29]
inline constexpr rw<brake>                 right_brake                    {0x201B, {0, 1},                    no_unit,                0,         saved};
/// 201Ch 输出端子 Y0 端子功能选择  0..3, default 0, RW/S
inline constexpr rw<output_function>       y0_function                    {0x201C, {0, 3},                    no_unit,                0,         saved};
/// 201Dh 输出端子 Y1 端子功能选择  0..3, default 0, RW/S
inline constexpr rw<output_function>       y1_function                    {0x201D, {0, 3},                    no_unit,                0,         saved};
/// 201Eh 驱动器温度保护阈值  0..1200 0.1 degC, default 800, RW/S [errata B10]
inline constexpr rw<u16>                   driver_temperature_limit       {0x201E, {0, 1200},                 degree_celsius / 10,    800,       saved};
/// 201Fh 报警PWM处理方式  0..1, default 1, RW/S [errata B13]
inline constexpr rw<off_on>                pwm_on_alarm                   {0x201F, {0, 1},                    no_unit,                1,         saved};
/// 2020h 过载处理方式  0..1, default 0, RW/S
inline constexpr rw<off_on>                overload_handling              {0x2020, {0, 1},                    no_unit,                0,         saved};
/// 2021h I/0 急停处理方式  0..1, default 0, RW/S [errata B12]
inline constexpr rw<input_stop_action>     input_stop                     {0x2021, {0, 1},                    no_unit,                0,         saved};
/// 2022h 给定速度分辨率  1..10, default 1, RW/S; a commanded count is 1/value r/min from the next power-on [errata B21]
inline constexpr rw<u16>                   speed_resolution               {0x2022, {1, 10},                   no_unit,                1,         saved | after_power_cycle};
/// 2023h 速度超差  0..1, default 1, RW/S [errata B8]
inline constexpr rw<off_on>                speed_deviation_monitoring     {0x2023, {0, 1},                    no_unit,                1,         saved};

// Left motor

/// 2030h 编码器线数设置  0..4096, default 1024, RW/S
inline constexpr rw<u16>                   left_encoder_lines             {0x2030, {0, 4096},                 no_unit,                1024,      saved};
/// 2031h 电机与 Hall 的偏移角度  -360..360 deg, default 0, RW/S
inline constexpr rw<i16>                   left_hall_offset_angle         {0x2031, {-360, 360},               degree,                 0,         saved};
/// 2032h 过载系数  0..300 %, default 200, RW/S
inline constexpr rw<u16>                   left_overload_factor           {0x2032, {0, 300},                  percent,                200,       saved};
/// 2033h 额定电流  0..150 0.1 A, default 150, RW/S
inline constexpr rw<u16>                   left_rated_current             {0x2033, {0, 150},                  ampere / 10,            150,       saved};
/// 2034h 最大电流  0..300 0.1 A, default 300, RW/S
inline constexpr rw<u16>                   left_max_current               {0x2034, {0, 300},                  ampere / 10,            300,       saved};
/// 2035h 过载保护时间  0..6553 10 ms, default 300, RW/S
inline constexpr rw<u16>                   left_overload_time             {0x2035, {0, 6553},                 multiple<10>(millisecond), 300,       saved};
/// 2036h 超差报警阈值  1..6553 10 counts, default 409, RW/S
inline constexpr rw<u16>                   left_following_error_limit     {0x2036, {1, 6553},                 multiple<10>(count),     409,       saved};
/// 2037h 速度平滑系数  0..30000, default 1000, RW/S
inline constexpr rw<u16>                   left_speed_smoothing           {0x2037, {0, 30000},                no_unit,                1000,      saved};
/// 2038h 电流环比例系数  0..30000, default 600, RW/S
inline constexpr rw<u16>                   left_current_loop_kp           {0x2038, {0, 30000},                no_unit,                600,       saved};
/// 2039h 电流环积分增益  0..30000, default 300, RW/S
inline constexpr rw<u16>                   left_current_loop_ki           {0x2039, {0, 30000},                no_unit,                300,       saved};
/// 203Ah 前馈输出平滑系数  0..30000, default 100, RW/S
inline constexpr rw<u16>                   left_feedforward_smoothing     {0x203A, {0, 30000},                no_unit,                100,       saved};
/// 203Bh 转矩输出平滑系数  0..30000, default 100, RW/S
inline constexpr rw<u16>                   left_torque_smoothing          {0x203B, {0, 30000},                no_unit,                100,       saved};
/// 203Ch 速度比例第一增益 Kp  0..30000, default 500, RW/S
inline constexpr rw<u16>                   left_speed_kp                  {0x203C, {0, 30000},                no_unit,                500,       saved};
/// 203Dh 速度积分第一增益 Ki  0..30000, default 100, RW/S
inline constexpr rw<u16>                   left_speed_ki                  {0x203D, {0, 30000},                no_unit,                100,       saved};
/// 203Eh 速度前馈增益 Kf  0..30000, default 500, RW/S
inline constexpr rw<u16>                   left_speed_kf                  {0x203E, {0, 30000},                no_unit,                500,       saved};
/// 203Fh 位置比例增益 Kp  0..30000, default 100, RW/S
inline constexpr rw<u16>                   left_position_kp               {0x203F, {0, 30000},                no_unit,                100,       saved};
/// 2040h 位置前馈增益 Kf  0..30000, default 50, RW/S [errata B7]
inline constexpr rw<u16>                   left_position_kf               {0x2040, {0, 30000},                no_unit,                50,        saved};
/// 2043h 起始速度  1..250 r/min, default 1, RW/S [errata B16]
inline constexpr rw<u16>                   left_start_speed               {0x2043, {1, 250},                  r_per_min,              1,         saved};
/// 2044h 位置模式启/停速度  1..250 r/min, default 1, RW [errata B15, B16]
inline constexpr rw<u16>                   left_position_start_speed      {0x2044, {1, 250},                  r_per_min,              1};
/// 2045h 电机极对数  4..64, default 15, RW/S
inline constexpr rw<u16>                   left_pole_pairs                {0x2045, {4, 64},                   no_unit,                15,        saved};
/// 2046h 电机温度保护阈值  0..1200 0.1 degC, default 800, RW/S [errata B10]
inline constexpr rw<u16>                   left_motor_temperature_limit   {0x2046, {0, 1200},                 degree_celsius / 10,    800,       saved};
/// 2047h 速度观测器系数1  0..30000, default 1000, RW [errata B15]
inline constexpr rw<u16>                   left_speed_observer_1          {0x2047, {0, 30000},                no_unit,                1000};
/// 2048h 速度观测器系数 2  0..30000, default 750, RW [errata B15]
inline constexpr rw<u16>                   left_speed_observer_2          {0x2048, {0, 30000},                no_unit,                750};
/// 2049h 速度观测器系数3  0..30000, default 350, RW [errata B15]
inline constexpr rw<u16>                   left_speed_observer_3          {0x2049, {0, 30000},                no_unit,                350};
/// 204Ah 速度观测器系数 4  0..30000, default 1000, RW [errata B15]
inline constexpr rw<u16>                   left_speed_observer_4          {0x204A, {0, 30000},                no_unit,                1000};

// Right motor

/// 2060h 编码器线数设置  0..4096, default 1024, RW/S
inline constexpr rw<u16>                   right_encoder_lines            {0x2060, {0, 4096},                 no_unit,                1024,      saved};
/// 2061h 电机与 Hall 的偏移角度  -360..360 deg, default 0, RW/S
inline constexpr rw<i16>                   right_hall_offset_angle        {0x2061, {-360, 360},               degree,                 0,         saved};
/// 2062h 过载系数  0..300 %, default 200, RW/S
inline constexpr rw<u16>                   right_overload_factor          {0x2062, {0, 300},                  percent,                200,       saved};
/// 2063h 额定电流  0..150 0.1 A, default 150, RW/S
inline constexpr rw<u16>                   right_rated_current            {0x2063, {0, 150},                  ampere / 10,            150,       saved};
/// 2064h 最大电流  0..300 0.1 A, default 300, RW/S
inline constexpr rw<u16>                   right_max_current              {0x2064, {0, 300},                  ampere / 10,            300,       saved};
/// 2065h 过载保护时间  0..6553 10 ms, default 300, RW/S
inline constexpr rw<u16>                   right_overload_time            {0x2065, {0, 6553},                 multiple<10>(millisecond), 300,       saved};
/// 2066h 超差报警阈值  1..6553 10 counts, default 409, RW/S
inline constexpr rw<u16>                   right_following_error_limit    {0x2066, {1, 6553},                 multiple<10>(count),     409,       saved};
/// 2067h 速度平滑系数  0..30000, default 1000, RW/S
inline constexpr rw<u16>                   right_speed_smoothing          {0x2067, {0, 30000},                no_unit,                1000,      saved};
/// 2068h 电流环比例系数  0..30000, default 600, RW/S
inline constexpr rw<u16>                   right_current_loop_kp          {0x2068, {0, 30000},                no_unit,                600,       saved};
/// 2069h 电流环积分增益  0..30000, default 300, RW/S
inline constexpr rw<u16>                   right_current_loop_ki          {0x2069, {0, 30000},                no_unit,                300,       saved};
/// 206Ah 前馈输出平滑系数  0..30000, default 100, RW/S
inline constexpr rw<u16>                   right_feedforward_smoothing    {0x206A, {0, 30000},                no_unit,                100,       saved};
/// 206Bh 转矩输出平滑系数  0..30000, default 100, RW/S
inline constexpr rw<u16>                   right_torque_smoothing         {0x206B, {0, 30000},                no_unit,                100,       saved};
/// 206Ch 速度比例第一增益 Kp  0..30000, default 500, RW/S
inline constexpr rw<u16>                   right_speed_kp                 {0x206C, {0, 30000},                no_unit,                500,       saved};
/// 206Dh 速度积分第一增益Ki  0..30000, default 100, RW/S
inline constexpr rw<u16>                   right_speed_ki                 {0x206D, {0, 30000},                no_unit,                100,       saved};
/// 206Eh 速度前馈增益 Kf  0..30000, default 500, RW/S
inline constexpr rw<u16>                   right_speed_kf                 {0x206E, {0, 30000},                no_unit,                500,       saved};
/// 206Fh 位置比例增益 Kp  0..30000, default 100, RW/S
inline constexpr rw<u16>                   right_position_kp              {0x206F, {0, 30000},                no_unit,                100,       saved};
/// 2070h 位置前馈增益 Kf  0..30000, default 1000, RW/S [errata B7]
inline constexpr rw<u16>                   right_position_kf              {0x2070, {0, 30000},                no_unit,                1000,      saved};
/// 2073h 起始速度  1..250 r/min, default 1, RW/S [errata B16]
inline constexpr rw<u16>                   right_start_speed              {0x2073, {1, 250},                  r_per_min,              1,         saved};
/// 2074h 位置模式启/停速度  1..250 r/min, default 1, RW [errata B15, B16]
inline constexpr rw<u16>                   right_position_start_speed     {0x2074, {1, 250},                  r_per_min,              1};
/// 2075h 电机极对数  4..64, default 15, RW/S
inline constexpr rw<u16>                   right_pole_pairs               {0x2075, {4, 64},                   no_unit,                15,        saved};
/// 2076h 电机温度保护阈值  0..1200 0.1 degC, default 800, RW/S [errata B10]
inline constexpr rw<u16>                   right_motor_temperature_limit  {0x2076, {0, 1200},                 degree_celsius / 10,    800,       saved};
/// 2077h 速度观测器系数1  0..30000, default 1000, RW [errata B15]
inline constexpr rw<u16>                   right_speed_observer_1         {0x2077, {0, 30000},                no_unit,                1000};
/// 2078h 速度观测器系数 2  0..30000, default 750, RW [errata B15]
inline constexpr rw<u16>                   right_speed_observer_2         {0x2078, {0, 30000},                no_unit,                750};
/// 2079h 速度观测器系数3  0..30000, default 350, RW [errata B15]
inline constexpr rw<u16>                   right_speed_observer_3         {0x2079, {0, 30000},                no_unit,                350};
/// 207Ah 速度观测器系数 4  0..30000, default 1000, RW [errata B15]
inline constexpr rw<u16>                   right_speed_observer_4         {0x207A, {0, 30000},                no_unit,                1000};

// Motion

/// 2080h 左电机S形加速时间  0..32767 ms, default 500, RW
inline constexpr rw<u16>                   left_acceleration_time         {0x2080, {0, 32767},                millisecond,            500};
/// 2081h 右电机S形加速时间  0..32767 ms, default 500, RW
inline constexpr rw<u16>                   right_acceleration_time        {0x2081, {0, 32767},                millisecond,            500};
/// 2082h 左电机S形减速时间  0..32767 ms, default 500, RW
inline constexpr rw<u16>                   left_deceleration_time         {0x2082, {0, 32767},                millisecond,            500};
/// 2083h 右电机S形减速时间  0..32767 ms, default 500, RW
inline constexpr rw<u16>                   right_deceleration_time        {0x2083, {0, 32767},                millisecond,            500};
/// 2084h 左电机急停减速时间  0..32767 ms, default 10, RW
inline constexpr rw<u16>                   left_quick_stop_time           {0x2084, {0, 32767},                millisecond,            10};
/// 2085h 右电机急停减速时间  0..32767 ms, default 10, RW
inline constexpr rw<u16>                   right_quick_stop_time          {0x2085, {0, 32767},                millisecond,            10};
/// 2086h 左电机转矩斜率  mA/s, default 300, RW [errata B6]
inline constexpr rw<u16>                   left_torque_slope              {0x2086, full<u16>,                 milliampere_per_second, 300};
/// 2087h 右电机转矩斜率  mA/s, default 300, RW [errata B6]
inline constexpr rw<u16>                   right_torque_slope             {0x2087, full<u16>,                 milliampere_per_second, 300};
/// 2088h 左电机目标速度  -3000..3000 r/min, default 0, RW [errata B5, B21]
inline constexpr rw<i16>                   left_target_speed              {0x2088, {-3000, 3000},             r_per_min,              0,         motion | scaled_elsewhere};
/// 2089h 右电机目标速度  -3000..3000 r/min, default 0, RW [errata B5, B21]
inline constexpr rw<i16>                   right_target_speed             {0x2089, {-3000, 3000},             r_per_min,              0,         motion | scaled_elsewhere};
/// 208Ah 左电机目标位置  -0x7FFFFFFF..0x7FFFFFFF pulses, default 0, RW [errata B20]
inline constexpr rw<i32>                   left_target_position           {0x208A, {-0x7FFFFFFF, 0x7FFFFFFF}, pulse,                  0,         motion};
/// 208Ch 右电机目标位置  -0x7FFFFFFF..0x7FFFFFFF pulses, default 0, RW [errata B20]
inline constexpr rw<i32>                   right_target_position          {0x208C, {-0x7FFFFFFF, 0x7FFFFFFF}, pulse,                  0,         motion};
/// 208Eh 左电机最大速度  1..1000 r/min, default 120, RW; position modes
inline constexpr rw<u16>                   left_max_speed                 {0x208E, {1, 1000},                 r_per_min,              120};
/// 208Fh 右电机最大速度  1..1000 r/min, default 120, RW; position modes
inline constexpr rw<u16>                   right_max_speed                {0x208F, {1, 1000},                 r_per_min,              120};
/// 2090h 左电机目标转矩  -30000..30000 mA, default 0, RW
inline constexpr rw<i16>                   left_target_torque             {0x2090, {-30000, 30000},           milliampere,            0,         motion};
/// 2091h 右电机目标转矩  -30000..30000 mA, default 0, RW
inline constexpr rw<i16>                   right_target_torque            {0x2091, {-30000, 30000},           milliampere,            0,         motion};

// Read-only

/// 20A0h 软件版本  RO
inline constexpr ro<u16>                   software_version               {0x20A0, full<u16>,                 no_unit,                no_default};
/// 20A1h 母线电压  0.01 V, default 0, RO
inline constexpr ro<u16>                   bus_voltage                    {0x20A1, full<u16>,                 volt / 100,             0};
/// 20A2h 状态字  default 0, RO [errata B9]
inline constexpr ro<status_flags>          status_word                    {0x20A2, unstated,                   no_unit,                0};
/// 20A3h 霍尔输入状态  0..7 a half, default 0, RO [errata B9]
inline constexpr ro<hall_inputs>           hall_state                     {0x20A3, unstated,                   no_unit,                0};
/// 20A4h 电机温度  -55..120 degC a half, RO [errata B9, B10]
inline constexpr ro<motor_temperatures>    motor_temperature              {0x20A4, unstated,                   degree_celsius,         no_default};
/// 20A5h 驱动器最近一次故障码(左)  default 0, RO [errata B1, B23]
inline constexpr ro<faults>                left_faults                    {0x20A5, unstated,                   no_unit,                0};
/// 20A6h 驱动器最近一次故障码(右)  default 0, RO [errata B1, B23]
inline constexpr ro<faults>                right_faults                   {0x20A6, unstated,                   no_unit,                0};
/// 20A7h 实际位置反馈(左)  -0x7FFFFFFF..0x7FFFFFFF counts, default 0, RO [errata B20]
inline constexpr ro<i32>                   left_actual_position           {0x20A7, {-0x7FFFFFFF, 0x7FFFFFFF}, count,                  0};
/// 20A9h 实际位置反馈(右)  -0x7FFFFFFF..0x7FFFFFFF counts, default 0, RO [errata B20]
inline constexpr ro<i32>                   right_actual_position          {0x20A9, {-0x7FFFFFFF, 0x7FFFFFFF}, count,                  0};
/// 20ABh 实际速度反馈(左)  0.1 r/min, default 0, RO [errata B2]
inline constexpr ro<i16>                   left_actual_speed              {0x20AB, full<i16>,                 r_per_min / 10,         0};
/// 20ACh 实际速度反馈(右)  0.1 r/min, default 0, RO [errata B2]
inline constexpr ro<i16>                   right_actual_speed             {0x20AC, full<i16>,                 r_per_min / 10,         0};
/// 20ADh 实时转矩反馈(左)  -300..300 0.1 A, default 0, RO
inline constexpr ro<i16>                   left_actual_torque             {0x20AD, {-300, 300},               ampere / 10,            0};
/// 20AEh 实时转矩反馈(右)  -300..300 0.1 A, default 0, RO
inline constexpr ro<i16>                   right_actual_torque            {0x20AE, {-300, 300},               ampere / 10,            0};
/// 20AFh 上位机与驱动器连接标志位  0..1, RO; the meaning of 0 and 1 is not stated [errata B19]
inline constexpr ro<u16>                   host_connected                 {0x20AF, {0, 1},                    no_unit,                no_default};
/// 20B0h 驱动器温度  -550..1200 0.1 degC, RO
inline constexpr ro<i16>                   driver_temperature             {0x20B0, {-550, 1200},              degree_celsius / 10,    no_default};
// clang-format on

} // namespace servobus::zlac8015d
