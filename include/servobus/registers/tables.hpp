// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of the other three tables of a Modbus device: input registers, coils and discrete inputs. Headers of devices
// that have such tables include it; a `reg` is a holding register. One address may exist in each table.
//
//     struct tank; // the device
//     constexpr input_reg<i16, tank> temperature{0x0000, full<i16>, units::degree_celsius / 10, no_default};
//     constexpr coil<access::rw, tank> valve{0x0003};
//     constexpr discrete_input<tank> is_door_open{0x0000};
//     static_assert(table_of<valve> == table::coils && !is_register<valve>);
//
// Source: Modbus Application Protocol V1.1b3, section 4.3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/registers/reg.hpp>

namespace servobus {

/// The four tables of the standard, in the order of the functions that read them, 01 .. 04.
enum class table : std::uint8_t { coils, discrete_inputs, holding_registers, input_registers };

/// An input register: a row that no function writes. Function 04 reads it.
template <class T, class Device> struct input_reg : reg<T, access::ro, Device> {};

/// A bit of `Device` that function 01 reads, and functions 05 and 0Fh write.
template <access Rights, class Device> struct coil {
    using value_type = bool;
    using device = Device;
    static constexpr access rights = Rights;

    u16 address;
    bool initial = false; ///< factory default
    flag flags = flag::none;
};

/// A bit of `Device` that function 02 reads.
template <class Device> struct discrete_input {
    using value_type = bool;
    using device = Device;
    static constexpr access rights = access::ro;

    u16 address;
    bool initial = false; ///< after power-on
    flag flags = flag::none;
};

namespace detail {
template <class T, class D> struct is_row<input_reg<T, D>> : std::true_type {};

template <class Row> inline constexpr table table_of_row = table::holding_registers;
template <class T, class D> inline constexpr table table_of_row<input_reg<T, D>> = table::input_registers;
template <access A, class D> inline constexpr table table_of_row<coil<A, D>> = table::coils;
template <class D> inline constexpr table table_of_row<discrete_input<D>> = table::discrete_inputs;
template <class Row, std::size_t N>
inline constexpr table table_of_row<reg_array<Row, N>> = table_of_row<Row>;

template <class Row> inline constexpr bool is_bit_row = false;
template <access A, class D> inline constexpr bool is_bit_row<coil<A, D>> = true;
template <class D> inline constexpr bool is_bit_row<discrete_input<D>> = true;
} // namespace detail

/// The table of row `R`, or of an array of rows.
template <const auto& R>
inline constexpr table table_of = detail::table_of_row<std::remove_cvref_t<decltype(R)>>;

/// True if `R` is a coil or a discrete input.
template <const auto& R>
concept is_bit = detail::is_bit_row<std::remove_cvref_t<decltype(R)>>;

namespace detail {
template <const auto& R>
requires is_bit<R>
struct sound_row<R> {
    using type = std::remove_cvref_t<decltype(R)>;
}; // no address of a bit contradicts its type

template <const auto& R>
concept is_in_other_table = table_of<R>
!= table::holding_registers;
} // namespace detail

} // namespace servobus
