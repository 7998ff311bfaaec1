// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The standard streams as the operating system has them; a variant each for POSIX and Windows.
#pragma once

#include <cstdio>

namespace tool::streams {

/// Before anything is opened. A standard descriptor that is closed becomes one on which every read and write
/// fails: no port or file that is opened later gets its number (Windows gives no file these numbers). A pipe whose
/// reader has gone and a file that grows too large are errors of a write, not signals that end the program between two
/// frames. Text has the same bytes on every system: lines end with LF.
void prepare_descriptors();

/// True for a terminal whose cursor escape sequences move.
bool is_terminal(std::FILE* stream);

/// Some file systems report a lost write only when a descriptor is closed. 0 or `errno`.
int close_copy_of(std::FILE* stream);

} // namespace tool::streams
