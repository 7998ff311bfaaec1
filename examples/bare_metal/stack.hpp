// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How deep the stack has been: start.cpp fills it with a mark before main() begins.
#pragma once

#include <cstddef>

/// Bytes of the stack that were ever used, interrupts included.
std::size_t stack_used();
