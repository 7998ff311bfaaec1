// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifndef _WIN32

#include "os.hpp"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <netdb.h>
#include <unistd.h>

#include "../../posix_access.hpp"
#include "../tool.hpp"
#include "interrupts.hpp"

namespace tool {
namespace {

volatile std::sig_atomic_t interruption = 0;

} // namespace

void interrupts::arm() {
    struct sigaction act {};
    act.sa_handler = [](int) { interruption = 1; };
    (void)::sigaction(SIGINT, &act, nullptr);
    (void)::sigaction(SIGTERM, &act, nullptr);
}
bool interrupts::came() { return interruption != 0; }

namespace os {

void prepare_streams() {
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

std::string error_text(int error) { return std::strerror(error); }
std::string advice_on_access(const char* path, int error) { return host::advice_on_access(path, error); }
std::string resolve_error_text(int error) { return ::gai_strerror(error); }

} // namespace os
} // namespace tool

#endif
