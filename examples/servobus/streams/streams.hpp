// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Standard input and output of every command: none of them succeeds if its output is lost or its input cannot
// be read.
#pragma once

#include <string>

namespace tool::streams {

/// Before anything is opened; see descriptors.hpp.
void prepare();

/// Flushes standard output. False if any of the output so far could not be written: a command that goes on
/// for long or writes to a drive ends then. `finish` says why.
bool flush();

/// As `flush`, for a command that has more to say: empty, or why, and then `finish` does not say it again.
std::string why_lost();

/// At the end of standard input: `status`, or `failed` after a complaint if it ended because it could not be
/// read.
int end_of_input(int status);

/// At the end of the program: `status`, but not `done` if output was lost. Complains by itself.
int finish(int status);

} // namespace tool::streams
