// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands, one a file of this folder. Their options are those of their rows in the table of the commands. Each
// returns its exit status.
#pragma once

#include "../command_line/arguments.hpp"

namespace tool {

int map(const arguments& asked);
int explain(const arguments& asked);
int simulate(const arguments& asked);
int read(const arguments& asked);
int write(const arguments& asked);
int scan(const arguments& asked);
int watch(const arguments& asked);
int send(const arguments& asked);
int alarms(const arguments& asked);
int backup(const arguments& asked);
int restore(const arguments& asked);
int apply(const arguments& asked);
int diff(const arguments& asked);
int turn(const arguments& asked);
int probe(const arguments& asked);
int listen(const arguments& asked);
int doctor(const arguments& asked);
int header(const arguments& asked);
int completion(const arguments& asked);

} // namespace tool
