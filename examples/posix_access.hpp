// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// POSIX: who may open a serial device that this user may not. The tool and the example programs append it to
// `no_permission`. The library has no such function: the system's lists of groups need a heap.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

namespace host {

/// True if this program has the rights of the group.
inline bool is_in_group(gid_t wanted) {
    const int count = ::getgroups(0, nullptr);
    std::vector<gid_t> groups(count > 0 ? static_cast<std::size_t>(count) : 0);
    if (::getgroups(static_cast<int>(groups.size()), groups.data()) < 0) groups.clear();
    return wanted == ::getegid() || std::find(groups.begin(), groups.end(), wanted) != groups.end();
}

/// Empty where the file does not say who may: its folder cannot be read, or this user is in its group.
inline std::string advice_on_access(const char* path) {
    struct stat of {};
    if (::stat(path, &of) != 0) return {};
    constexpr mode_t both = S_IRGRP | S_IWGRP;
    if ((of.st_mode & both) != both || of.st_gid == 0)
        return "; only its owner may use it, and the administrator";
    if (is_in_group(of.st_gid)) return {};
    const group* named = ::getgrgid(of.st_gid);
    const std::string name = named != nullptr ? named->gr_name : std::to_string(of.st_gid);
    return "; the group " + name + " may use it: sudo usermod -aG " + name +
           " $USER, then log out and in again";
}

} // namespace host
