// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: speed segments, which the drive runs by itself, group P12. Element i of an array is
// segment i + 1. c630s/registers.hpp includes it; row.hpp explains the comments of its rows. Source:
// manual V24.111, section 7.15; [errata Cn] are in device/errata_c630s.md.
//
//     auto set_segment_2(auto& servo) { // a client; the write goes into the EEPROM
//         return store<c630s::speed_segment_speeds>(servo, 1, -150 * units::r_per_min);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P12-00 多段速度指令运行方式  0..2, default 1, stopped, immediate, S
inline constexpr rw<segment_mode>                speed_segment_mode          {"P12-00"_p, {0, 2},        no_unit,     1,   stopped_now | speed_mode};
/// P12-01 速度指令终点段数选择  1..16, default 16, stopped, immediate, S
inline constexpr rw<u16>                         last_speed_segment          {"P12-01"_p, {1, 16},       no_unit,     16,  stopped_now | speed_mode};
/// P12-02 运行时间单位选择  0..1, default 0, stopped, immediate, S
inline constexpr rw<speed_time_unit>             speed_segment_time_unit     {"P12-02"_p, {0, 1},        no_unit,     0,   stopped_now | speed_mode};
/// P12-03 加速时间1  0..65535 ms, default 10, stopped, immediate, S
inline constexpr rw<u16>                         segment_acceleration_time_1 {"P12-03"_p, {0, 65535},    millisecond, 10,  stopped_now | speed_mode};
/// P12-04 减速时间1  0..65535 ms, default 10, stopped, immediate, S
inline constexpr rw<u16>                         segment_deceleration_time_1 {"P12-04"_p, {0, 65535},    millisecond, 10,  stopped_now | speed_mode};
/// P12-05 加速时间2  0..65535 ms, default 50, stopped, immediate, S
inline constexpr rw<u16>                         segment_acceleration_time_2 {"P12-05"_p, {0, 65535},    millisecond, 50,  stopped_now | speed_mode};
/// P12-06 减速时间2  0..65535 ms, default 50, stopped, immediate, S
inline constexpr rw<u16>                         segment_deceleration_time_2 {"P12-06"_p, {0, 65535},    millisecond, 50,  stopped_now | speed_mode};
/// P12-07 加速时间3  0..65535 ms, default 100, stopped, immediate, S
inline constexpr rw<u16>                         segment_acceleration_time_3 {"P12-07"_p, {0, 65535},    millisecond, 100, stopped_now | speed_mode};
/// P12-08 减速时间3  0..65535 ms, default 100, stopped, immediate, S
inline constexpr rw<u16>                         segment_deceleration_time_3 {"P12-08"_p, {0, 65535},    millisecond, 100, stopped_now | speed_mode};
/// P12-09 加速时间4  0..65535 ms, default 150, stopped, immediate, S
inline constexpr rw<u16>                         segment_acceleration_time_4 {"P12-09"_p, {0, 65535},    millisecond, 150, stopped_now | speed_mode};
/// P12-10 减速时间4  0..65535 ms, default 150, stopped, immediate, S
inline constexpr rw<u16>                         segment_deceleration_time_4 {"P12-10"_p, {0, 65535},    millisecond, 150, stopped_now | speed_mode};
/// P12-20, 23 .. 65 第1..16段速度指令  -6000..6000 rpm, default 0, stopped, immediate, S; the default is that of segment 1, see `speed_segment_defaults` [errata C58]
inline constexpr reg_array<rw<i16>, 16>          speed_segment_speeds        {{"P12-20"_p, {-6000, 6000}, r_per_min,   0,   stopped_now | speed_mode}, 3};
/// The defaults of P12-20, 23 .. 65. The row of `speed_segment_speeds` has only the first.
inline constexpr i16 speed_segment_defaults[speed_segment_speeds.size] = {
    0, 100, 300, 500, 700, 900, 600, 300, 100, -100, -300, -500, -700, -900, -600, -300};
/// P12-21, 24 .. 66 第1..16段指令运行时间  0..6553.5 s (min), default 5.0, stopped, immediate, S; P12-02 sets the unit
inline constexpr reg_array<rw<u16>, 16>          speed_segment_run_times     {{"P12-21"_p, {0, 65535},    second / 10, 50,  stopped_now | speed_mode | scaled_elsewhere}, 3};
/// P12-22, 25 .. 67 第1..16段加减速时间  0..4, default 0, stopped, immediate, S
inline constexpr reg_array<rw<segment_ramp>, 16> speed_segment_ramps         {{"P12-22"_p, {0, 4},        no_unit,     0,   stopped_now | speed_mode}, 3};
// clang-format on

} // namespace servobus::c630s
