// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of what registers.hpp describes. The library's client and server of the tests with other libraries share them.
#pragma once

#include <cstddef>
#include <utility>

#include <servobus/registers/profile.hpp>
#include <servobus/registers/tables.hpp>

#include "registers.hpp"

namespace interop {

/// The time limit is long, since a server may respond late on a busy machine.
struct device {
    static constexpr servobus::profile facts{.name = "tables",
                                             .baud = baud,
                                             .limits = {.response = servobus::milliseconds(5000)},
                                             .exceptions = servobus::standard_exceptions};
};

using servobus::u16, servobus::full, servobus::no_unit, servobus::no_default;
template <unsigned I>
inline constexpr servobus::coil<servobus::access::rw, device> coil{static_cast<u16>(first_coil + I)};
template <unsigned I>
inline constexpr servobus::discrete_input<device> input{static_cast<u16>(first_input + I)};
template <unsigned I>
inline constexpr servobus::input_reg<u16, device> input_word{static_cast<u16>(first + I), full<u16>, no_unit,
                                                             no_default};
template <unsigned I>
inline constexpr servobus::reg<u16, servobus::access::rw, device> word{static_cast<u16>(first + I), full<u16>,
                                                                       no_unit, no_default};

} // namespace interop
