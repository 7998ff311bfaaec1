// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the STM32 ports use of the HAL's UART module, after the types of the rest of the HAL.
#pragma once

#include <stdint.h>

extern "C" {

typedef uint32_t HAL_UART_StateTypeDef;
#define HAL_UART_STATE_READY 0x00000020U
#define HAL_UART_STATE_BUSY_TX 0x00000021U
#define HAL_UART_STATE_BUSY_RX 0x00000022U

#define HAL_UART_ERROR_NONE 0x00000000U
#define HAL_UART_ERROR_FE 0x00000004U

typedef struct {
    DMA_HandleTypeDef* hdmarx;
    volatile HAL_UART_StateTypeDef gState;
    volatile HAL_UART_StateTypeDef RxState;
    volatile uint32_t ErrorCode;
} UART_HandleTypeDef;

HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef* uart, const uint8_t* data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Transmit_DMA(UART_HandleTypeDef* uart, const uint8_t* data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef* uart, uint8_t* data, uint16_t size);
HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_DMA(UART_HandleTypeDef* uart, uint8_t* data, uint16_t size);

// Functions that the user's program defines.
void HAL_UART_RxCpltCallback(UART_HandleTypeDef* uart);
void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef* uart, uint16_t size);
void HAL_UART_TxCpltCallback(UART_HandleTypeDef* uart);
void HAL_UART_ErrorCallback(UART_HandleTypeDef* uart);
}
