// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The file that a command writes, whatever its name leads to.
#pragma once

#include <memory>
#include <string>

namespace tool {

/// A FILE of the command line. A regular file, also one that symbolic links lead to, is replaced as a whole:
/// it has the old content until the new one is on the disk, and keeps its mode, and its owner where the
/// system allows it (on Windows its attributes and access list). What is no regular file (a device, a FIFO, a pipe) is
/// written into as it is. A block device, a folder and a link to nothing are refused.
class file_target {
  public:
    explicit file_target(std::string path);
    ~file_target();

    /// Before the port is opened, so that a descriptor that FILE names (/dev/stdout, /dev/fd/5) is the
    /// caller's. Returns `done`, or the exit status after a complaint. Nothing is written.
    int prepare(const char* port);

    /// Writes all of it. Returns `done`, or the exit status after a complaint.
    int put(const std::string& text);

  private:
    class place; // what the system has at that path

    std::unique_ptr<place> place_;
};

} // namespace tool
