// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device of your own: a profile and its registers, in a header like this one and in a namespace of yours.
// Copy it, and write down what your device's manual says; that is all that the library needs to know.
//
// The device here is a winch that no factory makes. A program drives it like this:
//
//     servobus::line line{port, servobus::modbus::timing_at(winch::device::facts.baud)};
//     servobus::client<decltype(line), winch::device> drum{line, servobus::node<winch::device>{5}};
//
//     drum.write<winch::speed>(12 * winch::r_per_min);        // a constant: checked by the compiler
//     drum.write<winch::speed>(servobus::clamped(wanted));    // a value of the running program enters by
//     name drum.write<winch::order>(winch::command::wind); if (const auto load = drum.read<winch::load>())
//     show(load->rounded(winch::ampere));
#pragma once

#include <cstdint>

#include <servobus/registers/block.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>

namespace winch {

/// The device in numbers. What is not said here is as the Modbus standard has it.
struct device {
    static constexpr servobus::exception_meaning exceptions[] = {{1, "no such register"},
                                                                 {9, "rope is slack"}};
    static constexpr servobus::profile facts{.name = "winch",
                                             .max_read = 32,
                                             .highest_unit = 31,
                                             .order = servobus::word_order::low_first,
                                             .baud = 19200,
                                             .format = servobus::character_format::e81,
                                             .exceptions = exceptions};
};

/// What `order` takes. An enumeration is as wide as its register.
enum class command : std::uint16_t { stop = 0, wind = 1, unwind = 2 };

template <servobus::wire_value T> using ro = servobus::reg<T, servobus::access::ro, device>;
template <servobus::wire_value T> using rw = servobus::reg<T, servobus::access::rw, device>;

using servobus::i16, servobus::i32, servobus::u16;
using servobus::units::ampere, servobus::units::milliampere, servobus::units::millisecond,
    servobus::units::pulse, servobus::units::r_per_min;

// One line a register, like the manual's table: address, range, what one count is worth, default, facts.
// clang-format off
inline constexpr rw<command> order    {0x0001, {0, 2},             servobus::no_unit, 0,   servobus::trigger | servobus::motion};
inline constexpr rw<i16>     speed    {0x0002, {-600, 600},        r_per_min / 10,    0};
inline constexpr rw<u16>     ramp     {0x0003, {10, 5000},         millisecond,       500, servobus::saved};
inline constexpr rw<u16>     limit    {0x0004, {0, 250},           ampere / 10,       100, servobus::saved};
inline constexpr ro<u16>     load     {0x0010, servobus::full<u16>, ampere / 10,      0};
inline constexpr ro<i32>     position {0x0011, servobus::full<i32>, pulse,            0}; // two registers

/// Eight positions to stop at, at 0100h, 0104h, …: `write<stops>(3, …)`, or `at<stops, 3>` as a row of its
/// own.
inline constexpr servobus::reg_array<rw<i32>, 8> stops {{0x0100, {-1'000'000, 1'000'000}, pulse, 0}, 4};
// clang-format on

} // namespace winch
