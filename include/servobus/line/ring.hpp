// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Passes bytes from an interrupt to the main loop: one writer, one reader, no lock. A port whose bytes
// arrive in an interrupt includes it. It uses the atomic operations that are built into the compiler,
// since <atomic> would add more compile time than the whole core of this library.
//
//     inline ring<256> received;
//     void on_byte(std::uint8_t byte) { received.push(byte); } // call it in the UART's interrupt
//     transfer my_uart::receive(byte_buffer into) { return received.pop(into); } // of your port
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>

namespace servobus {

namespace detail {
/// A counter that one context writes and another reads.
class shared_count {
  public:
    /// In the context that writes it.
    std::uint16_t own() const { return __atomic_load_n(&value_, __ATOMIC_RELAXED); }
    /// In the other: what was written before the counter is there too.
    std::uint16_t others() const { return __atomic_load_n(&value_, __ATOMIC_ACQUIRE); }
    void publish(std::uint16_t value) { __atomic_store_n(&value_, value, __ATOMIC_RELEASE); }

  private:
    std::uint16_t value_ = 0;
};
} // namespace detail

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
        const std::uint16_t head = head_.own();
        if (static_cast<std::uint16_t>(head - tail_.others()) == Capacity) {
            overruns_.publish(static_cast<std::uint16_t>(overruns_.own() + 1));
            return false;
        }
        data_[head & mask] = byte;
        head_.publish(static_cast<std::uint16_t>(head + 1));
        return true;
    }

    /// Takes as many bytes as there are and fit; returns how many.
    std::uint16_t pop(byte_buffer to) {
        std::uint16_t tail = tail_.own();
        const auto there = static_cast<std::uint16_t>(head_.others() - tail);
        const auto n = there < to.size() ? there : static_cast<std::uint16_t>(to.size());
        for (std::uint16_t i = 0; i < n; ++i) to[i] = data_[tail++ & mask];
        tail_.publish(tail);
        return n;
    }

    /// True if there is nothing to take; asked by the reader, before it sleeps for example.
    bool is_empty() const { return head_.others() == tail_.own(); }

    /// Drops what is there; called by the reader.
    void clear() { tail_.publish(head_.others()); }

    /// Bytes dropped for want of room; wraps.
    std::uint16_t overruns() const { return overruns_.others(); }

  private:
    static constexpr std::uint16_t mask = Capacity - 1;

    std::uint8_t data_[Capacity]{};
    detail::shared_count head_;
    detail::shared_count tail_;
    detail::shared_count overruns_;
};

} // namespace servobus
