// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The checks of rows that every client makes: a row is of the client's device, and no write wears an EEPROM unnoticed.
// A row that fails does not compile, and the error says why.
//
//     servobus::detail::check_device<zlac8015d::device, zlac8015d::bus_voltage>(); // of a c630s::device: an error
//     servobus::detail::check_wear<zlac8015d::left_target_speed>();
#pragma once

#include <servobus/registers/reg.hpp>

namespace servobus::detail {

template <class Device, const auto&... Rs>
inline constexpr bool are_of = (belongs_to<typename row_type<Rs>::device, Device> && ...);

template <class Device, const auto&... Rs> constexpr void check_device() {
    static_assert(are_of<Device, Rs...>, "this register belongs to another device");
}

template <const auto& R> constexpr void check_wear() {
    static_assert(!has(R.flags, flag::saved_on_write),
                  "every write of this register wears the drive's EEPROM: store() it, or write it with "
                  "what ram_only() gives");
}

/// `Value`: one that stores its words itself.
template <class Value> constexpr void check_whole() {
    static_assert(!Value::is_part,
                  "a part of a register is written by change_bits<R>(value): the other bits are not known");
}

} // namespace servobus::detail
