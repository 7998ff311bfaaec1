// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// STM32 HAL: a port that receives by DMA with idle line detection, one interrupt a burst instead of one a
// byte. Sending, driver, errors and clock: see stm32_hal.hpp.
//
//     servobus::ports::stm32_hal_dma rs485{huart2, {GPIOA, GPIO_PIN_1}, &htim2};
//     void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef*, uint16_t) { rs485.on_received(); }
//     void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) { rs485.on_sent(); }
//     void HAL_UART_ErrorCallback(UART_HandleTypeDef*) { rs485.on_error(); }
//
// Call `rs485.start()` after MX_USART2_UART_Init(). The callbacks are C functions (extern "C"); with several
// UARTs they compare the handle.
//
// A partial read returns what the DMA had written at its last event: half of the buffer, its end, or a line
// that was idle for one character. So bytes are seen up to a character late: use host timing. Configure the
// receive DMA in circular mode, since in normal mode a byte may be lost while reception is restarted, and
// enable the global interrupts of the USART and of both DMA channels. On a core with a data cache the port
// must be in memory that is not cached.
#pragma once

#include <array>

#include "stm32_hal.hpp"

namespace servobus::ports {

/// A port over HAL_UARTEx_ReceiveToIdle_DMA and HAL_UART_Transmit_DMA.
class stm32_hal_dma : public stm32_hal<HAL_UART_Transmit_DMA> {
  public:
    /// `clock` is a 32-bit timer at 1 MHz; without one the time is that of HAL_GetTick.
    constexpr explicit stm32_hal_dma(UART_HandleTypeDef& uart, rs485_pin driver = {}, timer* clock = nullptr)
        : stm32_hal{uart, driver, clock} {}

    /// Starts reception. False if the UART is not ready; then each `receive` tries again.
    bool start() {
        taken_ = 0;
        is_deaf_ = false; // before the start: an interrupt may set it again immediately
        if (HAL_UARTEx_ReceiveToIdle_DMA(uart_, in_.data(), size) != HAL_OK) is_deaf_ = true;
        return !is_deaf_;
    }

    transfer receive(byte_buffer in) {
        if (is_deaf_) (void)start();
        return stm32_hal::receive(in);
    }

    // Call these from the HAL's callbacks of the same names.

    void on_received() {
        take_written();
        if (uart_->RxState == HAL_UART_STATE_READY) (void)start(); // normal mode has ended reception
    }
    void on_sent() {
        take_written(); // discards an echo that is in the buffer before its event has come
        end_request();
    }
    void on_error() {
        take_written();
        note_error();
        if (uart_->RxState == HAL_UART_STATE_READY) (void)start(); // every DMA error ends reception
    }

  private:
    static constexpr std::uint16_t size = 64;

    // Reads the position from the DMA itself: an event that was delayed reports an older one.
    void take_written() {
        const auto at = static_cast<std::uint16_t>(size - __HAL_DMA_GET_COUNTER(uart_->hdmarx));
        while (taken_ != at) {
            if (taken_ == size)
                taken_ = 0;
            else
                take(in_[taken_++]);
        }
    }

    std::array<std::uint8_t, size> in_{};
    std::uint16_t taken_ = 0;
    std::atomic<bool> is_deaf_{false};
};

static_assert(port<stm32_hal_dma>);

} // namespace servobus::ports
