// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: positioning segments, which the drive runs by itself, group P11. Element i of an
// array is segment i + 1. c630s/registers.hpp includes it; row.hpp explains the comments of its rows.
// Source: manual V24.111, section 7.14; [errata Cn] are in device/errata_c630s.md.
//
//     auto set_segment_2(auto& servo) { // a client whose word order is known; the write goes into the EEPROM
//         return store<c630s::position_segment_displacements>(servo, 1, 50'000 * units::reference_unit);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P11-00 多段位置运行方式  0..3, default 1, stopped, immediate, P
inline constexpr rw<segment_mode>       position_segment_mode               {"P11-00"_p, {0, 3},                    no_unit,        1,     stopped_now | position_mode};
/// P11-01 位移指令终点段数  1..16, default 1, stopped, immediate, P
inline constexpr rw<u16>                last_position_segment               {"P11-01"_p, {1, 16},                   no_unit,        1,     stopped_now | position_mode};
/// P11-02 余量处理方式  0..1, default 0, stopped, immediate, P
inline constexpr rw<segment_remainder>  position_segment_remainder          {"P11-02"_p, {0, 1},                    no_unit,        0,     stopped_now | position_mode};
/// P11-03 时间单位  0..1, default 0, stopped, immediate, P
inline constexpr rw<position_time_unit> position_segment_time_unit          {"P11-03"_p, {0, 1},                    no_unit,        0,     stopped_now | position_mode};
/// P11-04 位移指令类型选择  0..1, default 0, stopped, immediate, P
inline constexpr rw<displacement_type>  position_segment_type               {"P11-04"_p, {0, 1},                    no_unit,        0,     stopped_now | position_mode};
/// P11-05 顺序运行起始段选择  0..16, default 0, stopped, immediate, P [errata C53]
inline constexpr rw<u16>                first_position_segment              {"P11-05"_p, {0, 16},                   no_unit,        0,     stopped_now | position_mode};
/// P11-12, 17 .. 87 第1..16段移动位移  -1073741824..1073741824 reference units, default 10000, running, immediate, P
inline constexpr reg_array<rw<i32>, 16> position_segment_displacements      {{"P11-12"_p, {-1073741824, 1073741824}, reference_unit, 10000, running_now | position_mode}, 5};
/// P11-14, 19 .. 89 第1..16段位移最大运行速度  1..6000 rpm, default 200, running, immediate, P
inline constexpr reg_array<rw<u16>, 16> position_segment_speeds             {{"P11-14"_p, {1, 6000},                 r_per_min,      200,   running_now | position_mode}, 5};
/// P11-15, 20 .. 90 第1..16段位移加减速时间  0..65535 ms (s), default 10, running, immediate, P; P11-03 sets the unit
inline constexpr reg_array<rw<u16>, 16> position_segment_acceleration_times {{"P11-15"_p, {0, 65535},                millisecond,    10,    running_now | position_mode | scaled_elsewhere}, 5};
/// P11-16, 21 .. 91 第1..16段位移完成后等待时间  0..10000 ms (s), default 10, running, immediate, P; P11-03 sets the unit
inline constexpr reg_array<rw<u16>, 16> position_segment_wait_times         {{"P11-16"_p, {0, 10000},                millisecond,    10,    running_now | position_mode | scaled_elsewhere}, 5};
// clang-format on

} // namespace servobus::c630s
