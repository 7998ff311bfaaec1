// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of the other three tables of a Modbus device: input registers, coils and discrete inputs. A `reg` is a holding
// register. One address may exist in each table. registers/tables.hpp includes it.
//
//     struct tank; // the device
//     constexpr input_reg<i16, tank> temperature{0x0000, full<i16>, units::degree_celsius / 10, no_default};
//     constexpr coil<access::rw, tank> valve{0x0003};
//     constexpr reg_array<discrete_input<tank>, 8> is_door_open{{0x0000}, 1}; // 0 .. 7
//     static_assert(table_of<valve> == table::coils && !is_register<valve>);
//
// Source: Modbus Application Protocol V1.1b3, section 4.3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/registers/reg.hpp>

namespace servobus {

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

template <class T, class D> inline constexpr table table_of_row<input_reg<T, D>> = table::input_registers;
template <access A, class D> inline constexpr table table_of_row<coil<A, D>> = table::coils;
template <class D> inline constexpr table table_of_row<discrete_input<D>> = table::discrete_inputs;

template <access A, class D> inline constexpr std::size_t addresses_in<coil<A, D>> = 1;
template <class D> inline constexpr std::size_t addresses_in<discrete_input<D>> = 1;

template <const auto& R>
requires has_bits<R>
struct sound_row<R> {
    using type = std::remove_cvref_t<decltype(R)>;
}; // no address of a bit contradicts its type
} // namespace detail

} // namespace servobus
