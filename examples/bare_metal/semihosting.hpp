// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Arm semihosting: text and the exit status go to the debugger or the emulator by a breakpoint instruction.
// Without either of them the breakpoint is a fault: leave this header out of what you ship.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace semihosting {

namespace detail {
enum class operation : std::uint32_t { write_text = 0x04, exit_with_status = 0x20 };

inline void call(operation what, const void* with) {
    __asm__ volatile("mov r0, %0\n\tmov r1, %1\n\tbkpt 0xAB" : : "r"(what), "r"(with) : "r0", "r1", "memory");
}
} // namespace detail

/// Writes text and whole numbers, unbuffered.
struct console {
    const console& operator<<(const char* words) const {
        detail::call(detail::operation::write_text, words);
        return *this;
    }

    const console& operator<<(std::uint32_t number) const {
        std::array<char, 11> digits{};
        std::size_t at = digits.size() - 1; // the last character is the terminating zero
        do {
            digits[--at] = static_cast<char>('0' + static_cast<char>(number % 10));
            number /= 10;
        } while (number != 0);
        return *this << &digits[at];
    }

    const console& operator<<(std::int32_t number) const {
        if (number >= 0) return *this << static_cast<std::uint32_t>(number);
        return *this << "-" << 0u - static_cast<std::uint32_t>(number);
    }
};

inline constexpr console out{};

/// Ends the program; the emulator's exit status is `status`.
[[noreturn]] inline void exit(std::uint32_t status) {
    constexpr std::uint32_t application_exit = 0x20026;
    const std::array<std::uint32_t, 2> block{application_exit, status};
    detail::call(detail::operation::exit_with_status, block.data());
    for (;;) {}
}

} // namespace semihosting
