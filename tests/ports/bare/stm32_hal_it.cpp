// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The interrupt-driven STM32 port in a program.
#include "examples/ports/stm32_hal_it.hpp"

#include "tests/ports/program.hpp"

extern UART_HandleTypeDef huart2;
extern TIM_HandleTypeDef htim2;
extern GPIO_TypeDef bank;
constinit servobus::ports::stm32_hal_it rs485{huart2, {&bank, GPIO_PIN_1}, &htim2};

extern "C" {
void HAL_UART_RxCpltCallback(UART_HandleTypeDef* h) {
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
