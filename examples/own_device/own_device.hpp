// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device of your own: a profile and its registers, in a header like this one and in your own namespace.
// Copy it and fill in what your device's manual says; a client needs nothing else. own_drive.hpp adds commands
// and a facade, own_simulator.hpp a simulated one. The device here, a winch, is invented. With a `line` whose timing is
// `servobus::modbus::timing_at(winch::device::facts.baud)`:
//
//     servobus::client<decltype(line), winch::device> drum{line, servobus::node<winch::device>{5}};
//     if (!drum.write<winch::speed>(12 * winch::r_per_min)) return;
//     if (!drum.write<winch::speed>(servobus::clamped(wanted * winch::r_per_min))) return;
//     if (!drum.write<winch::control_word>(winch::control_code::turn)) return;
//     if (const auto load = drum.read<winch::load>()) show(load->rounded(winch::ampere));
//
// The compiler checks a constant against the register's range. A run-time value enters by `clamped` or
// `checked`.
#pragma once

#include <cstdint>

#include <servobus/registers/block.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>

namespace winch {

/// The device's profile. Members that are not set here have the values of the Modbus standard.
struct device {
    static constexpr servobus::exception_meaning exceptions[] = {{1, "no such register"},
                                                                 {9, "rope is slack"}};
    static constexpr servobus::profile facts{.name = "winch",
                                             .max_read = 32,
                                             .highest_address = 31,
                                             .word_order = servobus::word_order::low_first,
                                             .baud = 19200,
                                             .format = servobus::character_format::e81,
                                             .exceptions = exceptions};
};

/// Values of the register `control_word`. The enumeration's underlying type has the width of the register.
enum class control_code : std::uint16_t {
    off = 0,         ///< without power, the brake is closed
    hold = 1,        ///< energised, at standstill
    turn = 2,        ///< at `speed`
    move = 3,        ///< to `target`
    clear_fault = 4, ///< once its cause has ended
};

/// Bits of the register `status_word`.
struct status_bits {
    static constexpr std::uint16_t energised = 0x0001;
    static constexpr std::uint16_t turning = 0x0002;
};

template <servobus::wire_value T> using ro = servobus::reg<T, servobus::access::ro, device>;
template <servobus::wire_value T> using rw = servobus::reg<T, servobus::access::rw, device>;

using servobus::i16, servobus::i32, servobus::u16;
using servobus::units::ampere, servobus::units::milliampere, servobus::units::millisecond,
    servobus::units::pulse, servobus::units::r_per_min;

// One line a register, like the manual's table: address, range, unit of one count, default, flags.
// clang-format off
inline constexpr rw<control_code> control_word {0x0001, {0, 4},              servobus::no_unit, 0,   servobus::trigger | servobus::motion};
inline constexpr rw<i16>          speed        {0x0002, {-600, 600},         r_per_min / 10,    0};
inline constexpr rw<u16>          ramp         {0x0003, {10, 5000},          millisecond,       500, servobus::saved};
inline constexpr rw<u16>          limit        {0x0004, {0, 250},            ampere / 10,       100, servobus::saved};
inline constexpr rw<u16>          host_word    {0x0005, servobus::full<u16>, servobus::no_unit, 0};  // 0 after power-on
inline constexpr rw<i32>          target       {0x0006, {-1'000'000, 1'000'000}, pulse,         0,   servobus::motion};
inline constexpr ro<u16>          load         {0x0010, servobus::full<u16>, ampere / 10,       0};
inline constexpr ro<i32>          position     {0x0011, servobus::full<i32>, pulse,             0};   // two registers
inline constexpr ro<u16>          status_word  {0x0013, servobus::full<u16>, servobus::no_unit, 0};   // see status_bits
inline constexpr ro<u16>          fault        {0x0014, servobus::full<u16>, servobus::no_unit, 0};   // 0: none

/// Eight positions to stop at, at the addresses 0100h, 0104h, …: `write<stops>(3, …)`; `at<stops, 3>` is one
/// of them as a register.
inline constexpr servobus::reg_array<rw<i32>, 8> stops {{0x0100, {-1'000'000, 1'000'000}, pulse, 0}, 4};
// clang-format on

} // namespace winch
