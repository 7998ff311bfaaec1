// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifndef _WIN32

#include "descriptors.hpp"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <initializer_list>

#include <fcntl.h>
#include <unistd.h>

#include "messages.hpp"

namespace tool::streams {

void prepare_descriptors() {
    (void)std::signal(SIGPIPE, SIG_IGN);
    (void)std::signal(SIGXFSZ, SIG_IGN);
    // In ascending order each gets the lowest number that is free, which is its own. Input is opened for
    // writing and the others for reading, so that what the program wants of them fails with EBADF as on a
    // closed one.
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(fd, F_GETFD) != -1) continue;
        if (::open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY) != fd)
            std::_Exit(complain(failed, "a standard descriptor is closed, and /dev/null cannot be opened"));
    }
}

bool is_terminal(std::FILE* stream) { return ::isatty(::fileno(stream)) == 1; }

int close_copy_of(std::FILE* stream) {
    const int copy = ::dup(::fileno(stream));
    return copy >= 0 && ::close(copy) != 0 ? errno : 0;
}

} // namespace tool::streams

#endif
