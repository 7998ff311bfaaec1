// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: Modbus settings, group P0C. c630s/registers.hpp includes it; row.hpp explains
// the comments of its rows. Source: manual V24.111, section 7.12; [errata Cn] are in device/errata_c630s.md.
//
//     auto respond_later(auto& servo) { // a client; the write goes into the EEPROM
//         return store_if_different<c630s::response_delay>(servo, 2 * units::millisecond);
//     }
#pragma once

#include <servobus/device/c630s/registers/row.hpp>

namespace servobus::c630s {

// clang-format off

/// P0C-00 伺服轴地址  1..247, default 1, running, immediate, PST
inline constexpr rw<u16>             node_address               {"P0C-00"_p, {1, 247},  no_unit,     1,          running_now | pst_modes | communication};
/// P0C-02 串口波特率设置  0..5, default 5, running, immediate, PST
inline constexpr rw<baud_rate>       rs485_baud_rate            {"P0C-02"_p, {0, 5},    no_unit,     5,          running_now | pst_modes | communication};
/// P0C-03 Moubus数据格式  0..3, default 0, running, immediate, PST
inline constexpr rw<serial_format>   data_format                {"P0C-03"_p, {0, 3},    no_unit,     0,          running_now | pst_modes | communication};
/// P0C-09 通信VDI  0..1, default 0, stopped, immediate, PST
inline constexpr rw<off_on>          virtual_inputs_enable      {"P0C-09"_p, {0, 1},    no_unit,     0,          stopped_now | pst_modes};
/// P0C-10 上电后VDI默认值  default 0, running, power cycle, PST; a VDI with FunIN.1 then enables the motor
inline constexpr rw<virtual_inputs>  virtual_inputs_at_power_on {"P0C-10"_p, unstated,  no_unit,     0,          running_from_power_on | pst_modes};
/// P0C-11 通信VDO  0..1, default 0, stopped, immediate, PST
inline constexpr rw<off_on>          virtual_outputs_enable     {"P0C-11"_p, {0, 1},    no_unit,     0,          stopped_now | pst_modes};
/// P0C-12 VDO功能选择为0时的默认电平  default 0, stopped, immediate, PST
inline constexpr rw<virtual_outputs> virtual_output_defaults    {"P0C-12"_p, unstated,  no_unit,     0,          stopped_now | pst_modes};
/// P0C-13 Moubus通信写入功能码是否更新到EEPROM  0..1, default 1, running, immediate, PST [errata C10]
inline constexpr rw<off_on>          eeprom_update              {"P0C-13"_p, {0, 1},    no_unit,     1,          running_now | pst_modes | communication};
/// P0C-14 Moubus错误码  1..4, shown [errata C6, C8]
inline constexpr ro<bus_error>       last_bus_error             {"P0C-14"_p, {1, 4},    no_unit,     no_default};
/// P0C-25 Moubus指令应答延时  0..5000 ms, default 1, running, immediate, PST
inline constexpr rw<u16>             response_delay             {"P0C-25"_p, {0, 5000}, millisecond, 1,          running_now | pst_modes | communication};
/// P0C-26 Moubus通信数据高低位顺序  0..1, default 1, running, immediate, PST [errata C8]
inline constexpr rw<word_order_setting>      pair_word_order            {"P0C-26"_p, {0, 1},    no_unit,     1,          running_now | pst_modes | communication};
/// P0C-30 Moubus错误帧格式选择  0..1, default 1, running, immediate, PST [errata C7, C8]
inline constexpr rw<error_frame>     error_frame_format         {"P0C-30"_p, {0, 1},    no_unit,     1,          running_now | pst_modes | communication};
// clang-format on

static_assert(pair_word_order.address == device::facts.word_order_register);
static_assert(eeprom_update.address == device::facts.eeprom_switch);

} // namespace servobus::c630s
