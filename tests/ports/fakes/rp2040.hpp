// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The UART of the RP2040: FIFOs of 32 characters, an interrupt when the transmit FIFO has fallen to 4, one
// when 4 characters were received or none came for 32 bit times, and alarms.
#pragma once

#include <deque>

#include "hardware/gpio.h"
#include "hardware/uart.h"
#include "pico/time.h"

#include "../wire.hpp"

namespace fake::rp2040 {

inline uart_inst_t uart;
inline constexpr unsigned driver_pin = 2;
inline std::function<void()> interrupt;
inline std::deque<std::uint32_t> received;
inline unsigned waiting = 0; // characters in the transmit FIFO and the shift register
inline unsigned lost = 0;    // characters written into a full FIFO
inline bool rx_enabled = false, tx_enabled = false, is_output = false;
inline bool refuses = false; // refuses the next alarm
inline std::uint64_t last = 0;

inline void receive(std::uint8_t byte, damage how) {
    std::uint32_t entry = byte;
    if (how == damage::framing) entry |= UART_UARTDR_FE_BITS;
    if (how == damage::overrun) entry |= UART_UARTDR_OE_BITS;
    if (received.size() >= 32)
        received.back() |= UART_UARTDR_OE_BITS;
    else
        received.push_back(entry);
    last = line().now;
    if (received.size() >= 4 && rx_enabled) return interrupt();
    line().in(3 * wire::character, [at = last] {
        if (at == last && !received.empty() && rx_enabled) interrupt();
    });
}

inline void reset() {
    received.clear();
    waiting = lost = 0;
    rx_enabled = tx_enabled = is_output = false;
    refuses = false;
    line().hears = receive;
}

inline void alarm(std::uint64_t us, alarm_callback_t callback, void* data) {
    line().in(us, [callback, data] {
        const std::int64_t again = callback(1, data);
        if (again > 0) alarm(static_cast<std::uint64_t>(again), callback, data);
    });
}

} // namespace fake::rp2040

inline stub_data_register::operator uint32_t() const {
    const std::uint32_t entry = fake::rp2040::received.front();
    fake::rp2040::received.pop_front();
    return entry;
}
inline void stub_data_register::operator=(uint32_t byte) const {
    if (fake::rp2040::waiting >= 33) {
        ++fake::rp2040::lost;
        return;
    }
    ++fake::rp2040::waiting;
    fake::line().transmit(static_cast<std::uint8_t>(byte), [] {
        if (--fake::rp2040::waiting == 5 && fake::rp2040::tx_enabled) fake::rp2040::interrupt();
    });
}
inline stub_flag_register::operator uint32_t() const {
    return fake::rp2040::waiting != 0 ? UART_UARTFR_BUSY_BITS : 0u;
}
inline uart_hw_t* uart_get_hw(uart_inst_t* uart) { return &uart->hw; }
inline bool uart_is_writable(uart_inst_t*) { return fake::rp2040::waiting < 33; }
inline bool uart_is_readable(uart_inst_t*) { return !fake::rp2040::received.empty(); }
inline void uart_set_irq_enables(uart_inst_t*, bool rx_has_data, bool tx_needs_data) {
    fake::rp2040::rx_enabled = rx_has_data;
    fake::rp2040::tx_enabled = tx_needs_data;
}
inline void gpio_init(unsigned int) {}
inline void gpio_set_dir(unsigned int gpio, bool out) {
    if (gpio == fake::rp2040::driver_pin) fake::rp2040::is_output = out;
}
inline void gpio_put(unsigned int gpio, bool value) {
    if (gpio == fake::rp2040::driver_pin && fake::rp2040::is_output) fake::line().drive(value);
}
inline uint32_t time_us_32(void) { return static_cast<std::uint32_t>(fake::line().look()); }
inline alarm_id_t add_alarm_in_us(uint64_t us, alarm_callback_t callback, void* user_data, bool) {
    if (std::exchange(fake::rp2040::refuses, false)) return -1;
    fake::rp2040::alarm(us, callback, user_data);
    return 1;
}
