// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The file that a command writes, whatever its name leads to.
#pragma once

#include <string>

#include <servobus/posix/descriptor.hpp>

namespace tool {

/// A FILE of the command line. A regular file, also one that symbolic links lead to, is replaced as a whole:
/// it has the old content until the new one is on the disk, and keeps its mode, and its owner where the
/// system allows it. What is no regular file (a device, a FIFO, a pipe) is written into as it is. A block
/// device, a folder and a link to nothing are refused.
class file_target {
  public:
    explicit file_target(std::string path) : path_{std::move(path)} {}

    /// Before the port is opened, so that a descriptor that FILE names (/dev/stdout, /dev/fd/5) is the
    /// caller's. Returns `done`, or the exit status after a complaint. Nothing is written.
    int prepare(const char* port);

    /// Writes all of it. Returns `done`, or the exit status after a complaint.
    int put(const std::string& text);

  private:
    enum class kind { fresh, regular, stream };

    int look(); // these return 0 or errno
    int replace(const std::string& text) const;
    int stream(const std::string& text) const;
    int complain_of(const std::string& why) const;

    std::string path_;
    std::string place_{}; // where it is once its links are followed
    kind kind_ = kind::fresh;
    servobus::posix::descriptor given_{};
    std::string refusal_{}; // what strerror has no words for
};

} // namespace tool
