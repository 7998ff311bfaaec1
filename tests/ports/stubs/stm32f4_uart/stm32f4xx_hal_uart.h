// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// For the real HAL of the STM32F4 without its UART module: HAL_UART_MODULE_ENABLED includes this header.
#pragma once

#include "../stm32_hal/uart_module.h"
