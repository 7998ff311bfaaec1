// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// FreeRTOS: gives any port that receives by interrupt a `wait` that sleeps, so that blocking calls need not
// poll.
//
//     constinit servobus::ports::freertos_waiting<servobus::ports::stm32_hal_it> rs485{huart2};
//     void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) { rs485.on_received(), rs485.wake_from_isr(); }
//
// Call `wake_from_isr` in this way in each callback of the port. The interrupt's priority must allow FreeRTOS
// calls (configMAX_SYSCALL_INTERRUPT_PRIORITY).
//
// - Who waits: `wait` suspends the task until `wake_from_isr` is called or the time has passed, rounded down
//   to ticks. For less than a tick it yields: choose a tick of 1 ms (configTICK_RATE_HZ 1000) for gaps of
//   1.75 ms. The task that called `send` last is the one that is woken. The port uses the task's notification
//   0 during a call. A notification left over from a stop or an earlier frame ends a sleep early, which the
//   contract allows.
// - The RS-485 driver, partial reads, early bytes, errors and the clock are those of `Port`. Its ring keeps
//   the bytes, so a byte that arrives between a poll of the ring and the sleep is not lost.
#pragma once

#include <atomic>
#include <cstdint>

#include "FreeRTOS.h"
#include "task.h"

#include <servobus/line/port.hpp>

namespace servobus::ports {

/// A `Port` that can sleep. Its constructors are those of `Port`.
template <port Port> class freertos_waiting : public Port {
  public:
    using Port::Port;

    transfer send(bytes out) {
        task_ = xTaskGetCurrentTaskHandle(); // before sending, so that its interrupts wake this task
        return Port::send(out);
    }

    void wait(duration d) {
        const TickType_t ticks = d.us / (1'000'000u / configTICK_RATE_HZ);
        if (ticks == 0)
            taskYIELD();
        else
            (void)ulTaskNotifyTake(pdTRUE, ticks);
    }

    /// Wakes the sleeping task. Call it from an interrupt, after the port's own handler.
    void wake_from_isr() {
        const TaskHandle_t task = task_;
        if (task == nullptr) return;
        BaseType_t is_to_switch = pdFALSE;
        vTaskNotifyGiveFromISR(task, &is_to_switch);
        portYIELD_FROM_ISR(is_to_switch);
    }

  private:
    std::atomic<TaskHandle_t> task_{nullptr};
};

} // namespace servobus::ports
