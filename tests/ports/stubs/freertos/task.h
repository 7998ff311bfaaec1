// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the FreeRTOS mix-in uses of tasks.
#pragma once

#include "FreeRTOS.h"

typedef struct tskTaskControlBlock* TaskHandle_t;

extern "C" {
TaskHandle_t xTaskGetCurrentTaskHandle(void);
uint32_t ulTaskNotifyTake(BaseType_t clear_on_exit, TickType_t ticks_to_wait);
void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t* higher_priority_task_woken);
void stub_yield(void);
}
#define taskYIELD() stub_yield()
