// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A main loop that reads and writes registers of a ZLAC8015D and never waits, on an STM32 that receives
// one byte an interrupt. To receive by DMA with idle line detection, write `stm32_hal_dma` for `stm32_hal_it`.
// Call `run_drive` after the UART's initialisation.
#include "stm32_hal_it.hpp"

#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

extern UART_HandleTypeDef huart2; // made by CubeMX
extern TIM_HandleTypeDef htim2;

namespace {

using namespace servobus;
using namespace servobus::units;

ports::stm32_hal_it rs485{huart2, {GPIOA, GPIO_PIN_1}, &htim2};
constinit line wire{rs485, modbus::timing_at(zlac8015d::device::facts.baud)};
constinit client wheels{wire, node<zlac8015d::device>{1}};

} // namespace

extern "C" {
void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) { rs485.on_received(); }              // by interrupt
void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef*, uint16_t) { rs485.on_received(); } // by DMA
void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) { rs485.on_sent(); }
void HAL_UART_ErrorCallback(UART_HandleTypeDef*) { rs485.on_error(); }
}

/// Runs until the bus voltage is low or unknown.
void run_drive() {
    stepped_read<decltype(wheels), zlac8015d::bus_voltage> voltage{wheels};
    stepped_write<decltype(wheels), zlac8015d::left_acceleration_time> ramp{wheels};
    if (!rs485.start() || !ramp.begin(800 * millisecond)) return;
    if (!voltage.begin()) return;
    for (;;) {
        ramp.step();
        voltage.step();
        if (voltage.done()) {
            const auto seen = voltage.value();
            if (!seen || *seen < 22 * volt) return; // a call under way is given up
            if (!voltage.begin()) return;
        }
        // Here the rest of your program: no step waits.
    }
}
