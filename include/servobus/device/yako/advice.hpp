// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: advice about an alarm, by its bit in 0007h or its code in 0006h. Programs that show it
// to a person include this header; yako.hpp does not. Source: manual V2.6.0, section 5.1 and appendices 2 and
// 3. The manual does not list what the codes 1..5 mean [errata A36], so all have one advice.
//
//     const result<yako::closed_loop::feedback> seen = axis.read();
//     if (seen && seen->has_fault()) std::puts(yako::advice_for(seen->state).reset); // or by the code, seen->error
#pragma once

#include <cstdint>

#include <servobus/control/advice.hpp>
#include <servobus/device/yako/values.hpp>

namespace servobus::yako {

namespace detail {
inline constexpr advice alarm_advice{
    // appendices 2 and 3, 0006h 1~5: 错误; appendix 2, 010Ah 位置超差报警阈值
    .cause = "The manual does not list error codes. On closed loop, 010Ah is the threshold of a position "
             "deviation alarm.",
    .remedy = not_in_manual,
    // 5.1 (the command `fault_reset`), 002Dh 0x0021 驱动器报警清除; example 3: 当驱动器产生可复位报警时，将报警复位
    .reset = "Reset the alarm: write 0021h to 002Dh. The manual does not say which alarms this resets."};
} // namespace detail

/// The advice about an error code of 0006h.
constexpr advice advice_for(std::uint16_t error) {
    return error == 0 ? no_fault_advice : detail::alarm_advice;
}

/// The advice if the alarm bit is set.
constexpr advice advice_for(motion_status state) {
    return state.has_alarm() ? detail::alarm_advice : no_fault_advice;
}

} // namespace servobus::yako
