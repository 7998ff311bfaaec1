// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted: a pseudo-terminal as a port, for simulators and tests. The simulator uses this end; a program opens
// `path()` as it would open a serial port.
//
//     servobus::posix::pseudo_terminal drive_end;
//     if (drive_end.open("/tmp/drive") != servobus::errc::ok) return drive_end.os_error();
//     std::puts(drive_end.path()); // /dev/pts/N; /tmp/drive is a link to it
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <sys/stat.h>

#include <servobus/line/port.hpp>
#include <servobus/posix/clock.hpp>
#include <servobus/posix/descriptor.hpp>

namespace servobus::posix {

/// The master side of a pseudo-terminal, as a port. While no program has the other side open, nothing is
/// received and sent bytes are discarded; neither is an error. Move-only.
class pseudo_terminal {
  public:
    pseudo_terminal() = default;
    pseudo_terminal(pseudo_terminal&& other) noexcept : fd_{std::move(other.fd_)}, error_{other.error_} {
        take_state(other);
    }
    pseudo_terminal& operator=(pseudo_terminal&& other) noexcept {
        if (this != &other) {
            close();
            fd_ = std::move(other.fd_);
            error_ = other.error_;
            take_state(other);
        }
        return *this;
    }
    ~pseudo_terminal() { close(); }

    /// Makes a new pair, after closing the one that was open. `link`, if given, is made a symbolic link to
    /// the other side until `close`. An existing symbolic link of that name is replaced, any other file is
    /// not. Errors, with the system's reason in `os_error()`: `port_lost` (the system has no pseudo-terminal
    /// for it), `bad_argument` (the link cannot be made).
    status open(const char* link = nullptr) {
        close();
        descriptor fd{::posix_openpt(O_RDWR | O_NOCTTY)};
        if (!fd.is_open() || ::grantpt(fd.number()) != 0 || ::unlockpt(fd.number()) != 0)
            return fail(errc::port_lost);
        // posix_openpt need not take these flags.
        if (::fcntl(fd.number(), F_SETFD, FD_CLOEXEC) != 0) return fail(errc::port_lost);
        const int flags = ::fcntl(fd.number(), F_GETFL);
        if (flags < 0 || ::fcntl(fd.number(), F_SETFL, flags | O_NONBLOCK) != 0) return fail(errc::port_lost);
        termios t{};
        if (detail::name_other_side(fd.number(), path_, sizeof path_) != 0 ||
            ::tcgetattr(fd.number(), &t) != 0)
            return fail(errc::port_lost);
        detail::make_raw(t);
        if (::tcsetattr(fd.number(), TCSANOW, &t) != 0) return fail(errc::port_lost);
        fd_ = std::move(fd);
        if (link != nullptr && !make_link(link)) {
            const errc why = fail(errc::bad_argument);
            close();
            return why;
        }
        error_ = 0;
        has_hung_up_ = false;
        return errc::ok;
    }

    void close() {
        remove_link();
        fd_.close();
        path_[0] = '\0';
    }

    bool is_open() const { return fd_.is_open(); }
    /// `errno` of the last failure, for a message; 0 if there was none.
    int os_error() const { return error_; }
    /// The name of the device that a program opens, `/dev/pts/N`; empty while closed.
    const char* path() const { return path_; }

    /// True while a program has the other side open, and before the first one does. Where only a read tells that
    /// (not on Linux), as the last `receive` found it.
    bool has_peer() const {
        if constexpr (!detail::tells_hang_up) return fd_.is_open() && !has_hung_up_;
        return fd_.is_open() && (detail::wait_readable(fd_.number(), {}) & POLLHUP) == 0;
    }

    /// The rate that the program at the other side has set, in bits a second; 0 if the system does not tell,
    /// or while it is closed. Nothing here depends on it.
    std::uint32_t baud() const { return fd_.is_open() ? detail::speed_of(fd_.number()) : 0; }

    /// Sends as many bytes as the system takes. Errors: `port_lost` (it is closed), `send_failed`.
    transfer send(bytes out) {
        if (fd_.is_open() && !has_peer())
            return static_cast<std::uint16_t>(out.size() < 4096 ? out.size() : 4096);
        const detail::moved m = detail::write_some(fd_.number(), out);
        if (m.error != 0 && m.error != EIO) return lose(m.error, errc::send_failed);
        return static_cast<std::uint16_t>(m.count);
    }

    bool sent() const { return true; }

    /// Errors: `port_lost` (it is closed), `receive_failed`.
    transfer receive(byte_buffer in) {
        const detail::moved m = detail::read_some(fd_.number(), in);
        has_hung_up_ = m.error == EIO || m.error == EPIPE; // as the system says it
        if (m.error != 0 && !has_hung_up_) return lose(m.error, errc::receive_failed);
        return static_cast<std::uint16_t>(m.count);
    }

    instant now() const { return monotonic_now(); }

    /// Sleeps until a byte arrives, `d` has passed or a signal is handled. While no program has the other
    /// side open, it sleeps for at most 5 ms.
    void wait(duration d) {
        if (!fd_.is_open()) return sleep_for(d);
        const int events = detail::wait_readable(fd_.number(), d);
        const bool has_hung_up =
            detail::tells_hang_up ? (events & POLLIN) == 0 && (events & (POLLHUP | POLLERR | POLLNVAL)) != 0
                                  : has_hung_up_;
        if (has_hung_up) sleep_for(d < milliseconds(5) ? d : milliseconds(5));
    }

  private:
    errc fail(errc why) {
        error_ = errno;
        return why;
    }

    errc lose(int error, errc otherwise) {
        error_ = error;
        return detail::is_gone(error) ? errc::port_lost : otherwise;
    }

    bool make_link(const char* link) {
        const std::size_t size = std::strlen(link);
        if (size == 0 || size >= sizeof link_) {
            errno = size == 0 ? ENOENT : ENAMETOOLONG;
            return false;
        }
        struct stat s {};
        if (::lstat(link, &s) == 0 && S_ISLNK(s.st_mode)) (void)::unlink(link);
        if (::symlink(path_, link) != 0) return false;
        std::memcpy(link_, link, size + 1);
        return true;
    }

    // Removes the link only if it still leads to this device: another program may have replaced it.
    void remove_link() {
        if (link_[0] == '\0') return;
        char target[sizeof path_]{};
        const ssize_t n = ::readlink(link_, target, sizeof target - 1);
        if (n > 0 && std::strcmp(target, path_) == 0) (void)::unlink(link_);
        link_[0] = '\0';
    }

    void take_state(pseudo_terminal& other) {
        std::memcpy(path_, other.path_, sizeof path_);
        std::memcpy(link_, other.link_, sizeof link_);
        other.path_[0] = '\0';
        other.link_[0] = '\0';
        has_hung_up_ = other.has_hung_up_;
    }

    descriptor fd_;
    int error_ = 0;
    bool has_hung_up_ = false; ///< found by the last `receive`
    char path_[64]{};
    char link_[512]{};
};

static_assert(waiting_port<pseudo_terminal>);

} // namespace servobus::posix
