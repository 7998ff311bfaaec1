// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, Windows 7 or newer: RTU frames over a TCP connection, as RS485-Ethernet gateways carry them in transparent
// mode, as a port. For Modbus TCP: mbap.hpp. Programs link with ws2_32.
//
//     servobus::windows::tcp port;
//     if (port.open("192.168.1.7", "4001") != servobus::errc::ok) return 1;
//     constexpr auto mode = servobus::modbus::timing_mode::host;
//     servobus::line line{port, servobus::modbus::timing_at(115200, mode, servobus::milliseconds(50))};
//
// What holds behind a gateway is the same as for posix::tcp: its header says how to choose times.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/line/port.hpp>
#include <servobus/line/tcp_open.hpp>
#include <servobus/line/transmission.hpp>
#include <servobus/windows/clock.hpp>

// A whole <windows.h> before this header has included <winsock.h>. The headers of mingw replace it by <winsock2.h>, and
// warn of that; those of Microsoft cannot.
#if defined(_WINSOCKAPI_) && !defined(_WINSOCK2API_)
#ifdef __MINGW32__
#undef _WINSOCKAPI_
#else
#error "include <servobus/windows/tcp.hpp> before <windows.h>, or define WIN32_LEAN_AND_MEAN before it"
#endif
#endif
#include <winsock2.h>
#include <ws2tcpip.h>

#include <mstcpip.h> // after them

namespace servobus::windows {

using servobus::tcp_settings;

namespace detail {

/// The system's library of sockets, loaded as long as one of these is.
class winsock {
  public:
    winsock() = default;
    winsock(const winsock&) = delete;
    winsock& operator=(const winsock&) = delete;
    ~winsock() {
        if (is_loaded_) (void)::WSACleanup();
    }
    /// 0, or its error.
    int load() {
        WSADATA about{};
        const int error = is_loaded_ ? 0 : ::WSAStartup(MAKEWORD(2, 2), &about);
        is_loaded_ = error == 0;
        return error;
    }

  private:
    bool is_loaded_ = false;
};

/// A socket that does not block, and the event that its data and its end set.
class stream_socket {
  public:
    stream_socket() = default;
    stream_socket(const stream_socket&) = delete;
    stream_socket& operator=(const stream_socket&) = delete;
    ~stream_socket() { close(); }

    bool open(int family) {
        close();
        socket_ = ::WSASocketW(family, SOCK_STREAM, IPPROTO_TCP, nullptr, 0, WSA_FLAG_OVERLAPPED);
        event_ = ::WSACreateEvent();
        return is_open() && event_ != WSA_INVALID_EVENT &&
               ::WSAEventSelect(socket_, event_, FD_CONNECT | FD_READ | FD_CLOSE) == 0;
    }
    void close() {
        if (is_open()) (void)::closesocket(socket_);
        if (event_ != WSA_INVALID_EVENT) (void)::WSACloseEvent(event_);
        socket_ = INVALID_SOCKET;
        event_ = WSA_INVALID_EVENT;
        has_ended_ = false;
    }
    bool is_open() const { return socket_ != INVALID_SOCKET; }
    SOCKET number() const { return socket_; }

    template <class Value> void set(int level, int option, const Value& value) const {
        (void)::setsockopt(socket_, level, option, reinterpret_cast<const char*>(&value), sizeof value);
    }

    /// Waits until the connection is there or has failed. 0, or the error; WSAETIMEDOUT if neither came in time.
    int finish_connect(duration within) const {
        if (::WaitForSingleObject(event_, milliseconds_of(within)) != WAIT_OBJECT_0) return WSAETIMEDOUT;
        WSANETWORKEVENTS events{};
        if (::WSAEnumNetworkEvents(socket_, event_, &events) != 0) return ::WSAGetLastError();
        if ((events.lNetworkEvents & FD_CONNECT) == 0) return WSAECONNABORTED;
        return events.iErrorCode[FD_CONNECT_BIT];
    }
    /// Waits until a byte has arrived, the connection has ended or `d` has passed.
    void wait(duration d) {
        WSANETWORKEVENTS
        events{}; // takes those that have come; the event is set again by what comes from here on
        has_ended_ = has_ended_ || ::WSAEnumNetworkEvents(socket_, event_, &events) != 0 ||
                     (events.lNetworkEvents & FD_CLOSE) != 0;
        u_long waiting = 0;
        if (!has_ended_ && (::ioctlsocket(socket_, FIONREAD, &waiting) != 0 || waiting == 0))
            wait_for(event_, d);
    }

  private:
    SOCKET socket_ = INVALID_SOCKET;
    WSAEVENT event_ = WSA_INVALID_EVENT;
    bool has_ended_ = false; // a read reports it
};

} // namespace detail

/// A connection. It does not move. A default-constructed one is closed, and every transfer on it returns `port_lost`.
class tcp {
  public:
    static constexpr bool is_network = true;
    /// A host, its port and the settings: what `reconnecting` opens again. The texts are kept by their pointers.
    struct endpoint {
        const char* host = "";
        const char* service = "";
        tcp_settings settings{};
    };

    tcp() = default;
    tcp(const tcp&) = delete;
    tcp& operator=(const tcp&) = delete;
    ~tcp() = default;

