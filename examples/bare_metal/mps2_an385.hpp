// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The board: Arm MPS2 with the Cortex-M3 image AN385. Its SysTick is the clock; its UART 1 with an RS-485
// transceiver is the port of a servobus::line. Only `rs485::wait` waits.
//
//     mps2::clock::start();
//     mps2::rs485::start(115200);
//     mps2::rs485 port;
//     servobus::line line{port, servobus::modbus::timing_at(115200)};
#pragma once

#include <atomic>
#include <cstdint>

#include <servobus/line/port.hpp>
#include <servobus/line/ring.hpp>

namespace mps2 {

namespace detail {
inline constexpr std::uint32_t core_hz = 25'000'000;

inline volatile std::uint32_t& at(std::uintptr_t address) {
    return *reinterpret_cast<volatile std::uint32_t*>(address);
}
} // namespace detail

/// Disables interrupts during its lifetime; may be nested.
class interrupts_off {
  public:
    interrupts_off() { __asm__ volatile("mrs %0, primask\n\tcpsid i" : "=r"(before_) : : "memory"); }
    ~interrupts_off() { __asm__ volatile("msr primask, %0" : : "r"(before_) : "memory"); }
    interrupts_off(const interrupts_off&) = delete;
    interrupts_off& operator=(const interrupts_off&) = delete;

  private:
    std::uint32_t before_;
};

/// SysTick as a clock in microseconds. A round is a SysTick period of 1 ms; an interrupt counts the rounds.
class clock {
  public:
    static void start() {
        detail::at(reload) = ticks_a_round - 1;
        detail::at(value) = 0;
        detail::at(control) = 7;          // the core's clock, interrupt, on
        while (detail::at(value) == 0) {} // one tick, until the first round has begun
    }

    /// The time. May be called anywhere, also with interrupts off.
    static servobus::instant now() {
        const interrupts_off guard;
        std::uint32_t left = detail::at(value);
        std::uint32_t rounds = rounds_;
        // A round that has ended while interrupts are off is not counted yet, and `left` may have been read
        // before or after its end: it is read again.
        const bool has_wrapped = (detail::at(interrupt_state) & is_pending) != 0;
        if (has_wrapped) {
            left = detail::at(value);
            ++rounds;
        }
        // 0 is the end of a round: the first value after a detected wrap, the last one without.
        const std::uint32_t ticks = left != 0 ? ticks_a_round - left : has_wrapped ? 0 : ticks_a_round;
        return {rounds * us_a_round + ticks / ticks_a_us};
    }

    static void on_tick() { rounds_ = rounds_ + 1; }

  private:
    static constexpr std::uintptr_t control = 0xE000'E010;
    static constexpr std::uintptr_t reload = 0xE000'E014;
    static constexpr std::uintptr_t value = 0xE000'E018;
    static constexpr std::uintptr_t interrupt_state = 0xE000'ED04;
    static constexpr std::uint32_t is_pending = 1u << 26;

    static constexpr std::uint32_t us_a_round = 1000;
    static constexpr std::uint32_t ticks_a_us = detail::core_hz / 1'000'000;
    static constexpr std::uint32_t ticks_a_round = us_a_round * ticks_a_us;

    static inline constinit volatile std::uint32_t rounds_ = 0;
};

/// UART 1 with a transceiver. Pin 6 of GPIO 0 is its DE and /RE, tied together as on most boards: while the
/// driver is on, nothing is received, not even an echo.
///
///     send()         switches the driver on and puts the frame into a ring, which an interrupt empties
///     sent()         switches the driver off in the first call after the last stop bit: call it often
///     receive()      takes what the receive interrupt has put into its ring
class rs485 {
  public:
    static constexpr unsigned received_interrupt = 2;
    static constexpr unsigned sendable_interrupt = 3;

    static void start(std::uint32_t baud) {
        const std::uint32_t divider = detail::core_hz / baud;
        detail::at(baud_divider) = divider < 16 ? 16 : divider; // the smallest that the UART accepts
        character_ = servobus::microseconds((11'000'000u + baud - 1) / baud);
        detail::at(driver_is_output) = driver_pin;
        drive(false);
        detail::at(control) = 0x0F; // both directions, both interrupts
        detail::at(enable_interrupts) = 1u << received_interrupt | 1u << sendable_interrupt;
    }

