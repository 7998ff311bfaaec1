// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Arduino: any `Stream` with a wire behind it, such as `Serial1`, and a pin that switches the RS-485 driver.
// The core needs a compiler with C++20 (g++ 11 or newer): the boards with ESP32, RP2040, STM32 and Teensy
// cores have one, the Uno's avr-gcc 7.3 has not.
//
// - Who waits: nobody. `send` gives what the core's buffer has room for (`availableForWrite`; a core that
// always
//   says 0 cannot be used). `sent` reckons the wire time; only then it calls `flush`, which has little or
//   nothing left to wait for.
// - The driver: on before the first byte, off in `sent`. Arduino tells nobody that the last stop bit has
// left,
//   so the loop must come by at least every t3.5 (1.75 ms above 19200 Bd), as blocking calls do by
//   themselves.
// - A partial read is what the core's receive interrupt has stored; the next call goes on.
// - Before the request: `sent` drops what was heard while it left, but nothing that came later than t3.5:
// that
//   may be the response, if the loop was late.
// - Errors: a Stream tells of none. A byte that the core lost or dropped ends as `truncated_response` or
// `bad_crc`.
// - Clock: micros(), which wraps by itself at 2^32.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/line/port.hpp>
#include <servobus/modbus/rtu.hpp>

#include <Arduino.h> // behind the others: some cores have macros called min and max

namespace servobus::ports {

/// A port over a Stream that was begun: `Serial1.begin(115200)` first, then `start`.
class arduino_stream {
  public:
    /// `driver` is high while a request leaves; -1 if the transceiver switches by itself. `bits` counts a
    /// character with start, parity and stop bits.
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
        is_sending_ = true;
        return static_cast<std::uint16_t>(taken);
    }

    bool sent() {
        if (!is_sending_) return true;
        const instant at = now();
        if (went_back(free_at_, at)) return false;
        uart_->flush();
        if (since(free_at_, at) < silence_) {
            while (uart_->available() > 0) (void)uart_->read();
        }
        drive(false);
        is_sending_ = false;
        return true;
    }

    transfer receive(byte_buffer in) {
        std::uint16_t came = 0;
        while (came < in.size() && uart_->available() > 0)
            in[came++] = static_cast<std::uint8_t>(uart_->read());
        return came;
    }

    instant now() const { return {static_cast<std::uint32_t>(micros())}; }

  private:
    void drive(bool on) {
        if (driver_ >= 0) digitalWrite(static_cast<std::uint8_t>(driver_), on ? HIGH : LOW);
    }

    Stream* uart_;
    duration character_;
    duration silence_;
    instant free_at_{}; // when the wire is free again, reckoned
    std::int16_t driver_;
    bool is_sending_ = false;
};

static_assert(port<arduino_stream>);

} // namespace servobus::ports
