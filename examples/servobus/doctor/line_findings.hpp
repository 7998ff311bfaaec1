// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The findings about the port and the line: who else is on it, what its bytes show, and how long responses take.
#pragma once

#include <optional>
#include <span>

#include "report.hpp"

namespace tool::diagnosis {

/// Devices on one command line.
inline constexpr std::size_t most_devices = 16;

/// How long responses took to begin.
struct response_times {
    unsigned asked = 0;
    unsigned answered = 0;
    servobus::duration least{};
    servobus::duration median{};
    servobus::duration most{};
};

/// Other programs on an open port, and the latency timer of its USB adapter.
void judge_port(report& to, const std::string& port);

/// Explains a read without a value: what the bytes show, and what to try.
void explain_silence(report& to, const std::string& port, const target& of, servobus::status why,
                     const session& on);

/// Reads a row many times, and reports how long its responses took, of the time that they may take.
response_times judge_responses(report& to, session& on, const servobus::entry& row, servobus::table from);

/// Reports how short a program's period may be; `period_ms`: what it is to be, 0 if that is not known.
void judge_period(report& to, const session& on, const response_times& took, unsigned devices,
                  unsigned period_ms);

/// The settings that all devices of a line can have; none if they share no rate or no format, which is reported.
/// Prints what each of them needs.
std::optional<servobus::uart_settings> judge_shared_line(std::span<const target> all);

} // namespace tool::diagnosis
