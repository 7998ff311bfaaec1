// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Refuses a compiler that is not set to C++20, with a sentence in place of pages of errors. The headers that a program
// includes first include this one before all others. Programs need not include it.
// A header that does not exist ends the compilation there, which would print up to 3100 lines more.
//
//     static_assert(__cplusplus >= 202002L); // of g++ and clang++
#pragma once

#if defined(_MSVC_LANG) // there __cplusplus is 199711L without /Zc:__cplusplus
#if _MSVC_LANG < 202002L
#error "servobus needs C++20: compile with /std:c++20 or a newer standard"
#include "servobus needs /std:c++20"
#endif
#elif !defined(__cplusplus) || __cplusplus < 202002L
#error "servobus needs C++20: compile with -std=c++20 or a newer standard (g++ 11, clang++ 14 or newer)"
#include "servobus needs -std=c++20"
#endif
