// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// STM32 HAL, a byte an interrupt. Sending, driver, errors and clock: see stm32_hal.hpp. A partial read is
// what the interrupt has stored so far; the next call goes on. Every byte is there within its interrupt, so
// that strict timing may be used. Enable the USART's global interrupt, then:
//
//     constinit servobus::ports::stm32_hal_it rs485{huart2, {GPIOA, GPIO_PIN_1}, &htim2};
//     void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) { rs485.on_received(); }
//     void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) { rs485.on_sent(); }
//     void HAL_UART_ErrorCallback(UART_HandleTypeDef*) { rs485.on_error(); }
//
// and `rs485.start()` behind MX_USART2_UART_Init(). The callbacks are C functions (extern "C") and look at
// the handle where there are several UARTs.
#pragma once

#include "stm32_hal.hpp"

namespace servobus::ports {

/// A port over HAL_UART_Receive_IT and HAL_UART_Transmit_IT.
class stm32_hal_it : public stm32_hal<HAL_UART_Transmit_IT> {
  public:
    /// Without `clock` the time is HAL_GetTick's.
    constexpr explicit stm32_hal_it(UART_HandleTypeDef& uart, rs485_pin driver = {},
                                    TIM_HandleTypeDef* clock = nullptr)
        : stm32_hal{uart, driver, clock} {}

    /// Begins to receive. False if the UART is not ready.
    bool start() {
        is_deaf_ = false; // first: the interrupt may find it deaf again at once
        if (HAL_UART_Receive_IT(uart_, &byte_, 1) != HAL_OK) is_deaf_ = true;
        return !is_deaf_;
    }

    transfer receive(byte_buffer in) {
        // HALs with a lock refuse an interrupt that falls into HAL_UART_Transmit_IT: begin again.
        if (is_deaf_) (void)start();
        return stm32_hal::receive(in);
    }

    // To be called from the HAL's callbacks of the same names.
    void on_received() {
        if (uart_->ErrorCode == HAL_UART_ERROR_NONE)
            take(byte_);
        else
            note_error(); // the HAL hands a damaged byte on before it tells the error
        (void)start();
    }
    void on_sent() { end_request(); }
    void on_error() {
        note_error();
        if (uart_->RxState == HAL_UART_STATE_READY) (void)start(); // an over-run ends reception
    }

  private:
    std::uint8_t byte_ = 0;
    std::atomic<bool> is_deaf_{false};
};

static_assert(port<stm32_hal_it>);

} // namespace servobus::ports
