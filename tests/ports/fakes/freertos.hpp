// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// FreeRTOS with one task and the notification of that task.
#pragma once

#include "FreeRTOS.h"
#include "task.h"

#include "../wire.hpp"

struct tskTaskControlBlock {
    std::uint32_t notified = 0;
};

namespace fake::freertos {
inline tskTaskControlBlock task;
inline unsigned sleeps = 0;
} // namespace fake::freertos

extern "C" {
inline TaskHandle_t xTaskGetCurrentTaskHandle(void) { return &fake::freertos::task; }
inline uint32_t ulTaskNotifyTake(BaseType_t, TickType_t ticks) {
    ++fake::freertos::sleeps;
    fake::line().sleep(ticks * 1000u, [] { return fake::freertos::task.notified != 0; });
    return std::exchange(fake::freertos::task.notified, 0u);
}
inline void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t* woken) {
    ++task->notified;
    *woken = pdTRUE;
}
inline void stub_yield(void) { fake::line().look(); }
}
