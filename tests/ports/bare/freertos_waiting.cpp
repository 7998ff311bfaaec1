// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The FreeRTOS mix-in over the interrupt-driven STM32 port in a program.
#include "examples/ports/freertos_waiting.hpp"
#include "examples/ports/stm32_hal_it.hpp"

#include "tests/ports/program.hpp"

extern UART_HandleTypeDef huart2;
constinit servobus::ports::freertos_waiting<servobus::ports::stm32_hal_it> rs485{huart2};

extern "C" {
void HAL_UART_RxCpltCallback(UART_HandleTypeDef* h) {
    if (h == &huart2) rs485.on_received(), rs485.wake_from_isr();
}
void HAL_UART_TxCpltCallback(UART_HandleTypeDef* h) {
    if (h == &huart2) rs485.on_sent(), rs485.wake_from_isr();
}
void HAL_UART_ErrorCallback(UART_HandleTypeDef* h) {
    if (h == &huart2) rs485.on_error(), rs485.wake_from_isr();
}
}

bool job() { return rs485.start() && program::count_up(rs485); }
