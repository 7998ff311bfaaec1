// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: signals that the bus reads and sets while the drive operates, groups P30 and P31.
// c630s/registers.hpp includes it; row.hpp explains the comments of its rows. Source: manual V24.111,
// sections 7.17 and 7.18; [errata Cn] are in device/errata_c630s.md.
//
//     auto set_vdi_1_and_7(auto& servo, ram_only token) { // a client; the other levels become 0
//         return write<c630s::virtual_input_levels>(servo, c630s::virtual_inputs{}.with(1).with(7), token);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P30-00 通信读取伺服状态  read only, PST [errata C18]
inline constexpr ro<u16>                  servo_status              {"P30-00"_p, full<u16>,  no_unit, no_default, pst_modes};
/// P30-01 通信读取DO功能状态1  read only, PST; FunOUT.1 to 16 [errata C18]
inline constexpr ro<output_functions<1>>  active_functions_1_to_16  {"P30-01"_p, unstated,   no_unit, no_default, pst_modes};
/// P30-02 通信读取DO功能状态2  read only, PST; FunOUT.17 to 32 [errata C18]
inline constexpr ro<output_functions<17>> active_functions_17_to_32 {"P30-02"_p, unstated,   no_unit, no_default, pst_modes};
/// P30-03 通信读取输入脉冲指令采样值  shown, PST
inline constexpr ro<u16>                  pulse_command_samples     {"P30-03"_p, full<u16>,  no_unit, no_default, pst_modes};
/// P30-04 通信读取DI导通状态  0..511, shown, PST [errata C11]
inline constexpr ro<inputs>               input_conduction          {"P30-04"_p, {0, 511},   no_unit, no_default, pst_modes};
/// P31-00 通信给定VDI虚拟电平  0..65535, default 0, running, immediate, PST [errata C10]
inline constexpr rw<virtual_inputs>       virtual_input_levels      {"P31-00"_p, {0, 65535}, no_unit, 0,          running_now | pst_modes | trigger | motion};
/// P31-04 通信给定DO输出状态  0..31, default 0, running, immediate, PST [errata C11, C12]
inline constexpr rw<outputs>              bus_outputs               {"P31-04"_p, {0, 31},    no_unit, 0,          running_now | pst_modes | trigger};
// clang-format on

} // namespace servobus::c630s
