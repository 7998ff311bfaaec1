// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifdef _WIN32

#include "descriptors.hpp"

#include <cerrno>
#include <initializer_list>

#include <fcntl.h>
#include <io.h>

#include <servobus/windows/clock.hpp>

namespace tool::streams {

void prepare_descriptors() {
    for (std::FILE* const stream : {stdin, stdout, stderr}) (void)::_setmode(::_fileno(stream), _O_BINARY);
}

bool is_terminal(std::FILE* stream) {
    constexpr DWORD sequences = 0x4; // ENABLE_VIRTUAL_TERMINAL_PROCESSING, since Windows 10
    const HANDLE console = ::GetStdHandle(stream == stdout ? STD_OUTPUT_HANDLE : STD_ERROR_HANDLE);
    DWORD mode = 0;
    return ::_isatty(::_fileno(stream)) != 0 && ::GetConsoleMode(console, &mode) != 0 &&
           ::SetConsoleMode(console, mode | sequences) != 0;
}

int close_copy_of(std::FILE* stream) {
    const int copy = ::_dup(::_fileno(stream));
    return copy >= 0 && ::_close(copy) != 0 ? errno : 0;
}

} // namespace tool::streams

#endif
