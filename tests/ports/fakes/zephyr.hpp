// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The asynchronous UART of Zephyr: it keeps the caller's buffer, reports UART_TX_DONE while the last
// character is still leaving, and reports received bytes when a buffer is full or after a gap. An error
// stops reception.
#pragma once

#include <zephyr/drivers/gpio.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>

#include "../wire.hpp"

namespace fake::zephyr {

inline const device uart{"uart"};
inline const gpio_dt_spec pin{&uart, 2, 0};
inline uart_callback_t callback = nullptr;
inline void* user = nullptr;
inline bool is_output = false, is_sending = false, refuses = false;
inline unsigned deaf = 0; // the number of calls of uart_rx_enable that fail
inline std::uint8_t *buffer = nullptr, *next = nullptr;
inline std::size_t size = 0, next_size = 0, written = 0, told = 0;
inline std::uint64_t silence = 0, last = 0;

inline void reset() {
    callback = nullptr;
    is_output = is_sending = refuses = false;
    deaf = 0;
    buffer = next = nullptr;
}

inline void tell(uart_event event) {
    if (callback != nullptr) callback(&uart, &event, user);
}
inline void tell(uart_event_type type) {
    uart_event event{};
    event.type = type;
    tell(event);
}
inline void tell_received() {
    if (buffer == nullptr || written == told) return;
    uart_event event{};
    event.type = UART_RX_RDY;
    event.data.rx = {buffer, told, written - told};
    told = written;
    tell(event);
}
inline void disable() {
    tell_received();
    buffer = nullptr;
    tell(UART_RX_BUF_RELEASED);
    tell(UART_RX_DISABLED);
}

inline void receive(std::uint8_t byte, damage how) {
    if (buffer == nullptr) return;
    if (how != damage::none) {
        tell(UART_RX_STOPPED);
        return disable();
    }
    buffer[written++] = byte;
    last = line().now;
    if (written < size) {
        line().in(silence, [at = last] {
            if (at == last) tell_received();
        });
        return;
    }
    tell_received();
    if (next == nullptr) return disable();
    tell(UART_RX_BUF_RELEASED);
    buffer = std::exchange(next, nullptr);
    size = next_size;
    written = told = 0;
    tell(UART_RX_BUF_REQUEST);
}

inline void leave(const std::uint8_t* data, std::size_t left) {
    if (left == 1) {
        line().in(0, [] {
            is_sending = false;
            tell(UART_TX_DONE);
        });
    }
    line().transmit(*data, [data, left] {
        if (left > 1) leave(data + 1, left - 1);
    });
}

} // namespace fake::zephyr

extern "C" {
inline int uart_callback_set(const struct device*, uart_callback_t callback, void* user_data) {
    fake::zephyr::callback = callback;
    fake::zephyr::user = user_data;
    return 0;
}
inline int uart_tx(const struct device*, const uint8_t* buf, size_t len, int32_t) {
    if (fake::zephyr::is_sending || std::exchange(fake::zephyr::refuses, false)) return -16;
    fake::zephyr::is_sending = true;
    fake::zephyr::leave(buf, len);
    return 0;
}
inline int uart_rx_enable(const struct device*, uint8_t* buf, size_t len, int32_t timeout) {
    using namespace fake::zephyr;
    if (deaf > 0) return --deaf, -16;
    if (buffer != nullptr) return -16;
    buffer = buf;
    size = len;
    written = told = 0;
    silence = static_cast<std::uint64_t>(timeout);
    fake::line().hears = receive;
    tell(UART_RX_BUF_REQUEST);
    return 0;
}
inline int uart_rx_buf_rsp(const struct device*, uint8_t* buf, size_t len) {
    fake::zephyr::next = buf;
    fake::zephyr::next_size = len;
    return 0;
}
inline int gpio_pin_configure_dt(const struct gpio_dt_spec*, uint32_t flags) {
    fake::zephyr::is_output = flags == GPIO_OUTPUT_INACTIVE;
    return 0;
}
inline int gpio_pin_set_dt(const struct gpio_dt_spec*, int value) {
    if (fake::zephyr::is_output) fake::line().drive(value != 0);
    return 0;
}
inline int k_sem_init(struct k_sem* sem, unsigned int initial_count, unsigned int limit) {
    *sem = {initial_count, limit};
    return 0;
}
inline void k_sem_give(struct k_sem* sem) {
    if (sem->count < sem->limit) ++sem->count;
}
inline int k_sem_take(struct k_sem* sem, k_timeout_t timeout) {
    fake::line().sleep(static_cast<std::uint64_t>(timeout.ticks) * 100, [sem] { return sem->count != 0; });
    if (sem->count == 0) return -11;
    --sem->count;
    return 0;
}
inline void k_timer_init(struct k_timer* timer, k_timer_expiry_t expiry, k_timer_expiry_t) {
    timer->expiry = expiry;
}
inline void k_timer_user_data_set(struct k_timer* timer, void* data) { timer->user_data = data; }
inline void* k_timer_user_data_get(const struct k_timer* timer) { return timer->user_data; }
inline void k_timer_start(struct k_timer* timer, k_timeout_t duration, k_timeout_t) {
    fake::line().in(static_cast<std::uint64_t>(duration.ticks) * 100, [timer] { timer->expiry(timer); });
}
inline void k_yield(void) { fake::line().look(); }
inline int64_t k_uptime_ticks(void) { return static_cast<int64_t>(fake::line().look() / 100); }
}
