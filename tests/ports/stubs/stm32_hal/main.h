// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the STM32 ports use of the HAL: names, types and values; the behaviour is in fakes/stm32_hal.hpp.
#pragma once

#include <stdint.h>

extern "C" {

typedef enum { HAL_OK = 0, HAL_ERROR = 1, HAL_BUSY = 2, HAL_TIMEOUT = 3 } HAL_StatusTypeDef;

typedef uint32_t HAL_UART_StateTypeDef;
#define HAL_UART_STATE_READY 0x00000020U
#define HAL_UART_STATE_BUSY_TX 0x00000021U
#define HAL_UART_STATE_BUSY_RX 0x00000022U

#define HAL_UART_ERROR_NONE 0x00000000U
#define HAL_UART_ERROR_FE 0x00000004U

typedef struct {
    volatile uint32_t counter;
} DMA_HandleTypeDef;
#define __HAL_DMA_GET_COUNTER(handle) ((handle)->counter)

typedef struct {
    DMA_HandleTypeDef* hdmarx;
    volatile HAL_UART_StateTypeDef gState;
    volatile HAL_UART_StateTypeDef RxState;
    volatile uint32_t ErrorCode;
} UART_HandleTypeDef;

typedef struct {
    uint32_t unused;
} TIM_HandleTypeDef;
uint32_t stub_timer_counter(const TIM_HandleTypeDef* timer);
#define __HAL_TIM_GET_COUNTER(handle) stub_timer_counter(handle)

typedef struct {
    uint32_t unused;
} GPIO_TypeDef;
typedef enum { GPIO_PIN_RESET = 0U, GPIO_PIN_SET } GPIO_PinState;
extern GPIO_TypeDef port_a; // a fixed address in the vendor's header
#define GPIOA (&port_a)
#define GPIO_PIN_1 ((uint16_t)0x0002)
void HAL_GPIO_WritePin(GPIO_TypeDef* bank, uint16_t pin, GPIO_PinState state);

uint32_t HAL_GetTick(void);
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
