// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The hosted ports on the kernel's pseudo-terminals: bytes both ways, short writes, signals, a device that
// disappears, and ports that cannot be opened.
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/posix/serial.hpp>
#include <tests/support/collect.hpp>

namespace posix_tests {

using namespace servobus;
using namespace servobus::posix;
using tests::collect;

namespace {

std::vector<std::uint8_t> every_byte() {
    std::vector<std::uint8_t> all;
    for (unsigned i = 0; i < 256; ++i) all.push_back(static_cast<std::uint8_t>(i));
    return all;
}

template <class Do> duration time_of(Do act) {
    const instant start = monotonic_now();
    act();
    return since(start, monotonic_now());
}

struct pair {
    pseudo_terminal drive;
    serial host;
    pair() {
        REQUIRE(drive.open() == errc::ok);
        REQUIRE(host.open(drive.path()) == errc::ok);
    }
};

// A name that no other program uses.
std::string scratch_name() { return "/tmp/servobus-test-" + std::to_string(::getpid()); }

void ignore(int) {}

// Causes a signal every millisecond during its lifetime.
class nuisance {
  public:
    explicit nuisance(void (*handler)(int) = ignore) {
        struct sigaction act {};
        act.sa_handler = handler; // no SA_RESTART: calls end with EINTR
        (void)::sigaction(SIGALRM, &act, nullptr);
        set(1000);
    }
    ~nuisance() { set(0); }

