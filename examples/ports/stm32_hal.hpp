// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// STM32 HAL, what its two ports share: sending, the RS-485 driver, the clock, and errors.
//
// - Who waits: nobody. A frame is copied and leaves by interrupt or DMA.
// - The driver: `rs485_pin` is switched on before the first bit and off in the TC interrupt, behind the last
//   stop bit, whatever the main loop does then. Without a pin the USART does it (HAL_RS485Ex_Init).
// - Before the request: what is heard while a request leaves (an echo, a collision) is dropped as it comes.
// - Errors: over-run, framing, noise, parity. The bytes before the error are handed on, then the error once;
//   what came behind it by then is dropped.
// - Clock: a 32-bit timer at 1 MHz (TIM2 or TIM5, period 0xFFFFFFFF), which wraps by itself at 2^32; without
//   one HAL_GetTick in milliseconds, which host timing allows above 19200 Bd. A product taken modulo 2^32
//   counts on through every wrap of the tick.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "main.h" // CubeMX's: the HAL of your family, with HAL_UART_MODULE_ENABLED

#include <servobus/line/port.hpp>
#include <servobus/line/ring.hpp>

namespace servobus::ports {

/// The pin that switches the RS-485 driver on when it is high; none if the hardware does it.
struct rs485_pin {
    GPIO_TypeDef* bank = nullptr;
    std::uint16_t pin = 0;

    void set(bool on) const {
        if (bank != nullptr) HAL_GPIO_WritePin(bank, pin, on ? GPIO_PIN_SET : GPIO_PIN_RESET);
    }
};

/// The half of a port that receiving does not change. `Start` is HAL_UART_Transmit_IT or _DMA.
template <auto Start> class stm32_hal {
  public:
    constexpr stm32_hal(UART_HandleTypeDef& uart, rs485_pin driver, TIM_HandleTypeDef* clock)
        : uart_{&uart}, clock_{clock}, driver_{driver} {}
    stm32_hal(const stm32_hal&) = delete;
    stm32_hal& operator=(const stm32_hal&) = delete;

    /// Takes a whole frame, or nothing while another one leaves. Errors: `send_failed`.
    transfer send(bytes out) {
        if (is_sending_ || out.empty()) return std::uint16_t{0};
        const auto size = static_cast<std::uint16_t>(out.size() < out_.size() ? out.size() : out_.size());
        for (std::size_t i = 0; i < size; ++i) out_[i] = out[i];
        is_sending_ = true; // before the interrupt can say that it is over
        driver_.set(true);
        const HAL_StatusTypeDef status = Start(uart_, out_.data(), size);
        if (status == HAL_OK) return size;
        end_request();
        if (status == HAL_BUSY) return std::uint16_t{0};
        return failure{errc::send_failed};
    }

    bool sent() const { return !is_sending_; }

    /// Bytes first, then the error behind them.
    transfer receive(byte_buffer in) {
        const std::uint16_t came = input_.pop(in);
        if (came != 0 || !has_failed_) return came;
        has_failed_ = false;
        return failure{errc::receive_failed};
    }

    instant now() const {
        if (clock_ != nullptr) return {static_cast<std::uint32_t>(__HAL_TIM_GET_COUNTER(clock_))};
        return {static_cast<std::uint32_t>(HAL_GetTick()) * 1000u};
    }

    const UART_HandleTypeDef* uart() const { return uart_; }

  protected:
    // From interrupts only, but for the call in `send`.
    void end_request() {
        driver_.set(false);
        is_sending_ = false;
    }
    void take(std::uint8_t byte) {
        if (is_sending_ || has_failed_) return;
        if (!input_.push(byte)) has_failed_ = true;
    }
    void note_error() {
        if (!is_sending_)
            has_failed_ = true;
        else if (uart_->gState == HAL_UART_STATE_READY)
            end_request(); // sending itself was given up
    }

    UART_HandleTypeDef* uart_;

  private:
    TIM_HandleTypeDef* clock_;
    rs485_pin driver_;
    std::array<std::uint8_t, 256> out_{};
    ring<256> input_;
    std::atomic<bool> is_sending_{false};
    std::atomic<bool> has_failed_{false};
};

} // namespace servobus::ports
