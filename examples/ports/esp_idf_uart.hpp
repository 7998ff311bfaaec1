// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ESP-IDF (5.0 or newer): a port over the UART driver in its RS-485 half duplex mode.
//
//     servobus::ports::esp_idf_uart rs485{UART_NUM_1};
//     rs485.start(config, 17, 16, 4); // a uart_config_t; the pins TX, RX and RTS, which switches the driver
//
// - Who waits: `wait` sleeps on the driver's event queue until something arrives. The shortest sleep is a
//   tick (CONFIG_FREERTOS_HZ=1000 makes it 1 ms); for less, `wait` yields. No other call waits: `send` passes
//   on as many bytes as the UART driver's buffer has room for.
// - The RS-485 driver (DE) is on the RTS pin: the UART driver switches it on before the first bit and off in
//   its interrupt after the last stop bit. `sent` asks the UART driver for that end, but only after the
//   computed wire time, since before it the UART driver may not have begun to send its buffer.
// - A partial read returns what the UART driver has stored; the next call continues.
// - Before the request: as `sent` turns true it discards what was received while the request was sent. If it
//   is called later than t3.5 after the end of the request, it discards nothing: the bytes may be the
//   response.
// - Errors: FIFO and buffer overrun, framing, parity. `receive` returns the bytes before the error first,
//   then the error, once.
// - Clock: esp_timer_get_time(), 64 bits, truncated to 32 bits, so that it wraps at 2^32.
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

    /// Installs and configures the UART driver; `driver` is the RTS pin. False if a step fails.
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
                   ESP_OK; // 3 characters; by default bytes are reported 10 characters late
    }

    /// Errors: `send_failed`.
    transfer send(bytes out) {
        std::size_t room = 0;
        if (uart_get_tx_buffer_free_size(number_, &room) != ESP_OK) return errc::send_failed;
        const std::size_t size = out.size() < room ? out.size() : room;
        if (size == 0) return std::uint16_t{0};
        const int taken = uart_write_bytes(number_, out.data(), size);
        if (taken < 0) return errc::send_failed;
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

    /// Returns the bytes that were received first, then the error. Errors: `receive_failed`.
    transfer receive(byte_buffer in) {
        look_at_events();
        const int came = uart_read_bytes(number_, in.data(), static_cast<std::uint32_t>(in.size()), 0);
        if (came > 0) return static_cast<std::uint16_t>(came);
        if (came == 0 && !has_failed_) return std::uint16_t{0};
        has_failed_ = false;
        return errc::receive_failed;
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
    static constexpr int buffer = 512; // bytes: two frames of the maximum length

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
    instant free_at_{}; // computed end of the bytes that were taken
    bool is_sending_ = false;
    bool has_failed_ = false;
};

static_assert(waiting_port<esp_idf_uart>);

} // namespace servobus::ports
