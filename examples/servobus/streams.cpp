// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The one place that looks whether standard output was written.
#include "streams.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>

#include "tool.hpp"

namespace tool::streams {
namespace {

bool is_lost = false;
bool is_said = false;
int error = 0;

void lose(int why) {
    if (!is_lost) error = why;
    is_lost = true;
}

std::string reason() {
    const std::string what = "cannot write standard output";
    return error == 0 ? what : what + ": " + std::strerror(error);
}

} // namespace

void prepare() {
    (void)std::signal(SIGPIPE, SIG_IGN);
    (void)std::signal(SIGXFSZ, SIG_IGN);
    // Room for what a command prints between two flushes, whose failure has an errno. A terminal has lines.
    static char room[1u << 16];
    if (::isatty(STDOUT_FILENO) != 1) (void)std::setvbuf(stdout, room, _IOFBF, sizeof room);
    // In ascending order each gets the lowest number that is free, which is its own. Input is opened for
    // writing and the others for reading, so that what the program wants of them fails with EBADF as on a
    // closed one.
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(fd, F_GETFD) != -1) continue;
        if (::open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY) != fd)
            std::_Exit(complain(failed, "a standard descriptor is closed, and /dev/null cannot be opened"));
    }
}

bool flush() {
    if (std::fflush(stdout) != 0) lose(errno);
    if (std::ferror(stdout) != 0) lose(0); // before this flush: its errno is not kept
    return !is_lost;
}

std::string why_lost() {
    if (flush()) return {};
    is_said = true;
    return reason();
}

int end_of_input(int status) {
    const int why = errno;
    if (std::ferror(stdin) == 0) return status;
    return complain(failed, std::string{"cannot read standard input: "} + std::strerror(why));
}

int finish(int status) {
    // Some file systems report a lost write only when a descriptor is closed.
    if (flush()) {
        const int copy = ::dup(STDOUT_FILENO);
        if (copy >= 0 && ::close(copy) != 0) lose(errno);
    }
    if (is_lost && !is_said) note(reason());
    return is_lost && status == done ? failed : status;
}

} // namespace tool::streams
