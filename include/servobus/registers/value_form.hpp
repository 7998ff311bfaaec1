// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The properties of a value that its type does not state: bits of a register, an offset, raw values for
// "no value". registers/catalogue.hpp includes it. For the compiler, `with` in
// registers/value_types.hpp states the same.
//
//     constexpr value_form high_byte{.first_bit = 8, .bits = 8};
//     static_assert(high_byte.is_part() && high_byte.mask() == 0xFF00);
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/registers/reg.hpp>

namespace servobus {

/// The scaling of a value by another row.
enum class scaling : std::uint8_t {
    none,
    exponent, ///< the value is multiplied by ten to the power of the other row
    factor,   ///< the value is multiplied by the other row
};

/// The properties of a value besides its type. An entry without any has none.
struct value_form {
    std::uint8_t words = 0;     ///< of a text; 0 for all others, whose type states it
    std::uint8_t first_bit = 0; ///< of a part of a register, counted from 0
    std::uint8_t bits = 0;      ///< of a part of a register; 0: the whole register
    bool is_low_byte_first = false;
    std::int32_t offset = 0;              ///< added to the number before the scale, in counts
    std::span<const std::int64_t> none{}; ///< raw values that mean "no value", of an array of static lifetime
    scaling scaled = scaling::none;
    table scale_table = table::holding_registers; ///< of the row that scales the value
    u16 scale_address = 0;
    const char* symbol = nullptr; ///< of a unit of the device's own, `measure::device_unit`

    constexpr bool is_part() const { return bits != 0; }
    /// The bits of the register that the value takes.
    constexpr u16 mask() const {
        return bits == 0 ? u16{0xFFFF} : static_cast<u16>(((1u << bits) - 1u) << first_bit);
    }
};

} // namespace servobus
