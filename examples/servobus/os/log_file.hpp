// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The FILE of --log: rows are appended to it, whole ones only.
#pragma once

#include <string>
#include <string_view>

#include "locked_file.hpp"

namespace tool {

/// A regular file that one program at a time appends to. Errors are complained of here.
class log_file {
  public:
    log_file() = default;
    log_file(const log_file&) = delete;
    log_file& operator=(const log_file&) = delete;
    /// Closes the file, and removes one that was made here and got no row.
    ~log_file();

    /// Opens or makes the file and locks it. Nothing is written. A folder, a device, a pipe, a link to nothing
    /// and a file whose last line has no end are refused. Returns `done`, or the exit status.
    int open(const std::string& path);

    bool is_empty() const { return file_.size() == 0; }
    bool begins_with(std::string_view text) const;

    /// Appends a row in one write, after the header if the file is empty. If that fails the file is cut back
    /// to its last whole row. Returns `done`, or the exit status.
    int append(std::string_view header, std::string_view row);

  private:
    int complain_of(const std::string& why) const;

    std::string path_{};
    locked_file file_{};
};

} // namespace tool
