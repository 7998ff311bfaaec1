// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: what the POSIX ports use of Linux alone. system_portable.hpp has the same functions for other systems.
#pragma once

#include <servobus/core/time.hpp>
#include <servobus/posix/detail/timespec.hpp>
#include <servobus/posix/rs485_driver.hpp>

#if defined(__linux__) && !defined(SERVOBUS_PORTABLE_POSIX)

#include <cstddef>
#include <cstdint>

#include <errno.h>
#include <linux/serial.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>

namespace servobus::posix::detail {

inline constexpr bool tells_hang_up = true; ///< by the events of `wait_for`

/// Sets the thread's timer slack to the minimum during its lifetime, and restores it afterwards, so that
/// other sleeps of the program keep the slack that the program chose. Linux wakes an ordinary thread up to
/// its timer slack late: 50 us by default, a fifth of the wire time of a short frame at 115200 Bd.
class exact_wake_up {
  public:
    exact_wake_up() : slack_ns_{::prctl(PR_GET_TIMERSLACK)} {
        if (slack_ns_ > 1) (void)::prctl(PR_SET_TIMERSLACK, 1ul);
    }
    exact_wake_up(const exact_wake_up&) = delete;
    exact_wake_up& operator=(const exact_wake_up&) = delete;
    ~exact_wake_up() {
        if (slack_ns_ > 1) (void)::prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack_ns_));
    }

  private:
    int slack_ns_; // below 0 if it cannot be read; then it is not changed
};

/// Sleeps until `events` of poll, `d` has passed or a signal is handled. Returns the events, 0 for none.
inline int wait_for(int fd, short events, duration d) {
    pollfd p{fd, events, 0};
    const timespec t = to_timespec(d);
    if (d == duration{}) return ::ppoll(&p, 1, &t, nullptr) > 0 ? int{p.revents} : 0;
    const exact_wake_up precisely;
    return ::ppoll(&p, 1, &t, nullptr) > 0 ? int{p.revents} : 0;
}

/// A pseudo-terminal has no wire: no baud rate, no parity.
inline bool is_pseudo_terminal(int fd) {
    struct stat s {};
    if (::fstat(fd, &s) != 0) return false;
    const unsigned major_number = major(s.st_rdev);
    return major_number >= 136 && major_number <= 143;
}

/// The name of the other side of a pseudo-terminal. 0 or errno.
inline int name_other_side(int fd, char* name, std::size_t size) { return ::ptsname_r(fd, name, size); }

// Sets a rate that is none of the standard ones. 0 or errno.
//
// The kernel's struct of the settings, in which the speed is a number. <asm/termbits.h> defines it, but
// cannot be included together with <termios.h>; the ioctl numbers need the name `termios2` only for its size.
// Machines with another layout have the standard rates only.
#if defined(TCGETS2) && !defined(__mips__) && !defined(__sparc__) && !defined(__alpha__)
struct termios2 {
    tcflag_t c_iflag;
    tcflag_t c_oflag;
    tcflag_t c_cflag;
    tcflag_t c_lflag;
    cc_t c_line;
    cc_t c_cc[19];
    speed_t c_ispeed;
    speed_t c_ospeed;
};
static_assert(sizeof(termios2) == 44);

inline int set_any_speed(int fd, std::uint32_t baud) {
    constexpr tcflag_t speed_bits = 0010017;
    constexpr tcflag_t speed_is_a_number = 0010000;
    constexpr int input_shift = 16;
    termios2 t{};
    if (::ioctl(fd, TCGETS2, &t) != 0) return errno;
    t.c_cflag &= ~(speed_bits | speed_bits << input_shift);
    t.c_cflag |= speed_is_a_number | speed_is_a_number << input_shift;
    t.c_ispeed = t.c_ospeed = baud;
    if (::ioctl(fd, TCSETS2, &t) != 0 || ::ioctl(fd, TCGETS2, &t) != 0) return errno;
    const std::uint32_t off = t.c_ospeed < baud ? baud - t.c_ospeed : t.c_ospeed - baud;
    return off <= baud / 32 ? 0 : EINVAL; // the driver chose a rate more than 3 % away
}
/// The rate of a port, or of the other side of a pseudo-terminal, in bits a second; 0 if the system does not tell.
inline std::uint32_t speed_of(int fd) {
    termios2 t{};
    return ::ioctl(fd, TCGETS2, &t) == 0 ? t.c_ospeed : 0;
}
#else
inline int set_any_speed(int, std::uint32_t) { return EINVAL; }
inline std::uint32_t speed_of(int) { return 0; }
#endif

