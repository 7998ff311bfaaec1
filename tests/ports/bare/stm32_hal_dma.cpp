// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The DMA-driven STM32 port in a program.
#include "examples/ports/stm32_hal_dma.hpp"

#include "tests/ports/program.hpp"

extern UART_HandleTypeDef huart2;
constinit servobus::ports::stm32_hal_dma rs485{huart2}; // the USART switches the driver

extern "C" {
void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef* h, uint16_t) {
    if (h == &huart2) rs485.on_received();
}
void HAL_UART_TxCpltCallback(UART_HandleTypeDef* h) {
    if (h == &huart2) rs485.on_sent();
}
void HAL_UART_ErrorCallback(UART_HandleTypeDef* h) {
    if (h == &huart2) rs485.on_error();
}
}

bool job() { return rs485.start() && program::count_up(rs485); }
