// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// --csv, --json and --log of read and watch: which records are written, and where.
#pragma once

#include <optional>
#include <span>

#include "../command_line/arguments.hpp"
#include "../os/log_file.hpp"
#include "columns.hpp"

namespace tool {

/// Records go to standard output, in place of what people read, or with --log to a file beside it.
class recorder {
  public:
    /// Before the port is opened: refuses what cannot be recorded. Returns `done`, or the exit status after a
    /// complaint.
    int prepare(const arguments& asked, std::span<const chosen> wanted);

    bool is_on() const { return is_on_; }
    /// True if standard output is for people.
    bool has_display() const { return !is_on_ || log_.has_value(); }

    /// Writes the record of a snapshot, if any is wanted. Returns `done`, or the exit status.
    int put(const snapshot& s);

  private:
    columns columns_{};
    std::optional<log_file> log_{};
    bool is_on_ = false;
    bool is_json_ = false;
    bool has_header_ = false; // standard output has it
};

} // namespace tool
