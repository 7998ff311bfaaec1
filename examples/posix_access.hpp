// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// POSIX: who may open a serial device that this user may not. The tool and the example programs append it to the
// system's error.
#pragma once

#include <cerrno>
#include <string>

#include <grp.h>
#include <sys/stat.h>

namespace host {

/// Empty for any other error than EACCES.
inline std::string advice_on_access(const char* path, int error) {
    struct stat of {};
    if (error != EACCES || ::stat(path, &of) != 0) return {};
    constexpr mode_t both = S_IRGRP | S_IWGRP;
    if ((of.st_mode & both) != both || of.st_gid == 0)
        return "; only its owner may use it, and the administrator";
    const group* named = ::getgrgid(of.st_gid);
    const std::string name = named != nullptr ? named->gr_name : std::to_string(of.st_gid);
    return "; the group " + name + " may use it: sudo usermod -aG " + name +
           " $USER, then log out and in again";
}

} // namespace host
