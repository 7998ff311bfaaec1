// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The words of a register that stop the motor: a frame with one of them may be sent again. The author of a drive names
// them for each register that may also start something (flag `trigger` or `motion`), by a specialisation of
// `stop_words` before the routines, as examples/own_device/own_drive.hpp does. control/steps.hpp includes it.
//
//     static_assert(stop_words<zlac8015d::control_word>.contains(0x0007));  // stop
//     static_assert(!stop_words<zlac8015d::control_word>.contains(0x0008)); // enable
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/registers/wire.hpp>

namespace servobus {

/// Words of one register; of a 32-bit register, its values.
template <std::size_t N> struct stop_word_set {
    std::uint32_t words[N == 0 ? 1 : N]{};

    /// True if the register stops the motor by `value`. Only the bits of `used`, those of the register, are compared.
    constexpr bool contains(std::uint32_t value, std::uint32_t used = 0xFFFF'FFFF) const {
        for (std::size_t i = 0; i < N; ++i) {
            if (((words[i] ^ value) & used) == 0) return true;
        }
        return false;
    }
};

namespace detail {
template <class Value> consteval std::uint32_t stop_word(Value value) {
    if constexpr (std::is_integral_v<Value>) {
        return static_cast<std::uint32_t>(value);
    } else {
        return to_bits(value);
    }
}
} // namespace detail

/// Codes and flags of a register, or plain words: `words_that_stop(0)` for a target of which zero is standstill.
template <class... Values> consteval stop_word_set<sizeof...(Values)> words_that_stop(Values... values) {
    return {{detail::stop_word(values)...}};
}

/// The words that stop the motor when they are written to `R`. There are none before it is specialised.
template <const auto& R> inline constexpr stop_word_set<0> stop_words{};

} // namespace servobus
