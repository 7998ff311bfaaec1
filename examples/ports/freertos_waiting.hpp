// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// FreeRTOS: sleeping instead of polling, over any port whose bytes come by interrupt.
//
// - Who waits: `wait` puts the task to sleep until `wake_from_isr` or the time is over, to the tick; for less
//   than a tick it yields, so give silences of 1.75 ms a tick of 1 ms (configTICK_RATE_HZ 1000). The task
//   that sends is the one that is woken. Its notification 0 belongs to the port while a call runs; one that
//   was left over from a stop or an earlier frame ends a sleep early, which the contract allows.
// - The driver, partial reads, early bytes, errors and the clock are those of the port below. Bytes wait in
//   its ring, so nothing is lost between a look at it and the sleep.
//
//     constinit servobus::ports::freertos_waiting<servobus::ports::stm32_hal_it> rs485{huart2};
//     void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) { rs485.on_received(), rs485.wake_from_isr(); }
//
// and so in each callback of the port. The interrupt's priority must allow FreeRTOS calls
// (configMAX_SYSCALL_INTERRUPT_PRIORITY).
#pragma once

#include <atomic>
#include <cstdint>

#include "FreeRTOS.h"
#include "task.h"

#include <servobus/line/port.hpp>

namespace servobus::ports {

/// `Port`, which can sleep. It is made as `Port` is.
template <port Port> class freertos_waiting : public Port {
  public:
    using Port::Port;

    transfer send(bytes out) {
        task_ = xTaskGetCurrentTaskHandle(); // from here on no interrupt is missed
        return Port::send(out);
    }

    void wait(duration d) {
        const TickType_t ticks = d.us / (1'000'000u / configTICK_RATE_HZ);
        if (ticks == 0)
            taskYIELD();
        else
            (void)ulTaskNotifyTake(pdTRUE, ticks);
    }

    /// To be called from an interrupt, behind the port's own handler.
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
