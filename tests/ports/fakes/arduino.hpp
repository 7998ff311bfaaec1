// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An Arduino core: a serial port with buffers of 64 bytes, pins and micros().
#pragma once

#include <deque>

#include "../wire.hpp"

#include "Arduino.h"

namespace fake::arduino {

inline constexpr std::uint8_t driver_pin = 2;
inline bool is_output = false;

/// Drops damaged characters and those for which it has no room, without reporting it, as the cores do.
class serial final : public Stream {
  public:
    serial() {
        line().hears = [this](std::uint8_t byte, damage how) {
            if (how == damage::none && in_.size() < 63) in_.push_back(byte);
        };
    }

    std::size_t write(std::uint8_t byte) override { return write(&byte, 1); }
    std::size_t write(const std::uint8_t* data, std::size_t size) override {
        for (std::size_t i = 0; i < size; ++i) {
            if (waiting_ >= 63) ++blocked;
            while (waiting_ >= 63) line().advance(1);
            ++waiting_;
            line().transmit(data[i], [this] { --waiting_; });
        }
        return size;
    }
    int availableForWrite() override { return 63 - waiting_; }
    void flush() override {
        const std::uint64_t start = line().now;
        while (waiting_ != 0) line().advance(1);
        if (line().now - start > longest_flush) longest_flush = line().now - start;
    }
    int available() override { return static_cast<int>(in_.size()); }
    int read() override {
        if (in_.empty()) return -1;
        const std::uint8_t byte = in_.front();
        in_.pop_front();
        return byte;
    }
    int peek() override { return in_.empty() ? -1 : in_.front(); }

    unsigned blocked = 0;
    std::uint64_t longest_flush = 0;

  private:
    std::deque<std::uint8_t> in_;
    int waiting_ = 0;
};

} // namespace fake::arduino

extern "C" {
inline unsigned long micros(void) { return static_cast<std::uint32_t>(fake::line().look()); }
inline void pinMode(uint8_t pin, uint8_t mode) {
    if (pin == fake::arduino::driver_pin) fake::arduino::is_output = mode == OUTPUT;
}
inline void digitalWrite(uint8_t pin, uint8_t level) {
    if (pin == fake::arduino::driver_pin && fake::arduino::is_output) fake::line().drive(level == HIGH);
}
}
