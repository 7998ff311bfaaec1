// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Zephyr: a port over the asynchronous UART API (CONFIG_UART_ASYNC_API=y), which uses DMA on most chips.
//
//     servobus::ports::zephyr_uart rs485{uart, &driver, 115200}; // a const device*, a gpio_dt_spec
//     rs485.start();
//
// - Who waits: `wait` sleeps on a semaphore that the receive event gives, rounded down to kernel ticks; for
//   less than a tick it yields. No other call waits: `send` copies the frame and the UART driver sends it.
// - The driver: a GPIO, on before the first bit. UART_TX_DONE means that the UART driver no longer needs the
//   buffer; with some UART drivers the last character is still being sent. A kernel timer waits for the rest
//   of the wire time and switches the GPIO off. It does not depend on the thread. Without a GPIO the UART has
//   to switch the RS-485 driver.
// - A partial read returns what the UART driver has reported: it reports a full buffer, or a gap of two
//   characters. So bytes are seen up to two characters late: use host timing.
// - Before the request: what the UART driver reports while the request is sent, or within four characters
//   after its last stop bit, is taken as an echo and discarded. A response has at least five characters.
// - Errors: UART_RX_STOPPED. `receive` returns the bytes before the error first, then the error, once;
//   reception is restarted.
// - Clock: the kernel's ticks in 64 bits, as microseconds truncated to 32 bits, so that it wraps at 2^32.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <zephyr/drivers/gpio.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>

#include <servobus/line/port.hpp>
#include <servobus/line/ring.hpp>

namespace servobus::ports {

/// A port over a UART device that is configured (device tree or uart_configure).
class zephyr_uart {
  public:
    /// `driver` is active while a request is sent; it may be null. `bits` is the length of a character with
    /// start, parity and stop bits.
    constexpr zephyr_uart(const device* uart, const gpio_dt_spec* driver, std::uint32_t baud,
                          std::uint8_t bits = 10)
        : uart_{uart}, driver_{driver}, character_{(bits * 1'000'000u + baud - 1) / baud} {}
    zephyr_uart(const zephyr_uart&) = delete;
    zephyr_uart& operator=(const zephyr_uart&) = delete;

    /// Starts reception. False if the UART or the GPIO is not ready.
    bool start() {
        k_sem_init(&arrived_, 0, 1);
        k_timer_init(&rest_, on_rest, nullptr);
        k_timer_user_data_set(&rest_, this);
        if (driver_ != nullptr && gpio_pin_configure_dt(driver_, GPIO_OUTPUT_INACTIVE) != 0) return false;
        return uart_callback_set(uart_, on_event, this) == 0 && listen();
    }

    /// Takes a whole frame, or nothing while another one is being sent. Errors: `send_failed`.
    transfer send(bytes out) {
        if (is_sending_ || out.empty()) return std::uint16_t{0};
        const std::size_t size = out.size() < out_.size() ? out.size() : out_.size();
        for (std::size_t i = 0; i < size; ++i) out_[i] = out[i];
        free_at_ = now() + character_ * static_cast<std::uint32_t>(size);
        is_sending_ = true; // before the event that clears it can come
        drive(true);
        if (uart_tx(uart_, out_.data(), size, SYS_FOREVER_US) == 0) return static_cast<std::uint16_t>(size);
        end_request();
        return errc::send_failed;
    }

    bool sent() const { return !is_sending_; }

    /// Returns the bytes that were received first, then the error. Errors: `receive_failed`.
    transfer receive(byte_buffer in) {
        if (is_deaf_) (void)listen();
        const std::uint16_t came = input_.pop(in);
        if (came != 0 || !has_failed_) return came;
        has_failed_ = false;
        return errc::receive_failed;
    }

    instant now() const { return {static_cast<std::uint32_t>(k_ticks_to_us_floor64(k_uptime_ticks()))}; }

    void wait(duration d) {
        const auto ticks = k_us_to_ticks_floor32(d.us);
        if (ticks == 0)
            k_yield();
        else
            (void)k_sem_take(&arrived_, K_TICKS(ticks));
    }

  private:
    static void on_event(const device*, uart_event* event, void* self) {
        static_cast<zephyr_uart*>(self)->handle(*event);
    }
    static void on_rest(k_timer* timer) {
        static_cast<zephyr_uart*>(k_timer_user_data_get(timer))->end_request();
    }

    void handle(const uart_event& event) {
        switch (event.type) {
        case UART_TX_DONE:
            if (went_back(free_at_, now()))
                k_timer_start(&rest_, K_USEC(since(now(), free_at_).us), K_NO_WAIT);
            else
                end_request();
            break;
        case UART_TX_ABORTED: end_request(); break;
        case UART_RX_RDY: take({event.data.rx.buf + event.data.rx.offset, event.data.rx.len}); break;
        case UART_RX_BUF_REQUEST:
            which_ ^= 1u;
            (void)uart_rx_buf_rsp(uart_, in_[which_].data(), in_[which_].size());
            break;
        case UART_RX_STOPPED: was_stopped_ = true; break; // UART_RX_RDY may follow with earlier bytes
        case UART_RX_DISABLED:
            if (was_stopped_ && !is_sending_) has_failed_ = true;
            was_stopped_ = false;
            (void)listen();
            k_sem_give(&arrived_);
            break;
        default: break;
        }
    }

    bool listen() {
        which_ = 0;
        is_deaf_ = false;
        if (uart_rx_enable(uart_, in_[0].data(), in_[0].size(),
                           static_cast<std::int32_t>(2 * character_.us)) != 0)
            is_deaf_ = true;
        return !is_deaf_;
    }

    void take(bytes came) {
        if (is_sending_ || has_failed_ || since(ended_, now()) < character_ * 4) return;
        for (const std::uint8_t byte : came) {
            if (!input_.push(byte)) has_failed_ = true;
        }
        k_sem_give(&arrived_);
    }

    void end_request() {
        drive(false);
        ended_ = now();
        is_sending_ = false;
    }

    void drive(bool on) {
        if (driver_ != nullptr) (void)gpio_pin_set_dt(driver_, on ? 1 : 0);
    }

    const device* uart_;
    const gpio_dt_spec* driver_;
    duration character_;
    instant free_at_{}; // computed end of the frame
    instant ended_{};
    k_sem arrived_{};
    k_timer rest_{};
    std::array<std::uint8_t, 256> out_{};
    std::array<std::array<std::uint8_t, 64>, 2> in_{};
    std::uint8_t which_ = 0;
    bool was_stopped_ = false;
    ring<256> input_;
    std::atomic<bool> is_deaf_{false};
    std::atomic<bool> is_sending_{false};
    std::atomic<bool> has_failed_{false};
};

static_assert(waiting_port<zephyr_uart>);

} // namespace servobus::ports
