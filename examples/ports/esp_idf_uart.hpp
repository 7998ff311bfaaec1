// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ESP-IDF (5.0 or newer): the UART driver in its RS-485 half duplex mode.
//
// - Who waits: `wait` sleeps on the driver's event queue until something comes. A tick is the shortest sleep
//   (CONFIG_FREERTOS_HZ=1000 makes it 1 ms); for less it yields. Nothing else waits: `send` gives the driver
//   what its buffer has room for.
// - The driver (DE) is the RTS pin: the UART driver switches it on before the first bit and off in its
//   interrupt behind the last stop bit. `sent` asks for that end, not before the reckoned wire time, since
//   the driver may not have touched its buffer yet.
// - A partial read is what the driver has stored; the next call goes on.
// - Before the request: `sent` drops what was heard while it left, but nothing that came later than t3.5:
// that
//   may be the response, if the task was late.
// - Errors: FIFO and buffer over-run, framing, parity. The bytes before it are handed on, then the error
// once.
// - Clock: esp_timer_get_time(), 64 bits, cut to 32: it wraps rightly.
#pragma once

#include <cstddef>
#include <cstdint>

#include "driver/uart.h"
#include "esp_timer.h"
#include "freertos/FreeRTOS.h"
#include "freertos/queue.h"
#include "freertos/task.h"

#include <servobus/line/port.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::ports {

/// A port over one of the chip's UARTs.
class esp_idf_uart {
  public:
    constexpr explicit esp_idf_uart(uart_port_t number) : number_{number} {}
    esp_idf_uart(const esp_idf_uart&) = delete;
    esp_idf_uart& operator=(const esp_idf_uart&) = delete;

    /// Installs the driver. False if the chip cannot do it.
    bool start(const uart_config_t& wanted, int tx, int rx, int driver) {
        const auto baud = static_cast<std::uint32_t>(wanted.baud_rate);
        const std::uint32_t bits = (wanted.parity == UART_PARITY_DISABLE ? 9u : 10u) +
                                   (wanted.stop_bits == UART_STOP_BITS_1 ? 1u : 2u);
        character_ = duration{(bits * 1'000'000u + baud - 1) / baud};
        silence_ = duration{modbus::timing_at(baud).t3_5};
        return uart_driver_install(number_, buffer, buffer, 16, &events_, 0) == ESP_OK &&
               uart_param_config(number_, &wanted) == ESP_OK &&
               uart_set_pin(number_, tx, rx, driver, UART_PIN_NO_CHANGE) == ESP_OK &&
               uart_set_mode(number_, UART_MODE_RS485_HALF_DUPLEX) == ESP_OK &&
               uart_set_rx_timeout(number_, 3) ==
                   ESP_OK; // characters; as it is, 10 pass before bytes are told
    }

    /// Errors: `send_failed`.
    transfer send(bytes out) {
        std::size_t room = 0;
        if (uart_get_tx_buffer_free_size(number_, &room) != ESP_OK) return failure{errc::send_failed};
        const std::size_t size = out.size() < room ? out.size() : room;
        if (size == 0) return std::uint16_t{0};
        const int taken = uart_write_bytes(number_, out.data(), size);
        if (taken < 0) return failure{errc::send_failed};
        const instant at = now();
        if (!is_sending_ || !went_back(free_at_, at)) free_at_ = at;
        free_at_ = free_at_ + character_ * static_cast<std::uint32_t>(taken);
        is_sending_ = true;
        return static_cast<std::uint16_t>(taken);
    }

    bool sent() {
        if (!is_sending_) return true;
        const instant at = now();
        if (went_back(free_at_, at) || uart_wait_tx_done(number_, 0) != ESP_OK) return false;
        if (since(free_at_, at) < silence_) (void)uart_flush_input(number_);
        is_sending_ = false;
        return true;
    }

    /// Bytes first, then the error behind them.
    transfer receive(byte_buffer in) {
        look_at_events();
        const int came = uart_read_bytes(number_, in.data(), static_cast<std::uint32_t>(in.size()), 0);
        if (came > 0) return static_cast<std::uint16_t>(came);
        if (came == 0 && !has_failed_) return std::uint16_t{0};
        has_failed_ = false;
        return failure{errc::receive_failed};
    }

    instant now() const { return {static_cast<std::uint32_t>(esp_timer_get_time())}; }

    void wait(duration d) {
        const TickType_t ticks = d.us / (1'000'000u / configTICK_RATE_HZ);
        uart_event_t event;
        if (ticks == 0)
            taskYIELD();
        else
            (void)xQueuePeek(events_, &event, ticks);
    }

  private:
    static constexpr int buffer = 512; // two of the longest frames

    void look_at_events() {
        uart_event_t event;
        while (xQueueReceive(events_, &event, 0) == pdTRUE) {
            const bool is_error = event.type == UART_FIFO_OVF || event.type == UART_BUFFER_FULL ||
                                  event.type == UART_FRAME_ERR || event.type == UART_PARITY_ERR;
            if (is_error && !is_sending_) has_failed_ = true;
        }
    }

    uart_port_t number_;
    QueueHandle_t events_ = nullptr;
    duration character_{};
    duration silence_{};
    instant free_at_{}; // when the wire is free again, reckoned
    bool is_sending_ = false;
    bool has_failed_ = false;
};

static_assert(waiting_port<esp_idf_uart>);

} // namespace servobus::ports
