// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, POSIX: RTU frames over a TCP connection, as RS485-Ethernet gateways carry them in transparent mode, as a
// port. For Modbus TCP: mbap.hpp.
//
//     servobus::posix::tcp port;
//     if (port.open("192.168.1.7", "4001") != servobus::errc::ok) return 1;
//     constexpr auto mode = servobus::modbus::timing_mode::host;
//     servobus::line line{port, servobus::modbus::timing_at(115200, mode, servobus::milliseconds(50))};
//
// A gateway waits before it passes received bytes on, and may do so in pieces: give the line's timing an `inter_byte`
// longer than that, and the node a `limits.response` and a quarantine that contain both ways through the network. A
// gateway that repeats requests by itself, or answers for a drive, breaks G15 and G2: switch that off.
//
// A connection loses nothing: a request whose response did not come in time may reach the drive later, and its response
// after the quarantine would be taken for that of the next request. If your network can be late, `abort()` the
// connection after a request without a response, and open it again.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <servobus/line/port.hpp>
#include <servobus/line/tcp_open.hpp>
#include <servobus/line/transmission.hpp>
#include <servobus/posix/clock.hpp>
#include <servobus/posix/descriptor.hpp>

namespace servobus::posix {

using servobus::tcp_settings;

/// A connection. Move-only. A default-constructed one is closed, and every transfer on it returns `port_lost`.
class tcp {
  public:
    static constexpr bool is_network = true;
    /// A host, its port and the settings: what `reconnecting` opens again. The texts are kept by their pointers.
    struct endpoint {
        const char* host = "";
        const char* service = "";
        tcp_settings settings{};
    };

    /// Connects, after closing the connection that was open. `service` is a port number or a name of one. Waits for the
    /// name's resolution as long as the system does, and for the connection `connect_within`. Errors: `bad_argument`
    /// (no such host or service: `resolve_error()`), `timeout` (no answer), `port_lost` (refused, unreachable:
    /// `os_error()`).
    status open(const char* host, const char* service, const tcp_settings& wanted = {}) {
        close();
        error_ = 0;
        addrinfo hints{};
        hints.ai_socktype = SOCK_STREAM;
        addrinfo* found = nullptr;
        resolve_error_ = ::getaddrinfo(host, service, &hints, &found);
        if (resolve_error_ != 0) return errc::bad_argument;
        const errc why =
            connect_to_first(found, wanted.connect_within, monotonic_now,
                             [this](const addrinfo& to, duration within) { return connect_to(to, within); });
        ::freeaddrinfo(found);
        if (why != errc::ok) return why;
        sending_ = transmission{wanted.baud, longest_character};
        error_ = 0;
        return errc::ok;
    }
    status open(const endpoint& at) { return open(at.host, at.service, at.settings); }
    /// What the system has taken is still sent.
    void close() { fd_.close(); }
    /// Closes the connection; what has not left this host is not sent any more.
    void abort() {
        const linger at_once{.l_onoff = 1, .l_linger = 0};
        if (is_open()) (void)::setsockopt(fd_.number(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
        close();
    }
    bool is_open() const { return fd_.is_open(); }
    /// `errno` of the last failure, for a message; 0 if there was none.
    int os_error() const { return error_; }
    /// The error of getaddrinfo, for `gai_strerror`; 0 if there was none.
    int resolve_error() const { return resolve_error_; }

    /// Sends as many bytes as the system takes. Errors: `port_lost`.
    transfer send(bytes out) {
        if (!fd_.is_open()) return errc::port_lost;
        if (out.empty()) return std::uint16_t{0};
        const std::size_t size =
            out.size() < detail::largest_transfer ? out.size() : detail::largest_transfer;
        const instant at = now();
        const ssize_t n = ::send(fd_.number(), out.data(), size, detail::without_signal);
        if (n < 0 && (detail::would_block(errno) || errno == EINTR)) return std::uint16_t{0};
        if (n < 0) return lose(errno);
        if (n != 0) sending_.add(static_cast<std::size_t>(n), at);
        return static_cast<std::uint16_t>(n);
    }
    /// True when the gateway can have sent the bytes: after their wire time, if the rate is known.
    bool sent() {
        if (sending_.is_under_way() && !sending_.is_over(now())) return false;
        sending_.finish();
        return true;
    }
    /// Errors: `port_lost`, also if the peer has closed the connection.
    transfer receive(byte_buffer in) {
        const detail::moved m = detail::read_some(fd_.number(), in);
        if (m.error != 0) return lose(m.error == EPIPE ? ECONNRESET : m.error); // closed by the peer
        return static_cast<std::uint16_t>(m.count);
    }
    instant now() const { return monotonic_now(); }

    /// Sleeps until a byte arrives, `d` has passed or a signal is handled.
    void wait(duration d) {
        if (fd_.is_open())
            (void)detail::wait_readable(fd_.number(), d);
        else
            sleep_for(d);
    }

  private:
    errc connect_to(const addrinfo& to, duration within) {
        const instant end = now() + within;
        descriptor fd{detail::make_stream_socket(to.ai_family)};
        if (!fd.is_open()) return fail(errno, errc::port_lost);
        if (::connect(fd.number(), to.ai_addr, to.ai_addrlen) != 0) {
            if (errno != EINPROGRESS && errno != EINTR) return fail(errno, errc::port_lost);
            for (;;) { // a signal ends a wait early
                const duration rest = time_left(now(), end);
                if (rest == duration{}) return fail(ETIMEDOUT, errc::timeout);
                const int events = detail::wait_for(fd.number(), POLLOUT, rest);
                if ((events & POLLNVAL) != 0) return fail(EMFILE, errc::port_lost); // too many for select
                if (events != 0) break;
            }
            int why = 0;
            socklen_t size = sizeof why;
            if (::getsockopt(fd.number(), SOL_SOCKET, SO_ERROR, &why, &size) != 0) why = errno;
            if (why != 0) return fail(why, errc::port_lost);
        }
        const int on = 1; // a request leaves at once
        (void)::setsockopt(fd.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        notice_lost_peer(fd.number());
        fd_ = std::move(fd);
        return errc::ok;
    }
    // A peer that vanishes without a word is noticed after about 15 s, also by a program that only receives.
    static void notice_lost_peer(int fd) {
        const int on = 1;
        (void)::setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
#ifdef TCP_KEEPIDLE
        const int idle = 6; // seconds; then a question every 3 s, three times
        const int interval = 3;
        const int count = 3;
        (void)::setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof idle);
        (void)::setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &interval, sizeof interval);
        (void)::setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &count, sizeof count);
#endif
    }
    errc fail(int error, errc why) {
        error_ = error;
        return why;
    }
    // Every error of a connection is final.
    errc lose(int error) {
        if (error != EBADF) error_ = error;
        fd_.close();
        return errc::port_lost;
    }

    static constexpr unsigned longest_character = 11; ///< bits; the gateway's format is not known here

    descriptor fd_;
    transmission sending_{};
    int error_ = 0;
    int resolve_error_ = 0;
};

static_assert(waiting_port<tcp>);

} // namespace servobus::posix