    static servobus::transfer send(servobus::bytes frame) {
        if (!is_driving_) {
            received_.clear(); // older than the request
            drive(true);
        }
        std::uint16_t taken = 0;
        while (taken < frame.size() && leaving_.push(frame[taken])) ++taken;
        has_left_ = false;
        detail::at(raise_interrupt) = 1u << sendable_interrupt; // the interrupt sends the first byte too
        return taken;
    }

    /// The UART does not report the end of the last stop bit. It is one character after the last byte has
    /// left the UART's buffer.
    static bool sent() {
        if (!is_driving_) return true;
        if (!has_left_ || servobus::since(left_at_, now()) < character_) return false;
        drive(false);
        return true;
    }

    static servobus::transfer receive(servobus::byte_buffer into) {
        if (is_driving_) return std::uint16_t{0};
        has_come_ = false;
        const std::uint16_t count = received_.pop(into);
        if (count == into.size()) has_come_ = true; // there may be more
        return count;
    }

    static servobus::instant now() { return clock::now(); }

    /// Sleeps until a byte is received or `time` has passed; it may return up to a round (1 ms) late. A byte
    /// that arrives between the check and the sleep is not missed: interrupts are off there, stay pending,
    /// and end the sleep.
    static void wait(servobus::duration time) {
        const servobus::instant start = now();
        while (servobus::since(start, now()) < time) {
            const interrupts_off guard;
            if (has_come_) return;
            __asm__ volatile("wfi" : : : "memory");
        }
    }

    /// Bytes that were lost because the ring was full.
    static std::uint16_t overruns() { return received_.overruns(); }

    static void on_received() {
        detail::at(interrupt_clear) = receive_bit; // first: a later byte raises it again
        while ((detail::at(state) & receive_full) != 0)
            received_.push(static_cast<std::uint8_t>(detail::at(data)));
        has_come_ = true;
    }

    static void on_sendable() {
        detail::at(interrupt_clear) = send_bit;
        while ((detail::at(state) & send_full) == 0) {
            std::uint8_t next = 0;
            if (leaving_.pop({&next, 1}) == 0) {
                if (!has_left_) left_at_ = now();
                has_left_ = true;
                return;
            }
            detail::at(data) = next;
        }
    }

  private:
    static constexpr std::uintptr_t data = 0x4000'5000;
    static constexpr std::uintptr_t state = 0x4000'5004;
    static constexpr std::uintptr_t control = 0x4000'5008;
    static constexpr std::uintptr_t interrupt_clear = 0x4000'500C;
    static constexpr std::uintptr_t baud_divider = 0x4000'5010;
    static constexpr std::uint32_t send_full = 1, receive_full = 2; // of `state`
    static constexpr std::uint32_t send_bit = 1, receive_bit = 2;   // of `interrupt_clear`

    static constexpr std::uintptr_t enable_interrupts = 0xE000'E100;
    static constexpr std::uintptr_t raise_interrupt = 0xE000'E200;

    static constexpr std::uint32_t driver_pin = 1u << 6;
    static constexpr std::uintptr_t driver_is_output = 0x4001'0010;
    static constexpr std::uintptr_t driver_alone = 0x4001'0400 + 4 * driver_pin; // masks the other pins

    static void drive(bool on) {
        is_driving_ = on;
        detail::at(driver_alone) = on ? driver_pin : 0;
    }

    static inline constinit servobus::ring<64> leaving_{};
    static inline constinit servobus::ring<64> received_{};
    static inline constinit servobus::duration character_{};
    static inline constinit servobus::instant left_at_{};
    static inline constinit std::atomic<bool> has_left_{false};
    static inline constinit std::atomic<bool> has_come_{false};
    static inline constinit bool is_driving_ = false;
};

static_assert(servobus::waiting_port<rs485>);

} // namespace mps2
