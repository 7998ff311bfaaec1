// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Connections to real sockets of this machine: what cannot be opened, bytes both ways, and a peer that goes away.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <doctest/doctest.h>

#include <servobus/posix/mbap.hpp>
#include <servobus/posix/tcp.hpp>
#include <tests/support/collect.hpp>

namespace tcp_tests {

using namespace servobus;
using namespace servobus::posix;
using tests::collect;

namespace {

/// A socket that listens on a free port of 127.0.0.1 or ::1.
class host {
  public:
    explicit host(int family = AF_INET, int backlog = 4)
        : fd_{::socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0)} {
        sockaddr_storage at{};
        socklen_t size = sizeof(sockaddr_in);
        at.ss_family = static_cast<sa_family_t>(family);
        if (family == AF_INET) {
            reinterpret_cast<sockaddr_in*>(&at)->sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        } else {
            reinterpret_cast<sockaddr_in6*>(&at)->sin6_addr = in6addr_loopback;
            size = sizeof(sockaddr_in6);
        }
        is_there_ = ::bind(fd_.number(), reinterpret_cast<sockaddr*>(&at), size) == 0 &&
                    ::listen(fd_.number(), backlog) == 0 &&
                    ::getsockname(fd_.number(), reinterpret_cast<sockaddr*>(&at), &size) == 0;
        port_ = ntohs(family == AF_INET ? reinterpret_cast<sockaddr_in*>(&at)->sin_port
                                        : reinterpret_cast<sockaddr_in6*>(&at)->sin6_port);
    }
    bool is_there() const { return is_there_; }
    std::string service() const { return std::to_string(port_); }
    descriptor accept() { return descriptor{::accept(fd_.number(), nullptr, nullptr)}; }
    void close() { fd_.close(); }

  private:
    descriptor fd_;
    bool is_there_ = false;
    unsigned port_ = 0;
};

constexpr std::array<std::uint8_t, 8> request{1, 3, 0x20, 0xA1, 0, 1, 0xDE, 0x28};

} // namespace

TEST_CASE("tcp: a closed connection fails every transfer") {
    tcp port;
    std::array<std::uint8_t, 4> room{};
    CHECK_FALSE(port.is_open());
    CHECK(port.send(request).error() == errc::port_lost);
    CHECK(port.receive(room).error() == errc::port_lost);
    CHECK(port.sent());
    port.wait(milliseconds(1));
}

TEST_CASE("tcp: bytes pass both ways, over IPv4 and IPv6") {
    for (const int family : {AF_INET, AF_INET6}) {
        host h{family};
        if (family == AF_INET6 && !h.is_there()) {
            MESSAGE("this machine has no IPv6");
            continue;
        }
        tcp port;
        REQUIRE(port.open(family == AF_INET ? "127.0.0.1" : "::1", h.service().c_str()) == errc::ok);
        const descriptor peer = h.accept();
        const transfer n = port.send(request);
        REQUIRE(n);
        CHECK(*n == request.size());
        std::array<std::uint8_t, 16> got{};
        CHECK(::recv(peer.number(), got.data(), request.size(), MSG_WAITALL) ==
              static_cast<ssize_t>(request.size()));
        CHECK(std::equal(request.begin(), request.end(), got.begin()));
        REQUIRE(::send(peer.number(), request.data(), 3, 0) == 3);
        CHECK(collect(port, 3) == std::vector<std::uint8_t>{1, 3, 0x20});
        const transfer none = port.receive(got);
        REQUIRE(none);
        CHECK(*none == 0);
    }
}

TEST_CASE("G31: sent is not true before the gateway's wire can have carried the bytes") {
    host h;
    tcp port;
    REQUIRE(port.open("127.0.0.1", h.service().c_str(), {.baud = 1200}) == errc::ok);
    const instant start = port.now();
    REQUIRE(port.send(request));
    while (!port.sent()) port.wait(milliseconds(1));
    CHECK(since(start, port.now()) >= milliseconds(8 * 11 * 1000 / 1200));
    REQUIRE(port.open("127.0.0.1", h.service().c_str()) == errc::ok);
    REQUIRE(port.send(request));
    CHECK(port.sent());
}