/// Lets the kernel switch the RS-485 driver, which may be on for `longest_after` after the last stop bit. What `wanted`
/// leaves open stays as it is. If that fails, all stays as it was.
inline driver_result switch_direction(int fd, const rs485_driver& wanted, duration longest_after) {
    serial_rs485 before{};
    if (::ioctl(fd, TIOCGRS485, &before) != 0) return {errc::rs485_refused, errno};
    constexpr std::uint32_t polarity = SER_RS485_RTS_ON_SEND | SER_RS485_RTS_AFTER_SEND;
    const auto whole_ms = [](duration stated, std::uint32_t kept) {
        return stated == rs485_driver::as_configured ? kept
                                                     : stated.us / 1000 + (stated.us % 1000 != 0 ? 1u : 0u);
    };
    const auto is_late = [longest_after](const serial_rs485& m) {
        return std::uint64_t{m.delay_rts_after_send} * 1000 > longest_after.us;
    };
    serial_rs485 mode = before;
    mode.flags |= SER_RS485_ENABLED;
    if (wanted.polarity != rs485_polarity::as_configured) mode.flags &= ~polarity;
    if (wanted.polarity == rs485_polarity::rts_after_send) mode.flags |= SER_RS485_RTS_AFTER_SEND;
    if ((mode.flags & polarity) == 0) mode.flags |= SER_RS485_RTS_ON_SEND;
    mode.delay_rts_before_send = whole_ms(wanted.before_send, before.delay_rts_before_send);
    mode.delay_rts_after_send = whole_ms(wanted.after_send, before.delay_rts_after_send);
    if (is_late(mode)) return {errc::rs485_late, ERANGE};
    if (::ioctl(fd, TIOCSRS485, &mode) != 0) return {errc::rs485_refused, errno};
    // Kernels since 6.0 replace what a driver cannot do, and report success.
    driver_result result{};
    serial_rs485 got{};
    const bool is_stated = wanted.polarity != rs485_polarity::as_configured;
    if (::ioctl(fd, TIOCGRS485, &got) != 0) {
        result = {errc::rs485_refused, errno};
    } else if (is_late(got)) {
        result = {errc::rs485_late, ERANGE};
    } else if ((got.flags & SER_RS485_ENABLED) == 0 ||
               (is_stated && (got.flags & polarity) != (mode.flags & polarity)) ||
               got.delay_rts_before_send != mode.delay_rts_before_send ||
               got.delay_rts_after_send != mode.delay_rts_after_send) {
        result = {errc::rs485_refused, EINVAL};
    }
    if (result.why != errc::ok) (void)::ioctl(fd, TIOCSRS485, &before);
    result.before_send = milliseconds(got.delay_rts_before_send);
    return result;
}

/// True if received bytes are passed on immediately from now on.
inline bool ask_low_latency(int fd) {
    serial_struct s{};
    if (::ioctl(fd, TIOCGSERIAL, &s) != 0) return false;
    constexpr auto low_latency = static_cast<int>(ASYNC_LOW_LATENCY);
    s.flags |= low_latency;
    return ::ioctl(fd, TIOCSSERIAL, &s) == 0 && ::ioctl(fd, TIOCGSERIAL, &s) == 0 &&
           (s.flags & low_latency) != 0;
}

/// True if the driver tells whether the last stop bit has left.
inline bool tells_line_status(int fd) {
    int status = 0;
    return ::ioctl(fd, TIOCSERGETLSR, &status) == 0;
}
inline bool is_transmitter_empty(int fd) {
    int status = 0;
    return ::ioctl(fd, TIOCSERGETLSR, &status) != 0 || (status & TIOCSER_TEMT) != 0;
}

/// A socket that no other program inherits and that does not block.
inline int make_stream_socket(int family) {
    return ::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}
inline constexpr int without_signal = MSG_NOSIGNAL; ///< of `send` to a peer that has gone

} // namespace servobus::posix::detail

#endif
