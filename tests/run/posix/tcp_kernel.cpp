// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Connections on sockets that behave as real ones seldom do: a connect that ends at once or by a signal, one whose wait
// or outcome fails, a send that a signal interrupts. All other calls go to the real kernel.
#include <array>
#include <cstdint>
#include <string>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <doctest/doctest.h>

static int socket_by_test(int family, int type, int protocol);
static int connect_by_test(int fd, const sockaddr* to, socklen_t size);
static int getsockopt_by_test(int fd, int level, int what, void* to, socklen_t* size);
static int ppoll_by_test(pollfd* of, nfds_t count, const timespec* within, const sigset_t* mask);
static ssize_t send_by_test(int fd, const void* from, std::size_t size, int flags);

// The library calls the functions of the test, in a namespace of its own, since other tests use the real ones.
#define servobus servobus_over_test_sockets
#define socket socket_by_test
#define connect connect_by_test
#define getsockopt getsockopt_by_test
#define ppoll ppoll_by_test
#define send send_by_test // the ports' member too
#include <servobus/posix/tcp.hpp>
#undef socket
#undef connect
#undef getsockopt
#undef ppoll
#undef send

using namespace servobus;
using namespace servobus::posix;

namespace {

enum class what : std::uint8_t {
    usual,
    no_socket,
    at_once,
    by_signal,
    refused_at_once,
    bad_wait,
    bad_outcome
};

what next = what::usual;
int send_error = 0;         ///< of each send
bool sends_nothing = false; ///< as some systems may
std::size_t most = 0;       ///< bytes that were offered to a send

/// A socket that listens on 127.0.0.1.
struct host {
    descriptor fd{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    std::string service;

    host() {
        next = what::usual;
        send_error = 0;
        sends_nothing = false;
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof at;
        REQUIRE(::bind(fd.number(), reinterpret_cast<sockaddr*>(&at), size) == 0);
        REQUIRE(::listen(fd.number(), 4) == 0);
        REQUIRE(::getsockname(fd.number(), reinterpret_cast<sockaddr*>(&at), &size) == 0);
        service = std::to_string(ntohs(at.sin_port));
    }
    ~host() { next = what::usual; }
};

} // namespace

int socket_by_test(int family, int type, int protocol) {
    if (next != what::no_socket) return ::socket(family, type, protocol);
    errno = EMFILE;
    return -1;
}
int connect_by_test(int fd, const sockaddr* to, socklen_t size) {
    if (next == what::refused_at_once) {
        errno = ENETUNREACH;
        return -1;
    }
    const int result = ::connect(fd, to, size);
    if (next == what::at_once) {
        pollfd p{fd, POLLOUT, 0};
        return ::poll(&p, 1, 1000) == 1 ? 0 : -1;
    }
    if (next == what::by_signal) errno = EINTR; // the connection is made all the same
    return result;
}
int getsockopt_by_test(int fd, int level, int option, void* to, socklen_t* size) {
    if (next != what::bad_outcome) return ::getsockopt(fd, level, option, to, size);
    errno = ENOBUFS;
    return -1;
}
int ppoll_by_test(pollfd* of, nfds_t count, const timespec* within, const sigset_t* mask) {
    if (next != what::bad_wait) return ::ppoll(of, count, within, mask);
    of->revents = POLLNVAL;
    return 1;
}
ssize_t send_by_test(int fd, const void* from, std::size_t size, int flags) {
    most = size;
    if (sends_nothing) return 0;
    if (send_error == 0) return ::send(fd, from, size, flags);
    errno = send_error;
    return -1;
}

TEST_CASE("tcp: a connect that ends at once, or that a signal interrupts, is a connection") {
    for (const what how : {what::usual, what::at_once, what::by_signal}) {
        CAPTURE(static_cast<int>(how));
        host h;
        tcp port;
        next = how;
        REQUIRE(port.open("127.0.0.1", h.service.c_str()) == errc::ok);
        const descriptor peer{::accept(h.fd.number(), nullptr, nullptr)};
        REQUIRE(peer.is_open());
        const std::array<std::uint8_t, 3> three{1, 2, 3};
        CHECK(port.send_by_test(three).value_or(0) == 3);
        std::array<std::uint8_t, 3> got{};
        CHECK(::recv(peer.number(), got.data(), got.size(), MSG_WAITALL) == 3);
        CHECK(got == three);
    }
}

TEST_CASE("tcp: a connect that fails in any of its calls is reported with its reason") {
    struct scene {
        what how;
        int error;
    };
    for (const scene& s : {scene{what::no_socket, EMFILE}, scene{what::refused_at_once, ENETUNREACH},
                           scene{what::bad_wait, EMFILE}, scene{what::bad_outcome, ENOBUFS}}) {
        CAPTURE(static_cast<int>(s.how));
        host h;
        tcp port;
        next = s.how;
        CHECK(port.open("127.0.0.1", h.service.c_str()) == errc::port_lost);
        CHECK(port.os_error() == s.error);
        CHECK_FALSE(port.is_open());
    }
}

TEST_CASE("tcp: a send moves at most 4096 bytes, and none if there are none, no room, or a signal") {
    host h;
    tcp port;
    REQUIRE(port.open("127.0.0.1", h.service.c_str()) == errc::ok);
    const descriptor peer{::accept(h.fd.number(), nullptr, nullptr)};
    const std::array<std::uint8_t, 5000> much{};
    most = 99;
    CHECK(port.send_by_test({}).value_or(99) == 0);
    CHECK(most == 99); // the system is not asked
    CHECK(port.send_by_test(much).value_or(0) == 4096);
    CHECK(most == 4096);
    for (const int error : {EAGAIN, EINTR}) {
        send_error = error;
        CHECK(port.send_by_test(much).value_or(99) == 0);
        CHECK(port.is_open());
    }
    send_error = 0;
    sends_nothing = true;
    CHECK(port.send_by_test(much).value_or(99) == 0);
    sends_nothing = false;
    send_error = ECONNRESET;
    CHECK(port.send_by_test(much).error() == errc::port_lost);
    CHECK(port.os_error() == ECONNRESET);
    CHECK_FALSE(port.is_open());
}
