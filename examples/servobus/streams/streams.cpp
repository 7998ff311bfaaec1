// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The one place that looks whether standard output was written.
#include "streams.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "descriptors.hpp"
#include "messages.hpp"

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
    prepare_descriptors();
    // Room for what a command prints between two flushes, whose failure has an errno. A terminal has lines.
    static char room[1u << 16];
    if (!is_terminal(stdout)) (void)std::setvbuf(stdout, room, _IOFBF, sizeof room);
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
    if (flush()) {
        if (const int why = close_copy_of(stdout); why != 0) lose(why);
    }
    if (is_lost && !is_said) note(reason());
    return is_lost && status == done ? failed : status;
}

} // namespace tool::streams
