// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the FreeRTOS mix-in uses; a tick is 1 ms here.
#pragma once

#include <stdint.h>

typedef uint32_t TickType_t;
typedef long BaseType_t;
#define pdFALSE ((BaseType_t)0)
#define pdTRUE ((BaseType_t)1)
#define configTICK_RATE_HZ ((TickType_t)1000)
#define portYIELD_FROM_ISR(x) ((void)(x))
