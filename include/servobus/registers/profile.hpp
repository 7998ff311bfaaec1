// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The properties of a device that a client must know in addition to its registers: the sizes of requests,
// addresses, word order, factory settings of the line, timing, exceptions. Device headers include it;
// programs include it to describe a device of their own.
//
//     constexpr profile winch{.name = "winch", .max_read = 32, .highest_address = 31, .baud = 19200};
//     static_assert(winch.max_write == 123 && winch.word_order == word_order::high_first); // the defaults
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>

#include <servobus/core/response_limits.hpp>
#include <servobus/core/time.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus {

/// The meaning of one of a device's exception numbers.
struct exception_meaning {
    std::uint8_t number;
    const char* words;
};

/// A view of a device's exceptions, an array of static lifetime.
// Not a std::span: a further type of span costs compile time in every program (bench/include_cost.py).
class exception_table {
  public:
    constexpr exception_table() = default;
    template <unsigned N>
    constexpr exception_table(const exception_meaning (&table)[N]) // NOLINT: an array is a table
        : begin_{table}, end_{table + N} {}
    /// A table that was made at run time. It must outlive the view.
    constexpr exception_table(const exception_meaning* begin, const exception_meaning* end)
        : begin_{begin}, end_{end} {}

    constexpr const exception_meaning* begin() const { return begin_; }
    constexpr const exception_meaning* end() const { return end_; }

  private:
    const exception_meaning* begin_ = nullptr;
    const exception_meaning* end_ = nullptr;
};

/// Parity and stop bits; there are always eight data bits.
enum class character_format : std::uint8_t { n81, n82, e81, o81 };

constexpr const char* text(character_format f) {
    switch (f) {
    case character_format::n81: return "8N1";
    case character_format::n82: return "8N2";
    case character_format::e81: return "8E1";
    case character_format::o81: return "8O1";
    }
    return "unknown";
}

/// How the UARTs of all devices on a line are set.
struct uart_settings {
    std::uint32_t baud; ///< bits a second
    character_format format;
};

/// The rows that a device takes in blocks alone, also a single one.
enum class block_writes : std::uint8_t { none, registers, coils, all };

/// The properties of a device. A device class has them as `static constexpr profile facts`.
struct profile {
    const char* name;
    std::uint16_t max_read = 125;    ///< registers in one read
    std::uint16_t max_write = 123;   ///< registers in one write
    std::uint8_t lowest_address = 1; ///< of a node
    std::uint8_t highest_address = 247;
    servobus::word_order word_order =
        word_order::high_first; ///< of 32-bit values; `unknown` if the drive can switch it
    /// If the drive can switch its word order, this register is 0 for high word first, 1 for low word first.
    std::uint16_t word_order_register = 0;
    /// If writes can wear an EEPROM, this register is 0 while they do not.
    std::uint16_t eeprom_switch = 0;
    std::uint32_t baud = 9600;                       ///< factory setting
    character_format format = character_format::n81; ///< factory setting
    response_limits limits{};
    /// Gap before the next request after a transaction that did not end in exactly one valid response. A late
    /// response must begin within it.
    duration quarantine = milliseconds(100);
    duration gap{};                ///< gap that the device needs before a request, if above t3.5
    std::uint8_t read_retries = 2; ///< a failed read is repeated at most so many times
    exception_table exceptions{};
    /// It refuses function 06, function 05, or both: a single row is written by 10h or 0Fh.
    block_writes writes_blocks_only = block_writes::none;

    constexpr bool refuses_function_06() const {
        return writes_blocks_only == block_writes::registers || writes_blocks_only == block_writes::all;
    }
    constexpr bool refuses_function_05() const {
        return writes_blocks_only == block_writes::coils || writes_blocks_only == block_writes::all;
    }

    /// The manual's text for an exception number; "unknown exception" if it has none.
    constexpr const char* meaning(std::uint8_t number) const {
        for (const exception_meaning& e : exceptions) {
            if (e.number == number) return e.words;
        }
        return "unknown exception";
    }
};

/// A class that describes a device by its profile, `D::facts`.
template <class D>
concept device_class = requires {
    { D::facts } -> std::convertible_to<const profile&>;
};

/// True if the profile fixes the word order of all 32-bit values of the device.
template <device_class Device>
inline constexpr bool has_fixed_word_order =
    Device::facts.word_order != word_order::unknown&& Device::facts.word_order_register == 0;

/// The exception numbers of the standard, with its texts.
inline constexpr exception_meaning standard_exceptions[] = {
    {1, "illegal function"},      {2, "illegal data address"}, {3, "illegal data value"},
    {4, "server device failure"}, {5, "acknowledge"},          {6, "server device busy"},
};

} // namespace servobus
