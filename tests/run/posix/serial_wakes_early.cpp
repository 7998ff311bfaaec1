// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A serial port that wakes early: on a kernel in virtual time that wakes a sleeping program late, and on the real one,
// both with pseudo-terminals.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <doctest/doctest.h>

namespace late_kernel {
static int clock_gettime(clockid_t which, timespec* to);
static int ppoll(pollfd* of, nfds_t count, const timespec* longest, const sigset_t* mask);
} // namespace late_kernel

// The library calls the functions of the test, in a namespace of its own, since other tests use the real ones.
#define servobus servobus_over_a_late_kernel
#include <servobus/client/client.hpp>
#include <servobus/line/line.hpp>
#define clock_gettime late_kernel::clock_gettime
#define ppoll late_kernel::ppoll
#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/posix/serial.hpp>
#undef clock_gettime
#undef ppoll
#include <tests/support/collect.hpp>

using namespace servobus;
using namespace servobus::posix;

namespace {

struct state {
    bool is_real = false; ///< all below has no effect
    std::uint64_t time_us = 1'000'000;
    std::uint32_t late_us = 0; ///< each sleep ends so late, and each poll takes 1 us
    std::uint32_t sleeps = 0;
    std::uint32_t polls = 0;
};
state kernel;

} // namespace

namespace late_kernel {

int clock_gettime(clockid_t which, timespec* to) {
    if (kernel.is_real) return ::clock_gettime(which, to);
    *to = {static_cast<time_t>(kernel.time_us / 1'000'000),
           static_cast<long>(kernel.time_us % 1'000'000) * 1000};
    return 0;
}
int ppoll(pollfd* of, nfds_t count, const timespec* longest, const sigset_t* mask) {
    if (kernel.is_real) return ::ppoll(of, count, longest, mask);
    const auto us = static_cast<std::uint64_t>(longest->tv_sec * 1'000'000 + longest->tv_nsec / 1000);
    constexpr timespec at_once{};
    const int events = ::ppoll(of, count, &at_once, mask);
    if (us == 0) {
        ++kernel.polls;
        ++kernel.time_us;
    } else {
        ++kernel.sleeps;
        if (events == 0) kernel.time_us += us + kernel.late_us;
    }
    return events;
}

} // namespace late_kernel

namespace {

struct rig {
    pseudo_terminal wire;
    serial port;

    explicit rig(const serial_settings& wanted) {
        kernel = {};
        REQUIRE(wire.open() == errc::ok);
        REQUIRE(port.open(wire.path(), wanted) == errc::ok);
    }
    rig(const rig&) = delete;
    ~rig() { kernel = {}; }
    std::uint64_t time_of_wait(std::uint32_t us) {
        kernel.sleeps = kernel.polls = 0;
        const std::uint64_t begun = kernel.time_us;
        port.wait(duration{us});
        return kernel.time_us - begun;
    }
};
constexpr std::array<std::uint8_t, 8> eight{1, 2, 3, 4, 5, 6, 7, 8};

} // namespace

TEST_CASE("a port wakes early only if it is asked to") {
    for (const bool wakes_early : {false, true}) {
        CAPTURE(wakes_early);
        rig r{{.wakes_early = wakes_early}};
        kernel.late_us = 150;
        for (int i = 0; i < 12; ++i) (void)r.time_of_wait(1750); // it learns the lateness
        CHECK(r.time_of_wait(1750) == (wakes_early ? 1750u : 1900u));
        CHECK(kernel.sleeps == 1);
        CHECK(kernel.polls == 0);
        kernel.late_us = 100;
        CHECK(r.time_of_wait(1750) == (wakes_early ? 1750u : 1850u));
        CHECK(kernel.polls == (wakes_early ? 50u : 0u));
        CHECK(r.time_of_wait(5000) == 5100);
        CHECK(kernel.polls == 0);
    }
}

TEST_CASE("a port that wakes early sleeps while the request leaves") {
    rig r{{.wakes_early = true}};
    kernel.late_us = 150;
    for (int i = 0; i < 12; ++i) (void)r.time_of_wait(1750);
    REQUIRE(r.port.send(eight).value_or(0) == 8);
    CHECK(r.time_of_wait(95) == 95 + 150);
    CHECK(kernel.polls == 0);
    REQUIRE(r.port.sent());
    CHECK(r.time_of_wait(95) == 95);
    CHECK(kernel.sleeps == 0);
}

TEST_CASE("it polls when the last byte of a response is due, in the next wait and by the characters of its "
          "format") {
    struct format {
        serial_settings settings;
        std::uint32_t character_us;
    };
    using enum character_format;
    for (const format& f : {format{{.baud = 9600, .wakes_early = true}, 1042},
                            format{{.baud = 9600, .format = e81, .wakes_early = true}, 1146},
                            format{{.baud = 115'200, .wakes_early = true}, 87},
                            format{{.baud = 115'200, .format = n82, .wakes_early = true}, 96}}) {
        CAPTURE(f.character_us);
        rig r{f.settings};
        kernel.late_us = 20;
        for (int i = 0; i < 12; ++i) (void)r.time_of_wait(1750);
        kernel.late_us = 0;
        r.port.expect(2);
        // It is awake from twice the lateness before to once after that. No byte comes.
        const std::uint64_t took = r.time_of_wait(16'000);
        CHECK(kernel.polls == 3 * 20);
        CHECK(kernel.sleeps == 2);
        CHECK(took == 16'000);
        (void)r.time_of_wait(16'000); // it was told for one wait
        CHECK(kernel.polls == 0);
        r.port.expect(2);
        std::array<std::uint8_t, 8> room{};
        REQUIRE(r.wire.send(eight).value_or(0) == 8);
        CHECK(r.port.receive(room).value_or(0) == 8); // the response went on since
        (void)r.time_of_wait(16'000);
        CHECK(kernel.polls == 0);
    }
}

TEST_CASE("a byte that is there ends a wait at once, and a device that is gone is a lost port") {
    rig r{{.wakes_early = true}};
    REQUIRE(r.wire.send(eight).value_or(0) == 8);
    CHECK(r.time_of_wait(1750) == 0);
    CHECK(kernel.sleeps == 1);
    r.wire.close();
    std::array<std::uint8_t, 8> room{};
    CHECK(r.port.receive(room).error() == errc::port_lost);
    CHECK(r.port.send(eight).error() == errc::port_lost);
    rig other{{.wakes_early = true}};
    other.wire.close();
    other.port.wait(microseconds(100)); // finds it
    CHECK_FALSE(other.port.is_open());
}

TEST_CASE("on the real kernel a port that wakes early loses no byte, and no wait ends before its time") {
    rig r{{.wakes_early = true}};
    kernel.is_real = true;
    std::vector<std::uint8_t> all;
    for (unsigned i = 0; i < 256; ++i) all.push_back(static_cast<std::uint8_t>(i));
    for (int i = 0; i < 20; ++i) {
        for (const std::uint32_t us : {50u, 300u, 1750u}) {
            const instant start = r.port.now();
            r.port.wait(duration{us});
            CHECK(since(start, r.port.now()) >= microseconds(us));
        }
        REQUIRE(r.port.send(all).value_or(0) == 256);
        CHECK(r.port.sent());
        CHECK(tests::collect(r.wire, 256) == all);
        REQUIRE(r.wire.send(all).value_or(0) == 256);
        r.port.expect(3);
        CHECK(tests::collect(r.port, 256) == all);
    }
}
