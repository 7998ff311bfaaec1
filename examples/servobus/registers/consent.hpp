// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a person agrees to before a machine may move or lose its parameters.
#pragma once

#include <span>
#include <string>

#include <servobus/registers/wire.hpp>

namespace tool {

class arguments;
struct chosen;
struct target;

/// Returns `done` with `--yes`, or once a person has typed `verb`; else complains by itself.
int ask_consent(const arguments& asked, const std::string& verb, const char* to_do = "write",
                const char* refusal = "not confirmed, nothing was written");

/// What a write of these words may do to a machine, in words; empty if it can move nothing.
std::string peril(const target& of, const chosen& what, std::span<const servobus::u16> words);

} // namespace tool