    /// Connects, after closing the connection that was open. `service` is a port number or a name of one. Waits for the
    /// name's resolution as long as the system does, and for the connection `connect_within`. Errors: `bad_argument`
    /// (no such host or service: `resolve_error()`), `timeout` (no answer), `port_lost` (refused, unreachable:
    /// `os_error()`). Windows asks a port that refuses three times, about two seconds.
    status open(const char* host, const char* service, const tcp_settings& wanted = {}) {
        close();
        error_ = 0;
        if (const int error = system_.load(); error != 0) return fail(error, errc::port_lost);
        addrinfo hints{};
        hints.ai_socktype = SOCK_STREAM;
        addrinfo* found = nullptr;
        resolve_error_ = ::getaddrinfo(host, service, &hints, &found);
        if (resolve_error_ != 0) return errc::bad_argument;
        const errc why =
            connect_to_first(found, wanted.connect_within, monotonic_now,
                             [this](const addrinfo& to, duration within) { return connect_to(to, within); });
        ::freeaddrinfo(found);
        if (why != errc::ok) {
            close();
            return why;
        }
        sending_ = transmission{wanted.baud, longest_character};
        error_ = 0;
        return errc::ok;
    }
    status open(const endpoint& at) { return open(at.host, at.service, at.settings); }
    /// What the system has taken is still sent.
    void close() { socket_.close(); }
    /// Closes the connection; what has not left this host is not sent any more.
    void abort() {
        const linger at_once{.l_onoff = 1, .l_linger = 0};
        if (is_open()) socket_.set(SOL_SOCKET, SO_LINGER, at_once);
        close();
    }
    bool is_open() const { return socket_.is_open(); }
    /// The error of Winsock of the last failure, for a message; 0 if there was none.
    std::uint32_t os_error() const { return static_cast<std::uint32_t>(error_); }
    /// The error of getaddrinfo, one of Winsock too; 0 if there was none.
    std::uint32_t resolve_error() const { return static_cast<std::uint32_t>(resolve_error_); }

    /// Sends as many bytes as the system takes. Errors: `port_lost`.
    transfer send(bytes out) {
        if (!is_open()) return errc::port_lost;
        if (out.empty()) return std::uint16_t{0};
        const instant at = now();
        const int n =
            ::send(socket_.number(), reinterpret_cast<const char*>(out.data()), sized(out.size()), 0);
        if (n == SOCKET_ERROR) return failed_or_none();
        sending_.add(static_cast<std::size_t>(n), at);
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
        if (!is_open()) return errc::port_lost;
        if (in.empty()) return std::uint16_t{0};
        const int n = ::recv(socket_.number(), reinterpret_cast<char*>(in.data()), sized(in.size()), 0);
        if (n == SOCKET_ERROR) return failed_or_none();
        if (n == 0) return lose(WSAECONNRESET); // closed by the peer
        return static_cast<std::uint16_t>(n);
    }
    instant now() const { return monotonic_now(); }

    /// Sleeps until a byte arrives or `d` has passed. A Ctrl-C does not end it.
    void wait(duration d) {
        if (is_open())
            socket_.wait(d);
        else
            sleep_for(d);
    }

  private:
    static int sized(std::size_t size) { return size < 4096 ? static_cast<int>(size) : 4096; }

    errc connect_to(const addrinfo& to, duration within) {
        if (!socket_.open(to.ai_family)) return fail(::WSAGetLastError(), errc::port_lost);
        int error = 0;
        if (::connect(socket_.number(), to.ai_addr, static_cast<int>(to.ai_addrlen)) == SOCKET_ERROR)
            error = ::WSAGetLastError();
        if (error == 0 || error == WSAEWOULDBLOCK) error = socket_.finish_connect(within);
        if (error != 0) return fail(error, error == WSAETIMEDOUT ? errc::timeout : errc::port_lost);
        const BOOL on = TRUE;
        socket_.set(IPPROTO_TCP, TCP_NODELAY, on); // a request leaves at once
        notice_lost_peer();
        return errc::ok;
    }
    // A peer that vanishes without a word is noticed after about 15 s, also by a program that only receives.
    void notice_lost_peer() const {
        tcp_keepalive asks{.onoff = 1, .keepalivetime = 6000, .keepaliveinterval = 1000}; // ms; ten questions
        DWORD size = 0;
        (void)::WSAIoctl(socket_.number(), SIO_KEEPALIVE_VALS, &asks, sizeof asks, nullptr, 0, &size, nullptr,
                         nullptr);
    }
    errc fail(int error, errc why) {
        error_ = error;
        return why;
    }
    transfer failed_or_none() {
        const int error = ::WSAGetLastError();
        if (error == WSAEWOULDBLOCK) return std::uint16_t{0};
        return lose(error);
    }
    // Every error of a connection is final.
    errc lose(int error) {
        error_ = error;
        close();
        return errc::port_lost;
    }

    static constexpr unsigned longest_character = 11; ///< bits; the gateway's format is not known here

    detail::winsock system_; // before the socket: it is unloaded after it
    detail::stream_socket socket_;
    transmission sending_{};
    int error_ = 0;
    int resolve_error_ = 0;
};

static_assert(waiting_port<tcp>);

} // namespace servobus::windows
