// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Raspberry Pi RP2040 and RP2350, C SDK: a port over a UART with interrupts. An alarm switches the RS-485
// driver, since this UART has no interrupt at the end of the last stop bit. Interrupts and alarm run on the
// core that called `start`.
//
//     servobus::ports::rp2040_uart rs485{uart0, 2, 115200}; // after uart_init and gpio_set_function
//     irq_set_exclusive_handler(UART0_IRQ, on_uart0);        // a function that calls rs485.on_interrupt()
//     irq_set_enabled(UART0_IRQ, true);
//     rs485.start();
//
// - Who waits: no call waits. `send` copies the frame and the interrupt refills the FIFO, so that the frame
//   has no pause.
// - The driver: on before the first bit. At the end of the wire time an alarm checks whether the UART is
//   still busy, repeats the check after each further character, and switches the driver off. It does not
//   depend on the main loop.
// - A partial read returns what the interrupt has stored; the next call continues. The FIFO reports its last
//   bytes 32 bit times late: use host timing.
// - Before the request: bytes that are received while the request is sent are discarded as they arrive.
// - Errors: overrun, framing, parity, break. `receive` returns the bytes before the error first, then the
//   error, once.
// - Clock: time_us_32(), which wraps at 2^32.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "hardware/gpio.h"
#include "hardware/uart.h"
#include "pico/time.h"

#include <servobus/line/port.hpp>
#include <servobus/line/ring.hpp>

namespace servobus::ports {

/// A port over a UART that is initialised already (uart_init).
class rp2040_uart {
  public:
    /// `driver` is the number of a pin that is high while a request is sent; -1 if the transceiver switches
    /// by itself. `bits` is the length of a character with start, parity and stop bits.
    constexpr rp2040_uart(uart_inst_t* uart, int driver, std::uint32_t baud, std::uint8_t bits = 10)
        : uart_{uart}, driver_{driver}, character_us_{(bits * 1'000'000u + baud - 1) / baud} {}
    rp2040_uart(const rp2040_uart&) = delete;
    rp2040_uart& operator=(const rp2040_uart&) = delete;

    void start() {
        if (driver_ >= 0) {
            gpio_init(static_cast<unsigned>(driver_));
            gpio_set_dir(static_cast<unsigned>(driver_), true);
            drive(false);
        }
        uart_set_irq_enables(uart_, true, false);
    }

    /// Takes a whole frame, or nothing while another one is being sent. Errors: `send_failed` if the SDK has
    /// no alarm left.
    transfer send(bytes out) {
        if (is_sending_ || out.empty()) return std::uint16_t{0};
        size_ = static_cast<std::uint16_t>(out.size() < out_.size() ? out.size() : out_.size());
        for (std::size_t i = 0; i < size_; ++i) out_[i] = out[i];
        next_ = 0;
        is_sending_ = true;
        drive(true);
        if (add_alarm_in_us(size_ * character_us_, on_alarm, this, true) < 0) {
            drive(false);
            is_sending_ = false;
            return errc::send_failed;
        }
        fill();
        if (next_ < size_) {
            fills_ = true; // last: the receive interrupt must not fill the FIFO while this call does
            uart_set_irq_enables(uart_, true, true);
        }
        return size_;
    }

    bool sent() const { return !is_sending_; }

    /// Returns the bytes that were received first, then the error. Errors: `receive_failed`.
    transfer receive(byte_buffer in) {
        const std::uint16_t came = input_.pop(in);
        if (came != 0 || !has_failed_) return came;
        has_failed_ = false;
        return errc::receive_failed;
    }

    instant now() const { return {time_us_32()}; }

    /// Call it from the UART's interrupt.
    void on_interrupt() {
        read_all();
        if (!fills_) return;
        fill();
        if (next_ < size_) return;
        fills_ = false;
        uart_set_irq_enables(uart_, true, false);
    }

  private:
    static constexpr std::uint32_t any_error =
        UART_UARTDR_OE_BITS | UART_UARTDR_BE_BITS | UART_UARTDR_PE_BITS | UART_UARTDR_FE_BITS;

    static std::int64_t on_alarm(alarm_id_t, void* self) {
        return static_cast<rp2040_uart*>(self)->end_request();
    }

    // Returns after how many microseconds to check again; 0 once the driver is off.
    std::int64_t end_request() {
        const bool is_busy = (uart_get_hw(uart_)->fr & UART_UARTFR_BUSY_BITS) != 0;
        if (next_ < size_ || is_busy) return character_us_;
        read_all(); // discards an echo that is still in the FIFO
        drive(false);
        is_sending_ = false;
        return 0;
    }

    void fill() {
        std::uint16_t next = next_;
        while (next < size_ && uart_is_writable(uart_)) uart_get_hw(uart_)->dr = out_[next++];
        next_ = next;
    }

    void read_all() {
        while (uart_is_readable(uart_)) {
            const std::uint32_t came = uart_get_hw(uart_)->dr;
            if (is_sending_ || has_failed_) continue;
            if ((came & any_error) != 0 || !input_.push(static_cast<std::uint8_t>(came & 0xFFu)))
                has_failed_ = true;
        }
    }

    void drive(bool on) {
        if (driver_ >= 0) gpio_put(static_cast<unsigned>(driver_), on);
    }

    uart_inst_t* uart_;
    int driver_;
    std::uint32_t character_us_;
    std::array<std::uint8_t, 256> out_{};
    std::uint16_t size_ = 0;
    std::atomic<std::uint16_t> next_{0};
    ring<256> input_;
    std::atomic<bool> fills_{false};
    std::atomic<bool> is_sending_{false};
    std::atomic<bool> has_failed_{false};
};

static_assert(port<rp2040_uart>);

} // namespace servobus::ports
