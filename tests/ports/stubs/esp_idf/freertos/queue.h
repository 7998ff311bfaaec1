// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the ESP-IDF port uses of queues.
#pragma once

#include "FreeRTOS.h"

typedef struct QueueDefinition* QueueHandle_t;

extern "C" {
BaseType_t xQueueReceive(QueueHandle_t queue, void* const buffer, TickType_t ticks_to_wait);
BaseType_t xQueuePeek(QueueHandle_t queue, void* const buffer, TickType_t ticks_to_wait);
}
