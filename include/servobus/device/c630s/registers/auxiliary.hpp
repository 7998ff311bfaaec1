// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: auxiliary functions, group P0D. The drive never keeps these registers in the
// EEPROM. c630s/registers.hpp includes it; row.hpp explains the comments of its rows. Source: manual
// V24.111, section 7.13; [errata Cn] are in device/errata_c630s.md.
//
//     auto reset_alarm(auto& servo) { // a client; resets a fault only while the servo is off
//         return write<c630s::alarm_reset>(servo, c630s::action::execute);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P0D-00 软件复位  0..1, default 0, stopped, immediate
inline constexpr rw<action>        software_reset         {"P0D-00"_p, {0, 1},     no_unit, 0,          when_stopped | immediate | trigger};
/// P0D-01 故障复位  0..1, default 0, stopped, immediate
inline constexpr rw<action>        alarm_reset            {"P0D-01"_p, {0, 1},     no_unit, 0,          when_stopped | immediate | trigger};
/// P0D-02 离线惯量辨识功能  running, immediate [errata C61]
inline constexpr rw<u16>           identify_inertia       {"P0D-02"_p, full<u16>,  no_unit, no_default, when_running | immediate | trigger | motion};
/// P0D-03 初始角度识别  1 [errata C61]
inline constexpr rw<action>        identify_initial_angle {"P0D-03"_p, {1, 1},     no_unit, no_default, trigger | motion};
/// P0D-05 紧急停机  0..1, default 0, running, immediate
inline constexpr rw<action>        emergency_stop         {"P0D-05"_p, {0, 1},     no_unit, 0,          when_running | immediate | trigger};
/// P0D-10 保留  0 [errata C61]
inline constexpr rw<u16>           reserved_parameter     {"P0D-10"_p, {0, 0},     no_unit, no_default};
/// P0D-11 JOG试运行功能 [errata C61]
inline constexpr rw<u16>           jog_test_run           {"P0D-11"_p, full<u16>,  no_unit, no_default, trigger | motion};
/// P0D-17 DIDO强制输入输出使能  0..3, default 0, running, immediate
inline constexpr rw<forcing>       terminal_forcing       {"P0D-17"_p, {0, 3},     no_unit, 0,          when_running | immediate | trigger | motion};
/// P0D-18 DI强制输入给定  0..0x01FF, default 0x01FF, running, immediate [errata C11]
inline constexpr rw<inputs>        forced_inputs          {"P0D-18"_p, {0, 0x1FF}, no_unit, 0x01FF,     when_running | immediate | trigger | motion};
/// P0D-19 DO强制输出给定  0..0x001F, default 0, running, immediate [errata C11]
inline constexpr rw<outputs>       forced_outputs         {"P0D-19"_p, {0, 0x1F},  no_unit, 0,          when_running | immediate | trigger};
/// P0D-20 绝对编码器复位使能  0..2, default 0, stopped, immediate, ALL [errata C40]
inline constexpr rw<encoder_reset> reset_absolute_encoder {"P0D-20"_p, {0, 2},     no_unit, 0,          when_stopped | immediate | every_mode | trigger};
// clang-format on

} // namespace servobus::c630s
