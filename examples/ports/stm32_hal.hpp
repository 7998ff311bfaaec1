// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// STM32 HAL, what its two ports share: sending, the RS-485 driver, the clock and errors. Include
// stm32_hal_it.hpp or stm32_hal_dma.hpp, not this header.
//
// - Who waits: no call waits. `send` copies the frame, which is then sent by interrupt or DMA.
// - The driver: `rs485_pin` is switched on before the first bit and off in the TC interrupt, after the last
//   stop bit. It does not depend on the main loop. Without a pin the USART switches the driver
//   (HAL_RS485Ex_Init).
// - Before the request: bytes that are received while a request is sent (an echo, a collision) are discarded
//   as they arrive.
// - Errors: overrun, framing, noise, parity. `receive` returns the bytes before the error first, then the
//   error, once. Bytes that arrive between the error and that return are discarded.
// - Clock: a 32-bit timer at 1 MHz (TIM2 or TIM5, period 0xFFFFFFFF), which wraps at 2^32. Without a timer,
//   HAL_GetTick in milliseconds, which host timing allows above 19200 Bd; the tick times 1000 modulo 2^32
//   stays correct when the tick wraps.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "main.h" // made by CubeMX: the HAL of your family, with HAL_UART_MODULE_ENABLED

#include <servobus/line/port.hpp>
#include <servobus/line/ring.hpp>

namespace servobus::ports {

/// The pin that switches the RS-485 driver on while it is high; no pin if the hardware switches the driver.
struct rs485_pin {
    GPIO_TypeDef* bank = nullptr;
    std::uint16_t pin = 0;

    void set(bool on) const {
        if (bank != nullptr) HAL_GPIO_WritePin(bank, pin, on ? GPIO_PIN_SET : GPIO_PIN_RESET);
    }
};

#ifdef HAL_TIM_MODULE_ENABLED
using timer = TIM_HandleTypeDef;
inline std::uint32_t count_of(const timer* clock) { return __HAL_TIM_GET_COUNTER(clock); }
#else // the HAL without timers does not declare their handle: there is none to pass
struct timer;
inline std::uint32_t count_of(const timer*) { return 0; }
#endif

/// The part of a port that does not depend on how it receives. `Start` is HAL_UART_Transmit_IT or _DMA.
template <auto Start> class stm32_hal {
  public:
    constexpr stm32_hal(UART_HandleTypeDef& uart, rs485_pin driver, timer* clock)
        : uart_{&uart}, clock_{clock}, driver_{driver} {}
    stm32_hal(const stm32_hal&) = delete;
    stm32_hal& operator=(const stm32_hal&) = delete;

    /// Takes a whole frame, or nothing while another one is being sent. Errors: `send_failed`.
    transfer send(bytes out) {
        if (is_sending_ || out.empty()) return std::uint16_t{0};
        const auto size = static_cast<std::uint16_t>(out.size() < out_.size() ? out.size() : out_.size());
        for (std::size_t i = 0; i < size; ++i) out_[i] = out[i];
        is_sending_ = true; // before the interrupt that clears it can come
        driver_.set(true);
        const HAL_StatusTypeDef status = Start(uart_, out_.data(), size);
        if (status == HAL_OK) return size;
        end_request();
        if (status == HAL_BUSY) return std::uint16_t{0};
        return errc::send_failed;
    }

    bool sent() const { return !is_sending_; }

    /// Returns the bytes that were received first, then the error. Errors: `receive_failed`.
    transfer receive(byte_buffer in) {
        const std::uint16_t came = input_.pop(in);
        if (came != 0 || !has_failed_) return came;
        has_failed_ = false;
        return errc::receive_failed;
    }

    instant now() const {
        if (clock_ != nullptr) return {count_of(clock_)};
        return {static_cast<std::uint32_t>(HAL_GetTick()) * 1000u};
    }

    const UART_HandleTypeDef* uart() const { return uart_; }

  protected:
    // Called from interrupts only, except for the calls of end_request in `send`.
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
            end_request(); // the HAL has aborted the transmission
    }

    UART_HandleTypeDef* uart_;

  private:
    timer* clock_;
    rs485_pin driver_;
    std::array<std::uint8_t, 256> out_{};
    ring<256> input_;
    std::atomic<bool> is_sending_{false};
    std::atomic<bool> has_failed_{false};
};

} // namespace servobus::ports
