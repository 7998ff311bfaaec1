// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "log_file.hpp"

#include <cerrno>
#include <cstring>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tool.hpp"
#include "write_all.hpp"

namespace tool {
namespace {

// Returns 0 or errno.
int write_row(int fd, std::string_view row) {
    if (const int why = write_all(fd, row); why != 0) return why;
    // Some file systems report a lost write only when a descriptor is closed.
    const int copy = ::dup(fd);
    return copy >= 0 && ::close(copy) != 0 ? errno : 0;
}

} // namespace

log_file::~log_file() {
    if (is_made_here_ && is_empty()) (void)::unlink(path_.c_str());
    if (file_ >= 0) (void)::close(file_);
}

int log_file::complain_of(const std::string& why) const {
    return complain(failed, "cannot write " + path_ + ": " + why);
}

long long log_file::size() const {
    struct stat s {};
    return ::fstat(file_, &s) == 0 ? s.st_size : -1;
}

int log_file::open(const std::string& path) {
    path_ = path;
    // Looked at before it is opened, since that alone can change the lines of a port.
    struct stat s {};
    if (::stat(path.c_str(), &s) == 0 && !S_ISREG(s.st_mode))
        return complain_of(S_ISDIR(s.st_mode) ? std::strerror(EISDIR) : "it is no regular file");
    constexpr int flags = O_RDWR | O_APPEND | O_NOCTTY | O_NONBLOCK | O_CLOEXEC;
    file_ = ::open(path.c_str(), flags | O_CREAT | O_EXCL, 0666);
    const bool is_new = file_ >= 0;
    if (!is_new && errno == EEXIST) file_ = ::open(path.c_str(), flags);
    if (file_ < 0) return complain_of(std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
        if (errno == EWOULDBLOCK) return complain_of("another program logs into it");
        // A file system without locks: it is the user's matter that one program writes the file.
    }
    is_made_here_ = is_new;
    const long long bytes = size();
    if (bytes < 0) return complain_of(std::strerror(errno));
    char last = '\n';
    if (bytes > 0 && ::pread(file_, &last, 1, static_cast<off_t>(bytes - 1)) != 1)
        return complain_of("its last line cannot be read");
    if (last == '\n') return done;
    return complain(usage, path_ + ": its last line has no end; complete or remove that line first");
}

bool log_file::begins_with(std::string_view text) const {
    std::vector<char> found(text.size());
    const ssize_t n = ::pread(file_, found.data(), found.size(), 0);
    return n >= 0 && std::string_view{found.data(), static_cast<std::size_t>(n)} == text;
}

int log_file::append(std::string_view header, std::string_view row) {
    const long long before = size();
    if (before < 0) return complain_of(std::strerror(errno));
    const std::string rows = std::string{before == 0 ? header : ""} + std::string{row};
    const int why = write_row(file_, rows);
    if (why == 0) return done;
    const bool is_whole = size() <= before || ::ftruncate(file_, static_cast<off_t>(before)) == 0;
    return complain_of(std::strerror(why) + std::string{is_whole ? "" : "; its last row is not complete"});
}

} // namespace tool
