// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Exit statuses, and what is said on standard error. Every command returns its exit status and writes at most one
// line of complaint.
#pragma once

#include <cstddef>
#include <string>

namespace tool {

// Exit statuses.
inline constexpr int done = 0;
inline constexpr int failed = 1; // refused, unknown, no response, no such port
inline constexpr int usage = 2;  // bad input; nothing was sent

/// Writes `servobus: message` to standard error and returns `status`.
int complain(int status, const std::string& message);
/// As above, for a note or a warning.
void note(const std::string& message);
/// How many complaints and notes were written.
std::size_t note_count();

/// A line that a person types on standard input, after a question on standard error; empty at its end.
std::string answer_to(const std::string& question);

} // namespace tool
