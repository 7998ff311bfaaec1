// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the STM32 ports use of the HAL: names, types and values; the behaviour is in fakes/stm32_hal.hpp.
#pragma once

#include <stdint.h>

extern "C" {

typedef enum { HAL_OK = 0, HAL_ERROR = 1, HAL_BUSY = 2, HAL_TIMEOUT = 3 } HAL_StatusTypeDef;

typedef struct {
    volatile uint32_t counter;
} DMA_HandleTypeDef;
#define __HAL_DMA_GET_COUNTER(handle) ((handle)->counter)

#define HAL_TIM_MODULE_ENABLED
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
}

#include "uart_module.h"
