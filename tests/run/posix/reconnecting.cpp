// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Ports that open themselves again, over pseudo-terminals and connections of this machine. A terminal goes and comes, a
// link then points to another one, a listener closes and comes back.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include <servobus/line/reconnecting.hpp>
#include <servobus/posix/mbap.hpp>
#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/posix/serial.hpp>
#include <tests/support/loop_bound.hpp>

namespace posix_reconnecting_tests {

using namespace servobus;
using namespace servobus::posix;

namespace {

using byte_list = std::vector<std::uint8_t>;
constexpr std::array<std::uint8_t, 3> request{1, 2, 3};

std::string link_of(const char* name) {
    return "/tmp/servobus-test-" + std::to_string(::getpid()) + "-" + name;
}

template <class Port> errc receive(Port& from) {
    std::array<std::uint8_t, 64> room{};
    return from.receive(room).error();
}

// Asks the port until it is open.
template <class Port> void ask_until_open(Port& port) {
    for (tests::loop_bound left{"the port is open again"}; !port.is_open(); left.use()) {
        CHECK(receive(port) == errc::port_lost);
        port.wait(milliseconds(1));
    }
}

// Asks it until it is lost: the system may report it a moment later.
template <class Port> void ask_until_lost(Port& port) {
    for (tests::loop_bound left{"the port is lost"}; receive(port) != errc::port_lost; left.use())
        port.wait(milliseconds(1));
    CHECK_FALSE(port.is_open());
    CHECK(port.why() == errc::port_lost);
    CHECK(port.take_change());
}

// All that arrives at the other end, until it is so many bytes.
template <class Port> byte_list arrived(Port& at, std::size_t size) {
    byte_list all;
    for (tests::loop_bound left{"the bytes"}; all.size() < size; left.use()) {
        std::array<std::uint8_t, 64> room{};
        const transfer t = at.receive(room);
        REQUIRE(t);
        all.insert(all.end(), room.begin(), room.begin() + *t);
        if (*t == 0) at.wait(milliseconds(1));
    }
    return all;
}

int system_error(const tcp& of) { return of.os_error(); }
int system_error(const mbap& of) { return of.stream().os_error(); }

/// A socket that listens on 127.0.0.1, each time on the same port.
class listener {
  public:
    listener() { open(); }
    void open() {
        fd_ = descriptor{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
        const int on = 1;
        REQUIRE(::setsockopt(fd_.number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0);
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        at.sin_port = port_;
        socklen_t size = sizeof at;
        REQUIRE(::bind(fd_.number(), reinterpret_cast<sockaddr*>(&at), size) == 0);
        REQUIRE(::listen(fd_.number(), 4) == 0);
        REQUIRE(::getsockname(fd_.number(), reinterpret_cast<sockaddr*>(&at), &size) == 0);
        port_ = at.sin_port;
    }
    void close() { fd_.close(); }
    descriptor accept() { return descriptor{::accept(fd_.number(), nullptr, nullptr)}; }
    std::string service() const { return std::to_string(ntohs(port_)); }

  private:
    descriptor fd_;
    in_port_t port_ = 0;
};

} // namespace

TEST_CASE("G47: a terminal that goes and comes is opened again by its link, and no frame crosses the loss") {
    const std::string link = link_of("returns");
    pseudo_terminal drive;
    REQUIRE(drive.open(link.c_str()) == errc::ok);
    reconnecting<serial> port{link.c_str(), serial_settings{.baud = 9600}};
    REQUIRE(port.is_open());
    CHECK(port.take_change());
    CHECK(drive.baud() == 9600);
    for (int i = 0; i < 2; ++i) {
        CHECK(port.send(request).value_or(0) == request.size());
        CHECK(arrived(drive, request.size()) == byte_list{1, 2, 3});
        drive.close();
        ask_until_lost(port);
        // Without the terminal the attempts fail, and say why.
        for (tests::loop_bound left{"an attempt"}; port.why() == errc::port_lost; left.use()) {
            CHECK(receive(port) == errc::port_lost);
            port.wait(milliseconds(1));
        }
        CHECK(port.why() == errc::no_such_port);
        CHECK(port.port().os_error() == ENOENT);
        CHECK_FALSE(port.take_change());
        REQUIRE(drive.open(link.c_str()) == errc::ok);
        // The requests of the lost port, the one that opens it among them, do not arrive.
        for (tests::loop_bound left{"the port is open again"}; !port.is_open(); left.use()) {
            CHECK(port.send(std::array<std::uint8_t, 1>{9}).error() == errc::port_lost);
            port.wait(milliseconds(1));
        }
        CHECK(port.why());
        CHECK(port.take_change());
        CHECK(drive.baud() == 9600); // the settings too
    }
    CHECK(port.send(request).value_or(0) == request.size());
    CHECK(arrived(drive, request.size()) == byte_list{1, 2, 3});
}

TEST_CASE("G47: a link that points to another terminal after the loss leads there") {
    const std::string link = link_of("moves");
    pseudo_terminal first, second;
    REQUIRE(first.open(link.c_str()) == errc::ok);
    reconnecting<serial> port{link.c_str()};
    REQUIRE(port.is_open());
    REQUIRE(second.open(link.c_str()) == errc::ok); // replaces the link
    CHECK(port.send(request).value_or(0) == request.size());
    CHECK(arrived(first, request.size()) == byte_list{1, 2, 3}); // an open port stays where it is
    (void)port.take_change();
    first.close();
    ask_until_lost(port);
    ask_until_open(port);
    CHECK(port.send(request).value_or(0) == request.size());
    CHECK(arrived(second, request.size()) == byte_list{1, 2, 3});
}

TEST_CASE("G47: another program's port is said to be in use, and opened once it is free") {
    pseudo_terminal drive;
    REQUIRE(drive.open() == errc::ok);
    serial other;
    REQUIRE(other.open(drive.path()) == errc::ok);
    reconnecting<serial> port{serial::endpoint{drive.path(), {.baud = 19200}}};
    CHECK_FALSE(port.is_open());
    CHECK(port.why() == errc::port_in_use);
    CHECK(std::string{text(port.why().error())} == "another program has the port");
    other.close();
    ask_until_open(port);
    CHECK(port.why());
    CHECK(drive.baud() == 19200);
}

TEST_CASE_TEMPLATE("G47: a listener that closes and comes back is connected to again", Port, tcp, mbap) {
    listener at;
    const std::string service = at.service();
    const tcp_settings wanted{.connect_within = milliseconds(1000)};
    reconnecting<Port> port{"127.0.0.1", service.c_str(), wanted};
    REQUIRE(port.is_open());
    (void)port.take_change();
    {
        const descriptor peer = at.accept();
        REQUIRE(peer.is_open());
        at.close();
    }
    ask_until_lost(port);
    // Nobody listens: the attempts fail.
    for (tests::loop_bound left{"an attempt"}; system_error(port.port()) != ECONNREFUSED; left.use()) {
        CHECK(receive(port) == errc::port_lost);
        port.wait(milliseconds(1));
    }
    CHECK(port.why() == errc::port_lost);
    CHECK_FALSE(port.take_change());
    at.open();
    ask_until_open(port);
    CHECK(port.take_change());
    CHECK(port.why());
    const descriptor peer = at.accept();
    const std::array<std::uint8_t, 8> frame{1, 3, 0x20, 0xA1, 0, 1, 0xDE, 0x28};
    CHECK(port.send(frame).value_or(0) == frame.size());
    std::array<std::uint8_t, 12> got{};
    const std::size_t size = has_gateway<Port> ? 12 : 8;
    CHECK(::recv(peer.number(), got.data(), size, MSG_WAITALL) == static_cast<ssize_t>(size));
    CHECK(got[has_gateway<Port> ? 6 : 0] == 1);
    port.drop();
    CHECK_FALSE(port.is_open());
    ask_until_open(port);
}

} // namespace posix_reconnecting_tests
