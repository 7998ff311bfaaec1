// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The wish to end the program, as a question that a command asks between two requests: SIGINT and SIGTERM; on Windows
// Ctrl-C, Ctrl-Break and the end of the console, of the session and of the system.
#pragma once

namespace tool::interrupts {

/// From here on it ends no program. A signal ends a sleep and a wait for input.
void arm();
bool came();

} // namespace tool::interrupts
