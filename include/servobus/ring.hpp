// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Bytes from an interrupt to the main loop: one writer, one reader, no lock. The only header that needs
// <atomic>.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <servobus/bytes.hpp>

namespace servobus {

/// What a ring can hold: its counters wrap at 2^16.
template <std::size_t N>
concept power_of_two_up_to_32768 = N >= 2 && N <= 32768 && (N & (N - 1)) == 0;

/// A ring of `Capacity` bytes, a power of two of at most 32768. `push` may be called from one interrupt,
/// `pop` from one other context. A byte that finds the ring full is dropped and counted.
template <std::size_t Capacity>
requires power_of_two_up_to_32768<Capacity>
class ring {
  public:
    /// Puts a byte in; false if there was no room.
    bool push(std::uint8_t byte) {
        const std::uint16_t head = head_.load(std::memory_order_relaxed);
        if (static_cast<std::uint16_t>(head - tail_.load(std::memory_order_acquire)) == Capacity) {
            overruns_.store(static_cast<std::uint16_t>(overruns_.load(std::memory_order_relaxed) + 1),
                            std::memory_order_relaxed);
            return false;
        }
        data_[head & mask] = byte;
        head_.store(static_cast<std::uint16_t>(head + 1), std::memory_order_release);
        return true;
    }

    /// Takes as many bytes as there are and fit; returns how many.
    std::uint16_t pop(byte_buffer to) {
        std::uint16_t tail = tail_.load(std::memory_order_relaxed);
        const auto there = static_cast<std::uint16_t>(head_.load(std::memory_order_acquire) - tail);
        const auto n = there < to.size() ? there : static_cast<std::uint16_t>(to.size());
        for (std::uint16_t i = 0; i < n; ++i) to[i] = data_[tail++ & mask];
        tail_.store(tail, std::memory_order_release);
        return n;
    }

    /// True if there is nothing to take; asked by the reader, before it sleeps for example.
    bool is_empty() const {
        return head_.load(std::memory_order_acquire) == tail_.load(std::memory_order_relaxed);
    }

    /// Drops what is there; called by the reader.
    void clear() { tail_.store(head_.load(std::memory_order_acquire), std::memory_order_release); }

    /// Bytes dropped for want of room; wraps.
    std::uint16_t overruns() const { return overruns_.load(std::memory_order_relaxed); }

  private:
    static constexpr std::uint16_t mask = Capacity - 1;

    std::array<std::uint8_t, Capacity> data_{};
    std::atomic<std::uint16_t> head_{0};
    std::atomic<std::uint16_t> tail_{0};
    std::atomic<std::uint16_t> overruns_{0};
};

} // namespace servobus
