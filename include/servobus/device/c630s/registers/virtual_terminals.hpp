// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: virtual terminals, whose levels the bus sets (VDI) and reads (VDO), group P17.
// Element i of an array is terminal i + 1. c630s/registers.hpp includes it; row.hpp explains the
// comments of its rows. Source: manual V24.111, section 7.16; [errata Cn] are in device/errata_c630s.md.
//
//     auto assign_vdi_7(auto& servo) { // a client; the write goes into the EEPROM
//         constexpr auto start = c630s::input_function::position_segment_start;
//         return store<c630s::virtual_input_functions>(servo, 6, start);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P17-00, 02 .. 30 VDI1..16端子功能选择  0..37, default 0, running, at stop [errata C14, C15]
inline constexpr reg_array<rw<input_function>, 16>       virtual_input_functions  {{"P17-00"_p, {0, 37},  no_unit, 0,          running_from_stop}, 2};
/// P17-01, 03 .. 31 VDI1..16端子逻辑选择  0..1, default 0, running, at stop [errata C15]
inline constexpr reg_array<rw<virtual_input_logic>, 16>  virtual_input_logics     {{"P17-01"_p, {0, 1},   no_unit, 0,          running_from_stop}, 2};
/// P17-32 VDO虚拟电平  shown
inline constexpr ro<virtual_outputs>                     virtual_output_levels    {"P17-32"_p, unstated, no_unit, no_default};
/// P17-33, 35 .. 63 VDO1..16端子功能选择  0..22, default 0, running, at stop [errata C14]
inline constexpr reg_array<rw<output_function>, 16>      virtual_output_functions {{"P17-33"_p, {0, 22},  no_unit, 0,          running_from_stop}, 2};
/// P17-34, 36 .. 64 VDO1..16端子逻辑选择  0..1, default 0, running, at stop
inline constexpr reg_array<rw<virtual_output_logic>, 16> virtual_output_logics    {{"P17-34"_p, {0, 1},   no_unit, 0,          running_from_stop}, 2};
// clang-format on

} // namespace servobus::c630s
