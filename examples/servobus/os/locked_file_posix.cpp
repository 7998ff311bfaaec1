// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifndef _WIN32

#include "locked_file.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "write_all.hpp"

namespace tool {
namespace {

int number(std::intptr_t file) { return static_cast<int>(file); }

} // namespace

std::string locked_file::open(const std::string& path) {
    path_ = path;
    // Looked at before it is opened, since that alone can change the lines of a port.
    struct stat s {};
    if (::stat(path.c_str(), &s) == 0 && !S_ISREG(s.st_mode))
        return S_ISDIR(s.st_mode) ? std::strerror(EISDIR) : "it is no regular file";
    constexpr int flags = O_RDWR | O_APPEND | O_NOCTTY | O_NONBLOCK | O_CLOEXEC;
    file_ = ::open(path.c_str(), flags | O_CREAT | O_EXCL, 0666);
    const bool is_new = file_ != none;
    if (!is_new && errno == EEXIST) file_ = ::open(path.c_str(), flags);
    if (file_ == none) return std::strerror(errno);
    // A file system without locks: it is the user's matter that one program writes the file.
    if (::flock(number(file_), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return "another program logs into it";
    is_made_here_ = is_new;
    return {};
}

void locked_file::close() {
    if (file_ != none) (void)::close(number(file_));
    file_ = none;
}

void locked_file::remove() {
    (void)::unlink(path_.c_str());
    close();
}

std::optional<std::uint64_t> locked_file::size() const {
    struct stat s {};
    if (::fstat(number(file_), &s) != 0) return std::nullopt;
    return static_cast<std::uint64_t>(s.st_size);
}

bool locked_file::read(std::uint64_t at, std::span<char> to) const {
    const ssize_t n = ::pread(number(file_), to.data(), to.size(), static_cast<off_t>(at));
    return n >= 0 && static_cast<std::size_t>(n) == to.size();
}

std::string locked_file::append(std::string_view text) {
    int why = write_all(number(file_), text);
    // Some file systems report a lost write only when a descriptor is closed.
    if (const int copy = why == 0 ? ::dup(number(file_)) : -1; copy >= 0 && ::close(copy) != 0) why = errno;
    return why == 0 ? std::string{} : std::strerror(why);
}

bool locked_file::cut(std::uint64_t size) {
    return ::ftruncate(number(file_), static_cast<off_t>(size)) == 0;
}

} // namespace tool

#endif
