// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The findings about the port and the line: who else is on it, what its bytes show, and how long responses take.
#pragma once

#include <optional>
#include <span>

#include "../devices/devices.hpp"
#include "../frames/line_words.hpp"
#include "report.hpp"

namespace tool::diagnosis {

/// Devices on one command line.
inline constexpr std::size_t most_devices = 16;

/// Other programs on an open port, and the latency timer of its USB adapter.
void judge_port(report& to, const std::string& port);

/// Listens to a line, asks on it, and counts what comes.
class line_hearing {
  public:
    explicit line_hearing(session& on) : on_{&on} {}

    /// Listens while nothing is asked.
    void listen();
    /// Reads a row so often; less often on a line without a byte.
    void ask(unsigned count, const servobus::entry& row, servobus::table from);
    const line_account& account() const { return account_; }

  private:
    session* on_;
    line_account account_{};
};

/// Explains a read without a value: asks some more, and says what was heard and what to try.
void explain_silence(report& to, const std::string& port, const target& of, servobus::status why, session& on,
                     line_hearing& ear, const asked_row& asked);

/// Reads a row many times, and reports what was heard, and how long its responses took of the time that they may take.
void judge_responses(report& to, const std::string& port, const target& of, session& on, line_hearing& ear,
                     const asked_row& asked);

/// Reports by the time of a response how short a program's period may be; `period_ms`: what it is to be, 0 if that is
/// not known.
void judge_period(report& to, const session& on, servobus::duration response, bool is_drive, unsigned devices,
                  unsigned period_ms);

/// The settings that all devices of a line can have; none if they share no rate or no format, which is reported.
/// Prints what each of them needs.
std::optional<servobus::uart_settings> judge_shared_line(std::span<const target> all);

} // namespace tool::diagnosis
