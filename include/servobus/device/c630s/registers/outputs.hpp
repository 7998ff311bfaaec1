// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: digital outputs, group P04. c630s/registers.hpp includes it; row.hpp explains
// the comments of its rows. Source: manual V24.111, section 7.4; [errata Cn] are in device/errata_c630s.md.
//
//     auto show_speed_reached(auto& servo) { // a client; the write goes into the EEPROM
//         return store_if_different<c630s::do3_function>(servo, c630s::output_function::speed_reached);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P04-00 DO1端子功能选择  0..20, default 1, running, at stop
inline constexpr rw<output_function> do1_function {"P04-00"_p, {0, 20}, no_unit, 1,  running_from_stop};
/// P04-01 DO1端子逻辑选择  0..1, default 0, running, at stop
inline constexpr rw<output_logic>    do1_logic    {"P04-01"_p, {0, 1},  no_unit, 0,  running_from_stop};
/// P04-02 DO2端子功能选择  0..20, default 5, running, at stop
inline constexpr rw<output_function> do2_function {"P04-02"_p, {0, 20}, no_unit, 5,  running_from_stop};
/// P04-03 DO2端子逻辑选择  0..1, default 0, running, at stop
inline constexpr rw<output_logic>    do2_logic    {"P04-03"_p, {0, 1},  no_unit, 0,  running_from_stop};
/// P04-04 DO3端子功能选择  0..20, default 3, running, at stop
inline constexpr rw<output_function> do3_function {"P04-04"_p, {0, 20}, no_unit, 3,  running_from_stop};
/// P04-05 DO3端子逻辑选择  0..1, default 0, running, at stop
inline constexpr rw<output_logic>    do3_logic    {"P04-05"_p, {0, 1},  no_unit, 0,  running_from_stop};
/// P04-06 DO4端子功能选择  0..20, default 11, running, at stop
inline constexpr rw<output_function> do4_function {"P04-06"_p, {0, 20}, no_unit, 11, running_from_stop};
/// P04-07 DO4端子逻辑选择  0..1, default 0, running, at stop
inline constexpr rw<output_logic>    do4_logic    {"P04-07"_p, {0, 1},  no_unit, 0,  running_from_stop};
/// P04-08 DO5端子功能选择  0..20, default 16, running, at stop
inline constexpr rw<output_function> do5_function {"P04-08"_p, {0, 20}, no_unit, 16, running_from_stop};
/// P04-09 DO5端子逻辑选择  0..1, default 0, running, at stop
inline constexpr rw<output_logic>    do5_logic    {"P04-09"_p, {0, 1},  no_unit, 0,  running_from_stop};
/// P04-10 DO6端子功能选择  0..20, default 0, running, at stop [errata C20]
inline constexpr rw<output_function> do6_function {"P04-10"_p, {0, 20}, no_unit, 0,  running_from_stop};
/// P04-11 DO6端子逻辑选择  0..1, default 0, running, at stop
inline constexpr rw<output_logic>    do6_logic    {"P04-11"_p, {0, 1},  no_unit, 0,  running_from_stop};
// clang-format on

} // namespace servobus::c630s
