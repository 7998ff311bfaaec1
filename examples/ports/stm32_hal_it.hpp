// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// STM32 HAL: a port that receives one byte an interrupt. Sending, driver, errors and clock: see
// stm32_hal.hpp.
//
//     servobus::ports::stm32_hal_it rs485{huart2, {GPIOA, GPIO_PIN_1}, &htim2};
//     void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) { rs485.on_received(); }
//     void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) { rs485.on_sent(); }
//     void HAL_UART_ErrorCallback(UART_HandleTypeDef*) { rs485.on_error(); }
//
// Enable the global interrupt of the USART, and call `rs485.start()` after MX_USART2_UART_Init(). The
// callbacks are C functions (extern "C"); with several UARTs they compare the handle.
//
// A partial read returns what the interrupt has stored; the next call continues. Every byte is available
// immediately after its interrupt, so that strict timing may be used.
#pragma once

#include "stm32_hal.hpp"

namespace servobus::ports {

/// A port over HAL_UART_Receive_IT and HAL_UART_Transmit_IT.
class stm32_hal_it : public stm32_hal<HAL_UART_Transmit_IT> {
  public:
    /// `clock` is a 32-bit timer at 1 MHz; without one the time is that of HAL_GetTick.
    constexpr explicit stm32_hal_it(UART_HandleTypeDef& uart, rs485_pin driver = {}, timer* clock = nullptr)
        : stm32_hal{uart, driver, clock} {}

    /// Starts reception. False if the UART is not ready; then each `receive` tries again.
    bool start() {
        is_deaf_ = false; // before the start: an interrupt may set it again immediately
        if (HAL_UART_Receive_IT(uart_, &byte_, 1) != HAL_OK) is_deaf_ = true;
        return !is_deaf_;
    }

    transfer receive(byte_buffer in) {
        // HALs with a lock refuse to restart reception in an interrupt during HAL_UART_Transmit_IT: try
        // again.
        if (is_deaf_) (void)start();
        return stm32_hal::receive(in);
    }

    // Call these from the HAL's callbacks of the same names.
    void on_received() {
        if (uart_->ErrorCode == HAL_UART_ERROR_NONE)
            take(byte_);
        else
            note_error(); // the HAL passes a damaged byte on before it reports the error
        (void)start();
    }
    void on_sent() { end_request(); }
    void on_error() {
        note_error();
        if (uart_->RxState == HAL_UART_STATE_READY) (void)start(); // the HAL ends reception on an overrun
    }

  private:
    std::uint8_t byte_ = 0;
    std::atomic<bool> is_deaf_{false};
};

static_assert(port<stm32_hal_it>);

} // namespace servobus::ports
