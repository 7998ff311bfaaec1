// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How deep the stack has been: start.cpp fills it with a pattern before main() begins.
#pragma once

#include <cstddef>

/// The largest number of bytes of the stack that was in use, interrupts included.
std::size_t stack_used();
