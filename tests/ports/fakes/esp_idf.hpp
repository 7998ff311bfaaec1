// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The UART driver of ESP-IDF: it copies the bytes to send and begins to send them a little later (the
// interrupt may run on the other core), switches the RS-485 driver itself, and reports received bytes by
// events.
#pragma once

#include <cstring>
#include <deque>

#include "driver/uart.h"
#include "esp_timer.h"
#include "freertos/task.h"

#include "../wire.hpp"

struct QueueDefinition {
    std::deque<uart_event_t> events;
};

namespace fake::esp_idf {

inline QueueDefinition queue;
inline std::deque<std::uint8_t> to_send, fifo, received;
inline std::size_t rx_size = 0, tx_size = 0;
inline std::uint64_t timeout = 10 * wire::character, last = 0;
inline bool is_half_duplex = false, is_leaving = false, refuses = false;
inline int driver_pin = -1;

inline void reset() {
    queue.events.clear();
    to_send.clear();
    fifo.clear();
    received.clear();
    is_half_duplex = is_leaving = refuses = false;
    driver_pin = -1;
    line().hears = nullptr;
}

inline void tell(uart_event_type_t type) {
    if (queue.events.size() < 16) queue.events.push_back({type, 0, false});
}

inline void hand_on() {
    if (received.size() + fifo.size() > rx_size) {
        fifo.clear();
        return tell(UART_BUFFER_FULL);
    }
    received.insert(received.end(), fifo.begin(), fifo.end());
    fifo.clear();
    tell(UART_DATA);
}

inline void receive(std::uint8_t byte, damage how) {
    if (how == damage::overrun) {
        fifo.clear();
        return tell(UART_FIFO_OVF);
    }
    if (how == damage::framing) tell(UART_FRAME_ERR);
    fifo.push_back(byte);
    last = line().now;
    if (fifo.size() >= 120) return hand_on();
    line().in(timeout, [at = last] {
        if (at == last && !fifo.empty()) hand_on();
    });
}

inline void leave() {
    if (to_send.empty()) {
        if (is_half_duplex && driver_pin >= 0) line().drive(false);
        fifo.clear(); // the driver drops its echo
        is_leaving = false;
        return;
    }
    const std::uint8_t byte = to_send.front();
    to_send.pop_front();
    if (is_half_duplex && driver_pin >= 0) line().drive(true);
    line().transmit(byte, leave);
}

} // namespace fake::esp_idf

extern "C" {
inline esp_err_t uart_driver_install(uart_port_t, int rx, int tx, int, QueueHandle_t* events, int) {
    fake::esp_idf::rx_size = static_cast<std::size_t>(rx);
    fake::esp_idf::tx_size = static_cast<std::size_t>(tx);
    fake::line().hears = fake::esp_idf::receive;
    *events = &fake::esp_idf::queue;
    return ESP_OK;
}
inline esp_err_t uart_param_config(uart_port_t, const uart_config_t*) { return ESP_OK; }
inline esp_err_t uart_set_pin(uart_port_t, int, int, int rts, int) {
    fake::esp_idf::driver_pin = rts;
    return ESP_OK;
}
inline esp_err_t uart_set_mode(uart_port_t, uart_mode_t mode) {
    fake::esp_idf::is_half_duplex = mode == UART_MODE_RS485_HALF_DUPLEX;
    return ESP_OK;
}
inline esp_err_t uart_set_rx_timeout(uart_port_t, const uint8_t characters) {
    fake::esp_idf::timeout = characters * fake::wire::character;
    return ESP_OK;
}
inline esp_err_t uart_get_tx_buffer_free_size(uart_port_t, size_t* size) {
    if (std::exchange(fake::esp_idf::refuses, false)) return ESP_FAIL;
    *size = fake::esp_idf::tx_size - fake::esp_idf::to_send.size();
    return ESP_OK;
}
inline esp_err_t uart_wait_tx_done(uart_port_t, TickType_t) {
    return fake::esp_idf::is_leaving ? ESP_ERR_TIMEOUT : ESP_OK;
}
inline esp_err_t uart_flush_input(uart_port_t) {
    fake::esp_idf::received.clear();
    fake::esp_idf::fifo.clear();
    return ESP_OK;
}
inline int uart_write_bytes(uart_port_t, const void* source, size_t size) {
    const auto* data = static_cast<const std::uint8_t*>(source);
    fake::esp_idf::to_send.insert(fake::esp_idf::to_send.end(), data, data + size);
    fake::line().in(20, [] { // until then the UART reports that it is idle
        if (!std::exchange(fake::esp_idf::is_leaving, true)) fake::esp_idf::leave();
    });
    return static_cast<int>(size);
}
inline int uart_read_bytes(uart_port_t, void* buffer, uint32_t length, TickType_t) {
    auto* to = static_cast<std::uint8_t*>(buffer);
    int count = 0;
    while (static_cast<uint32_t>(count) < length && !fake::esp_idf::received.empty()) {
        to[count++] = fake::esp_idf::received.front();
        fake::esp_idf::received.pop_front();
    }
    return count;
}
inline BaseType_t xQueuePeek(QueueHandle_t queue, void* const buffer, TickType_t ticks) {
    fake::line().sleep(ticks * 1000u, [queue] { return !queue->events.empty(); });
    if (queue->events.empty()) return pdFALSE;
    std::memcpy(buffer, &queue->events.front(), sizeof(uart_event_t));
    return pdTRUE;
}
inline BaseType_t xQueueReceive(QueueHandle_t queue, void* const buffer, TickType_t ticks) {
    if (xQueuePeek(queue, buffer, ticks) == pdFALSE) return pdFALSE;
    queue->events.pop_front();
    return pdTRUE;
}
inline void stub_yield(void) { fake::line().look(); }
inline int64_t esp_timer_get_time(void) { return static_cast<int64_t>(fake::line().look()); }
}
