// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: advice about each fault of 20A5h and 20A6h. Programs that show it to a person include this
// header; zlac8015d.hpp does not. Source: RS485 manual V1.07, sections 3.5 and 4, which name the faults and
// the registers around them and give hardly any remedy; [errata Bn] are in device/errata.md.
//
//     const result<zlac8015d::feedback> seen = wheels.read();
//     for (const zlac8015d::fault f : zlac8015d::all_faults) // or advice_for(seen->left_faults), the first one
//         if (seen && seen->left_faults.has(f)) std::puts(zlac8015d::advice_for(f).remedy);
#pragma once

#include <servobus/control/advice.hpp>
#include <servobus/control/states.hpp>
#include <servobus/device/zlac8015d/values.hpp>

namespace servobus::zlac8015d {

namespace detail {
struct fault_advice {
    fault of;
    const char* cause;
    const char* remedy;
};

// clang-format off
inline constexpr fault_advice advice_table[] = {
    {fault::overvoltage,          // 3.5 0x0001 过压; 4 20A1h
     "Overvoltage. 20A1h shows the bus voltage.", not_in_manual},
    {fault::undervoltage,         // 3.5 0x0002 欠压; 4 20A1h
     "Undervoltage. 20A1h shows the bus voltage.", not_in_manual},
    {fault::overcurrent,          // 3.5 0x0004 过流; 4 2034h, 2064h
     "Overcurrent. 2034h (left) and 2064h (right) set the maximum current.", not_in_manual},
    {fault::overload,             // 3.5 0x0008 过载; 4 2032h, 2035h, 2062h, 2065h
     "Overload. 2032h and 2062h set the overload factor, 2035h and 2065h the protection time.", not_in_manual},
    {fault::current_deviation,    // 3.5 0x0010 电流超差 (预留)
     "Current deviation. The manual marks this fault as reserved.", not_in_manual},
    {fault::following_error,      // 3.5 0x0020 编码器超差; 4 2036h, 2066h
     "The encoder deviates too far. 2036h (left) and 2066h (right) set the limit.", not_in_manual},
    {fault::speed_deviation,      // 3.5 0x0040 速度超差 (预留); 4 2023h [errata B8]
     "The speed deviates too far. 2023h switches this check.", not_in_manual},
    {fault::reference_voltage,    // 3.5 0x0080 参考电压出错
     "The reference voltage is wrong.", not_in_manual},
    {fault::eeprom,               // 3.5 0x0100 EEPROM 读写错误
     "The EEPROM could not be read or written.", not_in_manual},
    {fault::hall,                 // 3.5 0x0200 霍尔出错; 4 20A3h
     "The Hall sensors are wrong. 20A3h shows 0 or 7 for that motor.", not_in_manual},
    {fault::motor_overtemperature, // 3.5 0x0400 电机温度过高; 4 20A4h, 2046h, 2076h
     "The motor is too hot. 20A4h shows its temperature; 2046h and 2076h set the limit.", not_in_manual},
    {fault::encoder,              // 3.5 0x0800 编码器错误
     "The encoder reports an error.", not_in_manual},
    {fault::speed_command,        // 3.5 0x2000 速度给定错误; 4 20A5h 给定速度不能超过额定转速
     "The commanded speed is above the rated speed.", "Command at most the rated speed."},
};
// clang-format on

// 3.5 故障清除; the command `fault_reset`. Whether the code itself is cleared is not stated [errata B32].
inline constexpr const char* reset_text = "Reset the fault: write 06h to 200Eh.";
} // namespace detail

/// The advice about one fault; `not_in_manual` for a bit that the manual does not list.
constexpr advice advice_for(fault f) {
    if (f == fault::none) return no_fault_advice;
    for (const detail::fault_advice& a : detail::advice_table) {
        if (a.of == f) return {a.cause, a.remedy, detail::reset_text};
    }
    return {not_in_manual, not_in_manual, detail::reset_text};
}

/// The advice about a state in which no fault shows. Only `needs_power_cycle` has one [errata B21].
constexpr advice advice_for(drive_state s) {
    if (s != drive_state::needs_power_cycle) return no_fault_advice;
    return {"A new value of 2022h scales commanded speeds from the next power-on.",
            "Power the drive off and on, then take it over again.", "An init finds that the power was off."};
}

/// The advice about the first fault of a set, in the manual's order.
constexpr advice advice_for(faults set) { return advice_for(set.first()); }

} // namespace servobus::zlac8015d
