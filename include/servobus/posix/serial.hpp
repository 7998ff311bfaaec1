// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, POSIX: a serial device (an on-board UART, a USB adapter, a pseudo-terminal) as a port of the
// library. It sets any baud rate that the hardware has, lets Linux switch the RS-485 direction, and
// loses no byte to a signal or a short write. After the device was unplugged, every call returns `port_lost`;
// `reconnecting<serial>` (line/reconnecting.hpp) opens it again.
//
//     servobus::posix::serial port;
//     if (port.open("/dev/ttyUSB0") != servobus::errc::ok) return port.os_error();
//     servobus::line line{port, servobus::modbus::timing_at(115200)};
//
// `sent()` is true when the kernel's queue is empty, the UART reports an empty transmitter (if the system and its
// driver can), and the wire time of the written bytes has passed. A pseudo-terminal has no wire: there a byte is
// sent immediately.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>
#include <utility>

#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <servobus/line/port.hpp>
#include <servobus/line/transmission.hpp>
#include <servobus/posix/clock.hpp>
#include <servobus/posix/descriptor.hpp>
#include <servobus/posix/detail/early_wake_up.hpp>
#include <servobus/posix/rs485_driver.hpp>
#include <servobus/registers/profile.hpp>

namespace servobus::posix {

/// The settings of a serial device. `settings_of(device::facts)` makes them from a drive's profile.
struct serial_settings {
    std::uint32_t baud = 115200; ///< bits a second; also rates that are not standard, such as 128000
    character_format format = character_format::n81;
    /// The kernel switches the RS-485 driver by RTS (TIOCSRS485 of Linux), as `driver` states. If the device or the
    /// system cannot do so, `open` fails, since nothing would reach the wire. Adapters that switch by themselves need
    /// `false`.
    bool rs485 = false;
    /// Polarity and delays with `rs485`; by default those of the board's device tree.
    rs485_driver driver{};
    /// The adapter has local echo and the line removes it (`echoed`): `sent` leaves the echo in the receiver.
    bool keeps_echo = false;
    /// Received bytes are passed on immediately (ASYNC_LOW_LATENCY of Linux: 1 ms instead of 16 ms with
    /// FTDI adapters). `open` succeeds without it too: see `serial::has_low_latency`.
    bool low_latency = true;
    /// Nothing is sent: the device is opened for reading only, `send` fails with `send_failed`, and RTS is withdrawn,
    /// which switches the RS-485 driver of some adapters.
    bool receive_only = false;
    /// Waits below 5 ms end on time, also if the system wakes a thread late: the port sleeps less by the lateness that
    /// it measures, and polls for the rest, each time 1 ms at most. A bus that fills a line of 115200 Bd then gets more
    /// from the line, and spends a few per cent of a core on it: bench/README.md has both figures. It is for threads of
    /// real-time priority or with a core to spare: an ordinary thread that polls may lose its turn to others.
    bool wakes_early = false;
};

/// The factory settings of a drive, from its profile.
constexpr serial_settings settings_of(const profile& facts) {
    return {
        .baud = facts.baud, .format = facts.format, .rs485 = false, .keeps_echo = false, .low_latency = true};
}

/// What the devices of a line share, as `settings_on_one_line` finds it.
constexpr serial_settings settings_of(const uart_settings& shared) {
    return {.baud = shared.baud,
            .format = shared.format,
            .rs485 = false,
            .keeps_echo = false,
            .low_latency = true};
}

namespace detail {

/// The system's constant for a standard baud rate; B0 if it has none. macOS has none above 230400.
inline speed_t standard_speed(std::uint32_t baud) {
    switch (baud) {
    case 600: return B600;
    case 1200: return B1200;
    case 2400: return B2400;
    case 4800: return B4800;
    case 9600: return B9600;
    case 19200: return B19200;
    case 38400: return B38400;
    case 57600: return B57600;
    case 115200: return B115200;
    case 230400: return B230400;
#ifdef B1000000
    case 460800: return B460800;
    case 500000: return B500000;
    case 576000: return B576000;
    case 921600: return B921600;
    case 1000000: return B1000000;
#endif
    default: return B0;
    }
}

} // namespace detail

/// A serial device, open for this program alone. Move-only. A default-constructed one is closed, and every
/// transfer on it returns `errc::port_lost`.
class serial {
  public:
    /// A device and its settings: what `reconnecting` opens again. The path is kept by its pointer.
    struct endpoint {
        const char* path = "";
        serial_settings settings{};
    };

    serial() = default;
    serial(serial&&) noexcept = default;
    serial& operator=(serial&&) noexcept = default;
    ~serial() { close(); }