  private:
    static void set(suseconds_t us) {
        itimerval every{};
        every.it_interval.tv_usec = every.it_value.tv_usec = us;
        (void)::setitimer(ITIMER_REAL, &every, nullptr);
    }
};

} // namespace

TEST_CASE("every byte value passes, both ways, unchanged") {
    pair p;
    const std::vector<std::uint8_t> all = every_byte();
    const transfer sent = p.host.send(all);
    REQUIRE(sent);
    CHECK(*sent == 256);
    CHECK(p.host.sent()); // no wire: immediately
    CHECK(collect(p.drive, 256) == all);
    const transfer answered = p.drive.send(all);
    REQUIRE(answered);
    CHECK(*answered == 256);
    CHECK(p.drive.sent());
    CHECK(collect(p.host, 256) == all);
    CHECK(p.host.is_pseudo_terminal());
}

TEST_CASE("without bytes, or without room for them, a transfer moves 0 bytes") {
    pair p;
    std::array<std::uint8_t, 8> room{};
    CHECK(p.host.receive(room).value_or(99) == 0);
    CHECK(p.drive.receive(room).value_or(99) == 0);
    CHECK(p.host.receive(byte_buffer{}).value_or(99) == 0);
    CHECK(p.host.send(bytes{}).value_or(99) == 0);
    CHECK(p.host.sent());
}

TEST_CASE("on a pseudo-terminal bytes that arrived before sent() are not dropped") {
    pair p;
    const std::array<std::uint8_t, 3> response{1, 2, 3};
    REQUIRE(p.host.send(std::array<std::uint8_t, 2>{9, 9}));
    REQUIRE(p.drive.send(response));
    p.host.wait(milliseconds(100));
    CHECK(p.host.sent());
    CHECK(collect(p.host, 3) == std::vector<std::uint8_t>(response.begin(), response.end()));
}

TEST_CASE("a full line takes fewer bytes, then none, and loses none") {
    pair p;
    std::vector<std::uint8_t> wanted;
    bool is_full = false;
    for (int i = 0; i < 200 && !is_full; ++i) {
        std::vector<std::uint8_t> chunk(1000);
        for (std::uint8_t& b : chunk)
            b = static_cast<std::uint8_t>(wanted.size() * 7 + static_cast<std::size_t>(i));
        const transfer took = p.host.send(chunk);
        REQUIRE(took);
        wanted.insert(wanted.end(), chunk.begin(), chunk.begin() + *took);
        is_full = *took == 0;
    }
    CHECK(is_full);
    CHECK(collect(p.drive, wanted.size()) == wanted);
    CHECK(p.host.send(std::array<std::uint8_t, 1>{5}).value_or(0) == 1);
}

TEST_CASE("more bytes than a transfer can move take several") {
    pair p;
    std::vector<std::uint8_t> room(10'000);
    CHECK(p.host.receive(room).value_or(99) == 0);
    REQUIRE(p.drive.send(std::array<std::uint8_t, 3>{1, 2, 3}));
    p.host.wait(milliseconds(500));
    CHECK(p.host.receive(room).value_or(99) == 3);
    CHECK(room[2] == 3);
    const transfer took = p.host.send(room);
    CHECK(took.value_or(0) > 0);
    CHECK(took.value_or(9999) <= 4096);
    // A pseudo-terminal for each: it may be full after the first.
    for (const std::size_t size : {std::size_t{10'000}, std::size_t{4096}, std::size_t{4095}}) {
        pair fresh;
        CHECK(fresh.drive.send(bytes{room}.first(size)).value_or(0) == (size < 4096 ? size : 4096));
    }
}

TEST_CASE("wait ends with a byte, or after its time") {
    pair p;
    const duration whole = time_of([&] { p.host.wait(milliseconds(30)); });
    CHECK(whole >= milliseconds(25));
    CHECK(time_of([&] { p.drive.wait(milliseconds(30)); }) >= milliseconds(25));
    REQUIRE(p.drive.send(std::array<std::uint8_t, 1>{1}));
    CHECK(time_of([&] { p.host.wait(milliseconds(2000)); }) < milliseconds(1000));
    REQUIRE(p.host.send(std::array<std::uint8_t, 1>{1}));
    CHECK(time_of([&] { p.drive.wait(milliseconds(2000)); }) < milliseconds(1000));
}

TEST_CASE("signals lose no byte and cause no error") {
    pair p;
    const nuisance signals;
    const std::vector<std::uint8_t> all = every_byte();
    for (int i = 0; i < 50; ++i) {
        const transfer sent = p.host.send(all);
        REQUIRE(sent);
        REQUIRE(*sent == 256);
        p.drive.wait(milliseconds(5));
        REQUIRE(collect(p.drive, 256) == all);
    }
}

TEST_CASE("a device that has disappeared is a lost port each time, and waiting for it sleeps") {
    pair p;
    REQUIRE(p.host.send(std::array<std::uint8_t, 1>{1}));
    p.drive.close();
    std::array<std::uint8_t, 8> room{};
    bool waits_first = false;
    SUBCASE("found by receiving") {}
    SUBCASE("found by waiting") { waits_first = true; }
    if (waits_first) p.host.wait(milliseconds(1));
    for (int i = 0; i < 3; ++i) {
        CHECK(p.host.receive(room).error() == errc::port_lost);
        CHECK(p.host.send(room).error() == errc::port_lost);
        CHECK(time_of([&] { p.host.wait(milliseconds(20)); }) >= milliseconds(18));
    }
    CHECK(p.host.os_error() != 0);
    CHECK(p.host.sent()); // nothing is left to send
    // A new device under the same name is another one until it is opened.
    pseudo_terminal next;
    REQUIRE(next.open() == errc::ok);
    CHECK(p.host.receive(room).error() == errc::port_lost);
    CHECK(p.host.open(next.path()) == errc::ok);
    CHECK(p.host.receive(room).value_or(99) == 0);
}

TEST_CASE("a lost port is found by sending") {
    pair p;
    p.drive.close();
    CHECK(p.host.send(std::array<std::uint8_t, 1>{1}).error() == errc::port_lost);
}

TEST_CASE("a pseudo-terminal without a host receives nothing and reports no error") {
    pair p;
    REQUIRE(p.drive.send(std::array<std::uint8_t, 4>{1, 2, 3, 4})); // never read
    REQUIRE(p.host.send(std::array<std::uint8_t, 2>{7, 8}));
    p.host.close();
    CHECK(collect(p.drive, 2) == std::vector<std::uint8_t>{7, 8}); // what was sent still arrives
    std::array<std::uint8_t, 8> room{};
    CHECK(p.drive.receive(room).value_or(99) == 0);
    CHECK_FALSE(p.drive.has_peer());
    CHECK(p.drive.send(room).value_or(0) == 8);
    const std::array<std::uint8_t, 5000> much{};
    CHECK(p.drive.send(much).value_or(0) == 4096);
    CHECK(time_of([&] { p.drive.wait(milliseconds(3)); }) >= milliseconds(2)); // sleeps
    const duration look = time_of([&] { p.drive.wait(milliseconds(2000)); });  // checks for a host
    CHECK(look >= milliseconds(4));
    CHECK(look < milliseconds(1000));
    REQUIRE(p.host.open(p.drive.path()) == errc::ok);
    CHECK(p.drive.receive(room).value_or(99) == 0);
    CHECK(p.drive.has_peer());
    CHECK(p.host.receive(room).value_or(99) == 0); // nothing stale
    REQUIRE(p.host.send(std::array<std::uint8_t, 1>{9}));
    CHECK(collect(p.drive, 1) == std::vector<std::uint8_t>{9});
}

TEST_CASE("a port that cannot be opened reports the reason") {
    serial port;
    CHECK_FALSE(port.is_open());
    CHECK(port.open("/dev/no-such-port") == errc::no_such_port);
    CHECK(port.os_error() == ENOENT);
    CHECK(port.open("/dev/null") == errc::bad_argument);
    CHECK(port.os_error() == ENOTTY);
    CHECK_FALSE(port.is_open());
    std::array<std::uint8_t, 4> room{};
    CHECK(port.receive(room).error() == errc::port_lost);
    CHECK(port.send(room).error() == errc::port_lost);
    pseudo_terminal drive;
    CHECK_FALSE(drive.is_open());
    CHECK_FALSE(drive.has_peer());
    CHECK(drive.receive(room).error() == errc::port_lost);
    CHECK(drive.send(room).error() == errc::port_lost);
    CHECK(drive.os_error() == EBADF);
    CHECK(time_of([&] { drive.wait(milliseconds(20)); }) >= milliseconds(18)); // sleeps
    CHECK(drive.baud() == 0);
    REQUIRE(drive.open() == errc::ok);
    CHECK(drive.is_open());
    CHECK(drive.os_error() == 0);
}

TEST_CASE("the drive's side of a pseudo-terminal knows the rate that the program has set") {
    pseudo_terminal drive;
    REQUIRE(drive.open() == errc::ok);
    for (const std::uint32_t baud : {9600u, 57'600u, 115'200u, 2400u}) {
        serial program;
        REQUIRE(program.open(drive.path(), {.baud = baud}) == errc::ok);
        CHECK(drive.baud() == baud);
    }
    CHECK(servobus::posix::detail::speed_of(-1) == 0); // no port
}

TEST_CASE("a port is open for one program at a time") {
    pair p;
    serial second;
    CHECK(second.open(p.drive.path()) == errc::port_in_use);
    p.host.close();
    CHECK(second.open(p.drive.path()) == errc::ok);
}

TEST_CASE("baud rates and every format are accepted; a rate of 0 and an RS-485 driver that the kernel cannot "
          "switch are refused") {
    pseudo_terminal drive;
    REQUIRE(drive.open() == errc::ok);
    serial host;
    for (const std::uint32_t baud :
         {1200u, 2400u, 4800u, 9600u, 19200u, 38400u, 57600u, 115200u, 230400u, 460800u})
        CHECK(host.open(drive.path(), {.baud = baud}) == errc::ok);
    using enum character_format;
    for (const character_format format : {n81, n82, e81, e81, o81, o81}) // again: nothing else changes then
        CHECK(host.open(drive.path(), {.baud = 19200, .format = format}) == errc::ok);
    CHECK(host.open(drive.path(), {.baud = 0}) == errc::bad_argument);
    CHECK(host.open(drive.path(), {.rs485 = true}) == errc::rs485_refused);
    CHECK(host.os_error() != 0);
    CHECK(host.open(drive.path(), {.low_latency = true}) == errc::ok); // not a condition
    CHECK_FALSE(host.has_low_latency());
}

TEST_CASE("ports can be moved") {
    pair p;
    serial host{std::move(p.host)};
    pseudo_terminal drive{std::move(p.drive)};
    REQUIRE(host.send(std::array<std::uint8_t, 1>{1}));
    CHECK(collect(drive, 1).size() == 1);
    serial other;
    other = std::move(host);
    pseudo_terminal other_drive;
    other_drive = std::move(drive);
    serial& same = other;
    other = std::move(same); // to itself
    pseudo_terminal& same_drive = other_drive;
    other_drive = std::move(same_drive);
    REQUIRE(other.send(std::array<std::uint8_t, 1>{2}));
    CHECK(collect(other_drive, 1) == std::vector<std::uint8_t>{2});
    CHECK(std::string{other_drive.path()}.starts_with("/dev/"));
}

TEST_CASE("a link to the pseudo-terminal exists as long as it does") {
    const std::string link = scratch_name();
    struct stat s {};
    {
        pseudo_terminal first;
        REQUIRE(first.open(link.c_str()) == errc::ok);
        serial host;
        CHECK(host.open(link.c_str()) == errc::ok);
        // A link of that name is replaced, and the pseudo-terminal that has lost it does not remove it.
        pseudo_terminal second;
        REQUIRE(second.open(link.c_str()) == errc::ok);
        first.close();
        CHECK(::lstat(link.c_str(), &s) == 0);
    }
    CHECK(::lstat(link.c_str(), &s) != 0);

    std::FILE* file = std::fopen(link.c_str(), "w"); // no link: it is not replaced
    REQUIRE(file != nullptr);
    (void)std::fclose(file);
    pseudo_terminal third;
    CHECK(third.open(link.c_str()) == errc::bad_argument);
    CHECK(third.os_error() == EEXIST);
    CHECK(::lstat(link.c_str(), &s) == 0);
    (void)::unlink(link.c_str());
    CHECK(third.open("/no/such/folder/link") == errc::bad_argument);
    CHECK(third.os_error() == ENOENT);
    CHECK(third.open("") == errc::bad_argument);
    CHECK(third.os_error() == ENOENT);
    CHECK(third.open(("/tmp/" + std::string(600, 'x')).c_str()) == errc::bad_argument);
    CHECK(third.os_error() == ENAMETOOLONG);
    CHECK_FALSE(third.is_open());

    // What has taken the name of a link since is not removed.
    REQUIRE(third.open(link.c_str()) == errc::ok);
    REQUIRE(::unlink(link.c_str()) == 0);
    file = std::fopen(link.c_str(), "w");
    REQUIRE(file != nullptr);
    (void)std::fclose(file);
    third.close();
    CHECK(::lstat(link.c_str(), &s) == 0);
    (void)::unlink(link.c_str());
}

#ifndef SERVOBUS_PORTABLE_POSIX // what only Linux has

namespace {

// The speed in bits a second, which both sides of a pseudo-terminal share.
std::uint32_t speed_of(const pseudo_terminal& drive) {
    const servobus::posix::descriptor fd{::open(drive.path(), O_RDWR | O_NOCTTY | O_NONBLOCK)};
    servobus::posix::detail::termios2 t{};
    using servobus::posix::detail::termios2; // its size is in the number of the call
    return ::ioctl(fd.number(), TCGETS2, &t) == 0 ? t.c_ospeed : 0;
}

// How much later than requested the kernel may wake this thread, in ns.
int timer_slack() { return ::prctl(PR_GET_TIMERSLACK); }
volatile std::sig_atomic_t least_slack = 0;
void note_slack(int) {
    const int now = timer_slack();
    if (now < least_slack) least_slack = now;
}

} // namespace

TEST_CASE("a sleep ends exactly when it is due, and leaves the thread's own timer slack as it was") {
    const int before = timer_slack();
    if (before < 0 || ::prctl(PR_SET_TIMERSLACK, 70'000ul) != 0 || timer_slack() != 70'000) {
        MESSAGE("no timer slack here");
        return;
    }
    pair p;
    const auto slack_within = [](auto sleep) { // as a signal handler reads it during the sleep
        least_slack = 70'000;
        const nuisance signals{note_slack};
        for (int i = 0; i < 1000 && least_slack == 70'000; ++i) sleep(); // one may come between two sleeps
        return int{least_slack};
    };
    CHECK(slack_within([&] { p.host.wait(milliseconds(20)); }) == 1);
    CHECK(timer_slack() == 70'000);
    CHECK(slack_within([&] { p.drive.wait(milliseconds(20)); }) == 1);
    CHECK(timer_slack() == 70'000);
    CHECK(slack_within([] { sleep_for(milliseconds(20)); }) == 1);
    CHECK(timer_slack() == 70'000);
    REQUIRE(::prctl(PR_SET_TIMERSLACK, 1ul) == 0); // as exact as it can be
    CHECK(slack_within([&] { p.host.wait(milliseconds(20)); }) == 1);
    CHECK(timer_slack() == 1);
    (void)::prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(before));
}

TEST_CASE("each rate is set as requested, also an odd baud rate") {
    pseudo_terminal drive;
    REQUIRE(drive.open() == errc::ok);
    serial host;
    for (const std::uint32_t baud :
         {600u, 1200u, 2400u, 4800u, 9600u, 19200u, 38400u, 57600u, 115200u, 128000u, 230400u, 250000u,
          460800u, 500000u, 576000u, 921600u, 1000000u, 1234567u}) {
        CAPTURE(baud);
        REQUIRE(host.open(drive.path(), {.baud = baud}) == errc::ok);
        CHECK(speed_of(drive) == baud);
    }
}

#else

TEST_CASE("a rate without a constant is refused where the system has no way to set it") {
    pseudo_terminal drive;
    REQUIRE(drive.open() == errc::ok);
    serial host;
    CHECK(host.open(drive.path(), {.baud = 128'000}) == errc::bad_argument);
    CHECK(host.open(drive.path(), {.baud = 115'200}) == errc::ok);
    CHECK(host.open(drive.path(), {.rs485 = true}) == errc::rs485_refused);
}

#endif

} // namespace posix_tests
