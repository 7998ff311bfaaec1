// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A whole text into a file of the operating system.
#pragma once

#include <cerrno>
#include <string_view>

#include <unistd.h>

namespace tool {

/// Returns 0 or errno. It is one write, unless the system takes only a part of it.
inline int write_all(int fd, std::string_view rest) {
    while (!rest.empty()) {
        const ssize_t n = ::write(fd, rest.data(), rest.size());
        if (n < 0 && errno != EINTR) return errno;
        if (n == 0) return EIO;
        if (n > 0) rest.remove_prefix(static_cast<std::size_t>(n));
    }
    return 0;
}

} // namespace tool