    /// Opens a device, after closing the one that was open. Bytes that were received before are discarded.
    /// Errors, with the system's reason in `os_error()`:
    /// - `no_such_port`: no device has this name, or none is behind it
    /// - `no_permission`: this user may not open it; usually its group may
    /// - `port_in_use`: another program has it
    /// - `bad_argument`: not a serial device, or a baud rate or format that it does not support
    /// - `rs485_refused`: the system or the device's driver cannot switch an RS-485 driver so
    /// - `rs485_late`: the driver's delay after the send exceeds t3.5 of `baud`
    /// - `port_lost`: another reason of the system, or the device was unplugged meanwhile
    ///
    /// After `rs485_refused` and `rs485_late` the kernel's RS-485 mode is as before.
    status open(const char* path, const serial_settings& wanted = {}) {
        close();
        const int access = wanted.receive_only ? O_RDONLY : O_RDWR;
        descriptor fd{::open(path, access | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
        if (!fd.is_open()) return fail(errno, detail::opening_error(errno));
        if (::isatty(fd.number()) == 0)
            return fail(errno, detail::is_gone(errno) ? errc::no_such_port : errc::bad_argument);
        if (::flock(fd.number(), LOCK_EX | LOCK_NB) != 0)
            return fail(errno, detail::would_block(errno) ? errc::port_in_use : detail::opening_error(errno));
        is_pty_ = detail::is_pseudo_terminal(fd.number());
        // Not on a pseudo-terminal: there the exclusive mode stays after a program was killed.
        if (!is_pty_) (void)::ioctl(fd.number(), TIOCEXCL);
        if (wanted.receive_only) {
            int driver = TIOCM_RTS; // the system asserts it as it opens a device
            (void)::ioctl(fd.number(), TIOCMBIC, &driver);
        }
        if (const int error = configure(fd.number(), wanted); error != 0)
            return fail(error, errc::bad_argument);
        delay_before_send_ = {};
        if (wanted.rs485) {
            const duration gap{modbus::timing_at(wanted.baud).t3_5};
            const detail::driver_result r = detail::switch_direction(fd.number(), wanted.driver, gap);
            if (r.why != errc::ok) return fail(r.error, detail::is_gone(r.error) ? errc::port_lost : r.why);
            delay_before_send_ = r.before_send;
        }
        has_low_latency_ = wanted.low_latency && detail::ask_low_latency(fd.number());
        tells_line_status_ = !is_pty_ && detail::tells_line_status(fd.number());
        (void)::tcflush(fd.number(), TCIOFLUSH);
        keeps_echo_ = wanted.keeps_echo;
        receive_only_ = wanted.receive_only;
        const unsigned bits = wanted.format == character_format::n81 ? 10u : 11u;
        sending_.restart(wanted.baud, bits);
        wakes_early_ = wanted.wakes_early;
        character_ = duration{(bits * 1'000'000u + wanted.baud - 1) / wanted.baud};
        missing_ = 0;
        error_ = 0;
        fd_ = std::move(fd);
        return errc::ok;
    }
    status open(const endpoint& at) { return open(at.path, at.settings); }

    void close() {
        if (fd_.is_open() && !is_pty_) (void)::ioctl(fd_.number(), TIOCNXCL);
        fd_.close();
    }

    bool is_open() const { return fd_.is_open(); }
    /// `errno` of the last failure, for a message; 0 if there was none.
    int os_error() const { return error_; }
    /// True on a pseudo-terminal: no wire, no baud rate, no parity.
    bool is_pseudo_terminal() const { return is_pty_; }
    /// True if the device's driver has set low latency.
    bool has_low_latency() const { return has_low_latency_; }

    /// Sends as many bytes as the kernel's queue has room for. Errors: `port_lost`, `send_failed` (also if the port is
    /// `receive_only`).
    transfer send(bytes out) {
        if (receive_only_ && fd_.is_open()) return errc::send_failed;
        const instant at = now();
        const detail::moved m = detail::write_some(fd_.number(), out);
        if (m.error != 0) return lose(m.error, errc::send_failed);
        if (m.count != 0) sending_.add(m.count, sending_.is_under_way() ? at : at + delay_before_send_);
        return static_cast<std::uint16_t>(m.count);
    }

    /// True when the last stop bit has left the wire; see the top of this header. As it turns true, it discards the
    /// local echo. If it is called later than t3.5 after the end of the request, the bytes may be the response: they
    /// stay, unless this adapter has echoed the last request that was seen in time: then it discards as many of them
    /// as were sent.
    bool sent() {
        if (!sending_.is_under_way()) return true;
        if (!is_pty_) {
            const instant at = now();
            int waiting = 0;
            if (fd_.is_open() && ::ioctl(fd_.number(), TIOCOUTQ, &waiting) == 0 && waiting > 0) return false;
            if (!sending_.is_over(at)) return false;
            if (tells_line_status_ && !detail::is_transmitter_empty(fd_.number())) return false;
            if (!keeps_echo_ && fd_.is_open()) discard_echo();
        }
        sending_.finish();
        return true;
    }

    /// Errors: `port_lost`, `receive_failed`.
    transfer receive(byte_buffer in) {
        const detail::moved m = detail::read_some(fd_.number(), in);
        if (m.error != 0) return lose(m.error, errc::receive_failed);
        if (m.count != 0 && sending_.is_under_way()) sending_.note_arrival(m.count, now());
        if (m.count != 0) missing_ = 0;
        return static_cast<std::uint16_t>(m.count);
    }

    instant now() const { return monotonic_now(); }

    /// Sleeps until a byte arrives, `d` has passed or a signal is handled. The thread's timer slack is
    /// lowered meanwhile and restored, so that it does not lengthen the sleep. If the device is gone it
    /// sleeps for all of `d`, so that a loop over it does not spin. With `wakes_early` it may poll before the end
    /// of `d`, and from when the last byte that was announced by `expect` may come.
    void wait(duration d) {
        if (!fd_.is_open()) return sleep_for(d);
        const duration due = character_ * std::exchange(missing_, std::uint16_t{0});
        // Nothing is urgent until the request has left.
        const int events = wakes_early_ && !sending_.is_under_way()
                               ? early_.wait(kernel{fd_.number()}, d, due)
                               : detail::wait_readable(fd_.number(), d);
        if ((events & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
            (void)lose(EIO, errc::port_lost);
            sleep_for(d);
        }
    }
    /// So many bytes of the response that has begun are missing: for the next `wait`.
    void expect(std::uint16_t missing) { missing_ = missing; }

  private:
    struct kernel {
        int fd;
        instant now() const { return monotonic_now(); }
        int wait(duration d) const { return detail::wait_readable(fd, d); }
    };

    errc fail(int error, errc why) {
        error_ = error;
        return why;
    }

    // Closes the descriptor of a device that is gone: it stays gone even if another device gets its name.
    errc lose(int error, errc otherwise) {
        if (error != EBADF) error_ = error;
        if (!detail::is_gone(error)) return otherwise;
        fd_.close();
        return errc::port_lost;
    }

    // By poll and read, which find also what FIONREAD does not count yet.
    void discard_echo() {
        std::uint8_t dropped[64];
        for (int reads = 0; reads < 16; ++reads) {
            if (detail::wait_readable(fd_.number(), {}) != POLLIN) break;
            const std::size_t most = sending_.most_to_discard(now());
            if (most == 0) break;
            const byte_buffer room{dropped};
            const detail::moved m =
                detail::read_some(fd_.number(), room.first(most < room.size() ? most : room.size()));
            if (m.error != 0 || m.count == 0) break;
            sending_.note_discarded(m.count);
        }
        sending_.decide_echo(now());
    }

    int configure(int fd, const serial_settings& wanted) {
        if (wanted.baud == 0) return EINVAL;
        termios t{};
        if (::tcgetattr(fd, &t) != 0) return errno;
        detail::make_raw(t);
        if (wanted.format == character_format::n82) t.c_cflag |= CSTOPB;
        // A pseudo-terminal has none: tcsetattr says EINVAL where nothing else changes, such as at a second opening.
        const bool has_parity =
            wanted.format == character_format::e81 || wanted.format == character_format::o81;
        if (has_parity && !is_pty_) t.c_cflag |= PARENB;
        if (wanted.format == character_format::o81 && !is_pty_) t.c_cflag |= PARODD;
        if ((t.c_cflag & PARENB) != 0) t.c_iflag |= INPCK; // a byte in error reads as 0: the CRC fails
        const speed_t speed = detail::standard_speed(wanted.baud);
        const bool is_standard = speed != B0;
        (void)::cfsetispeed(&t, is_standard ? speed : speed_t{B38400});
        (void)::cfsetospeed(&t, is_standard ? speed : speed_t{B38400});
        if (::tcsetattr(fd, TCSANOW, &t) != 0) return errno;
        // tcsetattr succeeds if any of the settings was made, so they are read back.
        termios got{};
        if (::tcgetattr(fd, &got) != 0) return errno;
        constexpr tcflag_t shape = CSIZE | CSTOPB | PARENB | PARODD;
        if (!is_pty_ && (got.c_cflag & shape) != (t.c_cflag & shape)) return EINVAL;
        if (is_standard) return ::cfgetospeed(&got) == speed ? 0 : EINVAL;
        return detail::set_any_speed(fd, wanted.baud);
    }

    descriptor fd_;
    transmission sending_{};
    detail::early_wake_up early_{};
    duration character_{};
    duration delay_before_send_{}; // of the kernel's RS-485 driver
    int error_ = 0;
    std::uint16_t missing_ = 0; // bytes of the response, for the next wait
    bool wakes_early_ = false;
    bool is_pty_ = false;
    bool keeps_echo_ = false;
    bool receive_only_ = false;
    bool has_low_latency_ = false;
    bool tells_line_status_ = false;
};

static_assert(expecting_port<serial>);

} // namespace servobus::posix
