// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A 32-bit register that 10000h stops, for the wrong program that repeats another value.
#pragma once

#include <servobus/control/stop_words.hpp>

#include "program.hpp"

inline constexpr servobus::reg<servobus::i32, servobus::access::rw, zlac::device> travel{
    0x3100, servobus::full<servobus::i32>, servobus::no_unit, 0, servobus::motion};
template <> inline constexpr auto servobus::stop_words<travel> = servobus::words_that_stop(0x1'0000);
