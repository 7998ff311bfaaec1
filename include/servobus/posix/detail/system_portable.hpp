// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: what the POSIX ports use of the system, by POSIX and BSD functions alone: macOS, the BSDs, and Linux if
// `SERVOBUS_PORTABLE_POSIX` is defined. It has no RS-485 switch, no low latency and no line status; `sent()` of a
// serial port then goes by the system's queue and the computed wire time.
#pragma once

#include <servobus/core/time.hpp>
#include <servobus/posix/detail/timespec.hpp>
#include <servobus/posix/rs485_driver.hpp>

#if !defined(__linux__) || defined(SERVOBUS_PORTABLE_POSIX)

#include <cstddef>
#include <cstdint>

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

namespace servobus::posix::detail {

inline constexpr bool tells_hang_up = false; ///< only a read tells it

/// Nothing is known here that makes the system wake a thread up later than it was asked.
class exact_wake_up {
  public:
    exact_wake_up() {}
    ~exact_wake_up() {}
};

/// Sleeps until `events` (POLLIN or POLLOUT), `d` has passed or a signal is handled. Returns the events, 0 for none.
/// By select, since poll of macOS does not take terminals. What has hung up is readable.
inline int wait_for(int fd, short events, duration d) {
    if (fd < 0 || fd >= static_cast<int>(FD_SETSIZE)) return POLLNVAL;
    fd_set set;
    FD_ZERO(&set);
    FD_SET(fd, &set);
    const timespec t = to_timespec(d);
    const bool reads = (events & POLLIN) != 0;
    const int n = ::pselect(fd + 1, reads ? &set : nullptr, reads ? nullptr : &set, nullptr, &t, nullptr);
    return n > 0 ? int{events} : 0;
}

/// By its name, the same on Linux, macOS and the BSDs' /dev/pts.
inline bool is_pseudo_terminal(int fd) {
    const char* name = ::ttyname(fd);
    return name != nullptr && (::strncmp(name, "/dev/pts/", 9) == 0 || ::strncmp(name, "/dev/ttys", 9) == 0);
}

/// The name of the other side of a pseudo-terminal. 0 or errno.
inline int name_other_side(int fd, char* name, std::size_t size) {
    const char* found = ::ptsname(fd);
    if (found == nullptr) return errno != 0 ? errno : ENOTTY;
    if (::strlen(found) >= size) return ERANGE;
    ::memcpy(name, found, ::strlen(found) + 1);
    return 0;
}

/// Sets a rate that has no constant. Where the constants are the rates themselves, as on macOS and the BSDs, the
/// driver decides; elsewhere there is no way. 0 or errno.
inline int set_any_speed(int fd, std::uint32_t baud) {
    if (B9600 != 9600) return EINVAL;
    termios t{};
    if (::tcgetattr(fd, &t) != 0) return errno;
    const auto speed = static_cast<speed_t>(baud);
    if (::cfsetispeed(&t, speed) != 0 || ::cfsetospeed(&t, speed) != 0) return errno;
    if (::tcsetattr(fd, TCSANOW, &t) != 0 || ::tcgetattr(fd, &t) != 0) return errno;
    return ::cfgetospeed(&t) == speed ? 0 : EINVAL;
}

/// The rate of a port, or of the other side of a pseudo-terminal, in bits a second; 0 if the system does not tell.
inline std::uint32_t speed_of(int fd) {
    termios t{};
    if (::tcgetattr(fd, &t) != 0) return 0;
    const speed_t set = ::cfgetospeed(&t);
    if (B9600 == 9600) return static_cast<std::uint32_t>(set);
    struct constant {
        speed_t name;
        std::uint32_t baud;
    };
    constexpr constant all[] = {
        {B2400, 2400},      {B4800, 4800}, {B9600, 9600}, {B19200, 19'200}, {B38400, 38'400},
#ifdef B57600
        {B57600, 57'600},
#endif
#ifdef B115200
        {B115200, 115'200},
#endif
    };
    for (const constant& c : all) {
        if (c.name == set) return c.baud;
    }
    return 0;
}

inline driver_result switch_direction(int, const rs485_driver&, duration) {
    return {errc::rs485_refused, ENOTSUP};
}
inline bool ask_low_latency(int) { return false; }
inline bool tells_line_status(int) { return false; }
inline bool is_transmitter_empty(int) { return true; }

/// A socket that no other program inherits and that does not block.
inline int make_stream_socket(int family) {
    const int fd = ::socket(family, SOCK_STREAM, 0);
    if (fd < 0) return fd;
    bool is_right = ::fcntl(fd, F_SETFD, FD_CLOEXEC) == 0 && ::fcntl(fd, F_SETFL, O_NONBLOCK) == 0;
#ifdef SO_NOSIGPIPE
    const int on = 1;
    is_right = is_right && ::setsockopt(fd, SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on) == 0;
#endif
    if (is_right) return fd;
    (void)::close(fd);
    return -1;
}
#ifdef MSG_NOSIGNAL
inline constexpr int without_signal = MSG_NOSIGNAL; ///< of `send` to a peer that has gone
#else
inline constexpr int without_signal = 0; // SO_NOSIGPIPE
#endif

} // namespace servobus::posix::detail

#endif
