// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Arduino: a port over any `Stream` that is a UART, such as `Serial1`, and a pin that switches the RS-485
// driver. The core needs a C++20 compiler (g++ 11 or newer): the ESP32, RP2040, STM32 and Teensy cores have
// one, the Uno's avr-gcc 7.3 is too old.
//
//     servobus::ports::arduino_stream rs485{Serial1, 2, 115200}; // pin 2 switches the driver
//     void setup() { Serial1.begin(115200), rs485.start(); }
//
// - Who waits: no call waits. `send` writes as many bytes as the core's buffer has room for
//   (`availableForWrite`; a core that always returns 0 cannot be used). `sent` computes the wire time and
//   calls `flush` only after it has passed, when little or nothing is left to wait for.
// - The driver: on before the first byte, off in `sent`. Arduino reports no end of the last stop bit, so a
//   superloop must call `step` at least every t3.5 (1.75 ms above 19200 Bd). Blocking calls do so by
//   themselves.
// - A partial read returns what the core's receive interrupt has stored; the next call continues.
// - Before the request: as `sent` turns true it discards what was received while the request was sent. If it
//   is called later than t3.5 after the end of the request, the bytes may be the response: they stay, unless this
//   transceiver has echoed the last request that was seen in time.
// - Errors: a Stream reports none. A byte that the core lost or dropped shows as `truncated_response` or
//   `bad_crc`.
// - Clock: micros(), which wraps at 2^32.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/line/port.hpp>
#include <servobus/modbus/rtu.hpp>

#include <Arduino.h> // after the others: some cores define macros called min and max

namespace servobus::ports {

/// A port over a Stream. Call `begin` of the Stream first, then `start`.
class arduino_stream {
  public:
    /// `driver` is the number of a pin that is high while a request is sent; -1 if the transceiver switches
    /// by itself. `bits` is the length of a character with start, parity and stop bits.
    constexpr arduino_stream(Stream& uart, std::int16_t driver, std::uint32_t baud, std::uint8_t bits = 10)
        : uart_{&uart}, character_{(bits * 1'000'000u + baud - 1) / baud},
          silence_{modbus::timing_at(baud).t3_5}, driver_{driver} {}

    void start() {
        if (driver_ < 0) return;
        pinMode(static_cast<std::uint8_t>(driver_), OUTPUT);
        drive(false);
    }

    transfer send(bytes out) {
        const int room = uart_->availableForWrite();
        if (room <= 0 || out.empty()) return std::uint16_t{0};
        const std::size_t size =
            out.size() < static_cast<unsigned>(room) ? out.size() : static_cast<unsigned>(room);
        drive(true);
        const std::size_t taken = uart_->write(out.data(), size);
        const instant at = now();
        if (!is_sending_ || !went_back(free_at_, at)) free_at_ = at;
        free_at_ = free_at_ + character_ * static_cast<std::uint32_t>(taken);
        unechoed_ += static_cast<std::int32_t>(taken);
        is_sending_ = true;
        return static_cast<std::uint16_t>(taken);
    }

    bool sent() {
        if (!is_sending_) return true;
        if (went_back(free_at_, now())) return false;
        uart_->flush();
        discard_echo();
        unechoed_ = 0;
        drive(false);
        is_sending_ = false;
        return true;
    }

    transfer receive(byte_buffer in) {
        std::uint16_t came = 0;
        while (came < in.size() && uart_->available() > 0)
            in[came++] = static_cast<std::uint8_t>(uart_->read());
        if (came != 0 && is_sending_ && is_echo()) unechoed_ -= came;
        return came;
    }

    instant now() const { return {static_cast<std::uint32_t>(micros())}; }

  private:
    // Until t3.5 after the end of the request the response cannot have come: what has arrived is an echo. The time is
    // read after the bytes.
    bool is_echo() const {
        const instant at = now();
        return went_back(free_at_, at) || since(free_at_, at) < silence_;
    }
    // Later it may be the response, but of a transceiver that echoed the last request whole also the echo alone, which
    // equals the response to a write.
    void discard_echo() {
        while (uart_->available() > 0) {
            const bool is_in_time = is_echo();
            if (!is_in_time && !has_echoed_) return;
            (void)uart_->read();
            if (is_in_time) --unechoed_;
        }
        if (is_echo()) has_echoed_ = unechoed_ <= 0;
    }
    void drive(bool on) {
        if (driver_ >= 0) digitalWrite(static_cast<std::uint8_t>(driver_), on ? HIGH : LOW);
    }

    Stream* uart_;
    duration character_;
    duration silence_;
    instant free_at_{};         // computed end of the bytes that were taken
    std::int32_t unechoed_ = 0; // bytes of the request whose echo has not arrived
    std::int16_t driver_;
    bool is_sending_ = false;
    bool has_echoed_ = false;
};

static_assert(port<arduino_stream>);

} // namespace servobus::ports