TEST_CASE("tcp: what cannot be opened is said") {
    tcp port;
    CHECK(port.open("no.such.host.invalid", "502") == errc::bad_argument);
    CHECK(port.resolve_error() != 0);
    CHECK(port.open("127.0.0.1", "no-such-service") == errc::bad_argument);
    host h;
    const std::string service = h.service();
    h.close();
    CHECK(port.open("127.0.0.1", service.c_str()) == errc::port_lost);
    CHECK(port.os_error() == ECONNREFUSED);
    CHECK_FALSE(port.is_open());
}

// No program accepts, and the queue of connections is full: the system does not answer a further one.
TEST_CASE("G29: a host that does not answer the connect is given up in time") {
    host h{AF_INET, 0};
    std::array<tcp, 8> ports;
    unsigned unanswered = 0;
    for (tcp& port : ports) {
        const status why =
            port.open("127.0.0.1", h.service().c_str(), {.baud = 0, .connect_within = milliseconds(100)});
        if (why) continue;
        CHECK(why == errc::timeout);
        CHECK_FALSE(port.is_open());
        if (++unanswered == 2) break;
    }
    CHECK(unanswered == 2);
}

TEST_CASE("G29: a connection that is closed, also in the middle of a response, is lost in each call") {
    host h;
    for (const bool is_reset : {false, true}) {
        tcp port;
        REQUIRE(port.open("127.0.0.1", h.service().c_str()) == errc::ok);
        {
            const descriptor peer = h.accept();
            REQUIRE(::send(peer.number(), request.data(), 3, 0) == 3);
            CHECK(collect(port, 3).size() == 3);
            const linger at_once{1, 0};
            if (is_reset)
                REQUIRE(::setsockopt(peer.number(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once) == 0);
        }
        std::array<std::uint8_t, 4> room{};
        port.wait(milliseconds(1000));
        CHECK(port.receive(room).error() == errc::port_lost);
        CHECK_FALSE(port.is_open());
        CHECK(port.send(request).error() == errc::port_lost);
        CHECK(port.receive(room).error() == errc::port_lost);
    }
}

TEST_CASE("tcp: close ends a connection, abort breaks it off; either port opens again") {
    host h;
    std::array<std::uint8_t, 4> room{};
    tcp port;
    for (const bool is_abort : {false, true, false}) {
        CAPTURE(is_abort);
        REQUIRE(port.open("127.0.0.1", h.service().c_str()) == errc::ok);
        const descriptor peer = h.accept();
        if (is_abort)
            port.abort();
        else
            port.close();
        CHECK_FALSE(port.is_open());
        errno = 0;
        CHECK(::recv(peer.number(), room.data(), room.size(), 0) == (is_abort ? -1 : 0));
        CHECK(errno == (is_abort ? ECONNRESET : 0));
    }
    port.abort(); // nothing is open
    CHECK(port.receive(room).error() == errc::port_lost);
}

TEST_CASE("tcp: a peer that has gone is no signal") { // SIGPIPE would end this program
    host h;
    tcp port;
    REQUIRE(port.open("127.0.0.1", h.service().c_str()) == errc::ok);
    { const descriptor peer = h.accept(); }
    errc why = errc::ok;
    for (int i = 0; i < 1000 && why == errc::ok; ++i) {
        const transfer n = port.send(request);
        if (!n) why = n.error();
        sleep_for(milliseconds(1));
    }
    CHECK(why == errc::port_lost);
}

TEST_CASE("Modbus TCP: the port connects, and reports what the connection reports") {
    host h;
    mbap port;
    REQUIRE(port.open("127.0.0.1", h.service().c_str()) == errc::ok);
    {
        const descriptor peer = h.accept();
        REQUIRE(port.send(request));
        std::array<std::uint8_t, 12> got{};
        REQUIRE(::recv(peer.number(), got.data(), got.size(), MSG_WAITALL) == 12);
        CHECK(got == std::array<std::uint8_t, 12>{0, 1, 0, 0, 0, 6, 1, 3, 0x20, 0xA1, 0, 1});
    }
    std::array<std::uint8_t, 4> room{};
    port.wait(milliseconds(1000));
    CHECK(port.receive(room).error() == errc::port_lost);
    CHECK(port.send(request).error() == errc::port_lost);
    CHECK(port.open("no.such.host.invalid", "502") == errc::bad_argument);
}

} // namespace tcp_tests
