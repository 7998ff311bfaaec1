// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device in numbers: what a client must know of it beside its registers.
#pragma once

#include <concepts>
#include <cstdint>

#include <servobus/core/response_limits.hpp>
#include <servobus/core/time.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus {

/// What an exception number of this device means.
struct exception_meaning {
    std::uint8_t number;
    const char* words;
};

/// The exceptions of a device: an array with a constant's life.
// No std::span: one kind more would slow every user's compiler (bench/include_cost.sh).
class exception_table {
  public:
    constexpr exception_table() = default;
    template <unsigned N>
    constexpr exception_table(const exception_meaning (&table)[N]) // NOLINT: an array is a table
        : begin_{table}, end_{table + N} {}

    constexpr const exception_meaning* begin() const { return begin_; }
    constexpr const exception_meaning* end() const { return end_; }

  private:
    const exception_meaning* begin_ = nullptr;
    const exception_meaning* end_ = nullptr;
};

/// Parity and stop bits beside eight data bits.
enum class character_format : std::uint8_t { n81, n82, e81, o81 };

/// A device class has `static constexpr profile facts`.
struct profile {
    const char* name;
    std::uint16_t max_read = 125;  ///< registers in one read
    std::uint16_t max_write = 123; ///< registers in one write
    std::uint8_t lowest_unit = 1;
    std::uint8_t highest_unit = 247;
    word_order order = word_order::high_first; ///< `unknown` where the drive can switch it:
    std::uint16_t order_register = 0;          ///< then this register has 0 for high, 1 for low word first
    std::uint16_t eeprom_switch = 0; ///< where writes wear an EEPROM: this register has 0 if not now
    std::uint32_t baud = 9600;       ///< from the factory
    character_format format = character_format::n81;
    response_limits limits{};
    duration quarantine = milliseconds(100); ///< silence after trouble; a late response begins within it
    duration gap{};                          ///< the device's own silence before a request, if above t3.5
    std::uint8_t read_retries = 2;
    exception_table exceptions{};

    /// The device's words for an exception number; "unknown exception" if its manual has none.
    constexpr const char* meaning(std::uint8_t number) const {
        for (const exception_meaning& e : exceptions) {
            if (e.number == number) return e.words;
        }
        return "unknown exception";
    }
};

/// What a device's header gives: a class with its profile.
template <class D>
concept device_class = requires {
    { D::facts } -> std::convertible_to<const profile&>;
};

/// True if every 32-bit value of the device has the same word order, which its profile tells.
template <device_class Device>
inline constexpr bool has_fixed_order =
    Device::facts.order != word_order::unknown&& Device::facts.order_register == 0;

/// Exceptions in the standard's numbers and words.
inline constexpr exception_meaning standard_exceptions[] = {
    {1, "illegal function"},      {2, "illegal data address"}, {3, "illegal data value"},
    {4, "server device failure"}, {5, "acknowledge"},          {6, "server device busy"},
};

} // namespace servobus
