// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted: a file descriptor that closes itself, and non-blocking transfers on it that a signal does not
// interrupt. serial.hpp, tcp.hpp and pseudo_terminal.hpp share it.
//
//     servobus::posix::descriptor fd{::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC)};
//     if (!fd.is_open()) return errno;
#pragma once

#include <cstddef>
#include <utility>

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <servobus/core/bytes.hpp>
#include <servobus/core/status.hpp>
#include <servobus/posix/clock.hpp>

namespace servobus::posix {

/// Owns a file descriptor; move-only.
class descriptor {
  public:
    descriptor() = default;
    explicit descriptor(int fd) : fd_{fd} {}
    descriptor(descriptor&& other) noexcept : fd_{std::exchange(other.fd_, -1)} {}
    descriptor& operator=(descriptor&& other) noexcept {
        if (this != &other) {
            close();
            fd_ = std::exchange(other.fd_, -1);
        }
        return *this;
    }
    ~descriptor() { close(); }

    int number() const { return fd_; }
    bool is_open() const { return fd_ >= 0; }
    void close() {
        if (fd_ >= 0) (void)::close(std::exchange(fd_, -1)); // no retry on EINTR: it is closed
    }

  private:
    int fd_ = -1;
};

namespace detail {

/// The number of bytes transferred, or `errno`. The end of the file is `error == EPIPE`.
struct moved {
    std::size_t count = 0;
    int error = 0;
};

inline constexpr std::size_t largest_transfer = 4096;

inline bool would_block(int error) { return error == EAGAIN || error == EWOULDBLOCK; }

/// True for errors that mean that the device of the descriptor is gone.
inline bool is_gone(int error) {
    return error == EIO || error == ENXIO || error == ENODEV || error == EBADF || error == EPIPE ||
           error == ESHUTDOWN;
}

/// Translates `errno` of an `open` that has failed. `port_lost` is for all other reasons, such as too many files.
inline errc opening_error(int error) {
    if (error == EBUSY) return errc::port_in_use; // TIOCEXCL
    if (error == EACCES || error == EPERM) return errc::no_permission;
    if (error == ENOENT || error == ENOTDIR || error == ENODEV || error == ENXIO) return errc::no_such_port;
    return errc::port_lost;
}

inline moved read_some(int fd, byte_buffer to) {
    if (to.empty()) return {};
    const std::size_t size = to.size() < largest_transfer ? to.size() : largest_transfer;
    for (int tries = 0; tries < 8; ++tries) {
        const ssize_t n = ::read(fd, to.data(), size);
        if (n > 0) return {static_cast<std::size_t>(n), 0};
        if (n == 0) return {0, EPIPE};
        if (would_block(errno)) return {};
        if (errno != EINTR) return {0, errno};
    }
    return {};
}

inline moved write_some(int fd, bytes from) {
    if (from.empty()) return {};
    const std::size_t size = from.size() < largest_transfer ? from.size() : largest_transfer;
    for (int tries = 0; tries < 8; ++tries) {
        const ssize_t n = ::write(fd, from.data(), size);
        if (n >= 0) return {static_cast<std::size_t>(n), 0};
        if (would_block(errno)) return {};
        if (errno != EINTR) return {0, errno};
    }
    return {};
}

/// Sleeps until something can be read, `d` has passed or a signal is handled. Returns the events of poll, 0
/// for none.
inline int wait_readable(int fd, duration d) { return wait_for(fd, POLLIN, d); }

/// Sets 8N1 without echo, signals, translation or flow control.
inline void make_raw(termios& t) {
    ::cfmakeraw(&t);
    t.c_iflag &= ~static_cast<tcflag_t>(IXOFF | IXANY | INPCK);
    t.c_iflag |= IGNBRK;
    t.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | PARODD | CRTSCTS);
    t.c_cflag |= CS8 | CREAD | CLOCAL;
    t.c_cc[VMIN] = 1; // a read of 0 bytes then means a hang-up, never "nothing yet"
    t.c_cc[VTIME] = 0;
}

} // namespace detail
} // namespace servobus::posix
