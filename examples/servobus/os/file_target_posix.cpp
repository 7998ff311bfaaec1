// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifndef _WIN32

#include "file_target.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <servobus/posix/descriptor.hpp>

#include "../streams/messages.hpp"
#include "../words/numbers.hpp"
#include "write_all.hpp"

namespace tool {
namespace {

namespace fs = std::filesystem;
using servobus::posix::descriptor;

// The descriptor of this program that a name such as /dev/stdout leads to. Such a link is followed by its
// number, since a pipe has no other name, and a regular file may hold what was written before.
std::optional<int> descriptor_named(fs::path path) {
    std::error_code error;
    const fs::path own = fs::canonical("/proc/self/fd", error);
    if (error) return std::nullopt;
    for (int links = 0; links < 40; ++links) {
        const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path{"."};
        if (fs::canonical(folder, error) == own && !error) {
            const std::optional<std::int64_t> number = parse_integer(path.filename().native());
            if (!number || *number < 0 || *number > INT32_MAX) return std::nullopt;
            return static_cast<int>(*number);
        }
        const fs::path next = fs::read_symlink(path, error);
        if (error) return std::nullopt;
        path = folder / next; // an absolute one stays as it is
    }
    return std::nullopt;
}

// A new file beside `place`, in the same file system. -1 and errno if there is none.
int make_draft(const std::string& place, mode_t mode, std::string& draft) {
    const std::size_t slash = place.rfind('/');
    const std::string folder = slash == place.npos ? std::string{} : place.substr(0, slash + 1);
    for (int tries = 0; tries < 100; ++tries) {
        draft = folder + "servobus" + std::to_string(::getpid()) + '-' + std::to_string(tries) + ".part";
        const int fd = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (fd >= 0 || errno != EEXIST) return fd;
    }
    return -1;
}

// Gives a draft the mode and, where the system allows it, the owner and group of the file that it replaces.
// Returns 0 or errno.
int take_over(int fd, const struct stat& old) {
    const bool has_owner = ::fchown(fd, old.st_uid, old.st_gid) == 0;
    if (!has_owner) (void)::fchown(fd, static_cast<uid_t>(-1), old.st_gid);
    struct stat now {};
    if (::fstat(fd, &now) != 0) return errno;
    mode_t mode = old.st_mode & 07777u;
    // These bits act with the rights of the owner and group.
    if (now.st_uid != old.st_uid || now.st_gid != old.st_gid) mode &= 0777u;
    return ::fchmod(fd, mode) == 0 ? 0 : errno;
}

} // namespace

class file_target::place {
  public:
    explicit place(std::string path) : path_{std::move(path)} {}

    int prepare(const char* port);
    int put(const std::string& text);

  private:
    enum class kind { fresh, regular, stream };

    int look(); // these return 0 or errno
    int replace(const std::string& text) const;
    int stream(const std::string& text) const;
    int complain_of(const std::string& why) const {
        return complain(failed, "cannot write " + path_ + ": " + why);
    }

    std::string path_;
    std::string place_{}; // where it is once its links are followed
    kind kind_ = kind::fresh;
    descriptor given_{};
    std::string refusal_{}; // what strerror has no words for
};

file_target::file_target(std::string path) : place_{std::make_unique<place>(std::move(path))} {}
file_target::~file_target() = default;
int file_target::prepare(const char* port) { return place_->prepare(port); }
int file_target::put(const std::string& text) { return place_->put(text); }

// What the name leads to now.
int file_target::place::look() {
    struct stat s {};
    place_ = path_;
    refusal_.clear();
    if (given_.is_open() ? ::fstat(given_.number(), &s) != 0 : ::stat(path_.c_str(), &s) != 0) {
        const int why = errno;
        if (why != ENOENT) return why;
        if (::lstat(path_.c_str(), &s) == 0 && S_ISLNK(s.st_mode)) {
            refusal_ = "it is a symbolic link to nothing";
            return why;
        }
        kind_ = kind::fresh;
        return 0;
    }
    if (S_ISDIR(s.st_mode)) return EISDIR;
    if (S_ISBLK(s.st_mode)) {
        refusal_ = "it is a block device";
        return EINVAL;
    }
    kind_ = S_ISREG(s.st_mode) && !given_.is_open() ? kind::regular : kind::stream;
    if (kind_ == kind::stream) return 0;
    std::error_code error;
    place_ = fs::canonical(path_, error).native();
    return error.value();
}

int file_target::place::prepare(const char* port) {
    if (const std::optional<int> number = descriptor_named(path_)) {
        given_ = descriptor{::fcntl(*number, F_DUPFD_CLOEXEC, 3)};
        if (!given_.is_open()) return complain_of(std::strerror(errno));
    }
    if (const int why = look(); why != 0)
        return complain_of(refusal_.empty() ? std::strerror(why) : refusal_);
    struct stat at {};
    struct stat of {};
    const bool is_found =
        given_.is_open() ? ::fstat(given_.number(), &at) == 0 : ::stat(path_.c_str(), &at) == 0;
    if (is_found && ::stat(port, &of) == 0 && S_ISCHR(at.st_mode) && S_ISCHR(of.st_mode) &&
        at.st_rdev == of.st_rdev)
        return complain(usage, path_ + " is the port");
    return done;
}

// All of it or nothing: under another name until it is on the disk.
int file_target::place::replace(const std::string& text) const {
    descriptor old;
    struct stat before {};
    if (kind_ == kind::regular) {
        // As if it were written in place: a file that may not be written is not replaced either.
        old = descriptor{::open(place_.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
        if (!old.is_open() || ::fstat(old.number(), &before) != 0) return errno;
        if (!S_ISREG(before.st_mode)) return EAGAIN; // it was exchanged just now
    }
    std::string draft;
    const int fd = make_draft(place_, kind_ == kind::regular ? 0600 : 0666, draft);
    if (fd < 0) return errno;
    int why = kind_ == kind::regular ? take_over(fd, before) : 0;
    if (why == 0) why = write_all(fd, text);
    if (why == 0 && ::fsync(fd) != 0) why = errno;
    if (::close(fd) != 0 && why == 0) why = errno;
    if (why == 0 && std::rename(draft.c_str(), place_.c_str()) != 0) why = errno;
    if (why != 0) {
        (void)::unlink(draft.c_str());
        return why;
    }
    // The new name is on the disk too, where the file system can say so.
    const std::string folder = fs::path{place_}.parent_path().native();
    const descriptor at{::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC)};
    if (at.is_open()) (void)::fsync(at.number());
    return 0;
}

int file_target::place::stream(const std::string& text) const {
    if (given_.is_open()) return write_all(given_.number(), text);
    const int fd = ::open(path_.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
    if (fd < 0) return errno;
    struct stat s {};
    int why = ::fstat(fd, &s) != 0 ? errno : S_ISREG(s.st_mode) || S_ISBLK(s.st_mode) ? EAGAIN : 0;
    if (why == 0) why = write_all(fd, text);
    if (::close(fd) != 0 && why == 0) why = errno;
    return why;
}

int file_target::place::put(const std::string& text) {
    int why = look(); // it may have changed while the drive was read
    if (why == 0) why = kind_ == kind::stream ? stream(text) : replace(text);
    if (why == 0) return done;
    return complain_of(refusal_.empty() ? std::strerror(why) : refusal_);
}

} // namespace tool

#endif
